// Long and short steps, gravity that turns, forces far beyond the usual, and no force at all.
#include <fmt/format.h>

#include <cmath>

#include "benchmarks/stability/isolate.hpp"
#include "benchmarks/stability/run.hpp"
#include "host/lab/check/validator.hpp"

namespace weft::stability {
namespace {

/// Falls for 0.3 s, whatever the step.
void time_step(const Setup& setup, int steps_per_second) {
  Scene scene = sheet_on_sphere(setup, 1.0 / steps_per_second);
  jitter(scene, setup);
  const double scale = weight_energy(scene);
  Run simulation = start(std::move(scene), setup);
  const double before = total_energy(simulation);
  simulation.watch(steps_per_second * 3 / 10);
  require_no_energy_gain(before, total_energy(simulation), scale);
}

/// Every triangle keeps to a limit of its largest principal stretch, minus one.
Observer stretch_within(double limit, const std::string& when) {
  return [limit, when](const Scene& scene, const Frame& frame, const Energy&) {
    Mesh mesh = scene.cloths[0].mesh;
    mesh.positions = frame.cloth_positions[0];
    require_at_most(lab::validate(mesh, nullptr).strain.largest.max, limit, "stretch " + when);
  };
}

/// A sheet that swings by two corners; gravity points up after 0.15 s, when it is fastest. Slices
/// of time go on from no checkpoint: their end goes on with the method that they are simulated by.
void flipped_gravity(const Setup& setup) {
  constexpr double step = 0.005, limit = 0.01;
  Scene scene = empty_scene(setup, step);
  scene.cloths.push_back(square(10, 0));
  scene.cloths[0].mesh.positions[0][2] = 0;
  scene.pins.push_back({0, {0, 10}, {}, -1, 1e9});
  scene.materials[0].strain_limits = StrainLimits{0, 1 + limit};
  jitter(scene, setup, 1e-5);  // must start within the limit
  Scene flipped = scene;
  flipped.gravity = {0, 0, 9.81};
  if (flipped.method == "time_parallel") flipped.method = flipped.time_parallel.method;
  Run before = start(std::move(scene), setup);
  before.watch(30, 30, stretch_within(limit, "before gravity turns"));
  const auto file = scratch_folder() / "flipped_gravity.weft";
  before.now().save(file);
  Run after = start(std::move(flipped), setup);
  after.resume(file, SceneChanges::allow);
  after.watch(60, 60, stretch_within(limit, "after gravity has turned"));
}

/// 10,000 steps without any force.
void rest(const Setup& setup, Bending bending) {
  Scene scene = empty_scene(setup, 0.001);
  // A frame is a state that slices keep.
  if (setup.method == "time_parallel") scene.time.frame_rate = 10;
  scene.precision = Precision::double_precision;
  scene.bending = bending;
  scene.gravity = {0, 0, 0};
  scene.cloths.push_back(square(6, 0));
  // The shape at rest is jittered along with the start.
  jitter(scene, setup, 0.1);
  for (std::size_t v = 0; v < scene.cloths[0].mesh.positions.size(); ++v) {
    Vec3<double>& x = scene.cloths[0].mesh.positions[v];
    scene.cloths[0].mesh.material[v] = {x[0], x[1]};
    x[2] = 0;
  }
  Run simulation = start(std::move(scene), setup);
  const Mesh before = cloth_mesh(simulation);
  simulation.watch(10000);
  require_at_most(largest_distance(before, cloth_mesh(simulation)) / side, 1e-8, "drift over L");
}

void weight(const Setup& setup, double times) {
  Scene scene = curtain(setup, 0.005, 8);
  scene.gravity = {0, 0, -9.81 * times};
  jitter(scene, setup);
  const double scale = weight_energy(scene) * times;
  Run simulation = start(std::move(scene), setup);
  const double before = total_energy(simulation);
  simulation.watch(40);
  require_no_energy_gain(before, total_energy(simulation), scale);
}

void pressure(const Setup& setup) {
  Scene scene = curtain(setup, 0.005, 8);
  scene.cloths[0].pressure = 1e6;
  jitter(scene, setup);
  run(std::move(scene), setup, 40);
}

void storm(const Setup& setup) {
  Scene scene = curtain(setup, 0.005, 8);
  scene.wind.density = 1.2;
  scene.wind.velocity = {300, 1000, 0};
  scene.wind.drag = 1;
  jitter(scene, setup);
  run(std::move(scene), setup, 40);
}

}  // namespace

std::vector<Case> motion_cases() {
  std::vector<Case> cases;
  for (const int n : {1000, 300, 100, 30, 10})
    cases.push_back({fmt::format("time_step_1_{}", n),
                     fmt::format("falls onto a sphere in steps of 1/{} s; energy does not grow", n),
                     [n](const Setup& s) { time_step(s, n); }});
  cases.push_back({"flipped_gravity",
                   "gravity turns while a sheet swings; a strain limit of 1 % holds",
                   flipped_gravity});
  cases.push_back({"rest_plate", "10,000 steps without a force, double: moves < 1e-8 L",
                   [](const Setup& s) { rest(s, Bending::plate); }});
  cases.push_back({"rest_hinge", "the same with bending by hinges",
                   [](const Setup& s) { rest(s, Bending::hinge); }});
  cases.push_back({"gravity_1e3", "a curtain under 1,000 times gravity; energy does not grow",
                   [](const Setup& s) { weight(s, 1e3); }});
  cases.push_back({"gravity_1e6", "the same under 1,000,000 times gravity",
                   [](const Setup& s) { weight(s, 1e6); }});
  cases.push_back({"pressure_1e6", "a curtain under a pressure of 1e6 Pa", pressure});
  cases.push_back({"storm", "a curtain in wind of 1,000 m/s", storm});
  return cases;
}

}  // namespace weft::stability
