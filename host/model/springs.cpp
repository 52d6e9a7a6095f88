#include "host/model/springs.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "host/geometry/similarity.hpp"
#include "host/scene/origin.hpp"
#include "host/scene/seams/sewing.hpp"
#include "weft/core/at.hpp"

namespace weft {
namespace {

/// Material coordinates by vertex; where pieces of a pattern meet, those in the first triangle.
std::vector<Vec2<double>> material_by_vertex(const Mesh& mesh) {
  if (mesh.material_triangles.empty()) return mesh.material;
  std::vector<Vec2<double>> material(mesh.positions.size());
  for (std::size_t t = mesh.triangles.size(); t-- > 0;)
    for (int j = 0; j < 3; ++j)
      material[at(mesh.triangles[t].v[j])] = mesh.material[at(mesh.material_triangles[t].v[j])];
  return material;
}

/// Where the vertices of a handle are drawn to, before its motion. [m]
std::vector<Vec3<double>> places_of(const Handle& handle, const Mesh& mesh) {
  std::vector<Vec3<double>> places;
  if (handle.shape != Handle::Shape::circle) {
    for (const Index v : handle.vertices) places.push_back(mesh.positions[at(v)]);
    return places;
  }
  const double radius = handle.circumference / (2 * std::numbers::pi);
  const std::vector<Vec2<double>> material = material_by_vertex(mesh);
  for (const Index v : handle.vertices) {
    const double angle = dot(material[at(v)], handle.direction) / radius;
    places.push_back(handle.center +
                     radius * (std::cos(angle) * handle.axis0 + std::sin(angle) * handle.axis1));
  }
  return places;
}

/// How the surface that carries a handle has moved since time 0.
/// @param placed obstacles at `time`; filled if it is empty
Similarity motion_of(const Handle::Carrier& carrier, const Scene& scene, const Model& model,
                     double time, std::vector<Vec3<double>>& placed) {
  if (placed.empty()) place_obstacles(scene, model, time, placed);
  std::vector<Vec3<double>> end;
  for (const Index v : carrier.vertices)
    end.push_back(placed[at(model.obstacle_offset[at(carrier.obstacle)] + v)]);
  return fitted_similarity(carrier.start, end);
}

/// @param placed see motion_of()
void add_handle(const Scene& scene, const Model& model, const Handle& handle, double time,
                std::vector<Vec3<double>>& placed, std::vector<Spring<double>>& springs) {
  const double stiffness = handle.stiffness * handle_strength(handle, time);
  if (!(stiffness > 0)) return;
  const Index first = model.input_offset[at(handle.cloth)];
  const auto internal = [&](Index v) { return model.to_internal[at(first + v)]; };
  if (handle.shape == Handle::Shape::glue) {
    const Index a = internal(handle.vertices[0]);
    const Index b = internal(handle.vertices[1]);
    if (a != b)
      springs.push_back({{a, b}, {}, stiffness, contact_thickness(scene.contact) / 2, {}});
    return;
  }
  const auto places = places_of(handle, scene.cloths[at(handle.cloth)].mesh);
  const double size = length(handle.along);
  const Vec3<double> along = size > 0 ? handle.along * (1 / size) : Vec3<double>{0, 0, 0};
  std::optional<Similarity> carried;
  Vec3<double> turned{0, 0, 0};
  if (handle.carrier.obstacle >= 0) {
    carried = motion_of(handle.carrier, scene, model, time, placed);
    turned = ((*carried)(along) - (*carried)({0, 0, 0})) * (1 / carried->scale);
  }
  for (std::size_t k = 0; k < places.size(); ++k) {
    if (internal(handle.vertices[k]) < 0) continue;  // of a part of a model: not in it
    Vec3<double> place = handle.motion.empty() ? places[k]
                                               : apply_in_world(transform_at(handle.motion, time),
                                                                places[k], origin_of(scene));
    if (!carried) {
      springs.push_back({{internal(handle.vertices[k]), -1}, place, stiffness, 0, along});
      continue;
    }
    // Only its place along the direction counts, which is to turn about the vertex.
    if (size > 0) place = places[k] + along * dot(along, place - places[k]);
    springs.push_back(
        {{internal(handle.vertices[k]), -1}, (*carried)(place), stiffness, 0, turned});
  }
}

/// Share of ramp_time in which a seam's dashpots would let a gap without inertia shrink to 1/e.
/// Without them, springs throw panels into each other. With 0.04 fine meshes have fewer collisions
/// still, but from 0.015 on edges of other panels may get between those that are sewn, and stay.
constexpr double relaxation_share = 0.01;

/// @param full [pairs] [N/m] at the end of the ramp
/// @param step [s] see springs_at()
void add_seam(const Scene& scene, const Model& model, const Seam& seam, const double* full,
              double time, double step, std::vector<Spring<double>>& springs) {
  const double strength = seam_strength(seam, time);
  if (!(strength > 0)) return;
  const double drag_share = relaxation_share * seam.ramp_time / step;
  const double slack = seam.weld_distance > 0 ? 0 : contact_thickness(scene.contact) / 2;
  for (std::size_t k = 0; k < seam.vertices[0].size(); ++k) {
    Index v[2];
    for (int side = 0; side < 2; ++side)
      v[side] =
          model.to_internal[at(model.input_offset[at(seam.cloths[side])] + seam.vertices[side][k])];
    const double stiffness = full[k] * strength;
    if (v[0] != v[1])
      springs.push_back({{v[0], v[1]}, {}, stiffness, slack, {}, drag_share * stiffness});
  }
}

}  // namespace

double handle_strength(const Handle& handle, double time) {
  if (time < handle.start_time) return 0;
  if (time <= handle.end_time) return 1;
  if (!(handle.fade_time > 0)) return 0;
  return std::max(0.0, 1 - (time - handle.end_time) / handle.fade_time);
}

double seam_strength(const Seam& seam, double time) {
  if (time < seam.start_time) return 0;
  if (!(seam.ramp_time > 0)) return 1;
  double share = (time - seam.start_time) / seam.ramp_time;
  if (!(time < seam.start_time + seam.ramp_time)) {
    const bool must_weld = seam.weld_distance > 0 && !seam.may_stay_open;
    share = must_weld ? std::clamp(share, 1.0, longest_pull) : 1;
  }
  return share * share * share;
}

std::vector<Spring<double>> springs_at(const Scene& scene, const Model& model, double time,
                                       double step) {
  std::vector<Spring<double>> springs;
  std::vector<Vec3<double>> placed;
  for (const Handle& handle : scene.handles)
    add_handle(scene, model, handle, time, placed, springs);
  const double* full = model.seam_stiffness.data();
  for (const Seam& seam : scene.seams) {
    add_seam(scene, model, seam, full, time, step, springs);
    full += seam.vertices[0].size();
  }
  return springs;
}

std::vector<Spring<double>> springs_of(const Scene& scene, const Model& model, const Handle& handle,
                                       double time) {
  std::vector<Spring<double>> springs;
  std::vector<Vec3<double>> placed;
  add_handle(scene, model, handle, time, placed, springs);
  return springs;
}

bool any_seam_open(const Scene& scene, const Model& model) {
  const std::vector<SeamPair> pairs = seam_pairs(scene);
  return std::any_of(pairs.begin(), pairs.end(), [&](const SeamPair& pair) {
    return model.to_internal[at(pair.v[0])] != model.to_internal[at(pair.v[1])];
  });
}

}  // namespace weft
