// Strips that hang: small vibrations, stretch under their own weight, between two edges.
#include <cmath>

#include "benchmarks/physics/sheets.hpp"
#include "benchmarks/physics/statics.hpp"
#include "benchmarks/physics/test.hpp"

namespace weft::physics {
namespace {

constexpr double gravity = 9.81;  // [m/s^2]
constexpr double density = 0.2;   // [kg/m^2]

Material membrane(double stretch_stiffness, double nu) {
  Material material;
  material.density = density;
  material.stretch_stiffness = stretch_stiffness;
  material.poisson_ratio = nu;
  material.bending_stiffness = 0;
  return material;
}

/// Frequency of a sheet that swings from one edge, in units of sqrt(g/L); half of the zeros of the
/// Bessel function J0 (D. Bernoulli 1733). The sheet is one cell wide: the fibres of a wider one
/// swing each by itself, at the same frequencies; so do its two sides, and every frequency comes
/// twice.
Outcome hanging_sheet(const Parameters& p) {
  const double zeros[] = {1.20241, 2.76004};
  const double length = 0.5;
  const int mode = std::min(p.count("mode"), 2);
  const int cells = p.count("cells");
  Scene scene = make_scene(make_sheet({length, length / cells, cells, 0, 0}, p),
                           membrane(density * gravity * length / p.positive("strain"), 0), 1);
  scene.gravity = {gravity, 0, 0};
  pin(scene, vertices_before(scene.cloths[0].mesh, 0));
  {
    Simulation simulation = start(scene);
    settle(simulation, 1e-12, 50);
    scene.cloths[0].mesh.positions = positions(simulation);
  }
  Vibration vibration;
  vibration.amplitude = 1e-6 * length;
  vibration.step = 2 * std::sqrt(length / gravity);
  vibration.modes = 2 * mode;
  vibration.rounds = 25;
  scene.solver.tolerance = 1e-12;
  scene.solver.newton_tolerance = 1e-10;
  const double square = vibration_squares(scene, vibration).back();
  return relative(std::sqrt(square * length / gravity), zeros[mode - 1], 0.01);
}

/// Stretch lambda of a strip without transverse contraction whose first Piola-Kirchhoff stress is
/// k lambda (lambda^2 - 1) / 2 = force.
double stretch_under(double force_over_k) {
  double stretch = 1;
  for (int n = 0; n < 50; ++n)
    stretch -=
        (stretch * (stretch * stretch - 1) / 2 - force_over_k) / ((3 * stretch * stretch - 1) / 2);
  return stretch;
}

/// Elongation of a strip that hangs from one edge, as a share of its length.
Outcome hanging_strip(const Parameters& p) {
  const double length = 0.5;
  const double load = p.positive("load");
  Scene scene = make_scene(make_sheet({length, length / 4, p.count("cells"), 0, 0}, p),
                           membrane(density * gravity * length / load, 0), 1);
  scene.gravity = {gravity, 0, 0};
  pin(scene, vertices_before(scene.cloths[0].mesh, 0));
  const auto tip = vertices_after(scene.cloths[0].mesh, length);
  Simulation simulation = start(std::move(scene));
  settle(simulation, 1e-10, 50);
  double reference = 0;
  constexpr int parts = 2000;
  for (int n = 0; n < parts; ++n) reference += stretch_under(load * (n + 0.5) / parts) - 1;
  return relative(mean_place(simulation, tip)[0] / length - 1, reference / parts, 0.01);
}

/// Half the span over the catenary's parameter: sinh(x) / x = length / span.
double catenary_argument(double length_over_span) {
  double low = 1e-6;
  double high = 20;
  while (high - low > 1e-14 * high) {
    const double x = (low + high) / 2;
    (std::sinh(x) / x < length_over_span ? low : high) = x;
  }
  return low;
}

/// Half the angle of the arc of a circle: x / sin(x) = length / span.
double arc_argument(double length_over_span) {
  double low = 1e-6;
  double high = 3.1;
  while (high - low > 1e-14 * high) {
    const double x = (low + high) / 2;
    (x / std::sin(x) < length_over_span ? low : high) = x;
  }
  return low;
}

/// Sag of a strip between two edges at one height, as a share of its length.
Outcome catenary(const Parameters& p) {
  const double length = 0.5;
  const double span = length * p.positive("span");
  Mesh mesh = make_sheet({length, length / 8, p.count("cells"), 0, 0}, p);
  const double half = arc_argument(length / span);
  const double radius = length / (2 * half);
  for (auto& x : mesh.positions) {
    const double angle = (2 * x[0] / length - 1) * half;
    x = {radius * std::sin(angle), x[1], radius * (std::cos(half) - std::cos(angle))};
  }
  Scene scene = make_scene(std::move(mesh),
                           membrane(density * gravity * length / p.positive("strain"), 0), 0.5);
  scene.gravity = {0, 0, -gravity};
  pin(scene, vertices_before(scene.cloths[0].mesh, 0));
  pin(scene, vertices_after(scene.cloths[0].mesh, length));
  const auto middle = vertices_where(scene.cloths[0].mesh, [&](const Vec2<double>& u) {
    return std::abs(u[0] - length / 2) < 1e-6 * length;
  });
  Simulation simulation = start(std::move(scene));
  settle(simulation, 1e-8, 100);
  const double argument = catenary_argument(length / span);
  const double sag = span / (2 * argument) * (std::cosh(argument) - 1);
  return relative(-mean_place(simulation, middle)[2] / length, sag / length, 0.01);
}

}  // namespace

std::vector<Test> hanging_tests() {
  return {{"hanging_sheet", "frequency of a sheet that swings from an edge; half the zeros of J0",
           std::vector<Parameter>{{"cells", "32", "along its length"},
                                  {"mode", "1", "1 or 2"},
                                  {"strain", "1e-3", "at the top"}} +
               mesh_parameters(),
           hanging_sheet},
          {"hanging_strip", "elongation under its own weight, as a share; quadrature of the law",
           std::vector<Parameter>{{"cells", "32", "along its length"},
                                  {"load", "0.1", "rho g L / (E h)"}} +
               mesh_parameters(),
           hanging_strip},
          {"catenary", "sag between two edges, over the length; that of an inextensible chain",
           std::vector<Parameter>{{"cells", "32", "along its length, even"},
                                  {"span", "0.8", "over the length"},
                                  {"strain", "1e-4", "about, at the ends"}} +
               mesh_parameters(),
           catenary}};
}

}  // namespace weft::physics
