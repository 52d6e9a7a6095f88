#include "host/model/material_rows.hpp"

#include <algorithm>
#include <cmath>

#include "host/scene/fabric/material_areas.hpp"
#include "host/scene/fabric/measured.hpp"

namespace weft {
namespace {

/// [m/s] The limits of a sheet stop parts of it that fly apart this fast, ...
constexpr double limit_speed = 2.5;
/// ... are at least so many times as stiff as its threads, ...
constexpr double limit_ratio = 20;
/// ... and hold so many times the weight of the heaviest cloth by a single triangle: cloth that
/// swings by a corner pulls harder than cloth at rest.
constexpr double limit_weights = 2;

/// Of the heaviest cloth, rounded to an eighth of an octave: that of its mesh in the course of a
/// run differs by rounding. [N]
double largest_weight(const Scene& scene) {
  double mass = 0;
  for (const Cloth& cloth : scene.cloths) {
    double sum = 0;
    for (std::size_t t = 0; t < cloth.mesh.triangles.size(); ++t) {
      const Index material =
          cloth.triangle_material.empty() ? cloth.material : cloth.triangle_material[t];
      sum += material_area(cloth.mesh, t) *
             scene.materials[static_cast<std::size_t>(material)].density;
    }
    mass = std::max(mass, sum);
  }
  const double weight = mass * length(scene.gravity);
  return weight > 0 ? std::exp2(std::round(8 * std::log2(weight)) / 8) : 0;
}

/// Stiffness along the stiffer threads. [N/m]
double threads_stiffness(const Material& m) {
  if (m.orthotropic) return std::max(m.orthotropic->warp, m.orthotropic->weft);
  if (!m.measured) return m.stretch_stiffness;
  double threads = 0;
  // the tables hold half of the stiffness
  for (const auto& row : m.measured->rows)
    threads = std::max(threads, 2 * std::max(row[0], row[2]));
  return threads;
}

/// Constants of the linear law of a material that is not measured.
OrthotropicMembrane<double> linear_law(const Material& m) {
  if (m.orthotropic)
    return orthotropic_membrane(m.orthotropic->warp, m.orthotropic->weft,
                                m.orthotropic->poisson_ratio, m.orthotropic->shear);
  const double nu = m.poisson_ratio;
  return orthotropic_membrane(m.stretch_stiffness, m.stretch_stiffness, nu,
                              m.stretch_stiffness / (2 * (1 + nu)));
}

}  // namespace

template <class T>
MaterialRows<T> material_rows(const std::vector<Material>& materials,
                              const std::vector<std::vector<double>>& tables, double weight) {
  MaterialRows<T> all;
  for (std::size_t i = 0; i < materials.size(); ++i) {
    const Material& m = materials[i];
    MaterialRow<T> row{
        membrane_constants(static_cast<T>(m.stretch_stiffness), static_cast<T>(m.poisson_ratio)),
        static_cast<T>(m.damping_stiffness)};
    if (m.measured) {
      row.kind = m.measured->form == MeasuredStretch::Form::arcsim ? MembraneKind::samples
                                                                   : MembraneKind::ridges;
      row.table = static_cast<Index>(all.tables.size());
      for (const double value : tables[i]) all.tables.push_back(static_cast<T>(value));
    } else {
      const OrthotropicMembrane<double> c = linear_law(m);
      if (m.orthotropic || m.strain_limits) row.kind = MembraneKind::orthotropic;
      row.orthotropic = {static_cast<T>(c.c11), static_cast<T>(c.c12), static_cast<T>(c.c22),
                         static_cast<T>(c.c33)};
    }
    if (m.strain_limits)
      row.limits = membrane_limits(static_cast<T>(m.strain_limits->min),
                                   static_cast<T>(m.strain_limits->max),
                                   static_cast<T>(limit_ratio * threads_stiffness(m)),
                                   static_cast<T>(m.density / 2 * limit_speed * limit_speed));
    if (m.strain_limits) row.limits.force = static_cast<T>(limit_weights * weight);
    row.density = static_cast<T>(m.density);
    all.rows.push_back(row);
  }
  return all;
}

template MaterialRows<float> material_rows(const std::vector<Material>&,
                                           const std::vector<std::vector<double>>&, double);
template MaterialRows<double> material_rows(const std::vector<Material>&,
                                            const std::vector<std::vector<double>>&, double);

StretchLaws stretch_laws(const Scene& scene) {
  std::vector<std::vector<double>> tables;
  for (const Material& material : scene.materials) tables.push_back(stretch_table(material));
  const double weight = largest_weight(scene);
  return {material_rows<double>(scene.materials, tables, weight),
          material_rows<float>(scene.materials, tables, weight)};
}

namespace {

double unlimited_density(const MaterialRows<double>& materials, const MaterialRow<double>& row,
                         const detail::Symmetric2<double>& green) {
  const double* table = materials.tables.data() + row.table;
  switch (row.kind) {
    case MembraneKind::isotropic:
    case MembraneKind::orthotropic:
      return row.orthotropic.energy(green);
    case MembraneKind::samples:
      return MembraneSamples<double>{table}.energy(green);
    case MembraneKind::ridges:
      return MembraneRidges<double>{table}.energy(green);
  }
  return 0;
}

/// Green strain that the material sees.
detail::Symmetric2<double> seen_strain(const Vec3<double> x[3], const Mat2<double>& inv_rest,
                                       double compression) {
  const detail::Symmetric2<double> green = detail::membrane_strain(x, inv_rest).green;
  return compression < 1 ? buckled_strain(green, compression) : green;
}

}  // namespace

double stretching_energy(const MaterialRows<double>& materials, Index material,
                         const Vec3<double> x[3], const Mat2<double>& inv_rest, double area,
                         double compression) {
  const MaterialRow<double>& row = materials.rows[static_cast<std::size_t>(material)];
  const detail::Symmetric2<double> green = seen_strain(x, inv_rest, compression);
  const double limits = row.limits.any() ? row.limits.of_triangle(area).energy(green) : 0;
  return area * (unlimited_density(materials, row, green) + limits);
}

bool has_limits(const MaterialRows<double>& materials) {
  return std::any_of(materials.rows.begin(), materials.rows.end(),
                     [](const MaterialRow<double>& row) { return row.limits.any(); });
}

double limit_excess(const MaterialRows<double>& materials, Index material, const Vec3<double> x[3],
                    const Mat2<double>& inv_rest, double compression) {
  const MaterialRow<double>& row = materials.rows[static_cast<std::size_t>(material)];
  return row.limits.any() ? row.limits.excess(seen_strain(x, inv_rest, compression)) : 0;
}

}  // namespace weft
