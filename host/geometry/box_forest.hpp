#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

#include "host/geometry/box_tree.hpp"
#include "weft/core/ids.hpp"
#include "weft/core/vec.hpp"

namespace weft {

/// Binary tree over boxes that come and go: plain arrays, the same shape for the same calls.
class BoxForest {
 public:
  /// Starts with boxes 0, 1, 2, ..., but for empty ones; halved by the median along the longest
  /// side of the box of their centres.
  explicit BoxForest(const std::vector<Aabb>& boxes);

  /// Adds a box under a number that has none.
  void insert(Index item, const Aabb& box);
  void remove(Index item);
  /// Gives a number that has a box another one nearby.
  void replace(Index item, const Aabb& box);

  /// The box of a number that has one.
  const Aabb& box(Index item) const {
    return nodes_[static_cast<std::size_t>(leaf_[static_cast<std::size_t>(item)])].box;
  }

  /// Calls visit(item) for every box that has a point in common with `box`.
  template <class Visit>
  void overlapping(const Aabb& box, Visit&& visit) const {
    if (root_ < 0) return;
    std::vector<Index>& stack = stack_;
    stack.clear();
    if (meets(root_, box)) stack.push_back(root_);
    while (!stack.empty()) {
      const Node& node = nodes_[static_cast<std::size_t>(stack.back())];
      stack.pop_back();
      if (node.item >= 0) {
        visit(node.item);
        continue;
      }
      for (int k = 1; k >= 0; --k)
        if (meets(node.child[k], box)) stack.push_back(node.child[k]);
    }
  }

  /// Calls visit(item) for boxes near a point, roughly nearer ones first: for all that are no
  /// farther than the reach, but for those that are farther than what visit() has made of it by
  /// then.
  /// @param reach [m]
  /// @param visit returns the reach [m] from then on, no longer than before
  template <class Visit>
  void around(const Vec3<double>& x, double reach, Visit&& visit) const {
    if (root_ < 0) return;
    struct Step {
      Index node;
      double distance_sq;
    };
    std::vector<Step> steps{{root_, distance_sq(root_, x)}};
    double reach_sq = reach * reach;
    while (!steps.empty()) {
      const Step step = steps.back();
      steps.pop_back();
      if (step.distance_sq > reach_sq) continue;
      const Node& node = nodes_[static_cast<std::size_t>(step.node)];
      if (node.item >= 0) {
        reach = visit(node.item);
        reach_sq = reach * reach;
        continue;
      }
      Step children[2];
      for (int k = 0; k < 2; ++k) children[k] = {node.child[k], distance_sq(node.child[k], x)};
      const int farther = children[1].distance_sq < children[0].distance_sq ? 0 : 1;
      steps.push_back(children[farther]);
      steps.push_back(children[1 - farther]);
    }
  }

 private:
  /// From a point to the box of a node. [m^2]
  double distance_sq(Index node, const Vec3<double>& x) const {
    const Aabb& box = nodes_[static_cast<std::size_t>(node)].box;
    double sum = 0;
    for (int c = 0; c < 3; ++c) {
      const double out = std::max({box.lo[c] - x[c], x[c] - box.hi[c], 0.0});
      sum += out * out;
    }
    return sum;
  }

  struct Node {
    Aabb box;
    Index parent = -1;
    Index child[2] = {-1, -1};
    Index item = -1;  ///< -1: not a leaf
  };
  /// As Aabb::overlaps(), without a branch a side: what has been asked says nothing of the next.
  bool meets(Index n, const Aabb& b) const {
    const Aabb& own = nodes_[static_cast<std::size_t>(n)].box;
    bool apart = false;
    for (int c = 0; c < 3; ++c) apart = apart | (own.lo[c] > b.hi[c]) | (b.lo[c] > own.hi[c]);
    return !apart;
  }
  Index new_node();
  struct Placed {
    Vec3<double> centre_twice;
    Index item;
  };
  Index build(std::vector<Placed>& items, std::size_t first, std::size_t last,
              const std::vector<Aabb>& boxes);
  /// Makes the boxes from node n up those of what is below them.
  void tighten(Index n);
  Node& node(Index n) { return nodes_[static_cast<std::size_t>(n)]; }

  std::vector<Node> nodes_;
  std::vector<Index> free_;
  std::vector<Index> leaf_;  ///< [items] -1: none
  Index root_ = -1;
  mutable std::vector<Index> stack_;
};

}  // namespace weft
