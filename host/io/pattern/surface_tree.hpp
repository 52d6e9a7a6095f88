#pragma once

#include "host/geometry/box_tree.hpp"
#include "host/geometry/triangle_pair.hpp"
#include "weft/core/at.hpp"
#include "weft/scene.hpp"

namespace weft::io {

/// A surface in which triangles are looked up by place.
class SurfaceTree {
 public:
  /// @param surface [m] kept by reference; at least one triangle
  explicit SurfaceTree(const Mesh& surface)
      : surface_(surface),
        tree_({surface.positions.data(), surface.positions.size()},
              {surface.triangles.data(), surface.triangles.size()}, Index{0},
              static_cast<Index>(surface.triangles.size()), 1e-9) {}

  /// Corners of a triangle of the surface. [m]
  Corners corners(Index triangle) const {
    const auto& v = surface_.triangles[at(triangle)].v;
    return {surface_.positions[at(v[0])], surface_.positions[at(v[1])],
            surface_.positions[at(v[2])]};
  }

  /// Calls visit(triangle) for each one whose box overlaps a box.
  template <class Visit>
  void visit_boxes(const Aabb& box, Visit& visit) const {
    visit_overlaps(tree_, 1, box, visit);
  }

  /// Calls visit(triangle) for each one that meets a triangle of another mesh.
  template <class Visit>
  void visit_meeting(const Corners& other, Visit&& visit) const {
    Aabb box;
    for (const Vec3<double>& corner : other) box.include(corner);
    auto test = [&](Index t) {
      const Corners there = corners(t);
      if (!plainly_apart(other, there, 0) &&
          triangles_intersect({{0, 1, 2}}, {{3, 4, 5}}, other, there))
        visit(t);
    };
    visit_overlaps(tree_, 1, box, test);
  }

 private:
  const Mesh& surface_;
  BoxTree tree_;
};

}  // namespace weft::io
