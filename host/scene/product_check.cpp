#include "host/scene/product_check.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <string>
#include <vector>

#include "host/input/checker.hpp"
#include "host/scene/fabric/material_areas.hpp"
#include "host/scene/frame_steps.hpp"
#include "host/scene/validate.hpp"

namespace weft {
namespace {

/// Edges as long as they may be make this many triangles at least.
void check_remeshed_size(const Scene& scene, std::size_t c) {
  const Cloth& cloth = scene.cloths[c];
  const Remeshing& r = cloth.remeshing ? *cloth.remeshing : scene.adaptive.remeshing;
  if (!(r.size_max > 0)) return;
  double area = 0;
  for (std::size_t t = 0; t < cloth.mesh.triangles.size(); ++t)
    area += material_area(cloth.mesh, t);
  const double triangles = area / (std::sqrt(3.0) / 4 * r.size_max * r.size_max);
  const std::string owner = cloth.remeshing ? numbered("cloths", c) + ".remeshing" : "remeshing";
  if (triangles > static_cast<double>(most_elements))
    Checker(scene.file, owner)
        .refuse("size[1]",
                text_of(r.size_max) + " (" + text_of(std::floor(triangles)) + " triangles)",
                "a size that makes up to " + std::to_string(most_elements) + " triangles");
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
  const double step_sq = longest_step(scene.time) * longest_step(scene.time);
  const auto require = [&](const std::string& field, const std::string& what, double value,
                           const char* unit) {
    if (!(value >= limits.least && value <= limits.most))
      check.refuse(field, what + " of " + text_of(value) + " " + unit,
                   short_number(limits.least) + " to " + short_number(limits.most) + " " + unit +
                       " in the run's precision");
  };
  if (remeshes(scene) || slices_remesh(scene))
    for (std::size_t c = 0; c < scene.cloths.size(); ++c) check_remeshed_size(scene, c);
  const std::vector<MaterialAreas> areas = areas_by_material(scene);
  for (std::size_t i = 0; i < areas.size(); ++i) {
    if (!(areas[i].sum > 0)) continue;
    const Material& m = scene.materials[i];
    const std::string name = m.name.empty() ? numbered("materials", i) : "materials." + m.name;
    const double lightest = m.density * areas[i].least / 3;
    const double heaviest = m.density * areas[i].sum;
    require(name + ".density", "a smallest mass", lightest, "kg");
    require(name + ".density", "a total mass", heaviest, "kg");
    const double repulsion = scene.contact.stiffness / step_sq;
    require("time.step", "a least repulsion", repulsion * lightest, "N/m");
    require("time.step", "a greatest repulsion", repulsion * heaviest, "N/m");
    const double bending = largest_bending(m) * step_sq / areas[i].least;
    if (bending > 0 && bending > limits.most)
      require(name + ".bending_stiffness", "bending in a step", bending, "kg");
  }
}

}  // namespace weft
