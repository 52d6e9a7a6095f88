#include "host/state/energy.hpp"

#include <algorithm>

#include "host/base/parallel.hpp"
#include "host/model/material_rows.hpp"
#include "weft/elements/hinge.hpp"
#include "weft/elements/spring.hpp"

namespace weft {
namespace {

double compression_of(const Model& model, std::size_t triangle) {
  return model.compression.empty() ? 1 : model.compression[triangle];
}

}  // namespace

Energy measure_energy(const Scene& scene, const Model& model,
                      const std::vector<Vec3<double>>& positions,
                      const std::vector<Vec3<double>>& velocities,
                      const std::vector<Spring<double>>& springs, const PlateMatrix& plate) {
  Energy energy;
  energy.kinetic = sum_of(velocities.size(), [&](std::size_t v) {
    return model.mass[v] / 2 * length_sq(velocities[v]);
  });
  energy.gravitational = sum_of(velocities.size(), [&](std::size_t v) {
    return -model.mass[v] * dot(scene.gravity, positions[v]);
  });
  const MaterialRows<double>& materials = model.laws->rows;
  const auto at = [&](Index v) { return positions[static_cast<std::size_t>(v)]; };
  energy.elastic = sum_of(model.area.size(), [&](std::size_t t) {
    const Tri& tri = model.triangles[t];
    const Vec3<double> x[3] = {at(tri.v[0]), at(tri.v[1]), at(tri.v[2])};
    return stretching_energy(materials, model.material[t], x, model.inv_rest[t], model.area[t],
                             compression_of(model, t));
  });
  energy.elastic += sum_of(model.hinges.size(), [&](std::size_t h) {
    const Hinge& hinge = model.hinges[h];
    const Vec3<double> x[4] = {at(hinge.v[0]), at(hinge.v[1]), at(hinge.v[2]), at(hinge.v[3])};
    return hinge_energy(x, model.hinge_rest_angle[h], model.hinge_stiffness[h]);
  });
  energy.elastic += plate_energy(plate, positions);
  for (const Spring<double>& spring : springs)
    energy.elastic += spring_energy(
        spring_span(at(spring.v[0]) - (spring.v[1] < 0 ? spring.anchor : at(spring.v[1])),
                    spring.along),
        spring.rest, spring.stiffness);
  return energy;
}

double largest_limit_excess(const Model& model, const std::vector<Vec3<double>>& positions) {
  const MaterialRows<double>& materials = model.laws->rows;
  if (!has_limits(materials)) return 0;
  const auto at = [&](Index v) { return positions[static_cast<std::size_t>(v)]; };
  double largest = 0;
  for (std::size_t t = 0; t < model.area.size(); ++t) {
    const Tri& tri = model.triangles[t];
    const Vec3<double> x[3] = {at(tri.v[0]), at(tri.v[1]), at(tri.v[2])};
    largest = std::max(largest, limit_excess(materials, model.material[t], x, model.inv_rest[t],
                                             compression_of(model, t)));
  }
  return largest;
}

}  // namespace weft
