#include "host/untangle/untangle_scene.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdio>
#include <string>
#include <utility>
#include <vector>

#include "host/model/material_points.hpp"
#include "host/scene/intersection_check.hpp"
#include "host/scene/seams/sewing.hpp"
#include "host/scene/surfaces.hpp"
#include "host/scene/tangled_start.hpp"
#include "host/untangle/untangle.hpp"
#include "weft/core/at.hpp"

namespace weft {
namespace {

/// Masses of cloth by the area it covers, which only says how motions are shared out.
void weigh(const Scene& scene, IntersectingSurfaces& s) {
  std::vector<double> mass(s.points.size(), 0);
  std::size_t t = 0;
  for (const Cloth& cloth : scene.cloths)
    for (std::size_t local = 0; local < cloth.mesh.triangles.size(); ++local, ++t) {
      const Index material =
          cloth.triangle_material.empty() ? cloth.material : cloth.triangle_material[local];
      const Tri& tri = s.triangles[t];
      const Vec3<double>& a = s.points[at(tri.v[0])];
      const double area = length(cross(s.points[at(tri.v[1])] - a, s.points[at(tri.v[2])] - a)) / 2;
      for (const Index v : tri.v) mass[at(v)] += scene.materials[at(material)].density * area / 3;
    }
  s.inverse_mass.assign(s.points.size(), 0);
  for (std::size_t v = 0; v < mass.size(); ++v)
    if (mass[v] > 0) s.inverse_mass[v] = 1 / mass[v];
}

/// Holds what pins hold at the start.
void hold_pinned(const Scene& scene, const std::vector<Index>& joined, IntersectingSurfaces& s) {
  const std::vector<Index> offsets = input_offsets(scene);
  for (const Pin& pin : scene.pins)
    for (const Index v : pin.vertices)
      s.inverse_mass[at(joined[at(offsets[at(pin.cloth)] + v)])] = 0;
}

/// Where cloth lies at rest, and by how much it is compressed.
void lay_out(const Scene& scene, IntersectingSurfaces& s) {
  SheetsAtRest& rest = s.rest;
  std::size_t t = 0;
  for (std::size_t c = 0; c < scene.cloths.size(); ++c) {
    const Mesh& mesh = scene.cloths[c].mesh;
    append_material_points(mesh, rest.points);
    rest.cloth.resize(rest.points.size(), static_cast<Index>(c));
    rest.compression.resize(rest.points.size(), 1);
    for (std::size_t local = 0; local < mesh.triangles.size(); ++local, ++t) {
      const std::array<Vec2<double>, 3> corners = material_corners(mesh, local);
      for (std::size_t j = 0; j < 3; ++j) {
        const std::size_t k = (j + 1) % 3;
        const auto a = at(s.triangles[t].v[j]), b = at(s.triangles[t].v[k]);
        const double share = length(s.points[b] - s.points[a]) / length(corners[k] - corners[j]);
        rest.compression[a] = std::min(rest.compression[a], share);
        rest.compression[b] = std::min(rest.compression[b], share);
      }
    }
  }
}

IntersectingSurfaces intersecting_surfaces(const Scene& scene,
                                           const std::vector<unsigned char>& welded,
                                           const std::vector<Index>& joined) {
  const Surfaces all = surfaces_at_start(scene, welded);
  IntersectingSurfaces s;
  s.points = all.points;
  s.triangles = all.triangles;
  s.cloth_triangle_count = all.first_triangle[scene.cloths.size()];
  s.self = scene.contact.self;
  for (std::size_t mesh = 0; mesh + 1 < all.first_triangle.size(); ++mesh) {
    s.mesh.resize(at(all.first_triangle[mesh + 1]), static_cast<Index>(mesh));
    s.solid.push_back(mesh >= scene.cloths.size() &&
                      is_closed(scene.obstacles[mesh - scene.cloths.size()].mesh));
  }
  lay_out(scene, s);
  weigh(scene, s);
  hold_pinned(scene, joined, s);
  return s;
}

/// Such as "0.123".
std::string text_of(double metres) {
  char text[32];
  std::snprintf(text, sizeof text, "%.3g", metres + 0.0);
  return text;
}

/// One contour that is left.
struct Remains {
  double length = 0;            ///< [m]
  Vec3<double> place;           ///< [m] on it
  std::array<Index, 2> meshes;  ///< that meet there, the lower number first
};

/// The longest first.
std::vector<Remains> remains_of(const IntersectingSurfaces& s, const Contours& c) {
  std::vector<Remains> all(at(c.count));
  for (const ContourArc& arc : c.arcs) {
    Remains& r = all[at(c.number[at(arc.piercing[0])])];
    if (r.length == 0) {
      r.place = c.piercings[at(arc.piercing[0])].point;
      const auto [low, high] =
          std::minmax(s.mesh[at(arc.triangle[0])], s.mesh[at(arc.triangle[1])]);
      r.meshes = {low, high};
    }
    r.length += arc.length;
  }
  std::erase_if(all, [](const Remains& r) { return r.length == 0; });
  std::stable_sort(all.begin(), all.end(),
                   [](const Remains& a, const Remains& b) { return a.length > b.length; });
  return all;
}

std::string place_of(const Remains& r, const Vec3<double>& origin) {
  const Vec3<double> x = r.place + origin;
  return "(" + text_of(x[0]) + ", " + text_of(x[1]) + ", " + text_of(x[2]) + ")";
}

/// Names the longest contours that are left.
std::string describe(const Scene& scene, const std::vector<Remains>& remains,
                     const UntangleReport& report) {
  constexpr std::size_t shown_max = 3;
  if (remains.empty()) return ", after untangling, which leaves triangles that touch";
  std::string text = ", after untangling, which leaves " + text_of(report.left.length()) + " of " +
                     text_of(report.contour_length.front()) + " m of contour: ";
  for (std::size_t i = 0; i < std::min(remains.size(), shown_max); ++i) {
    const Remains& r = remains[i];
    text += (i > 0 ? ", " : "") + text_of(r.length) + " m ";
    text += r.meshes[0] == r.meshes[1] ? "within " + name_of(scene, at(r.meshes[0]))
                                       : "between " + name_of(scene, at(r.meshes[0])) + " and " +
                                             name_of(scene, at(r.meshes[1]));
    text += " at " + place_of(r, scene.origin.value_or(Vec3<double>{0, 0, 0}));
  }
  if (remains.size() > shown_max)
    text += ", and " + std::to_string(remains.size() - shown_max) + " shorter ones";
  return text;
}

/// Cloths and obstacles as they are now.
Frame frame_of(const Scene& scene, const Surfaces& surfaces) {
  Frame frame;
  frame.origin = scene.origin.value_or(Vec3<double>{0, 0, 0});
  for (const Cloth& cloth : scene.cloths) frame.cloth_positions.push_back(cloth.mesh.positions);
  for (std::size_t mesh = scene.cloths.size(); mesh + 1 < surfaces.first_point.size(); ++mesh)
    frame.obstacle_positions.emplace_back(surfaces.points.begin() + surfaces.first_point[mesh],
                                          surfaces.points.begin() + surfaces.first_point[mesh + 1]);
  frame.displaced_obstacle_positions.resize(scene.obstacles.size());
  return frame;
}

}  // namespace

void untangle_start(Scene& scene, const std::vector<unsigned char>& welded,
                    std::function<void()> each_round) {
  const std::vector<Index> joined = joined_inputs(scene, welded);
  IntersectingSurfaces surfaces = intersecting_surfaces(scene, welded, joined);
  const std::vector<Vec3<double>> before = surfaces.points;
  const UntangleReport report = untangle(
      surfaces, {.gap = contact_thickness(scene.contact), .each_round = std::move(each_round)});
  std::size_t input = 0;
  for (Cloth& cloth : scene.cloths)
    for (Vec3<double>& x : cloth.mesh.positions) {
      const auto v = at(joined[input++]);
      if (!(surfaces.points[v] == before[v])) x = surfaces.points[v];
    }
  if (report.left.empty()) return;
  const std::vector<Remains> remains = remains_of(surfaces, report.left);
  try {
    refuse_intersecting_start(scene, welded, describe(scene, remains, report));
  } catch (const SceneError& error) {
    const Vec3<double> place =
        remains.empty()
            ? surfaces.points[at(surfaces.triangles[at(report.left.touching[0].first)].v[0])]
            : remains[0].place;
    throw TangledStart(error.what(), scene, frame_of(scene, surfaces_at_start(scene, welded)),
                       place);
  }
}

}  // namespace weft
