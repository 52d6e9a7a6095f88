#pragma once

#include <vector>

#include "weft/kernels/assemble/membrane.hpp"
#include "weft/scene.hpp"

namespace weft {

/// Materials as the kernels take them.
/// @return [materials]
template <class T>
std::vector<MaterialRow<T>> material_rows(const std::vector<Material>& materials);

/// Energy of one triangle that stretches by a material's law. [J]
/// @param x        [m]   [3] deformed corners
/// @param inv_rest [1/m] 2x2
/// @param area     [m^2] at rest
double stretching_energy(const MaterialRow<double>& row, const Vec3<double> x[3],
                         const Mat2<double>& inv_rest, double area);

}  // namespace weft
