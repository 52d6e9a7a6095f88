// Loads at which a flat strip or plate leaves its plane: where the lowest frequency vanishes.
#include <cmath>
#include <functional>
#include <numbers>

#include "benchmarks/physics/lateral_reference.hpp"
#include "benchmarks/physics/sheets.hpp"
#include "benchmarks/physics/statics.hpp"
#include "benchmarks/physics/test.hpp"

namespace weft::physics {
namespace {

constexpr double plate_length = 0.2;  // [m] from the second clamped column of vertices
constexpr double density = 0.2;       // [kg/m^2]
constexpr double stiffness = 1e-4;    // [N m]

std::vector<Parameter> plate_parameters() {
  return std::vector<Parameter>{{"cells", "24", "along the length"},
                                {"slenderness", "100", "length over thickness"}} +
         bending_parameter() + mesh_parameters();
}

Scene plate(const Parameters& p, double width) {
  const double nu = p.number("nu");
  const double thickness = plate_length / p.positive("slenderness");
  Material material;
  material.density = density;
  material.bending_stiffness = stiffness;
  material.poisson_ratio = nu;
  material.stretch_stiffness = 12 * (1 - nu * nu) * stiffness / (thickness * thickness);
  Scene scene =
      make_scene(make_sheet({plate_length, width, p.count("cells"), 1, 0}, p), material, 1);
  scene.bending = bending_of(p);
  pin(scene, vertices_before(scene.cloths[0].mesh, 0));
  return scene;
}

/// Square of the lowest frequency across the plane, about equilibrium in the plane, in units of
/// D / (rho L^4).
double lowest_square(Scene scene) {
  const double unit = std::sqrt(stiffness / density) / (plate_length * plate_length);
  scene.time.step = 0.3 / unit;
  scene.time.frame_rate = 1 / scene.time.step;
  {
    Scene planar = scene;
    planar.solver.tolerance = 1e-6;
    Simulation simulation = start(std::move(planar));
    settle(simulation, 1e-9 * plate_length, 50);
    scene.cloths[0].mesh.positions = positions(simulation);
    for (auto& x : scene.cloths[0].mesh.positions) x[2] = 0;
  }
  scene.solver.tolerance = 1e-8;
  scene.solver.newton_tolerance = 1e-8;
  Vibration vibration;
  vibration.amplitude = 1e-5 * plate_length;
  vibration.step = 0.3 / unit;
  vibration.rounds = 8;
  return vibration_squares(scene, vibration).front() / (unit * unit);
}

/// Where a function that falls is zero, from two guesses below; it is nearly a parabola in the
/// load.
double zero_of(const std::function<double(double)>& square, double guess) {
  double a = 0.8 * guess;
  double b = 0.95 * guess;
  double fa = square(a);
  double fb = square(b);
  for (int n = 0; n < 3; ++n) {
    const double c = b - fb * (b - a) / (fb - fa);
    a = b;
    fa = fb;
    b = c;
    if (std::abs(b / a - 1) < 1e-3) break;
    fb = square(b);
  }
  return b;
}

/// Load at the free end that buckles a clamped strip, in units of pi^2 B / (4 L^2) a width.
Outcome euler_buckling(const Parameters& p) {
  const double width = plate_length / 8;
  const Scene base = plate(p, width);
  const auto tip = vertices_after(base.cloths[0].mesh, plate_length);
  const auto shares = line_shares(base.cloths[0].mesh, tip);
  const double unit =
      std::numbers::pi * std::numbers::pi / 4 * stiffness / (plate_length * plate_length) * width;
  const double load = zero_of(
      [&](double force) {
        Scene scene = base;
        add_dead_load(scene, tip, shares, {-force * unit, 0, 0}, plate_length);
        return lowest_square(std::move(scene));
      },
      1);
  return p.number("nu") == 0 ? relative(load, 1, 0.02) : unjudged(load);
}

/// Weight at which a plate that is clamped at one end, its width vertical, falls sideways.
Outcome lateral_buckling(const Parameters& p) {
  const double nu = p.number("nu");
  const double ratio = p.positive("ratio");
  const double reference = lateral_buckling_load(ratio, nu);
  const Scene base = plate(p, plate_length * ratio);
  const double load = zero_of(
      [&](double weight) {
        Scene scene = base;
        scene.gravity = {0, -weight * stiffness / (density * std::pow(plate_length, 3)), 0};
        return lowest_square(std::move(scene));
      },
      reference);
  const std::string& mesh = p.text("mesh");
  Outcome outcome = relative(load, reference, mesh == "aligned" || mesh == "rotated" ? 0.03 : 0.05);
  outcome.more = {{"slender_limit", slender_lateral_load(nu)}};
  return outcome;
}

/// The reference itself, for a plate so slender that the limit is known.
Outcome lateral_limit(const Parameters& p) {
  const double nu = p.number("nu");
  return relative(lateral_buckling_load(p.positive("ratio"), nu), slender_lateral_load(nu), 0.02);
}

}  // namespace

std::vector<Test> buckling_tests() {
  return {
      {"euler_buckling", "end load of a clamped strip over pi^2 B / (4 L^2); 1",
       std::vector<Parameter>{{"nu", "0", "Poisson's ratio"}} + plate_parameters(), euler_buckling},
      {"lateral_buckling", "rho g L^3 / D at which it falls sideways; Ritz's method",
       std::vector<Parameter>{{"ratio", "0.25", "width over length"},
                              {"nu", "0", "Poisson's ratio"}} +
           plate_parameters(),
       lateral_buckling},
      {"lateral_limit",
       "no simulation: Ritz's method against Prandtl's slender limit",
       {{"ratio", "0.02", "width over length"}, {"nu", "0", "Poisson's ratio"}},
       lateral_limit}};
}

}  // namespace weft::physics
