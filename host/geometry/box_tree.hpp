#pragma once

#include <algorithm>
#include <cstddef>
#include <limits>
#include <vector>

#include "host/geometry/aabb.hpp"
#include "weft/core/ids.hpp"
#include "weft/core/span.hpp"
#include "weft/core/vec.hpp"

namespace weft {

/// Boxes of a run of triangles as a complete binary tree, halved by the median along the longest
/// side, so that its depth is bounded whatever the sizes of the triangles. Node k has the children
/// 2k and 2k + 1; nodes from leaf_count on are leaves of at most four triangles.
struct BoxTree {
  struct Item {
    Aabb box;
    Index triangle;
    double centre_twice(int axis) const { return box.lo[axis] + box.hi[axis]; }
  };
  std::vector<Item> items;
  std::vector<Aabb> nodes;
  std::vector<std::size_t> leaf_first;  ///< [leaf_count + 1] into items
  std::size_t leaf_count = 1;
  /// Pairs of triangles are visited only where one of them is awake; all are at first.
  std::vector<unsigned char> item_awake;  ///< [items]
  std::vector<unsigned char> node_awake;  ///< [nodes] any item below

  /// @param points       [m]
  /// @param triangles    all of them; the tree holds numbers first .. last - 1
  /// @param relative_pad boxes are larger than triangles by this share of their longest side
  BoxTree(Span<const Vec3<double>> points, Span<const Tri> triangles, Index first, Index last,
          double relative_pad);

  /// Recomputes the boxes after the points have moved. The tree's shape stays.
  /// @param points       [m]   @param triangles as given to the constructor
  /// @param pad          [m] boxes are larger than triangles by this
  /// @param point_awake  [points] triangles with such a corner are awake
  void refit(Span<const Vec3<double>> points, Span<const Tri> triangles, double pad,
             Span<const unsigned char> point_awake);
  /// @param pads [triangles] [m] of each its own
  void refit(Span<const Vec3<double>> points, Span<const Tri> triangles, Span<const double> pads,
             Span<const unsigned char> point_awake);

 private:
  /// A node and the run of items below it.
  struct Run {
    std::size_t node, first, last;
  };
  template <class PadOf>
  void refit_by(Span<const Vec3<double>> points, Span<const Tri> triangles, const PadOf& pad_of,
                Span<const unsigned char> point_awake);
  void build_all();
  std::size_t halve(const Run& run);
  void build(const Run& run);
};

/// Calls visit(triangle of s, triangle of t) where boxes below node a of s and node b of t overlap.
template <class Visit>
void visit_pairs(const BoxTree& s, std::size_t a, const BoxTree& t, std::size_t b, Visit& visit) {
  if (s.node_awake[a] == 0 && t.node_awake[b] == 0) return;
  if (!s.nodes[a].overlaps(t.nodes[b])) return;
  const bool a_leaf = a >= s.leaf_count;
  const bool b_leaf = b >= t.leaf_count;
  if (a_leaf && b_leaf) {
    for (std::size_t i = s.leaf_first[a - s.leaf_count]; i < s.leaf_first[a - s.leaf_count + 1];
         ++i)
      for (std::size_t j = t.leaf_first[b - t.leaf_count]; j < t.leaf_first[b - t.leaf_count + 1];
           ++j)
        if ((s.item_awake[i] != 0 || t.item_awake[j] != 0) &&
            s.items[i].box.overlaps(t.items[j].box))
          visit(s.items[i].triangle, t.items[j].triangle);
  } else if (b_leaf || (!a_leaf && a <= b)) {
    visit_pairs(s, 2 * a, t, b, visit);
    visit_pairs(s, 2 * a + 1, t, b, visit);
  } else {
    visit_pairs(s, a, t, 2 * b, visit);
    visit_pairs(s, a, t, 2 * b + 1, visit);
  }
}

/// The same for each two triangles of one tree, once.
template <class Visit>
void visit_own_pairs(const BoxTree& t, std::size_t node, Visit& visit) {
  if (t.node_awake[node] == 0) return;
  if (node < t.leaf_count) {
    visit_own_pairs(t, 2 * node, visit);
    visit_own_pairs(t, 2 * node + 1, visit);
    visit_pairs(t, 2 * node, t, 2 * node + 1, visit);
    return;
  }
  const std::size_t last = t.leaf_first[node - t.leaf_count + 1];
  for (std::size_t i = t.leaf_first[node - t.leaf_count]; i < last; ++i)
    for (std::size_t j = i + 1; j < last; ++j)
      if ((t.item_awake[i] != 0 || t.item_awake[j] != 0) && t.items[i].box.overlaps(t.items[j].box))
        visit(t.items[i].triangle, t.items[j].triangle);
}

/// Calls visit(triangle) for each one below node `a` whose box overlaps `box`.
template <class Visit>
void visit_overlaps(const BoxTree& t, std::size_t a, const Aabb& box, Visit& visit) {
  if (!t.nodes[a].overlaps(box)) return;
  if (a < t.leaf_count) {
    visit_overlaps(t, 2 * a, box, visit);
    visit_overlaps(t, 2 * a + 1, box, visit);
    return;
  }
  for (std::size_t i = t.leaf_first[a - t.leaf_count]; i < t.leaf_first[a - t.leaf_count + 1]; ++i)
    if (t.items[i].box.overlaps(box)) visit(t.items[i].triangle);
}

}  // namespace weft
