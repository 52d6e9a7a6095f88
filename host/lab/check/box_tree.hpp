#pragma once

#include <cstddef>
#include <vector>

#include "weft/core/ids.hpp"
#include "weft/core/vec.hpp"

namespace weft::lab {

/// Closed axis-aligned box.
struct Box {
  Vec3<double> lo;
  Vec3<double> hi;
};

/// Whether two closed boxes have a point in common.
inline bool overlap(const Box& a, const Box& b) noexcept {
  return a.lo[0] <= b.hi[0] && b.lo[0] <= a.hi[0] && a.lo[1] <= b.hi[1] && b.lo[1] <= a.hi[1] &&
         a.lo[2] <= b.hi[2] && b.lo[2] <= a.hi[2];
}

/// The smallest box around both.
Box join(const Box& a, const Box& b) noexcept;

/// Binary tree over boxes, split at the median centre of the widest axis. A tree, because one frame
/// may hold triangles of any size side by side: a floor of two triangles, a remeshed wrinkle.
class BoxTree {
 public:
  /// @param boxes finite boxes
  /// @param ids   what a query reports for each of them
  BoxTree(const std::vector<Box>& boxes, const std::vector<Index>& ids);

  /// Number of leaves; they can be queried independently, by several threads at once.
  std::size_t leaf_count() const noexcept { return leaves_.size(); }

  /// Calls found(id, id) for every pair of overlapping boxes, one of them in leaf `leaf` and the
  /// other in the same leaf or a later one; over all leaves that is every pair once.
  template <class Found>
  void pairs_from_leaf(std::size_t leaf, Found&& found) const;

  /// Calls found(id) for every box that overlaps `box`.
  template <class Found>
  void overlapping(const Box& box, Found&& found) const;

 private:
  struct Item {
    Box box;
    Index id;
  };
  /// Items [first, last); the left child follows its parent, `right` is 0 in a leaf.
  struct Node {
    Box box;
    Index first;
    Index last;
    Index right;
  };
  static constexpr Index leaf_size = 4;

  void build(Index first, Index last);

  /// Calls visit(node) for every leaf that overlaps `box` and does not end before item `from`.
  template <class Visit>
  void visit_leaves(const Box& box, Index from, Visit&& visit) const;

  std::vector<Item> items_;
  std::vector<Node> nodes_;
  std::vector<Index> leaves_;  ///< node numbers, in item order
};

template <class Visit>
void BoxTree::visit_leaves(const Box& box, Index from, Visit&& visit) const {
  if (nodes_.empty()) return;
  Index stack[64];  // median splits keep the depth at log2 of the 2^31 items that ids allow
  int depth = 0;
  stack[depth++] = 0;
  while (depth > 0) {
    const Index n = stack[--depth];
    const Node& node = nodes_[static_cast<std::size_t>(n)];
    if (node.last <= from || !overlap(node.box, box)) continue;
    if (node.right == 0) {
      visit(node);
    } else {
      stack[depth++] = node.right;
      stack[depth++] = n + 1;
    }
  }
}

template <class Found>
void BoxTree::pairs_from_leaf(std::size_t leaf, Found&& found) const {
  const Node& own = nodes_[static_cast<std::size_t>(leaves_[leaf])];
  visit_leaves(own.box, own.first, [&](const Node& other) {
    for (Index i = own.first; i < own.last; ++i) {
      const Item& a = items_[static_cast<std::size_t>(i)];
      const Index begin = other.first == own.first ? i + 1 : other.first;
      for (Index j = begin; j < other.last; ++j) {
        const Item& b = items_[static_cast<std::size_t>(j)];
        if (overlap(a.box, b.box)) found(a.id, b.id);
      }
    }
  });
}

template <class Found>
void BoxTree::overlapping(const Box& box, Found&& found) const {
  visit_leaves(box, 0, [&](const Node& node) {
    for (Index i = node.first; i < node.last; ++i) {
      const Item& item = items_[static_cast<std::size_t>(i)];
      if (overlap(item.box, box)) found(item.id);
    }
  });
}

}  // namespace weft::lab
