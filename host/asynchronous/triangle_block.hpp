#pragma once

#include "host/asynchronous/simd.hpp"
#include "host/asynchronous/trajectory.hpp"
#include "weft/core/mat.hpp"
#include "weft/elements/membrane.hpp"

namespace weft {

/// Four triangles of isotropic cloth, whose forces are computed side by side.
struct TriangleBlock {
  Tri v[Simd::count]{};  ///< places without a triangle repeat one
  Mat2<Simd> inv_rest;   ///< [1/m]
  Simd area;             ///< [m^2]
  MembraneConstants<Simd> membrane;
  Simd damping;         ///< [s] Rayleigh b
  bool damped = false;  ///< any of them
  bool whole = false;   ///< four triangles, all isotropic: only then the rest is of use
};

/// What corner c of the triangle in place k gets.
using BlockGradient = Vec3<double>[Simd::count][3];

/// Gradient of stretching and Kelvin's and Voigt's damping, that is of the stress of the strain's
/// rate, which rigid motion leaves alone. [N]
/// @pre block.whole, and all corners have been advanced to one time
[[gnu::flatten]] inline void block_gradient(const TriangleBlock& block, const VertexMotion& motion,
                                            BlockGradient& out) {
  const auto gathered = [&](const std::vector<Vec3<double>>& from, Vec3<Simd>(&to)[3]) {
    for (int k = 0; k < Simd::count; ++k)
      for (int c = 0; c < 3; ++c) {
        const Vec3<double>& x = from[static_cast<std::size_t>(block.v[k].v[c])];
        for (int j = 0; j < 3; ++j) to[c][j].set(k, x[j]);
      }
  };
  Vec3<Simd> x[3];
  gathered(motion.x, x);
  auto strain = detail::membrane_strain(x, block.inv_rest);
  if (block.damped) {
    Vec3<Simd> v[3];
    gathered(motion.v, v);
    const Vec3<Simd> d1 = v[1] - v[0], d2 = v[2] - v[0];
    const Mat2<Simd>& inv = block.inv_rest;
    const Vec3<Simd> r0 = d1 * inv(0, 0) + d2 * inv(1, 0);
    const Vec3<Simd> r1 = d1 * inv(0, 1) + d2 * inv(1, 1);
    // The law is linear: the stress of strain and rate at once.
    strain.green.xx += block.damping * dot(strain.f0, r0);
    strain.green.xy += block.damping * Simd(0.5) * (dot(strain.f0, r1) + dot(strain.f1, r0));
    strain.green.yy += block.damping * dot(strain.f1, r1);
  }
  Vec3<Simd> g[3];
  detail::membrane_forces(strain, detail::membrane_stress(strain.green, block.membrane),
                          block.inv_rest, block.area, g);
  for (int k = 0; k < Simd::count; ++k)
    for (int c = 0; c < 3; ++c)
      for (int j = 0; j < 3; ++j) out[k][c][j] = g[c][j][k];
}

}  // namespace weft
