#include "host/scene/material_rows.hpp"

namespace weft {

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
    } else if (m.orthotropic) {
      const OrthotropicMembrane<double> c =
          orthotropic_membrane(m.orthotropic->warp, m.orthotropic->weft,
                               m.orthotropic->poisson_ratio, m.orthotropic->shear);
      row.kind = MembraneKind::orthotropic;
      row.orthotropic = {static_cast<T>(c.c11), static_cast<T>(c.c12), static_cast<T>(c.c22),
                         static_cast<T>(c.c33)};
    }
    all.rows.push_back(row);
  }
  return all;
}

template MaterialRows<float> material_rows(const std::vector<Material>&,
                                           const std::vector<std::vector<double>>&);
template MaterialRows<double> material_rows(const std::vector<Material>&,
                                            const std::vector<std::vector<double>>&);

double stretching_energy(const MaterialRows<double>& materials, Index material,
                         const Vec3<double> x[3], const Mat2<double>& inv_rest, double area) {
  const MaterialRow<double>& row = materials.rows[static_cast<std::size_t>(material)];
  const double* table = materials.tables.data() + row.table;
  switch (row.kind) {
    case MembraneKind::isotropic:
      return membrane_energy(x, inv_rest, area, row.membrane);
    case MembraneKind::orthotropic:
      return membrane_law_energy(x, inv_rest, area, row.orthotropic);
    case MembraneKind::samples:
      return membrane_law_energy(x, inv_rest, area, MembraneSamples<double>{table});
    case MembraneKind::ridges:
      return membrane_law_energy(x, inv_rest, area, MembraneRidges<double>{table});
  }
  return 0;
}

}  // namespace weft
