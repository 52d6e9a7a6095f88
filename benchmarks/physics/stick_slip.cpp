// A strip that is pressed upright on a table: it buckles, and slips once its foot is pushed aside
// harder than friction holds (Romero et al. 2021, "stick-slip").
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "benchmarks/physics/sheets.hpp"
#include "benchmarks/physics/statics.hpp"
#include "benchmarks/physics/test.hpp"
#include "weft/error.hpp"
#include "weft/shapes.hpp"

namespace weft::physics {
namespace {

constexpr double strip_length = 0.1;  // [m] from the clamp to the foot
constexpr double density = 0.2;       // [kg/m^2]
constexpr double stiffness = 1e-4;    // [N m]
constexpr double thickness = 5e-4;    // [m] of contact

/// An inextensible strip of unit length and stiffness, clamped at its top, whose foot stands free
/// to turn under the clamp.
struct Elastica {
  double shortening = 0;            ///< 1 - height
  double force = 0;                 ///< at the foot
  std::vector<Vec2<double>> shape;  ///< from the foot, across and up, at even steps
};

struct Ends {
  double slope_at_clamp, offset, height;
};

/// theta'' = -F sin(theta + phi) from a foot without moment, theta the angle from the vertical, by
/// the classical rule of Runge and Kutta.
Ends integrate(double force, double phi, double foot_angle, std::vector<Vec2<double>>* shape) {
  constexpr int parts = 400;
  constexpr double h = 1.0 / parts;
  std::array<double, 4> y = {foot_angle, 0, 0, 0};
  const auto rate = [&](const std::array<double, 4>& q) {
    return std::array<double, 4>{q[1], -force * std::sin(q[0] + phi), std::sin(q[0]),
                                 std::cos(q[0])};
  };
  const auto moved = [](const std::array<double, 4>& q, const std::array<double, 4>& k, double s) {
    return std::array<double, 4>{q[0] + s * k[0], q[1] + s * k[1], q[2] + s * k[2],
                                 q[3] + s * k[3]};
  };
  if (shape != nullptr) *shape = {{0, 0}};
  for (int n = 0; n < parts; ++n) {
    const auto a = rate(y);
    const auto b = rate(moved(y, a, h / 2));
    const auto c = rate(moved(y, b, h / 2));
    const auto d = rate(moved(y, c, h));
    for (std::size_t k = 0; k < 4; ++k) y[k] += h / 6 * (a[k] + 2 * b[k] + 2 * c[k] + d[k]);
    if (shape != nullptr) shape->push_back({y[2], y[3]});
  }
  return {y[0], y[2], y[3]};
}

/// The strip whose foot is pushed aside with `ratio` of what it stands on: Newton's method for the
/// force and the angle at the foot, from the limit of small ratios (tan x = x).
/// @param ratio 0.001 to 0.5
/// @throws SceneError outside of that
Elastica standing_strip(double ratio) {
  if (!(ratio >= 0.001 && ratio <= 0.5))
    throw SceneError("", "mu", std::to_string(ratio), "0.001 to 0.5");
  const double phi = -std::atan(ratio);
  // In the limit theta + phi = a cos(k s) with k = tan k, and theta vanishes at the clamp.
  const double k = 4.493409457909064;
  double force = k * k;
  double foot = -phi * (1 - 1 / std::cos(k));
  for (int n = 0; n < 50; ++n) {
    const Ends e = integrate(force, phi, foot, nullptr);
    const double df = 1e-6 * force;
    const double da = 1e-7;
    const Ends f = integrate(force + df, phi, foot, nullptr);
    const Ends a = integrate(force, phi, foot + da, nullptr);
    const double m00 = (f.slope_at_clamp - e.slope_at_clamp) / df;
    const double m10 = (f.offset - e.offset) / df;
    const double m01 = (a.slope_at_clamp - e.slope_at_clamp) / da;
    const double m11 = (a.offset - e.offset) / da;
    const double det = m00 * m11 - m01 * m10;
    const double step_force = (m11 * e.slope_at_clamp - m01 * e.offset) / det;
    const double step_angle = (m00 * e.offset - m10 * e.slope_at_clamp) / det;
    force -= step_force;
    foot -= step_angle;
    if (std::abs(step_force) < 1e-9 * force && std::abs(step_angle) < 1e-10) break;
  }
  Elastica strip;
  strip.force = force;
  strip.shortening = 1 - integrate(force, phi, foot, &strip.shape).height;
  return strip;
}

/// Where a point of the strip is, `up` of its length from the foot.
Vec2<double> place_on(const Elastica& strip, double up) {
  const double at = up * static_cast<double>(strip.shape.size() - 1);
  const auto n = std::min(static_cast<std::size_t>(at), strip.shape.size() - 2);
  const double share = at - static_cast<double>(n);
  return (1 - share) * strip.shape[n] + share * strip.shape[n + 1];
}

/// The strip as it stands with a little of the push that makes it slip, and the table.
Scene strip_on_table(const Parameters& p, const Elastica& begin, double step) {
  Material material;
  material.density = density;
  material.bending_stiffness = stiffness;
  material.poisson_ratio = 0;
  material.damping_mass = p.number("damping");
  const double sheet = strip_length / p.positive("slenderness");
  material.stretch_stiffness = 12 * stiffness / (sheet * sheet);
  const double width = strip_length * p.positive("width");
  Mesh mesh = make_sheet({strip_length, width, p.count("cells"), 1, 0}, p);
  const double top = (1 - begin.shortening) * strip_length;
  for (auto& x : mesh.positions) {
    // The sheet's x runs from the clamp down.
    const double down = x[0] / strip_length;
    const Vec2<double> q = down <= 0
                               ? Vec2<double>{place_on(begin, 1)[0], 1 - begin.shortening - down}
                               : place_on(begin, 1 - down);
    x = {strip_length * q[0], x[1], strip_length * q[1] + 0.99 * thickness};
  }
  Scene scene = make_scene(std::move(mesh), material, step);
  scene.bending = bending_of(p);
  scene.contact.thickness = thickness;
  scene.solver.tolerance = 1e-7;
  scene.solver.newton_iterations = p.count("newton");
  scene.solver.newton_tolerance = 1e-6;
  Obstacle table;
  table.name = "table";
  table.mesh = make_grid({4 * top, 4 * top}, {1, 1}, Diagonals::same);
  table.mesh.material.clear();
  // The foot stands within one of the two triangles.
  for (auto& x : table.mesh.positions) x += Vec3<double>{top, -0.4 * top, 0};
  table.friction = p.positive("mu");
  scene.obstacles = {table};
  return scene;
}

/// Shortening (L - height) / L at which the foot slips first.
Outcome stick_slip(const Parameters& p) {
  const double mu = p.positive("mu");
  const Elastica slipping = standing_strip(mu);
  const Elastica begin = standing_strip(mu * p.positive("begin"));
  const double h = p.positive("step");
  const double time = p.positive("time");
  Scene scene = strip_on_table(p, begin, h);
  const Mesh& mesh = scene.cloths[0].mesh;
  const auto clamp = vertices_before(mesh, 0);
  const auto foot = vertices_after(mesh, strip_length);
  const auto edge = vertices_where(
      mesh, [](const Vec2<double>& u) { return std::abs(u[0]) < 1e-6 * strip_length; });
  // Cubic between keys: of even speed from the second on.
  const double way = (1.5 * slipping.shortening - begin.shortening) * strip_length;
  Pin pin;
  pin.vertices = clamp;
  for (int k = 0; k <= 8; ++k) {
    Transform there;
    there.translate = {0, 0, -way * k / 8};
    pin.motion.push_back({time * k / 8, there});
  }
  scene.pins.push_back(pin);
  Simulation simulation = start(std::move(scene));
  const auto shortening = [&] {
    return 1 - (mean_place(simulation, edge)[2] - mean_place(simulation, foot)[2]) / strip_length;
  };
  const int settling = static_cast<int>(0.05 * time / h);
  advance(simulation, settling);
  const double stands = mean_place(simulation, foot)[0];
  const double slip = p.positive("slip") * strip_length;
  double crept = 0;
  double half_way = 0;
  while (simulation.time() < time) {
    advance(simulation, 1);
    crept = std::abs(mean_place(simulation, foot)[0] - stands);
    const double now = shortening();
    if (now < (begin.shortening + slipping.shortening) / 2) half_way = crept;
    if (crept > slip) {
      Outcome outcome = relative(now, slipping.shortening, 0.03);
      outcome.more = {{"crept_half_way", half_way / strip_length}};
      return outcome;
    }
  }
  throw SimulationError("the strip's foot does not slip");
}

}  // namespace

std::vector<Test> stick_slip_tests() {
  return {
      {"stick_slip",
       "(L - height) / L at which a strip that is pressed on a table slips; elastica, 0.0469 "
       "for mu = 0.1",
       std::vector<Parameter>{{"mu", "0.1", "0.001 to 0.5"},
                              {"cells", "24", "along the strip"},
                              {"width", "0.2", "over the length"},
                              {"slenderness", "300", "length over thickness"},
                              {"begin", "0.4", "share of the push at which the strip starts"},
                              {"slip", "0.0002", "way of the foot that counts, over the length"},
                              {"damping", "10", "[1/s] of mass"},
                              {"step", "0.001", "[s]"},
                              {"time", "4", "[s] in which the clamp comes down"},
                              {"newton", "3", "iterations a step"}} +
           bending_parameter() + mesh_parameters(),
       stick_slip}};
}

}  // namespace weft::physics
