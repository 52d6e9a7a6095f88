// What must not matter: the unit of length, and where the origin is.
#include <fmt/format.h>

#include <cmath>
#include <utility>

#include "benchmarks/stability/run.hpp"

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
  scene.contact.thickness = s * contact_thickness(scene.contact);
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

constexpr Vec3<double> away{1e3 * side, -1e3 * side, 1e3 * side};

Scene moved_away(Scene scene) {
  for (Cloth& cloth : scene.cloths)
    for (auto& x : cloth.mesh.positions) x += away;
  for (Obstacle& obstacle : scene.obstacles) obstacle.transform.translate += away;
  for (CameraKey& key : scene.camera.keys) {
    key.position += away;
    key.look_at += away;
  }
  return scene;
}

/// Moves everything to places that a distance of `away` does not round.
void snap(Scene& scene) {
  const auto snap = [](Vec3<double>& x) {
    for (int c = 0; c < 3; ++c) x[c] = std::ldexp(std::round(std::ldexp(x[c], 40)), -40);
  };
  for (Cloth& cloth : scene.cloths)
    for (auto& x : cloth.mesh.positions) snap(x);
  for (Obstacle& obstacle : scene.obstacles) snap(obstacle.transform.translate);
  for (CameraKey& key : scene.camera.keys) {
    snap(key.position);
    snap(key.look_at);
  }
}

void far_away(const Setup& setup, Scene scene, Precision precision, int steps) {
  if (setup.method != "asynchronous") scene.precision = precision;
  jitter(scene, setup);
  snap(scene);
  const Mesh there = cloth_mesh(run(moved_away(scene), setup, steps));
  Mesh expected = cloth_mesh(run(std::move(scene), setup, steps));
  for (auto& x : expected.positions) x += away;
  require_at_most(largest_distance(there, expected) / side, 0,
                  "distance from the scene at the origin, over L");
}

/// Impacts are chaotic: a start that differs by a rounding ends elsewhere, and may do so anywhere.
void far_away_rounded(const Setup& setup, Scene scene, int steps) {
  jitter(scene, setup);
  Mesh there = cloth_mesh(run(moved_away(scene), setup, steps));
  for (auto& x : there.positions) x -= away;
  Scene shaken = scene;
  jitter(shaken, {setup.method, setup.seed + 1000, setup.device});
  const Mesh expected = cloth_mesh(run(std::move(scene), setup, steps));
  const double spread =
      largest_distance(cloth_mesh(run(std::move(shaken), setup, steps)), expected);
  require_at_most(largest_distance(there, expected) / spread, 1,
                  "distance from the scene at the origin, over that of a jittered start");
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
      {"far_away_free",
       "a curtain 1,000 L away from the origin, moved by an offset that rounds nothing: the same "
       "bits, double",
       [](const Setup& s) { far_away(s, curtain(s, 0.005, 8), Precision::double_precision, 40); }},
      {"far_away", "the same for a sheet on a sphere",
       [](const Setup& s) {
         far_away(s, sheet_on_sphere(s, 0.005), Precision::double_precision, 40);
       }},
      {"far_away_float", "the same in the method's usual precision",
       [](const Setup& s) {
         far_away(s, sheet_on_sphere(s, 0.005), Precision::single_precision, 40);
       }},
      {"far_away_rounded",
       "the same where the offset rounds the start: nearer to the scene at the origin than a start "
       "that is jittered by a thousandth of an edge",
       [](const Setup& s) { far_away_rounded(s, sheet_on_sphere(s, 0.005), 40); }},
  };
}

}  // namespace weft::stability
