#pragma once

#include "weft/core/mat.hpp"
#include "weft/scene.hpp"

// What the numbers of a material come to: isotropic ones follow from Young's modulus, and the
// matrices of stretching and bending from either kind.

namespace weft {

/// Bending of a sheet whose threads differ, from what is usually measured: the stiffness along
/// either kind of thread. The coupling is that of a homogeneous sheet, the twist Huber's estimate
///   D12 = nu weft,  D66 = (sqrt(warp weft) - D12) / 2
/// which is exact for isotropic sheets.
/// @param warp, weft    [N m] >= 0
/// @param poisson_ratio narrowing along the weft over stretch along the warp; nu^2 weft <= warp
/// @cite ventsel2001, section 7.2
OrthotropicBending huber_bending(double warp, double weft, double poisson_ratio);

/// Bending of a sheet whose stiffness is known along the warp, along the weft and halfway between,
/// where it is (D11 + D22) / 4 + D12 / 2 + D66. That leaves a choice: D12 is 0 where D66 can then
/// be >= 0, and else the least that it must be, held at -sqrt(warp weft).
/// @param warp, weft, halfway [N m] >= 0
/// @cite ventsel2001, section 7.2
OrthotropicBending directional_bending(double warp, double weft, double halfway);

/// Symmetric matrix D [N m] with the energy per area k^T D k / 2 for k = (k11, k22, k12), the
/// curvatures along warp and weft and the twist. Isotropic: B [1, nu, 0; nu, 1, 0; 0, 0, 2 (1-nu)].
Mat3<double> bending_rigidity(const Material& material);

/// Plate stiffness for bending in one direction, averaged over all directions. [N m]
///   3/8 (D11 + D22) + (D12 + 2 D66) / 4
double mean_bending_stiffness(const Material& material);

}  // namespace weft
