#include "host/model/material_rows.hpp"

#include <algorithm>

#include "host/scene/measured.hpp"

namespace weft {
namespace {

/// [m/s] A sheet's limits are at least as stiff as threads in which sound travels this fast.
constexpr double limit_sound_speed = 100;
/// A sheet's limits are this many times as stiff as its threads.
constexpr double limit_ratio = 20;

/// Stiffness at the limits. [N/m]
double limit_stiffness(const Material& m) {
  double threads = m.stretch_stiffness;
  if (m.orthotropic) threads = std::max(m.orthotropic->warp, m.orthotropic->weft);
  if (m.measured) {
    threads = 0;
    // the tables hold half of the stiffness
    for (const auto& row : m.measured->rows)
      threads = std::max(threads, 2 * std::max(row[0], row[2]));
  }
  return std::max(limit_ratio * threads, m.density * limit_sound_speed * limit_sound_speed);
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
                              const std::vector<std::vector<double>>& tables) {
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
      row.limits =
          membrane_limits(static_cast<T>(m.strain_limits->min),
                          static_cast<T>(m.strain_limits->max), static_cast<T>(limit_stiffness(m)));
    all.rows.push_back(row);
  }
  return all;
}

template MaterialRows<float> material_rows(const std::vector<Material>&,
                                           const std::vector<std::vector<double>>&);
template MaterialRows<double> material_rows(const std::vector<Material>&,
                                            const std::vector<std::vector<double>>&);

StretchLaws stretch_laws(const std::vector<Material>& materials) {
  std::vector<std::vector<double>> tables;
  for (const Material& material : materials) tables.push_back(stretch_table(material));
  return {material_rows<double>(materials, tables), material_rows<float>(materials, tables)};
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

}  // namespace

double stretching_energy(const MaterialRows<double>& materials, Index material,
                         const Vec3<double> x[3], const Mat2<double>& inv_rest, double area,
                         double compression) {
  const MaterialRow<double>& row = materials.rows[static_cast<std::size_t>(material)];
  detail::Symmetric2<double> green = detail::membrane_strain(x, inv_rest).green;
  if (compression < 1) green = buckled_strain(green, compression);
  const double limits = row.limits.any() ? row.limits.energy(green) : 0;
  return area * (unlimited_density(materials, row, green) + limits);
}

}  // namespace weft
