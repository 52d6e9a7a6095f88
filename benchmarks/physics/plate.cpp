// Plates that bend a little, or without stretching: energy of a half cylinder, modes of a square.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "benchmarks/physics/sheets.hpp"
#include "benchmarks/physics/statics.hpp"
#include "benchmarks/physics/test.hpp"

namespace weft::physics {
namespace {

/// Elastic energy of a sheet rolled into a half cylinder about the y axis. [J]
double rolled_energy(const Parameters& p, double stiffness, double stretch) {
  Material material;
  material.bending_stiffness = stiffness;
  material.stretch_stiffness = stretch;
  material.poisson_ratio = p.number("nu");
  const double radius = 1 / std::numbers::pi;
  Mesh mesh = make_sheet({1, p.positive("width"), p.count("cells"), 0, 0}, p);
  for (auto& x : mesh.positions)
    x = {radius * std::sin(x[0] / radius), x[1], radius * std::cos(x[0] / radius)};
  Scene scene = make_scene(std::move(mesh), material, 1);
  scene.bending = bending_of(p);
  return start(std::move(scene)).energy().elastic;
}

/// Energies of the isometric half cylinder of R/h, membrane and bending apart.
struct RolledEnergies {
  double membrane, bending, exact;
};

RolledEnergies rolled_energies(const Parameters& p) {
  const double nu = p.number("nu");
  const double radius = 1 / std::numbers::pi;
  const double thickness = radius / p.positive("slenderness");
  const double stiffness = 1e-4;
  const double stretch = 12 * (1 - nu * nu) * stiffness / (thickness * thickness);
  RolledEnergies e;
  e.membrane = rolled_energy(p, 0, stretch);
  e.bending = rolled_energy(p, stiffness, stretch) - e.membrane;
  e.exact = stiffness / 2 * p.positive("width") / (radius * radius);
  return e;
}

Outcome half_cylinder(const Parameters& p) {
  const std::string& mesh = p.text("mesh");
  const double tolerance = mesh == "aligned" || mesh == "rotated" ? 0.02
                           : mesh == "aniso"                      ? 0.25
                                                                  : 0.10;
  const RolledEnergies e = rolled_energies(p);
  return relative(e.bending / e.exact, 1, tolerance);
}

Outcome half_cylinder_membrane(const Parameters& p) {
  const RolledEnergies e = rolled_energies(p);
  return absolute(e.membrane / e.exact, 0, 0.01);
}

/// A strip that is a half cylinder at rest, clamped at one end.
Scene curled_strip(const Parameters& p) {
  const int cells = p.count("cells");
  const double nu = p.number("nu");
  Material material;
  material.bending_stiffness = 1e-4;
  material.poisson_ratio = nu;
  const double thickness = 1 / (std::numbers::pi * p.positive("slenderness"));
  material.stretch_stiffness = 12 * (1 - nu * nu) * 1e-4 / (thickness * thickness);
  Mesh mesh = make_sheet({1, p.positive("width"), cells, 0, 0}, p);
  // On facets that are as long as the pattern's cells, where the mesh has such.
  const double turn = std::numbers::pi / cells;
  const double radius = 0.5 / cells / std::sin(turn / 2);
  std::vector<Vec3<double>> rest;
  for (const auto& u : mesh.material)
    rest.push_back({radius * std::sin(std::numbers::pi * u[0]), u[1],
                    radius * std::cos(std::numbers::pi * u[0])});
  Scene scene = make_scene(std::move(mesh), material, 10);
  scene.bending = bending_of(p);
  scene.cloths[0].rest_positions = std::move(rest);
  return scene;
}

/// Energy of a half cylinder at rest that is flattened.
Outcome flattened(const Parameters& p) {
  const Scene scene = curled_strip(p);
  const double exact = 1e-4 / 2 * p.positive("width") * std::numbers::pi * std::numbers::pi;
  const std::string& mesh = p.text("mesh");
  const double tolerance = mesh == "aligned" || mesh == "rotated" ? 0.02
                           : mesh == "aniso"                      ? 0.25
                                                                  : 0.10;
  return relative(start(scene).energy().elastic / exact, 1, tolerance);
}

/// How far a strip strays from its curved rest shape when nothing pulls at it.
Outcome keeps_shape(const Parameters& p) {
  Scene scene = curled_strip(p);
  scene.cloths[0].mesh.positions = scene.cloths[0].rest_positions;
  const std::vector<Vec3<double>> before = scene.cloths[0].rest_positions;
  pin(scene, vertices_before(scene.cloths[0].mesh, 1.0 / p.count("cells")));
  Simulation simulation = start(std::move(scene));
  advance(simulation, 5);
  const auto after = positions(simulation);
  double moved = 0;
  for (std::size_t v = 0; v < after.size(); ++v)
    moved = std::max(moved, length(after[v] - before[v]));
  return absolute(moved, 0, 1e-9);
}

/// Frequencies of a square plate clamped on one side, in units of sqrt(D / rho) / a^2.
Outcome plate_modes(const Parameters& p) {
  const double squares[] = {3.4711, 8.5067, 21.285};  // Leissa 1969, nu = 0.3
  const int mode = std::min(p.count("mode"), 3);
  const double side = 0.2;
  const double nu = p.number("nu");
  Material material;
  material.density = 0.2;
  material.bending_stiffness = 1e-4;
  material.poisson_ratio = nu;
  const double thickness = side / p.positive("slenderness");
  material.stretch_stiffness =
      12 * (1 - nu * nu) * material.bending_stiffness / (thickness * thickness);
  const double unit = std::sqrt(material.bending_stiffness / material.density) / (side * side);
  Scene scene = make_scene(make_sheet({side, side, p.count("cells"), 1, 0}, p), material, 1);
  scene.bending = bending_of(p);
  scene.solver.newton_iterations = 3;
  pin(scene, vertices_before(scene.cloths[0].mesh, 0));
  Vibration vibration;
  vibration.amplitude = 1e-6 * side;
  vibration.step = 0.3 / unit;
  vibration.modes = mode;
  const double square = vibration_squares(scene, vibration).back();
  const double value = std::sqrt(square) / unit;
  return nu == 0.3 ? relative(value, squares[mode - 1], 0.02) : unjudged(value);
}

}  // namespace

std::vector<Test> plate_tests() {
  const auto cylinder = std::vector<Parameter>{{"cells", "140", "around, at least 65"},
                                               {"width", "0.5", "over the arc's length"},
                                               {"slenderness", "300", "R / h"},
                                               {"nu", "0", "Poisson's ratio"}} +
                        bending_parameter() + mesh_parameters();
  return {
      {"half_cylinder", "bending energy over D/2 A/R^2; 1", cylinder, half_cylinder},
      {"half_cylinder_membrane", "membrane energy over the exact bending energy; 0", cylinder,
       half_cylinder_membrane},
      {"flattened", "energy of a flattened half cylinder over D/2 A/R^2; 1", cylinder, flattened},
      {"keeps_shape", "how far a strip strays from its curved rest shape, over its length; 0",
       std::vector<Parameter>{{"cells", "16", "around"},
                              {"width", "0.25", "over the arc's length"},
                              {"slenderness", "300", "R / h"},
                              {"nu", "0", "Poisson's ratio"}} +
           bending_parameter() + mesh_parameters(),
       keeps_shape},
      {"plate_modes", "frequency of a square cantilever plate; Leissa 1969 for nu = 0.3",
       std::vector<Parameter>{{"cells", "24", "along a side"},
                              {"mode", "1", "1 to 3"},
                              {"slenderness", "100", "side over thickness"},
                              {"nu", "0.3", "Poisson's ratio"}} +
           bending_parameter() + mesh_parameters(),
       plate_modes}};
}

}  // namespace weft::physics
