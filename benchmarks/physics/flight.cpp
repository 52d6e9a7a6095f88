// Free flight of two sheets that meet: what must be kept, and what must not grow.
#include <algorithm>
#include <cmath>

#include "benchmarks/physics/sheets.hpp"
#include "benchmarks/physics/statics.hpp"
#include "benchmarks/physics/test.hpp"

namespace weft::physics {
namespace {

/// Two sheets one above the other, released from a stretch, that turn and fly into each other.
Scene meeting_sheets(const Parameters& p) {
  Material material;
  material.density = 0.2;
  material.stretch_stiffness = 100;
  material.bending_stiffness = 1e-6;
  const double speed = p.positive("speed");
  Scene scene =
      make_scene(make_sheet({0.1, 0.1, p.count("cells"), 0, 0}, p), material, p.positive("step"));
  for (auto& x : scene.cloths[0].mesh.positions) x = (1 + p.number("stretch")) * x;
  scene.contact.self = true;
  scene.contact.thickness = 1e-3;
  scene.contact.friction = p.number("friction");
  scene.solver.tolerance = 1e-13;
  scene.solver.newton_iterations = p.count("newton");
  scene.cloths.push_back(scene.cloths[0]);
  scene.cloths[1].name = "other";
  for (auto& x : scene.cloths[1].mesh.positions) x += Vec3<double>{0.013, 0.021, 0.004};
  scene.cloths[0].velocity = {0.1 * speed, 0, speed};
  scene.cloths[0].angular_velocity = {0, 4 * speed, 0};
  scene.cloths[1].velocity = {0, 0.2 * speed, -0.4 * speed};
  scene.cloths[1].angular_velocity = {3 * speed, 0, 2 * speed};
  return scene;
}

Vec3<double> momentum(const Simulation& simulation) {
  const Frame frame = simulation.frame();
  Vec3<double> sum{};
  for (std::size_t c = 0; c < frame.cloth_velocities.size(); ++c) {
    const Scene& scene = simulation.scene();
    const auto areas = vertex_areas(scene.cloths[c].mesh);
    for (std::size_t v = 0; v < areas.size(); ++v)
      sum += (areas[v] * scene.materials[0].density) * frame.cloth_velocities[c][v];
  }
  return sum;
}

/// Largest change of the linear momentum, over what it is.
Outcome flight_momentum(const Parameters& p) {
  Simulation simulation = start(meeting_sheets(p));
  const Vec3<double> at_start = momentum(simulation);
  double change = 0;
  const int steps = p.count("steps");
  for (int n = 0; n < steps; ++n) {
    advance(simulation, 1);
    change = std::max(change, length(momentum(simulation) - at_start));
  }
  return absolute(change / length(at_start), 0, 1e-11);
}

/// Largest excess of the energy over what it was at the start, as a share of that.
Outcome flight_energy(const Parameters& p) {
  Simulation simulation = start(meeting_sheets(p));
  const auto energy = [&] {
    const Energy e = simulation.energy();
    return e.kinetic + e.elastic;
  };
  const double at_start = energy();
  double before = at_start;
  double excess = 0;
  double growth = 0;
  const int steps = p.count("steps");
  for (int n = 0; n < steps; ++n) {
    advance(simulation, 1);
    const double now = energy();
    excess = std::max(excess, now - at_start);
    growth = std::max(growth, now - before);
    before = now;
  }
  Outcome outcome = absolute(excess / at_start, 0, 1e-11);
  outcome.more = {{"largest_growth_in_a_step", growth / at_start}, {"left", before / at_start}};
  return outcome;
}

}  // namespace

std::vector<Test> flight_tests() {
  const std::vector<Parameter> parameters =
      std::vector<Parameter>{{"cells", "8", "along a side of each sheet"},
                             {"steps", "100", ""},
                             {"step", "0.001", "[s]"},
                             {"speed", "0.5", "[m/s]"},
                             {"stretch", "0.01", "at the start"},
                             {"friction", "0.3", "cloth against cloth"},
                             {"newton", "1", "iterations a step"}} +
      mesh_parameters();
  return {
      {"flight_momentum", "change of linear momentum, as a share, of two sheets that collide; 0",
       parameters, flight_momentum},
      {"flight_energy", "excess of kinetic and elastic energy over the start's, as a share; 0",
       parameters, flight_energy}};
}

}  // namespace weft::physics
