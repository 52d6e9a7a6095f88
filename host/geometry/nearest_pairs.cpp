#include "host/geometry/nearest_pairs.hpp"

#include <algorithm>
#include <cstddef>
#include <limits>
#include <numeric>

#include "host/geometry/aabb.hpp"

namespace weft {
namespace {

/// Points in a tree of boxes, halved along their longest side.
class PointTree {
 public:
  explicit PointTree(const std::vector<Vec3<double>>& points) : points_(points) {
    order_.resize(points.size());
    std::iota(order_.begin(), order_.end(), Index{0});
    if (!points.empty()) build(0, points.size());
  }

  /// @pre there is a point
  Index nearest(const Vec3<double>& x) const {
    Best best;
    visit(0, x, best);
    return best.point;
  }

 private:
  struct Node {
    Aabb box;
    std::size_t first = 0, last = 0;    ///< into order_
    std::size_t lesser = 0, upper = 0;  ///< into nodes_; both 0 in a leaf
  };
  struct Best {
    double distance_sq = std::numeric_limits<double>::infinity();
    Index point = std::numeric_limits<Index>::max();
  };
  static constexpr std::size_t leaf_size = 8;

  const Vec3<double>& point(Index i) const { return points_[static_cast<std::size_t>(i)]; }

  std::size_t build(std::size_t first, std::size_t last) {
    Node node;
    node.first = first;
    node.last = last;
    for (std::size_t i = first; i < last; ++i) node.box.include(point(order_[i]));
    const std::size_t here = nodes_.size();
    nodes_.push_back(node);
    if (last - first <= leaf_size) return here;
    const Vec3<double> size = node.box.size();
    int axis = 0;
    for (int k = 1; k < 3; ++k)
      if (size[k] > size[axis]) axis = k;
    const std::size_t middle = first + (last - first) / 2;
    const auto begin = order_.begin();
    std::nth_element(begin + static_cast<std::ptrdiff_t>(first),
                     begin + static_cast<std::ptrdiff_t>(middle),
                     begin + static_cast<std::ptrdiff_t>(last),
                     [&](Index i, Index j) { return point(i)[axis] < point(j)[axis]; });
    const std::size_t lesser = build(first, middle);
    const std::size_t upper = build(middle, last);
    nodes_[here].lesser = lesser;
    nodes_[here].upper = upper;
    return here;
  }

  static double distance_sq(const Node& node, const Vec3<double>& x) {
    Vec3<double> gap{};
    for (int k = 0; k < 3; ++k)
      gap[k] = std::max({node.box.lo[k] - x[k], x[k] - node.box.hi[k], 0.0});
    return dot(gap, gap);
  }

  void visit(std::size_t number, const Vec3<double>& x, Best& best) const {
    const Node& node = nodes_[number];
    if (distance_sq(node, x) > best.distance_sq) return;
    if (node.upper == 0) {
      for (std::size_t k = node.first; k < node.last; ++k) {
        const Index i = order_[k];
        const Vec3<double> gap = point(i) - x;
        const double distance = dot(gap, gap);
        if (distance < best.distance_sq || (distance == best.distance_sq && i < best.point))
          best = {distance, i};
      }
      return;
    }
    std::size_t near = node.lesser;
    std::size_t far = node.upper;
    if (distance_sq(nodes_[far], x) < distance_sq(nodes_[near], x)) std::swap(near, far);
    visit(near, x, best);
    visit(far, x, best);
  }

  const std::vector<Vec3<double>>& points_;
  std::vector<Index> order_;
  std::vector<Node> nodes_;
};

}  // namespace

std::vector<std::pair<Index, Index>> nearest_pairs(const std::vector<Vec3<double>>& a,
                                                   const std::vector<Vec3<double>>& b) {
  std::vector<std::pair<Index, Index>> pairs;
  if (a.empty() || b.empty()) return pairs;
  const PointTree in_a(a);
  const PointTree in_b(b);
  for (std::size_t i = 0; i < a.size(); ++i) {
    const Index j = in_b.nearest(a[i]);
    if (in_a.nearest(b[static_cast<std::size_t>(j)]) == static_cast<Index>(i))
      pairs.emplace_back(static_cast<Index>(i), j);
  }
  return pairs;
}

}  // namespace weft
