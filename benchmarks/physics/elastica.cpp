// Strips that bend a lot: under their weight, a load or a moment at the tip.
#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "benchmarks/physics/sheets.hpp"
#include "benchmarks/physics/statics.hpp"
#include "benchmarks/physics/test.hpp"
#include "weft/error.hpp"

namespace weft::physics {
namespace {

constexpr double strip_length = 0.2;  // [m] from the second clamped column of vertices
constexpr double density = 0.2;       // [kg/m^2]

std::vector<Parameter> strip_parameters() {
  return std::vector<Parameter>{{"cells", "32", "along the strip"},
                                {"width", "0.25", "over the length"},
                                {"slenderness", "300", "length over thickness"},
                                {"nu", "0", "Poisson's ratio; the references take 0"},
                                {"pace", "1", "step, in units of 10 over the lowest frequency"}} +
         bending_parameter() + mesh_parameters();
}

/// A strip along x, the first two columns of vertices clamped, and how stiff it is.
Scene strip(const Parameters& p, double bending_stiffness, int columns_after,
            bool mirrored = false) {
  const double nu = p.number("nu");
  const double thickness = strip_length / p.positive("slenderness");
  Material material;
  material.density = density;
  material.bending_stiffness = bending_stiffness;
  material.poisson_ratio = nu;
  material.stretch_stiffness = 12 * (1 - nu * nu) * bending_stiffness / (thickness * thickness);
  const SheetShape shape{strip_length,     strip_length * p.positive("width"),
                         p.count("cells"), 1,
                         columns_after,    mirrored};
  const double period =
      strip_length * strip_length * std::sqrt(density / bending_stiffness) / 3.516;
  Scene scene = make_scene(make_sheet(shape, p), material, 10 * p.positive("pace") * period);
  scene.bending = bending_of(p);
  // Newton's method and settle() see to the accuracy; thin strips make stiff systems.
  scene.solver.tolerance = 1e-4;
  scene.solver.newton_tolerance = 1e-6;
  pin(scene, vertices_before(scene.cloths[0].mesh, 0));
  return scene;
}

/// 1 % where cells are alike and well shaped, 3 % elsewhere.
double tolerance_of(const Parameters& p) {
  const std::string& mesh = p.text("mesh");
  return mesh == "aligned" || mesh == "rotated" ? 0.01 : 0.03;
}

/// Drop of the tip over its horizontal distance from the clamp.
Outcome cantilever(const Parameters& p) {
  const double gravity = 9.81;
  const double gamma = p.positive("gamma");
  const double reference = table_value("heavy_elastica.csv", "H_over_W", gamma);
  Scene scene = strip(p, density * gravity * std::pow(strip_length, 3) / gamma, 0);
  scene.gravity = {0, 0, -gravity};
  const auto tip = vertices_after(scene.cloths[0].mesh, strip_length);
  Simulation simulation = start(std::move(scene));
  settle(simulation, 1e-6 * strip_length, 300);
  const Vec3<double> place = mean_place(simulation, tip);
  Outcome outcome = relative(-place[2] / place[0], reference, tolerance_of(p));
  outcome.more = {{"steps", static_cast<double>(simulation.step_number())}};
  return outcome;
}

/// Deflection of the tip under a load of fixed direction there, over the length.
Outcome tip_load(const Parameters& p) {
  const double stiffness = 1e-4;
  const double alpha = p.positive("alpha");
  const double reference = table_value("tip_load_elastica.csv", "W_over_L", alpha);
  Scene scene = strip(p, stiffness, 0);
  const double width = strip_length * p.positive("width");
  const auto tip = vertices_after(scene.cloths[0].mesh, strip_length);
  const double force = alpha * stiffness / (strip_length * strip_length) * width;
  add_dead_load(scene, tip, line_shares(scene.cloths[0].mesh, tip), {0, 0, -force}, strip_length);
  Simulation simulation = start(std::move(scene));
  settle(simulation, 1e-6 * strip_length, 300);
  const Vec3<double> place = mean_place(simulation, tip);
  Outcome outcome = relative(-place[2] / strip_length, reference, 0.01);
  outcome.more = {{"shortening", 1 - place[0] / strip_length},
                  {"steps", static_cast<double>(simulation.step_number())}};
  return outcome;
}

/// Curvature of the circle that is nearest to points of the xz plane, by least squares (Kasa 1976).
double circle_curvature(const std::vector<Vec3<double>>& points) {
  Eigen::MatrixXd a(static_cast<Eigen::Index>(points.size()), 3);
  Eigen::VectorXd b(a.rows());
  for (Eigen::Index n = 0; n < a.rows(); ++n) {
    const auto& x = points[static_cast<std::size_t>(n)];
    a.row(n) << 2 * x[0], 2 * x[2], 1;
    b[n] = x[0] * x[0] + x[2] * x[2];
  }
  const Eigen::Vector3d c = a.colPivHouseholderQr().solve(b);
  return 1 / std::sqrt(c[2] + c[0] * c[0] + c[1] * c[1]);
}

/// Two columns of vertices at the end of a strip, which take a couple.
struct EndColumns {
  std::vector<Index> inner, outer;
};

EndColumns end_columns(const Mesh& mesh, double cell) {
  const auto column = [&](double x) {
    return vertices_where(
        mesh, [&](const Vec2<double>& u) { return std::abs(u[0] - x) < 1e-6 * strip_length; });
  };
  return {column(strip_length), column(strip_length + cell)};
}

Vec3<double> mean_of(const std::vector<Vec3<double>>& x, const std::vector<Index>& vertices) {
  Vec3<double> sum{};
  for (const Index v : vertices) sum += x[static_cast<std::size_t>(v)];
  return (1.0 / static_cast<double>(vertices.size())) * sum;
}

/// Angle of the strip's end above the x axis, -pi to pi. [rad]
double end_angle(const std::vector<Vec3<double>>& x, const EndColumns& end) {
  const Vec3<double> along = mean_of(x, end.outer) - mean_of(x, end.inner);
  return std::atan2(along[2], along[0]);
}

/// Equilibrium under a couple that follows the end: two forces whose direction is set from where
/// the end is thought to be, and again from where it came to be, until that is the same. The forces
/// lag behind the normal of the end by a constant angle, and are larger by what their lever is
/// shorter: a couple of fixed direction holds an end that is ahead of it, and lets go of one that
/// is not, in the plane as well as out of it.
/// @param angle [rad] of the end, to begin with
/// @param x     where to start, and the equilibrium
/// @throws SimulationError if a round does not come to rest
void settle_under_couple(const Scene& base, const EndColumns& end, double moment, double cell,
                         double angle, double accuracy, std::vector<Vec3<double>>& x) {
  constexpr int rounds_max = 30;
  constexpr double lag = 0.5;  // [rad]
  for (int round = 0; round < rounds_max; ++round) {
    Scene scene = base;
    scene.cloths[0].mesh.positions = x;
    const double direction = angle - lag;
    const Vec3<double> across = moment / (cell * std::cos(lag)) *
                                Vec3<double>{-std::sin(direction), 0, std::cos(direction)};
    add_dead_load(scene, end.inner, line_shares(base.cloths[0].mesh, end.inner), -1.0 * across,
                  strip_length);
    add_dead_load(scene, end.outer, line_shares(base.cloths[0].mesh, end.outer), across,
                  strip_length);
    Simulation simulation = start(std::move(scene));
    settle(simulation, std::min(0.1 * accuracy, 0.01) * strip_length, 30);
    x = positions(simulation);
    const double turned = std::remainder(end_angle(x, end) - angle, 2 * std::numbers::pi);
    if (std::abs(turned) <= accuracy) return;
    angle += turned;
  }
  throw SimulationError("the couple at the end does not come to rest");
}

/// Turns of a strip under the end moment 2 pi B / L, from the circle that it forms.
Outcome roll_up(const Parameters& p) {
  const double stiffness = 1e-4;
  const Scene scene = strip(p, stiffness, 1, true);
  const Mesh& mesh = scene.cloths[0].mesh;
  const double cell = strip_length / p.count("cells");
  const double width = strip_length * p.positive("width");
  const double moment = 2 * std::numbers::pi * stiffness / strip_length * width;
  const EndColumns end = end_columns(mesh, cell);
  const int ramp = p.count("ramp");
  auto x = mesh.positions;
  for (int n = 1; n <= ramp; ++n) {
    const double angle = end_angle(x, end) + 2 * std::numbers::pi / ramp;
    settle_under_couple(scene, end, moment * n / ramp, cell, angle, n < ramp ? 1 : 1e-3, x);
  }
  std::vector<Vec3<double>> middle;
  for (std::size_t v = 0; v < x.size(); ++v)
    if (std::abs(mesh.material[v][0] / strip_length - 0.5) <= 0.4) middle.push_back(x[v]);
  const double curvature = circle_curvature(middle);
  Outcome outcome = relative(curvature * strip_length / (2 * std::numbers::pi), 1, 0.01);
  outcome.more = {{"gap", length(mean_of(x, end.inner)) / strip_length},
                  {"end_angle_error", end_angle(x, end)}};
  return outcome;
}

}  // namespace

std::vector<Test> elastica_tests() {
  // What has little to do with bending can be soft.
  std::vector<Parameter> rolled = strip_parameters();
  for (Parameter& p : rolled)
    if (p.key == "slenderness") p.value = "100";
  return {
      {"cantilever", "H/W of a strip under its own weight; heavy_elastica.csv",
       std::vector<Parameter>{{"gamma", "10", "rho g L^3 / B"}} + strip_parameters(), cantilever},
      {"tip_load", "deflection over length under a load at the tip; tip_load_elastica.csv",
       std::vector<Parameter>{{"alpha", "4", "P L^2 / B, P a width"}} + strip_parameters(),
       tip_load},
      {"roll_up", "turns under the end moment 2 pi B / L, from the circle formed; 1",
       std::vector<Parameter>{{"ramp", "20", "parts in which the moment is applied"}} +
           strip_parameters(),
       roll_up}};
}

}  // namespace weft::physics
