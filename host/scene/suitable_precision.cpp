#include "host/scene/suitable_precision.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "host/scene/fabric/material_areas.hpp"
#include "host/scene/fabric/rigidity.hpp"
#include "host/scene/frame_steps.hpp"

namespace weft {
namespace {

/// r of suitable_precision() from which double precision is suitable.
constexpr double stiffest_single = 1e7;

double stretch_stiffness(const Material& m) {
  if (m.orthotropic) return std::max(m.orthotropic->warp, m.orthotropic->weft);
  if (m.measured) return 2 * std::max(m.measured->rows[0][0], m.measured->rows[0][2]);
  return m.stretch_stiffness;
}

}  // namespace

Precision suitable_precision(const Scene& scene) {
  if (scene.method == "asynchronous") return Precision::double_precision;
  const double h = longest_step(scene.time);
  const double refinement =
      scene.refinement.when == Refinement::When::never ? 1 : std::pow(4.0, scene.refinement.levels);
  const std::vector<MaterialAreas> areas = areas_by_material(scene);
  for (std::size_t i = 0; i < areas.size(); ++i) {
    if (!(areas[i].sum > 0)) continue;
    const Material& m = scene.materials[i];
    const double area = areas[i].sum / areas[i].count / refinement;
    const double stiffness = stretch_stiffness(m) + mean_bending_stiffness(m) / area;
    if (h * (h + m.damping_stiffness) * stiffness > stiffest_single * m.density * area)
      return Precision::double_precision;
  }
  return Precision::single_precision;
}

}  // namespace weft
