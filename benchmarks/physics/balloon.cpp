// A balloon of two discs that are joined at their rims, of a film that does not stretch along its
// meridians and wrinkles freely across them (Paulsen 1994, "What is the shape of a Mylar
// balloon?").
#include <algorithm>
#include <cmath>
#include <numbers>

#include "benchmarks/physics/sheets.hpp"
#include "benchmarks/physics/statics.hpp"
#include "benchmarks/physics/test.hpp"
#include "weft/shapes.hpp"

namespace weft::physics {
namespace {

constexpr double radius = 0.1;      // [m] of the discs
constexpr double pressure = 100;    // [Pa]
constexpr double density = 0.05;    // [kg/m^2]
constexpr double exact = 0.762759;  // inflated over deflated radius: 4 sqrt(2 pi) / Gamma(1/4)^2

/// Two discs, one on the other, that share the vertices of their rims; fronts outwards. Every
/// triangle has a pattern of its own, whose first coordinate runs along the meridian.
Mesh two_discs(Index rings) {
  const Mesh disc = make_disc(radius, rings);
  const auto count = static_cast<Index>(disc.positions.size());
  const Index rim = count - 6 * rings;
  Mesh mesh;
  mesh.positions = disc.positions;
  mesh.positions.insert(mesh.positions.end(), disc.positions.begin(), disc.positions.begin() + rim);
  for (const bool below : {false, true})
    for (const Tri& t : disc.triangles) {
      Vec2<double> middle{};
      for (const Index v : t.v) middle += disc.material[static_cast<std::size_t>(v)];
      const Vec2<double> out = (1 / length(middle)) * middle;
      Tri corners{};
      Tri pattern{};
      for (int j = 0; j < 3; ++j) {
        // Seen from below, corners come the other way around.
        const Index v = t.v[below ? 2 - j : j];
        const Vec2<double> u = disc.material[static_cast<std::size_t>(v)];
        const double across = out[0] * u[1] - out[1] * u[0];
        corners.v[j] = below && v < rim ? count + v : v;
        pattern.v[j] = static_cast<Index>(mesh.material.size());
        mesh.material.push_back({dot(out, u), below ? -across : across});
      }
      mesh.triangles.push_back(corners);
      mesh.material_triangles.push_back(pattern);
    }
  return mesh;
}

/// A film that wrinkles more finely than any mesh can show: it bears tension along the meridians,
/// and next to nothing across them.
Material wrinkled_film(const Parameters& p) {
  const double stretch = pressure * radius / p.positive("strain");
  const double soft = p.positive("soft") * stretch;
  Material material;
  material.density = density;
  material.stretch_stiffness = stretch;
  material.poisson_ratio = 0;
  material.bending_stiffness = 0;
  material.orthotropic = OrthotropicStretch{stretch, soft, 0, p.positive("shear") * stretch};
  return material;
}

/// Mean radius of the rim of an inflated balloon over that of the discs.
Outcome mylar_balloon(const Parameters& p) {
  const auto rings = static_cast<Index>(p.count("rings", 2));
  Mesh mesh = two_discs(rings);
  const auto count = static_cast<Index>(make_disc(radius, rings).positions.size());
  const double bump = p.positive("bump") * radius;
  for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
    auto& x = mesh.positions[v];
    const double height = bump * (1 - (x[0] * x[0] + x[1] * x[1]) / (radius * radius));
    x[2] = static_cast<Index>(v) < count ? height : -height;
  }
  const double unit = std::sqrt(density * radius / pressure);
  Scene scene = make_scene(std::move(mesh), wrinkled_film(p), p.positive("step") * unit);
  scene.cloths[0].pressure = pressure;
  scene.bending = Bending::hinge;  // of no stiffness
  scene.solver.tolerance = 1e-4;
  scene.solver.newton_iterations = p.count("newton");
  scene.solver.newton_tolerance = 1e-4;
  Simulation simulation = start(std::move(scene));
  settle(simulation, p.positive("rest") * radius, 2000);
  const auto x = positions(simulation);
  // About its own middle: nothing holds a balloon in place.
  Vec3<double> middle{};
  for (Index v = count - 6 * rings; v < count; ++v)
    middle += (1.0 / (6 * rings)) * x[static_cast<std::size_t>(v)];
  double sum = 0;
  double low = 1e9;
  double high = 0;
  for (Index v = count - 6 * rings; v < count; ++v) {
    const Vec3<double> q = x[static_cast<std::size_t>(v)] - middle;
    const double r = std::hypot(q[0], q[1]);
    sum += r;
    low = std::min(low, r);
    high = std::max(high, r);
  }
  Outcome outcome = relative(sum / (6 * rings) / radius, exact, 0.02);
  outcome.more = {{"smallest", low / radius},
                  {"largest", high / radius},
                  {"height", (x[0][2] - x[static_cast<std::size_t>(count)][2]) / radius},
                  {"steps", static_cast<double>(simulation.step_number())}};
  return outcome;
}

}  // namespace

std::vector<Test> balloon_tests() {
  return {
      {"mylar_balloon",
       "radius of two joined discs when inflated, over that of the discs; Paulsen 1994",
       {{"rings", "16", "of triangles"},
        {"strain", "5e-3", "pressure times radius over the stiffness along the meridians"},
        {"soft", "1e-4", "stiffness across the meridians over that along them"},
        {"shear", "0.3", "shear stiffness in the same units; without effect on a round balloon"},
        {"bump", "0.2", "height of the middle at the start, over the radius"},
        {"step", "1", "in units of sqrt(density radius / pressure)"},
        {"newton", "10", "iterations a step"},
        {"rest", "1e-4", "largest move in a step at rest, over the radius"}},
       mylar_balloon}};
}

}  // namespace weft::physics
