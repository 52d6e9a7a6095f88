// Membranes: constant stress, modes of a stretched one, a pressed disc.
#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include "benchmarks/physics/sheets.hpp"
#include "benchmarks/physics/statics.hpp"
#include "benchmarks/physics/test.hpp"
#include "weft/shapes.hpp"

namespace weft::physics {
namespace {

/// Largest distance from an affine map that the outline is held on, after the inside was moved.
Outcome patch(const Parameters& p) {
  const double side = 0.2;
  Material material;
  material.stretch_stiffness = 1000;
  material.poisson_ratio = p.number("nu");
  material.bending_stiffness = 0;
  Mesh mesh = make_sheet({side, side, p.count("cells"), 0, 0}, p);
  const double stretch = p.number("stretch");
  const auto affine = [&](const Vec2<double>& u) {
    return Vec3<double>{(1 + stretch) * u[0] + 0.6 * stretch * u[1],
                        0.2 * stretch * u[0] + (1 + 0.4 * stretch) * u[1], 0.1 * u[0]};
  };
  for (std::size_t v = 0; v < mesh.positions.size(); ++v)
    mesh.positions[v] = affine(mesh.material[v]);
  std::mt19937_64 random(7);
  const auto held = outline(mesh);
  const double push = 0.05 * side / p.count("cells");
  for (std::size_t v = 0; v < mesh.positions.size(); ++v)
    if (!std::binary_search(held.begin(), held.end(), static_cast<Index>(v)))
      for (int a = 0; a < 2; ++a)
        mesh.positions[v][a] += push * (static_cast<double>(random() >> 11) * 0x1p-52 - 1);
  Scene scene = make_scene(std::move(mesh), material, 10);
  pin(scene, held);
  scene.solver.tolerance = 1e-12;
  scene.solver.newton_tolerance = 1e-15;
  Simulation simulation = start(std::move(scene));
  settle(simulation, 1e-15, 10);
  const auto x = positions(simulation);
  double worst = 0;
  for (std::size_t v = 0; v < x.size(); ++v)
    worst = std::max(worst,
                     length(x[v] - affine(simulation.scene().cloths[0].mesh.material[v])) / side);
  return absolute(worst, 0, 1e-12);
}

/// Angular frequency of a mode of a square membrane of side a, in units of pi/a sqrt(S/rho): S is
/// the second Piola-Kirchhoff stress of an equal stretch, a and rho those before it.
double membrane_frequency(const Parameters& p, int cells, int mode) {
  const double side = 0.2;
  const double stretch = 1 + p.positive("stretch");
  const double nu = 0.3;
  Material material;
  material.density = 0.2;
  material.stretch_stiffness = 1000;
  material.poisson_ratio = nu;
  material.bending_stiffness = 0;
  Mesh mesh = make_sheet({side, side, cells, 0, 0}, p);
  for (auto& x : mesh.positions) x = stretch * x;
  const double stress = material.stretch_stiffness / (1 - nu) * (stretch * stretch - 1) / 2;
  const double unit = std::numbers::pi / side * std::sqrt(stress / material.density);
  Scene scene = make_scene(std::move(mesh), material, 1 / unit);
  scene.solver.tolerance = 1e-12;
  pin(scene, outline(scene.cloths[0].mesh));
  Vibration vibration;
  vibration.amplitude = 1e-6 * side;
  vibration.step = 1 / unit;
  vibration.modes = mode;
  vibration.rounds = 25;
  return std::sqrt(vibration_squares(scene, vibration).back()) / unit;
}

constexpr double membrane_squares[] = {2, 5, 5, 8, 10, 10};  // m^2 + n^2 in ascending order

Outcome membrane_modes(const Parameters& p) {
  const int mode = std::min(p.count("mode"), 6);
  return relative(membrane_frequency(p, p.count("cells"), mode),
                  std::sqrt(membrane_squares[mode - 1]), 0.01);
}

Outcome membrane_order(const Parameters& p) {
  const int cells = p.count("cells");
  const double exact = std::sqrt(2.0);
  const double coarse = membrane_frequency(p, cells, 1) / exact - 1;
  const double fine = membrane_frequency(p, 2 * cells, 1) / exact - 1;
  Outcome outcome = absolute(std::log2(coarse / fine), 2, 0.05);
  outcome.more = {{"error", coarse}, {"error_half_cell", fine}};
  return outcome;
}

/// Deflection of the middle of a clamped disc under an even load, in units of a (q a / (E
/// h))^(1/3). Hencky's load is a pressure on small slopes: here it is weight, and the slope is
/// about 0.01.
Outcome hencky(const Parameters& p) {
  const double radius = 0.1;
  const double nu = p.number("nu");
  const double load = p.positive("load");
  Material material;
  material.density = 0.2;
  material.stretch_stiffness = 1000;
  material.poisson_ratio = nu;
  material.bending_stiffness = 0;
  const double gravity = load * material.stretch_stiffness / (radius * material.density);
  const double unit = radius * std::cbrt(load);
  const double reference = table_value("hencky.csv", "C", nu);
  Mesh mesh = make_disc(radius, p.count("rings"));
  const auto rim = outline(mesh);
  for (auto& x : mesh.positions)
    x[2] = -0.8 * reference * unit * (1 - (x[0] * x[0] + x[1] * x[1]) / (radius * radius));
  // The tension is about 0.4 E h (w/a)^2.
  const double tension = 0.4 * material.stretch_stiffness * std::pow(load, 2.0 / 3);
  const double period = 2.6 * radius * std::sqrt(material.density / tension);
  Scene scene = make_scene(std::move(mesh), material, 2 * period);
  scene.gravity = {0, 0, -gravity};
  for (const Index v : rim) scene.cloths[0].mesh.positions[static_cast<std::size_t>(v)][2] = 0;
  pin(scene, rim);
  Simulation simulation = start(std::move(scene));
  settle(simulation, 1e-6 * unit, 100);
  return relative(-positions(simulation)[0][2] / unit, reference, 0.01);
}

}  // namespace

std::vector<Test> membrane_tests() {
  return {{"patch", "distance from a homogeneous strain, as a share of the side; 0",
           std::vector<Parameter>{{"cells", "8", "along a side"},
                                  {"stretch", "0.05", ""},
                                  {"nu", "0.3", "Poisson's ratio"}} +
               mesh_parameters(),
           patch},
          {"membrane_modes", "frequency of a stretched square membrane; sqrt(m^2 + n^2)",
           std::vector<Parameter>{
               {"cells", "24", "along a side"}, {"mode", "1", "1 to 6"}, {"stretch", "0.05", ""}} +
               mesh_parameters(),
           membrane_modes},
          {"membrane_order", "order with which the first frequency's error falls; 2",
           std::vector<Parameter>{{"cells", "10", "along a side, and twice as many"},
                                  {"stretch", "0.05", ""}} +
               mesh_parameters(),
           membrane_order},
          {"hencky",
           "deflection of a clamped disc under an even load; Hencky 1915 (hencky.csv)",
           {{"rings", "20", "of triangles"},
            {"load", "1e-6", "q a / (E h)"},
            {"nu", "0.3", "Poisson's ratio: 0, 0.1 ... 0.5"}},
           hencky}};
}

}  // namespace weft::physics
