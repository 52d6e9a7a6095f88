// What must not matter: the unit of length, and where the origin is.
#include <fmt/format.h>

#include <cmath>
#include <cstdint>
#include <limits>
#include <utility>

#include "benchmarks/stability/run.hpp"
#include "host/base/random.hpp"

namespace weft::stability {
namespace {

/// The same motion s times as large: lengths times s and times as they are make accelerations s
/// times as large; with the same mass per area, energies s^4 times, so that stretch stiffness
/// (energy an area) takes s^2 and bending stiffness (energy) s^4.
Scene scaled(Scene scene, double s) {
  scene.gravity = s * scene.gravity;
  for (Material& m : scene.materials) {
    m.stretch_stiffness *= s * s;
    m.bending_stiffness *= s * s * s * s;
  }
  for (Cloth& cloth : scene.cloths) {
    for (auto& x : cloth.mesh.positions) x = s * x;
    for (auto& x : cloth.mesh.material) x = s * x;
  }
  for (Obstacle& obstacle : scene.obstacles)
    for (auto& x : obstacle.mesh.positions) x = s * x;
  for (CameraKey& key : scene.camera.keys) {
    key.position = s * key.position;
    key.look_at = s * key.look_at;
  }
  scene.view.margin *= s;
  scene.time_parallel.recovery_factor *= s;  // iterations are that over a length
  scene.contact.thickness *= s;
  scene.asynchronous.stiffness *= s * s;
  scene.adaptive.remeshing.refine_compression *= s;
  scene.adaptive.remeshing.refine_velocity *= s;
  return scene;
}

void scale(const Setup& setup, Scene scene, double s, int steps) {
  scene.precision = Precision::double_precision;
  jitter(scene, setup);
  const Mesh larger = cloth_mesh(run(scaled(scene, s), setup, steps));
  Mesh expected = cloth_mesh(run(std::move(scene), setup, steps));
  for (auto& x : expected.positions) x = s * x;
  for (auto& x : expected.material) x = s * x;
  require_at_most(largest_distance(larger, expected) / (s * side), 1e-12,
                  "distance from the scene that was not scaled, over L");
}

/// By how much a scene ends elsewhere if its cloths start off by what places that far away are
/// rounded by, over L: what no method can be asked to stay below there.
double departure_by_rounding(const Setup& setup, const Scene& scene, double distance, int steps) {
  const bool single = scene.precision == Precision::single_precision;
  const double grain = distance * (single ? std::numeric_limits<float>::epsilon()
                                          : std::numeric_limits<double>::epsilon());
  Scene shaken = scene;
  std::uint64_t state = setup.seed;
  for (Cloth& cloth : shaken.cloths)
    for (auto& x : cloth.mesh.positions)
      for (int c = 0; c < 3; ++c) x[c] += grain * next_random(state);
  const Mesh there = cloth_mesh(run(std::move(shaken), setup, steps));
  return largest_distance(there, cloth_mesh(run(scene, setup, steps))) / side;
}

void far_away(const Setup& setup, Scene scene, Precision precision, double tolerance, int steps) {
  if (setup.method != "asynchronous") scene.precision = precision;
  jitter(scene, setup);
  const Vec3<double> away{1e3 * side, -1e3 * side, 1e3 * side};
  Scene moved = scene;
  for (Cloth& cloth : moved.cloths)
    for (auto& x : cloth.mesh.positions) x += away;
  for (Obstacle& obstacle : moved.obstacles) obstacle.transform.translate += away;
  for (CameraKey& key : moved.camera.keys) {
    key.position += away;
    key.look_at += away;
  }
  const Mesh there = cloth_mesh(run(std::move(moved), setup, steps));
  Mesh expected = cloth_mesh(run(scene, setup, steps));
  for (auto& x : expected.positions) x += away;
  const double distance = largest_distance(there, expected) / side;
  if (!(distance <= tolerance))
    throw Wrong(fmt::format(
        "distance from the scene at the origin, over L is {:.4g}, not {:g} at most; there, a start "
        "that is off by the rounding here makes {:.4g}",
        distance, tolerance, departure_by_rounding(setup, scene, length(away), steps)));
}

}  // namespace

std::vector<Case> invariance_cases() {
  return {
      {"scaled_1024_free",
       "a curtain 1,024 times as large in all lengths: the same to 1e-12 L, double",
       [](const Setup& s) { scale(s, curtain(s, 0.005, 8), 1024, 40); }},
      {"scaled_1024", "the same for a sheet on a sphere",
       [](const Setup& s) { scale(s, sheet_on_sphere(s, 0.005), 1024, 40); }},
      {"scaled_1_1024", "the same, 1,024 times smaller",
       [](const Setup& s) { scale(s, sheet_on_sphere(s, 0.005), 1.0 / 1024, 40); }},
      {"far_away_free", "a curtain 1,000 L away from the origin: the same to 1e-8 L, double",
       [](const Setup& s) {
         far_away(s, curtain(s, 0.005, 8), Precision::double_precision, 1e-8, 40);
       }},
      {"far_away", "a sheet on a sphere 1,000 L away: the same to 1e-6 L, double",
       [](const Setup& s) {
         far_away(s, sheet_on_sphere(s, 0.005), Precision::double_precision, 1e-6, 40);
       }},
      {"far_away_float", "the same to 1e-2 L in the method's usual precision",
       [](const Setup& s) {
         far_away(s, sheet_on_sphere(s, 0.005), Precision::single_precision, 1e-2, 40);
       }},
  };
}

}  // namespace weft::stability
