#include "host/io/pattern/inner_layers.hpp"

#include <algorithm>
#include <cstddef>
#include <limits>
#include <utility>

#include "host/geometry/aabb.hpp"
#include "host/io/pattern/surface_tree.hpp"
#include "weft/core/at.hpp"
#include "weft/elements/distance.hpp"

namespace weft::io {
namespace {

constexpr double layer_gap = 0.01;   ///< [m] between layers at the start
constexpr double reach = 0.06;       ///< [m] from which points are lifted
constexpr int lift_rounds = 3;       ///< cloth may lie on cloth several times
constexpr double push_step = 0.005;  ///< [m]
constexpr int push_rounds = 40;

Vec3<double> area_normal(const Mesh& mesh, const Tri& t) {
  const auto x = [&](int k) { return mesh.positions[at(t.v[k])]; };
  return cross(x(1) - x(0), x(2) - x(0));
}

/// Moves a point that lies beneath the nearest inner cloth, or on it, to its outer side.
void lift_point(const SurfaceTree& inner, const Mesh& mesh, Vec3<double>& p) {
  Aabb box;
  for (const double side : {-reach, reach}) box.include(p + Vec3<double>{side, side, side});
  double least = reach * reach;
  Vec3<double> difference{0, 0, 0}, normal{0, 0, 0};
  auto visit = [&](Index t) {
    const Corners there = inner.corners(t);
    const Vec3<double> corners[4]{p, there[0], there[1], there[2]};
    const Proximity<double> nearest = vertex_triangle(corners);
    if (nearest.distance_sq >= least) return;
    const Vec3<double> n = area_normal(mesh, mesh.triangles[at(t)]);
    if (!(length(n) > 0)) return;
    least = nearest.distance_sq;
    difference = nearest.difference;
    normal = n * (1 / length(n));
  };
  inner.visit_boxes(box, visit);
  const double height = dot(difference, normal);
  if (least < reach * reach && height < layer_gap) p += normal * (layer_gap - height);
}

}  // namespace

/// Unit normal of a panel that looks away from what of the body is nearest to its middle.
Vec3<double> InnerLayers::outward(const Garment& garment, const GarmentPanel& panel) const {
  const Mesh& mesh = garment.mesh;
  Vec3<double> normal{0, 0, 0}, middle{0, 0, 0};
  for (Index t = 0; t < panel.triangle_count; ++t)
    normal += area_normal(mesh, mesh.triangles[at(panel.first_triangle + t)]);
  for (Index v = 0; v < panel.vertex_count; ++v)
    middle += mesh.positions[at(panel.first_vertex + v)] * (1.0 / panel.vertex_count);
  Vec3<double> away = normal;
  double least = std::numeric_limits<double>::infinity();
  for (const Vec3<double>& p : body_.positions)
    if (length_sq(middle - p) < least) {
      least = length_sq(middle - p);
      away = middle - p;
    }
  const double size = length(normal);
  if (!(size > 0)) return {0, 0, 0};
  return normal * ((dot(normal, away) < 0 ? -1 : 1) / size);
}

void InnerLayers::add(const Garment& garment) {
  const auto first = static_cast<Index>(mesh_.positions.size());
  const Mesh& mesh = garment.mesh;
  mesh_.positions.insert(mesh_.positions.end(), mesh.positions.begin(), mesh.positions.end());
  for (const GarmentPanel& panel : garment.panels) {
    const Vec3<double> out = outward(garment, panel);
    double along = 0;
    for (Index t = 0; t < panel.triangle_count; ++t)
      along += dot(area_normal(mesh, mesh.triangles[at(panel.first_triangle + t)]), out);
    for (Index t = 0; t < panel.triangle_count; ++t) {
      Tri tri = mesh.triangles[at(panel.first_triangle + t)];
      for (Index& v : tri.v) v += first;
      if (along < 0) std::swap(tri.v[1], tri.v[2]);
      mesh_.triangles.push_back(tri);
    }
  }
}

void InnerLayers::stand_outside(Garment& garment) const {
  if (empty() || body_.positions.empty()) return;
  for (const GarmentPanel& panel : garment.panels) {
    const Vec3<double> out = outward(garment, panel);
    const auto begin = garment.mesh.positions.begin() + panel.first_vertex;
    const auto end = begin + panel.vertex_count;
    // Inner cloth within the panel's box, seen along its normal.
    const auto flat = [&](const Vec3<double>& p) { return p - out * dot(p, out); };
    Aabb box;
    for (auto p = begin; p != end; ++p) box.include(flat(*p));
    double shift = 0;
    for (const Vec3<double>& p : mesh_.positions) {
      const Vec3<double> q = flat(p);
      bool within = true;
      for (int k = 0; k < 3; ++k)
        within = within && q[k] >= box.lo[k] - layer_gap && q[k] <= box.hi[k] + layer_gap;
      if (within) shift = std::max(shift, dot(p - *begin, out) + layer_gap);
    }
    for (auto p = begin; p != end; ++p) *p += out * shift;
  }
}

void InnerLayers::lift(const std::vector<Tri>& cloth, std::vector<Vec3<double>>& x) const {
  if (empty()) return;
  const SurfaceTree inner(mesh_);
  for (int round = 0; round < lift_rounds; ++round)
    for (Vec3<double>& p : x) lift_point(inner, mesh_, p);
  // Points are outside now where inner cloth is near; triangles between them may still meet it.
  for (int round = 0; round < push_rounds; ++round) {
    std::vector<Vec3<double>> push(x.size(), Vec3<double>{0, 0, 0});
    bool any = false;
    for (const Tri& t : cloth)
      inner.visit_meeting({x[at(t.v[0])], x[at(t.v[1])], x[at(t.v[2])]}, [&](Index other) {
        const Vec3<double> n = area_normal(mesh_, mesh_.triangles[at(other)]);
        if (!(length(n) > 0)) return;
        for (const Index v : t.v) push[at(v)] += n * (1 / length(n));
        any = true;
      });
    if (!any) return;
    for (std::size_t v = 0; v < x.size(); ++v)
      if (length(push[v]) > 0) x[v] += push[v] * (push_step / length(push[v]));
  }
}

}  // namespace weft::io
