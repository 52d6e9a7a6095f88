#pragma once

#include "weft/core/ids.hpp"
#include "weft/core/mat.hpp"
#include "weft/core/span.hpp"
#include "weft/core/vec.hpp"
#include "weft/elements/rotation.hpp"

namespace weft {

/// Where a triangle would resist being stopped with this share of its kinetic energy is turned by
/// half of what its velocities say. Chosen in docs/decisions/003-linear-solve.md.
constexpr double turned_start_share = 0.03;

/// [rad] Rotations that are left to the solve: it takes them for strains below 1e-6.
constexpr double turned_start_angle_min = 1e-3;

/// The start of a step in its moving frame, with each triangle turned as far as its velocities
/// there say: a linear system about a triangle that is not turned takes its rotation by an angle a
/// for a strain of a^2 / 2.
///
/// If something stops the triangle instead, the system takes the missing rotation for strain: it
/// drives the triangle on with up to c a^4 / 8 per area, c its stiffness. Beside kinetic energy
/// that is little unless cloth is stiff, light or small for the time step. Where it is not,
/// contacts and weight would no longer stop cloth, so triangles turn less there.
template <class T>
struct TurnedStart {
  Span<const Vec3<T>> positions{};   ///< [m] in the moving frame; empty: nothing turns
  Span<const Vec3<T>> velocities{};  ///< [m/s] relative to the frame
  T dt = T(0);                       ///< [s]

  /// @param edge [m] [2] out, x1 - x0 and x2 - x0, turned; undefined if nothing turns
  /// @param stiffness [N/m]   @param density [kg/m^2]
  /// @return whether the triangle is turned
  WEFT_HD bool edges(const Tri& t, const Mat2<T>& inv_rest, T stiffness, T density,
                     Vec3<T> edge[2]) const noexcept {
    if (positions.empty()) return false;
    const Vec3<T>& origin = positions.data()[t.v[0]];
    const Vec3<T>& velocity = velocities.data()[t.v[0]];
    Vec3<T> moved[2];
    T speed_sq = length_sq(velocity);
    for (int k = 0; k < 2; ++k) {
      const Vec3<T>& other = velocities.data()[t.v[k + 1]];
      edge[k] = positions.data()[t.v[k + 1]] - origin;
      moved[k] = dt * (other - velocity);
      speed_sq += length_sq(other);
    }
    const Vec3<T> angle = triangle_rotation(edge, moved, inv_rest);
    const T angle_sq = length_sq(angle);
    constexpr auto angle_min = static_cast<T>(turned_start_angle_min);
    if (!(angle_sq > angle_min * angle_min)) return false;
    const T resisted = stiffness / T(8) * angle_sq * angle_sq;
    const T allowed = static_cast<T>(turned_start_share) * density / T(6) * speed_sq;
    if (!(allowed > T(0))) return false;
    const Vec3<T> half = (allowed / (allowed + resisted) / T(2)) * angle;
    for (int k = 0; k < 2; ++k) edge[k] = cayley_turned(edge[k], half);
    return true;
  }
};

}  // namespace weft
