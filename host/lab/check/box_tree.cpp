#include "host/lab/check/box_tree.hpp"

#include <algorithm>

namespace weft::lab {

Box join(const Box& a, const Box& b) noexcept {
  Box r = a;
  for (int k = 0; k < 3; ++k) {
    r.lo[k] = std::min(a.lo[k], b.lo[k]);
    r.hi[k] = std::max(a.hi[k], b.hi[k]);
  }
  return r;
}

BoxTree::BoxTree(const std::vector<Box>& boxes, const std::vector<Index>& ids) {
  items_.reserve(boxes.size());
  for (std::size_t i = 0; i < boxes.size(); ++i) items_.push_back({boxes[i], ids[i]});
  nodes_.reserve(boxes.size());
  if (!items_.empty()) build(0, static_cast<Index>(items_.size()));
}

void BoxTree::build(Index first, Index last) {
  const auto at = [this](Index i) { return items_.begin() + i; };
  // Halves are summed, not the sum halved: two coordinates near the largest double must not
  // overflow.
  const auto centre = [](const Box& b, int k) { return 0.5 * b.lo[k] + 0.5 * b.hi[k]; };

  Box box = at(first)->box;
  Box centres{{centre(box, 0), centre(box, 1), centre(box, 2)}, {}};
  centres.hi = centres.lo;
  for (Index i = first + 1; i < last; ++i) {
    const Box& b = at(i)->box;
    const Vec3<double> c{centre(b, 0), centre(b, 1), centre(b, 2)};
    box = join(box, b);
    centres = join(centres, {c, c});
  }

  const std::size_t self = nodes_.size();
  nodes_.push_back({box, first, last, 0});
  if (last - first <= leaf_size) {
    leaves_.push_back(static_cast<Index>(self));
    return;
  }
  int axis = 0;
  for (int k = 1; k < 3; ++k)
    if (centres.hi[k] - centres.lo[k] > centres.hi[axis] - centres.lo[axis]) axis = k;
  const Index middle = first + (last - first) / 2;
  std::nth_element(at(first), at(middle), at(last), [&](const Item& a, const Item& b) {
    return centre(a.box, axis) < centre(b.box, axis);
  });
  build(first, middle);
  nodes_[self].right = static_cast<Index>(nodes_.size());
  build(middle, last);
}

}  // namespace weft::lab
