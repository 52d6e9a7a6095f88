#pragma once

#include "weft/core/ids.hpp"
#include "weft/core/span.hpp"
#include "weft/core/vec.hpp"
#include "weft/exec/element_wise.hpp"

namespace weft {

/// Initial guess of dv for the rows of one rank: the step's starting velocity less the iterate, so
/// that the residual of the guess is the right-hand side of P-Cloth eq. (3); prescribed vertices
/// get the velocity that takes them to their target. Components of cloth that nothing holds guess
/// that they fall freely, (v~ + h gravity) / (1 + h a): then no error of the solve, nor rounding,
/// hides their weight. Later Newton iterations guess zero. Reads: positions, velocities. Writes: x
/// of its own row. Order: independent. Ghosts: none.
template <class T>
struct SolveInitialGuess {
  Index row_begin = 0;
  Index row_count = 0;
  Span<const Vec3<T>> positions_t1;      ///< [vertices] [m] fixed vertices: their target
  Span<const Vec3<T>> base;              ///< [cloth vertices] [m] x~
  Span<const Vec3<T>> start_velocities;  ///< [cloth vertices] [m/s]; empty: guess zero
  Span<const Vec3<T>> velocities;        ///< [cloth vertices] [m/s] v_k; empty: zero
  Span<const unsigned char> fixed;       ///< [cloth vertices]
  T h;                                   ///< [s]
  Span<Vec3<T>> x;                       ///< [vertices] [m/s]
  // Of those that fall
  Span<const Index> held;                 ///< [components] 0: falls; empty: none does
  Span<const Index> component_of_vertex;  ///< [cloth vertices]
  Span<const Vec3<T>> base_velocities;    ///< [cloth vertices] [m/s] v~
  Span<const T> damping_mass;             ///< [cloth vertices] [1/s]
  Vec3<T> gravity;                        ///< [m/s^2]

  WEFT_HD bool falls(std::size_t v) const noexcept {
    return !held.empty() && held[static_cast<std::size_t>(component_of_vertex[v])] == 0;
  }

  WEFT_HD Index count() const noexcept { return row_count; }

  WEFT_HD void operator()(Index i) const noexcept {
    const auto v = static_cast<std::size_t>(row_begin + i);
    const Vec3<T> iterate = velocities.empty() ? Vec3<T>{} : velocities[v];
    if (fixed[v] != 0)
      x[v] = (T(1) / h) * (positions_t1[v] - base[v]) - iterate;
    else if (start_velocities.empty())
      x[v] = {};
    else if (falls(v))
      x[v] = (T(1) / (T(1) + h * damping_mass[v])) * (base_velocities[v] + h * gravity) - iterate;
    else
      x[v] = start_velocities[v] - iterate;
  }
};

}  // namespace weft
