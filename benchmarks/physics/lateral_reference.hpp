#pragma once

namespace weft::physics {

/// Load at which a cantilever plate, its width vertical, falls sideways under its own weight:
/// Kirchhoff plate theory with the in-plane stress of plane elasticity, both by Ritz's method with
/// polynomials.
/// @param ratio width over length, > 0
/// @param nu    Poisson's ratio, (-1, 0.5]
/// @return rho g L^3 / D
double lateral_buckling_load(double ratio, double nu);

/// Its limit for slender plates: 12.85 sqrt(EI GJ) of a narrow strip (Prandtl 1899).
double slender_lateral_load(double nu);

}  // namespace weft::physics
