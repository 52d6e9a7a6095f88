// Compression and folds, where the energy's Hessian has negative directions.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "benchmarks/stability/run.hpp"

namespace weft::stability {
namespace {

/// Elastic energy of the square if it were compressed along x to `share` of its length and stayed
/// flat, narrow enough to widen freely: K / 2 e^2 A with Green's strain e. [J]
double flat_energy(double stiffness, double share) {
  const double strain = (share * share - 1) / 2;
  return stiffness / 2 * strain * strain * side * side;
}

/// The right edge is pushed towards the left one.
void compressed(const Setup& setup) {
  Scene scene = empty_scene(setup, 0.005);
  scene.gravity = {0, 0, 0};
  scene.cloths.push_back(square(12, 0));
  const Mesh& mesh = scene.cloths[0].mesh;
  scene.pins.push_back({0, left_vertices(mesh, 0.001), {}, -1, 1e9});
  Transform there;
  there.translate = {-side / 2, 0, 0};
  scene.pins.push_back({0, right_vertices(mesh, 0.001), {{0, {}}, {0.3, there}}, -1, 1e9});
  jitter(scene, setup, 1e-2);
  Run simulation = run(std::move(scene), setup, 100);
  require_at_most(simulation.now().energy().elastic,
                  0.02 * flat_energy(cotton().stretch_stiffness, 0.5), "elastic energy [J]");
}

/// Starts flat at half its length: a saddle from which Newton's method has to get away.
void saddle(const Setup& setup, int newton_iterations) {
  Scene scene = empty_scene(setup, 0.005);
  scene.precision = Precision::double_precision;
  scene.gravity = {0, 0, 0};
  scene.solver.newton_iterations = newton_iterations;
  scene.solver.tolerance = 1e-6;
  scene.cloths.push_back(square(12, 0));
  for (auto& x : scene.cloths[0].mesh.positions) x[0] /= 2;
  const Mesh& mesh = scene.cloths[0].mesh;
  scene.pins.push_back({0, left_vertices(mesh, 0.001), {}, -1, 1e9});
  scene.pins.push_back({0, right_vertices(mesh, 0.001), {}, -1, 1e9});
  jitter(scene, setup, 1e-3);
  Run simulation = start(std::move(scene), setup);
  const double before = total_energy(simulation);
  simulation.watch(40);
  const double after = total_energy(simulation);
  require_no_energy_gain(before, after, before);
  require_at_most(after, before / 10, "energy [J] that is left of the saddle's");
}

/// Half of the sheet turns about its middle by 200 degrees and back, through itself if it may.
void folded(const Setup& setup, Bending bending, bool self) {
  Scene scene = empty_scene(setup, 0.005);
  scene.gravity = {0, 0, 0};
  scene.bending = bending;
  scene.contact.self = self;
  scene.materials[0].bending_stiffness = 1e-3;
  scene.materials[0].damping_mass = 5;
  scene.cloths.push_back(square(8, 0));
  const Mesh& mesh = scene.cloths[0].mesh;
  scene.pins.push_back({0, left_vertices(mesh, 0.051), {}, -1, 1e9});
  Transform turned;
  turned.rotation_axis = {0, 1, 0};
  turned.rotation_angle = -200 * std::numbers::pi / 180;
  scene.pins.push_back(
      {0, right_vertices(mesh, 0.051), {{0, {}}, {0.4, turned}, {0.8, {}}}, -1, 1e9});
  jitter(scene, setup, 1e-4);
  Run simulation = start(std::move(scene), setup);
  double largest = 0;
  simulation.watch(300, 300, [&](const Scene&, const Frame&, const Energy& energy) {
    largest = std::max(largest, energy.elastic);
  });
  require_at_most(simulation.now().energy().elastic / largest, 0.01,
                  "elastic energy left once unfolded, over the largest");
}

/// Two triangles whose common edge is a hinge, driven by 200 degrees and back.
void hinge(const Setup& setup, Bending bending) {
  Scene scene = empty_scene(setup, 0.005);
  scene.gravity = {0, 0, 0};
  scene.bending = bending;
  scene.contact.self = false;
  Cloth cloth;
  cloth.name = "hinge";
  cloth.mesh.material = {{0, -0.1}, {0, 0.1}, {-0.15, 0}, {0.15, 0}};
  for (const auto& m : cloth.mesh.material) cloth.mesh.positions.push_back({m[0], m[1], 0});
  cloth.mesh.triangles = {{{0, 1, 2}}, {{1, 0, 3}}};
  scene.cloths.push_back(cloth);
  scene.pins.push_back({0, {2}, {}, -1, 1e9});
  Transform turned;
  turned.rotation_axis = {0, 1, 0};
  turned.rotation_angle = -200 * std::numbers::pi / 180;
  scene.pins.push_back({0, {3}, {{0, {}}, {0.4, turned}, {0.8, {}}}, -1, 1e9});
  jitter(scene, setup, 1e-4);
  run(std::move(scene), setup, 240);
}

}  // namespace

std::vector<Case> folding_cases() {
  return {
      {"compressed", "pushed together to half its length: it buckles, most of the energy goes",
       compressed},
      {"saddle_linear", "starts flat at half its length, one linear solve per step: it buckles",
       [](const Setup& s) { saddle(s, 1); }},
      {"saddle_newton", "the same with Newton's method", [](const Setup& s) { saddle(s, 20); }},
      {"fold_200",
       "half a sheet turns by 200 degrees, with self-contact, and back: it is flat again",
       [](const Setup& s) { folded(s, Bending::plate, true); }},
      {"fold_200_through", "the same through itself",
       [](const Setup& s) { folded(s, Bending::plate, false); }},
      {"fold_200_through_hinge", "the same with bending by hinges",
       [](const Setup& s) { folded(s, Bending::hinge, false); }},
      {"one_hinge_200", "two triangles turn against each other by 200 degrees and back",
       [](const Setup& s) { hinge(s, Bending::hinge); }},
      {"one_hinge_200_plate", "the same with bending as a plate",
       [](const Setup& s) { hinge(s, Bending::plate); }},
  };
}

}  // namespace weft::stability
