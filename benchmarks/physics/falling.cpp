// A folded strip that falls, faster than free fall, because it is never slack.
#include <cmath>
#include <numbers>

#include "benchmarks/physics/sheets.hpp"
#include "benchmarks/physics/statics.hpp"
#include "benchmarks/physics/test.hpp"
#include "weft/error.hpp"

namespace weft::physics {
namespace {

constexpr double gravity = 9.81;      // [m/s^2]
constexpr double strip_length = 0.5;  // [m]

/// Time that the free end takes to fall by a share of the strip's length, over that of free fall:
/// v^2 = 2 g y (1 - y / 2L) / (1 - y / L), from the conservation of energy.
double time_ratio(double drop) {
  // y = drop sin^2(a) takes the root out of both ends.
  constexpr int parts = 20000;
  double time = 0;
  for (int n = 0; n < parts; ++n) {
    const double a = (n + 0.5) / parts * std::numbers::pi / 2;
    const double y = drop * std::sin(a) * std::sin(a);
    const double rate = 2 * drop * std::sin(a) * std::cos(a);
    time += rate / std::sqrt(2 * y * (1 - y / 2) / (1 - y)) * std::numbers::pi / 2 / parts;
  }
  return time / std::sqrt(2 * drop);
}

Outcome folded_strip(const Parameters& p) {
  const double drop = p.positive("drop");
  const double gap = strip_length * p.positive("gap");
  const double h = p.positive("step");
  Material material;
  material.density = 0.2;
  material.stretch_stiffness = material.density * gravity * strip_length / p.positive("strain");
  material.poisson_ratio = 0;
  material.bending_stiffness = 0;
  const int cells = p.count("cells");
  Mesh mesh = make_sheet({strip_length, strip_length / cells, cells, 0, 0}, p);
  const double arc = std::numbers::pi * gap / 2;
  const double leg = (strip_length - arc) / 2;
  for (auto& x : mesh.positions) {
    const double s = x[0];
    if (s <= leg) {
      x = {0, x[1], -s};
    } else if (s >= leg + arc) {
      x = {gap, x[1], s - strip_length};
    } else {
      const double angle = (s - leg) / arc * std::numbers::pi;
      x = {gap / 2 * (1 - std::cos(angle)), x[1], -leg - gap / 2 * std::sin(angle)};
    }
  }
  Scene scene = make_scene(std::move(mesh), material, h);
  scene.gravity = {0, 0, -gravity};
  scene.integrator = p.one_of("integrator", {"implicit_euler", "bdf2"}) == "bdf2"
                         ? Integrator::bdf2
                         : Integrator::implicit_euler;
  scene.solver.tolerance = 1e-7;
  scene.solver.newton_tolerance = 1e-6;
  pin(scene, vertices_before(scene.cloths[0].mesh, 0));
  const auto end = vertices_after(scene.cloths[0].mesh, strip_length);
  Simulation simulation = start(std::move(scene));
  const double free_fall = std::sqrt(2 * drop * strip_length / gravity);
  double before = 0;
  while (simulation.time() < 2 * free_fall) {
    advance(simulation, 1);
    const double fallen = -mean_place(simulation, end)[2] / strip_length;
    if (fallen >= drop) {
      const double time = simulation.time() - h * (fallen - drop) / (fallen - before);
      return relative(time / free_fall, time_ratio(drop), 0.03);
    }
    before = fallen;
  }
  throw SimulationError("the strip's end does not fall as far as that");
}

}  // namespace

std::vector<Test> falling_tests() {
  return {{"folded_strip", "time to fall over that of free fall; 0.84721 for the whole length",
           std::vector<Parameter>{{"cells", "128", "along its length"},
                                  {"drop", "0.99", "over the length, below 1"},
                                  {"gap", "0.02", "between the two halves, over the length"},
                                  {"strain", "1e-4", "about, under its own weight"},
                                  {"step", "2.5e-4", "[s]"},
                                  {"integrator", "bdf2", "implicit_euler or bdf2"}} +
               mesh_parameters(),
           folded_strip}};
}

}  // namespace weft::physics
