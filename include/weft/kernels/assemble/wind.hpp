#pragma once

#include <cmath>

#include "weft/core/ids.hpp"
#include "weft/core/mat.hpp"
#include "weft/core/span.hpp"
#include "weft/core/vec.hpp"
#include "weft/exec/element_wise.hpp"

namespace weft {

template <class T>
WEFT_HD Vec3<T> mean_of_corners(Span<const Vec3<T>> values, const Tri& t) noexcept {
  return (T(1) / T(3)) *
         (values[static_cast<std::size_t>(t.v[0])] + values[static_cast<std::size_t>(t.v[1])] +
          values[static_cast<std::size_t>(t.v[2])]);
}

/// Drag of moving air on every triangle, added to what AssembleMembrane wrote. With n the normal, v
/// the mean velocity of the corners and u = wind - v, each corner bears a third of
///   F = area (density |u . n| (u . n) n + drag (u - (u . n) n)),
/// as ARCSim's wind. |u . n| and the normal are those of the step's start, so F is linear in the
/// new velocity and its Jacobian semi-definite: a light sheet in a gale stays stable.
/// Reads: positions and velocities of all corners. Writes: impulse, block of its own triangle
/// (adds), corner_drag. Order: independent. Ghosts: positions and velocities of all vertices.
/// Flags: none.
template <class T>
struct AssembleWind {
  Span<const Tri> triangles;             ///< [n] global vertex numbers
  Span<const Vec3<T>> start_positions;   ///< [m] x_n
  Span<const Vec3<T>> start_velocities;  ///< [m/s] v_n
  Span<const Vec3<T>> velocities;        ///< [m/s] iterate v_k; empty: zero
  T density;                             ///< [kg/m^3] of the air
  T drag;                                ///< [kg/(m^2 s)] tangential
  Vec3<T> wind;                          ///< [m/s]
  T h;                                   ///< [s] effective time step
  Span<Vec3<T>> impulse;                 ///< [3n] [N s] as in AssembleMembrane
  Span<Mat3<T>> block;                   ///< [6n] [kg] as in AssembleMembrane
  Span<Mat3<T>> corner_drag;             ///< [n] [kg] of each corner, if all three move alike

  WEFT_HD Index count() const noexcept { return static_cast<Index>(triangles.size()); }

  WEFT_HD void operator()(Index i) const noexcept {
    using std::fabs;
    using std::sqrt;
    const auto n = static_cast<std::size_t>(i);
    const Tri& t = triangles[n];
    const Vec3<T>& x0 = start_positions[static_cast<std::size_t>(t.v[0])];
    const Vec3<T> twice_area = cross(start_positions[static_cast<std::size_t>(t.v[1])] - x0,
                                     start_positions[static_cast<std::size_t>(t.v[2])] - x0);
    const T size = sqrt(length_sq(twice_area));
    if (!(size > T(0))) {  // nothing for the wind to take hold of
      corner_drag[n] = {};
      return;
    }
    const Vec3<T> normal = (T(1) / size) * twice_area;
    const T area = size / T(2);
    const T speed = fabs(dot(wind - mean_of_corners(start_velocities, t), normal));
    // The force is C (wind - v).
    const Mat3<T> across = outer(normal, normal);
    const Mat3<T> c = area * (density * speed * across + drag * (Mat3<T>::identity() - across));
    const Vec3<T> v = velocities.empty() ? Vec3<T>{} : mean_of_corners(velocities, t);
    const Vec3<T> share = (h / T(3)) * (c * (wind - v));
    for (std::size_t k = 0; k < 3; ++k) impulse[3 * n + k] += share;
    for (std::size_t b = 0; b < 6; ++b) block[6 * n + b] += (h / T(9)) * c;
    corner_drag[n] = (h / T(3)) * c;
  }
};

}  // namespace weft
