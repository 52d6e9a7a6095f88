// Sheets that slide, stick and wind: Coulomb's law against obstacles.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "benchmarks/physics/sheets.hpp"
#include "benchmarks/physics/statics.hpp"
#include "benchmarks/physics/test.hpp"
#include "weft/shapes.hpp"

namespace weft::physics {
namespace {

constexpr double gravity = 9.81;     // [m/s^2]
constexpr double thickness = 0.001;  // [m] of contact

/// A sheet of 0.1 m on a plane that is level or, seen along gravity, falls towards +x.
Scene sheet_on_plane(const Parameters& p, double slope) {
  Material material;
  material.density = 0.2;
  material.stretch_stiffness = 500;
  Mesh mesh = make_sheet({0.1, 0.1, p.count("cells"), 0, 0}, p);
  for (auto& x : mesh.positions) x[2] = 0.9 * thickness;
  Scene scene = make_scene(std::move(mesh), material, p.positive("step"));
  scene.contact.thickness = thickness;
  scene.solver.newton_iterations = p.count("newton");
  scene.solver.tolerance = 1e-8;
  const double along = 1 / std::sqrt(1 + slope * slope);
  scene.gravity = {gravity * slope * along, 0, -gravity * along};
  Obstacle plane;
  plane.name = "plane";
  plane.mesh = make_grid({4, 2}, {4, 2}, Diagonals::same);
  plane.mesh.material.clear();
  plane.friction = p.number("mu");
  scene.obstacles = {plane};
  return scene;
}

/// Mean place and velocity along x.
Vec2<double> progress(const Simulation& simulation) {
  const Frame frame = simulation.frame();
  Vec2<double> sum{0, 0};
  for (std::size_t v = 0; v < frame.cloth_positions[0].size(); ++v)
    sum += {frame.cloth_positions[0][v][0], frame.cloth_velocities[0][v][0]};
  return (1.0 / static_cast<double>(frame.cloth_positions[0].size())) * sum;
}

/// Coefficient of friction that the sheet's acceleration down a slope shows.
Outcome incline_slides(const Parameters& p) {
  const double slope = p.positive("slope");
  Simulation simulation = start(sheet_on_plane(p, slope));
  const int settling = static_cast<int>(0.2 / simulation.step_length());
  const int steps = static_cast<int>(p.positive("time") / simulation.step_length());
  advance(simulation, settling);
  const double before = progress(simulation)[1];
  advance(simulation, steps);
  const double after = progress(simulation)[1];
  const double acceleration = (after - before) / (steps * simulation.step_length());
  Outcome outcome =
      relative(slope - acceleration * std::sqrt(1 + slope * slope) / gravity, p.number("mu"), 0.02);
  outcome.more = {{"speed", after}};
  return outcome;
}

/// Speed of a sheet that should stick, at the end. [m/s]
Outcome incline_holds(const Parameters& p) {
  Simulation simulation = start(sheet_on_plane(p, p.positive("slope")));
  const int steps = static_cast<int>(p.positive("time") / simulation.step_length());
  advance(simulation, steps / 2);
  const double middle = progress(simulation)[0];
  advance(simulation, steps - steps / 2);
  const double moved = progress(simulation)[0] - middle;
  // A thousandth of what the smallest smoothing of friction that is in use would leave.
  return absolute(moved / ((steps - steps / 2) * simulation.step_length()), 0, 1e-6);
}

/// Way on a level plane until rest, over v^2 / (2 mu g).
Outcome stopping(const Parameters& p) {
  Scene scene = sheet_on_plane(p, 0);
  scene.cloths[0].velocity = {p.positive("speed"), 0, 0};
  Simulation simulation = start(std::move(scene));
  advance(simulation, static_cast<int>(0.05 / simulation.step_length()));
  const Vec2<double> before = progress(simulation);
  const double rate = p.positive("mu") * gravity;
  advance(simulation, static_cast<int>(1.5 * before[1] / rate / simulation.step_length()));
  const double way = progress(simulation)[0] - before[0];
  return relative(way / (before[1] * before[1] / (2 * rate)), 1, 0.03);
}

/// Part of a cylinder about the y axis, or of any outline of the xz plane, as wide as `width`.
Mesh extruded(const std::vector<Vec2<double>>& line, double width) {
  Mesh mesh;
  for (const auto& q : line)
    for (const double y : {-width / 2, width / 2}) mesh.positions.push_back({q[0], y, q[1]});
  for (std::size_t k = 0; k + 1 < line.size(); ++k) {
    const auto a = static_cast<Index>(2 * k);
    mesh.triangles.push_back({{a, a + 2, a + 3}});
    mesh.triangles.push_back({{a, a + 3, a + 1}});
  }
  return mesh;
}

/// Half of a cylinder about the y axis, its top upwards, and a little more at both ends.
Mesh half_cylinder(double radius, int segments, double width) {
  std::vector<Vec2<double>> line;
  for (int k = 0; k <= segments; ++k) {
    const double angle = -0.1 + (std::numbers::pi + 0.2) * k / segments;
    line.push_back({-radius * std::cos(angle), radius * std::sin(angle)});
  }
  return extruded(line, width);
}

/// A strip, x along it, laid over half a cylinder so that `leg` hangs from it at either end.
void wind(Mesh& strip, double leg, double around) {
  for (auto& x : strip.positions) {
    const double s = x[0] - leg;
    const double angle = std::clamp(s / around, 0.0, std::numbers::pi);
    const double beyond = s - angle * around;
    x = {-around * std::cos(angle), x[1], around * std::sin(angle) - (s < 0 ? -beyond : beyond)};
  }
}

/// Ratio of the tensions of a strip that is drawn over half a cylinder.
Outcome capstan(const Parameters& p) {
  const double mu = p.positive("mu");
  const double radius = 0.05;
  const double around = radius + thickness;
  const double leg = 0.04;
  const double strip = std::numbers::pi * around + 2 * leg;
  const double width = 0.02;
  const double tension = 2;  // [N/m] at the slack end
  Material material;
  material.density = 0.2;
  material.stretch_stiffness = 5000;
  material.poisson_ratio = 0;
  material.bending_stiffness = 0;
  Mesh mesh = make_sheet({strip, width, p.count("cells"), 0, 0}, p);
  wind(mesh, leg, around);
  Scene scene = make_scene(std::move(mesh), material, p.positive("step"));
  scene.contact.thickness = thickness;
  scene.solver.newton_iterations = p.count("newton", 0);
  scene.solver.tolerance = p.positive("tolerance");
  Obstacle cylinder;
  cylinder.name = "cylinder";
  cylinder.mesh = half_cylinder(radius, p.count("segments", 8), 3 * width);
  cylinder.friction = mu;
  scene.obstacles = {cylinder};
  const Mesh& sheet = scene.cloths[0].mesh;
  const auto slack = vertices_before(sheet, 0);
  const auto drawn = vertices_after(sheet, strip);
  add_dead_load(scene, slack, line_shares(sheet, slack), {0, 0, -tension * width}, strip);
  Handle handle;
  handle.vertices = drawn;
  handle.stiffness = 100;
  const double time = p.positive("time");
  Transform there;
  there.translate = {0, 0, -p.positive("speed") * time};
  // Cubic between keys: of even speed where there are three.
  Transform halfway;
  halfway.translate = 0.5 * there.translate;
  handle.motion = {{0, {}}, {time / 2, halfway}, {time, there}};
  scene.handles.push_back(handle);
  std::vector<Vec3<double>> places;
  for (const Index v : drawn) places.push_back(sheet.positions[static_cast<std::size_t>(v)]);
  Simulation simulation = start(std::move(scene));
  const int steps = static_cast<int>(0.75 * time / simulation.step_length());
  double sum = 0;
  int samples = 0;
  for (int n = 0; n < steps; ++n) {
    advance(simulation, 1);
    if (3 * n < steps) continue;
    const auto x = positions(simulation);
    const Transform target = transform_at(handle.motion, simulation.time());
    for (std::size_t k = 0; k < drawn.size(); ++k)
      sum += handle.stiffness *
             length(apply(target, places[k]) - x[static_cast<std::size_t>(drawn[k])]);
    ++samples;
  }
  return relative(sum / samples / (tension * width), std::exp(mu * std::numbers::pi), 0.03);
}

/// Height of the hanging part of a strip that slides off a smooth table, over that at the start:
/// what hangs is pulled by its own weight and has all of the strip to move, so that the height
/// grows as cosh(t sqrt(g/L)) whatever the edge's rounding.
Outcome sliding_off(const Parameters& p) {
  const double strip = 0.4;
  const double around = 0.004 + thickness;
  const double hanging = p.positive("hanging") * strip;  // height
  const int cells = p.count("cells");
  Material material;
  material.density = 0.2;
  material.stretch_stiffness = 2000;
  material.poisson_ratio = 0;
  material.bending_stiffness = 0;
  Mesh mesh = make_sheet({strip, strip / cells, cells, 0, 0}, p);
  const double arc = std::numbers::pi / 2 * around;
  const double flat = strip - arc - (hanging - around);
  for (auto& x : mesh.positions) {
    const double s = x[0] - flat;
    const double angle = std::clamp(s / around, 0.0, std::numbers::pi / 2);
    x = {std::min(s, 0.0) + around * std::sin(angle), x[1],
         around * std::cos(angle) - 0.004 - std::max(s - arc, 0.0)};
  }
  Scene scene = make_scene(std::move(mesh), material, p.positive("step"));
  scene.contact.thickness = thickness;
  scene.solver.newton_iterations = p.count("newton");
  scene.solver.tolerance = 1e-6;
  scene.gravity = {0, 0, -gravity};
  Obstacle table;
  table.name = "table";
  std::vector<Vec2<double>> line = {{-1, 0}};
  for (int k = 0; k <= 16; ++k) {
    const double angle = std::numbers::pi / 2 * k / 16;
    line.push_back({0.004 * std::sin(angle), 0.004 * (std::cos(angle) - 1)});
  }
  line.push_back({0.004, -1});
  table.mesh = extruded(line, 0.2);
  table.friction = 0;
  scene.obstacles = {table};
  const auto tail = vertices_before(scene.cloths[0].mesh, 0);
  Simulation simulation = start(std::move(scene));
  const double before = mean_place(simulation, tail)[0];
  const double rate = std::sqrt(gravity / strip);
  const int steps =
      static_cast<int>(std::acosh(p.positive("until")) / rate / simulation.step_length());
  advance(simulation, steps);
  const double moved = mean_place(simulation, tail)[0] - before;
  return relative(1 + moved / hanging, std::cosh(rate * simulation.time()), 0.02);
}

}  // namespace

std::vector<Test> friction_tests() {
  const auto plane = std::vector<Parameter>{{"cells", "6", "along a side of the sheet"},
                                            {"step", "0.002", "[s]"},
                                            {"newton", "1", "iterations a step"}} +
                     mesh_parameters();
  const std::vector<Parameter> slope = {{"slope", "0.5", "tangent of the plane's angle"},
                                        {"time", "1", "[s]"}};
  return {
      {"incline_slides", "friction that a sheet's acceleration down a slope shows; mu",
       std::vector<Parameter>{{"mu", "0.49", "below the slope"}} + slope + plane, incline_slides},
      {"incline_holds", "speed [m/s] of a sheet that should stick; 0",
       std::vector<Parameter>{{"mu", "0.51", "above the slope"}} + slope + plane, incline_holds},
      {"stopping", "stopping distance over v^2 / (2 mu g); 1",
       std::vector<Parameter>{{"mu", "0.3", ""}, {"speed", "1", "[m/s]"}} + plane, stopping},
      {"capstan", "tension over tension, half a turn around a cylinder; exp(mu pi)",
       std::vector<Parameter>{{"mu", "0.3", ""},
                              {"cells", "64", "along the strip"},
                              {"segments", "128", "of the cylinder"},
                              {"step", "0.002", "[s]"},
                              {"time", "0.4", "[s]"},
                              {"speed", "0.05", "[m/s]"},
                              {"newton", "1", "iterations a step; 0: as many as it takes"},
                              {"tolerance", "1e-6", "of the solver"}} +
           mesh_parameters(),
       capstan},
      {"sliding_off", "height of what hangs off a smooth table, over that at the start; cosh",
       std::vector<Parameter>{{"cells", "80", "along the strip"},
                              {"hanging", "0.25", "height at the start over the length"},
                              {"until", "1.8", "growth at which to stop"},
                              {"step", "0.0005", "[s]"},
                              {"newton", "10", "iterations a step"}} +
           mesh_parameters(),
       sliding_off}};
}

}  // namespace weft::physics
