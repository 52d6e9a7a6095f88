#include "host/scene/material_rows.hpp"

namespace weft {

template <class T>
std::vector<MaterialRow<T>> material_rows(const std::vector<Material>& materials) {
  std::vector<MaterialRow<T>> rows;
  for (const Material& m : materials) {
    MaterialRow<T> row{
        membrane_constants(static_cast<T>(m.stretch_stiffness), static_cast<T>(m.poisson_ratio)),
        static_cast<T>(m.damping_stiffness)};
    if (m.orthotropic) {
      const OrthotropicMembrane<double> c =
          orthotropic_membrane(m.orthotropic->warp, m.orthotropic->weft,
                               m.orthotropic->poisson_ratio, m.orthotropic->shear);
      row.kind = MembraneKind::orthotropic;
      row.orthotropic = {static_cast<T>(c.c11), static_cast<T>(c.c12), static_cast<T>(c.c22),
                         static_cast<T>(c.c33)};
    }
    rows.push_back(row);
  }
  return rows;
}

template std::vector<MaterialRow<float>> material_rows(const std::vector<Material>&);
template std::vector<MaterialRow<double>> material_rows(const std::vector<Material>&);

double stretching_energy(const MaterialRow<double>& row, const Vec3<double> x[3],
                         const Mat2<double>& inv_rest, double area) {
  if (row.kind == MembraneKind::orthotropic)
    return membrane_law_energy(x, inv_rest, area, row.orthotropic);
  return membrane_energy(x, inv_rest, area, row.membrane);
}

}  // namespace weft
