#include "host/implicit/sleep/rest_boxes.hpp"

#include <utility>

#include "host/geometry/box_tree.hpp"

namespace weft {

RestBoxes::RestBoxes() = default;
RestBoxes::RestBoxes(RestBoxes&&) noexcept = default;
RestBoxes& RestBoxes::operator=(RestBoxes&&) noexcept = default;
RestBoxes::~RestBoxes() = default;

RestBoxes::RestBoxes(Span<const Vec3<double>> points, const std::vector<Tri>& triangles,
                     std::vector<Index> piece, double reach)
    : tree_(std::make_unique<BoxTree>(points, triangles, 0, static_cast<Index>(triangles.size()),
                                      0.0)),
      piece_(std::move(piece)) {
  const std::vector<unsigned char> awake(points.size(), 1);
  tree_->refit(points, triangles, reach, awake);
}

void RestBoxes::mark(const Vec3<double>& low, const Vec3<double>& high,
                     std::vector<unsigned char>& near) const {
  if (!tree_) return;
  Aabb box;
  box.include(low, high);
  auto visit = [&](Index t) {
    near[static_cast<std::size_t>(piece_[static_cast<std::size_t>(t)])] = 1;
  };
  visit_overlaps(*tree_, 1, box, visit);
}

}  // namespace weft
