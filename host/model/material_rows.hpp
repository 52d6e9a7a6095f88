#pragma once

#include <type_traits>
#include <vector>

#include "weft/kernels/assemble/membrane.hpp"
#include "weft/scene.hpp"

namespace weft {

/// Materials as the kernels take them.
template <class T>
struct MaterialRows {
  std::vector<MaterialRow<T>> rows;  ///< [materials]
  std::vector<T> tables;             ///< of all, one after the other; rows say where theirs begins
};

/// @param tables [materials] what stretch_table() gives for each
/// @param weight [N] that strain limits have to hold at any vertex
template <class T>
MaterialRows<T> material_rows(const std::vector<Material>& materials,
                              const std::vector<std::vector<double>>& tables, double weight = 0);

/// The laws of stretching of a scene's materials in both precisions. They do not depend on how fine
/// meshes are: models of one scene share them.
struct StretchLaws {
  MaterialRows<double> rows;
  MaterialRows<float> single;

  template <class T>
  const MaterialRows<T>& in() const {
    if constexpr (std::is_same_v<T, float>)
      return single;
    else
      return rows;
  }
};
StretchLaws stretch_laws(const Scene& scene);

/// Energy of one triangle that stretches by a material's law, within its limits. [J]
/// @param x        [m]   [3] deformed corners
/// @param inv_rest [1/m] 2x2
/// @param area     [m^2] at rest
/// @param compression [0, 1] share of a compression that the material sees, see buckling.hpp
double stretching_energy(const MaterialRows<double>& materials, Index material,
                         const Vec3<double> x[3], const Mat2<double>& inv_rest, double area,
                         double compression = 1);

/// Whether any material has strain limits.
bool has_limits(const MaterialRows<double>& materials);

/// By how much a triangle exceeds its material's strain limits, see MembraneLimits::excess(); 0
/// within, or without limits. Arguments as for stretching_energy(). [1]
double limit_excess(const MaterialRows<double>& materials, Index material, const Vec3<double> x[3],
                    const Mat2<double>& inv_rest, double compression = 1);

}  // namespace weft
