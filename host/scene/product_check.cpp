#include "host/scene/product_check.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <string>
#include <vector>

#include "host/scene/checker.hpp"

namespace weft {
namespace {

/// Smallest and largest triangle, and all together, of the triangles of one material.
struct Areas {
  double least = std::numeric_limits<double>::infinity();
  double sum = 0;
};

double material_area(const Mesh& mesh, std::size_t t) {
  const Tri& tri = mesh.material_triangles.empty() ? mesh.triangles[t] : mesh.material_triangles[t];
  const auto at = [&](int k) { return mesh.material[static_cast<std::size_t>(tri.v[k])]; };
  const Vec2<double> a = at(1) - at(0);
  const Vec2<double> b = at(2) - at(0);
  return std::abs(a[0] * b[1] - a[1] * b[0]) / 2;
}

std::vector<Areas> areas_by_material(const Scene& scene) {
  std::vector<Areas> areas(scene.materials.size());
  for (const Cloth& cloth : scene.cloths)
    for (std::size_t t = 0; t < cloth.mesh.triangles.size(); ++t) {
      const Index material =
          cloth.triangle_material.empty() ? cloth.material : cloth.triangle_material[t];
      Areas& of = areas[static_cast<std::size_t>(material)];
      const double area = material_area(cloth.mesh, t);
      of.least = std::min(of.least, area);
      of.sum += area;
    }
  return areas;
}

double largest_bending(const Material& m) {
  if (!m.orthotropic_bending) return m.bending_stiffness;
  return std::max(m.orthotropic_bending->warp, m.orthotropic_bending->weft);
}

/// What leaves eight orders of magnitude of a float, and many more of a double, on either side.
struct Limits {
  double least, most;
  explicit Limits(Precision precision)
      : least(precision == Precision::single_precision ? 1e-30 : 1e-200), most(1 / least) {}
};

}  // namespace

void check_products(const Scene& scene) {
  const Limits limits(scene.precision);
  const Checker check(scene.file, "");
  const double step_sq = scene.time.step * scene.time.step;
  const auto require = [&](const std::string& field, const std::string& what, double value,
                           const char* unit) {
    if (!(value >= limits.least && value <= limits.most))
      check.refuse(field, what + " of " + text_of(value) + " " + unit,
                   short_number(limits.least) + " to " + short_number(limits.most) + " " + unit +
                       " in the run's precision");
  };
  const std::vector<Areas> areas = areas_by_material(scene);
  for (std::size_t i = 0; i < areas.size(); ++i) {
    if (!(areas[i].sum > 0)) continue;
    const Material& m = scene.materials[i];
    const std::string name = m.name.empty() ? numbered("materials", i) : "materials." + m.name;
    const double lightest = m.density * areas[i].least / 3;
    const double heaviest = m.density * areas[i].sum;
    require(name + ".density", "a smallest mass", lightest, "kg");
    require(name + ".density", "a total mass", heaviest, "kg");
    const double repulsion = scene.contact.stiffness / step_sq;
    require("contact.stiffness", "a least repulsion", repulsion * lightest, "N/m");
    require("contact.stiffness", "a greatest repulsion", repulsion * heaviest, "N/m");
    const double bending = largest_bending(m) * step_sq / areas[i].least;
    if (bending > 0 && bending > limits.most)
      require(name + ".bending_stiffness", "bending in a step", bending, "kg");
  }
}

}  // namespace weft
