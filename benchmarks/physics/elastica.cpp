// Strips that bend a lot: under their weight, a load or a moment at the tip.
#include <Eigen/Dense>
#include <cmath>
#include <numbers>

#include "benchmarks/physics/sheets.hpp"
#include "benchmarks/physics/statics.hpp"
#include "benchmarks/physics/test.hpp"

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
Scene strip(const Parameters& p, double bending_stiffness, int columns_after) {
  const double nu = p.number("nu");
  const double thickness = strip_length / p.positive("slenderness");
  Material material;
  material.density = density;
  material.bending_stiffness = bending_stiffness;
  material.poisson_ratio = nu;
  material.stretch_stiffness = 12 * (1 - nu * nu) * bending_stiffness / (thickness * thickness);
  const SheetShape shape{strip_length, strip_length * p.positive("width"), p.count("cells"), 1,
                         columns_after};
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

/// A couple at the end, of two columns of vertices, that grows and turns with the end: forces of
/// the direction that the end should have by then.
void add_end_couple(Scene& scene, double moment, double cell, int ramp_steps) {
  const Mesh& mesh = scene.cloths[0].mesh;
  const double far = 1e7 * strip_length;
  const double h = scene.time.step;
  for (const int side : {0, 1}) {
    const double x = strip_length + side * cell;
    const auto line = vertices_where(
        mesh, [&](const Vec2<double>& u) { return std::abs(u[0] - x) < 1e-6 * strip_length; });
    const auto shares = line_shares(mesh, line);
    Motion motion;
    for (int n = 0; n <= ramp_steps; ++n) {
      const double share = static_cast<double>(n) / ramp_steps;
      const double angle = 2 * std::numbers::pi * share;
      Transform there;
      there.translate =
          (side == 1 ? far : -far) * share * Vec3<double>{-std::sin(angle), 0, std::cos(angle)};
      motion.push_back({n * h, there});
    }
    for (std::size_t k = 0; k < line.size(); ++k) {
      Handle handle;
      handle.vertices = {line[k]};
      handle.stiffness = shares[k] * moment / cell / far;
      handle.motion = motion;
      scene.handles.push_back(std::move(handle));
    }
  }
}

/// Turns of a strip under the end moment 2 pi B / L, from the circle that it forms.
Outcome roll_up(const Parameters& p) {
  const double stiffness = 1e-4;
  Scene scene = strip(p, stiffness, 1);
  const double cell = strip_length / p.count("cells");
  const double width = strip_length * p.positive("width");
  const int ramp = p.count("ramp");
  add_end_couple(scene, 2 * std::numbers::pi * stiffness / strip_length * width, cell, ramp);
  const Mesh mesh = scene.cloths[0].mesh;
  Simulation simulation = start(std::move(scene));
  advance(simulation, ramp);
  settle(simulation, 1e-6 * strip_length, 300);
  const auto x = positions(simulation);
  std::vector<Vec3<double>> middle;
  for (std::size_t v = 0; v < x.size(); ++v)
    if (std::abs(mesh.material[v][0] / strip_length - 0.5) <= 0.4) middle.push_back(x[v]);
  const double curvature = circle_curvature(middle);
  Outcome outcome = relative(curvature * strip_length / (2 * std::numbers::pi), 1, 0.01);
  const auto end = vertices_where(mesh, [&](const Vec2<double>& u) {
    return std::abs(u[0] - strip_length) < 1e-6 * strip_length;
  });
  outcome.more = {{"gap", length(mean_place(simulation, end)) / strip_length}};
  return outcome;
}

}  // namespace

std::vector<Test> elastica_tests() {
  return {
      {"cantilever", "H/W of a strip under its own weight; heavy_elastica.csv",
       std::vector<Parameter>{{"gamma", "10", "rho g L^3 / B"}} + strip_parameters(), cantilever},
      {"tip_load", "deflection over length under a load at the tip; tip_load_elastica.csv",
       std::vector<Parameter>{{"alpha", "4", "P L^2 / B, P a width"}} + strip_parameters(),
       tip_load},
      {"roll_up", "turns under the end moment 2 pi B / L, from the circle formed; 1",
       std::vector<Parameter>{{"ramp", "20", "steps in which the moment grows"}} +
           strip_parameters(),
       roll_up}};
}

}  // namespace weft::physics
