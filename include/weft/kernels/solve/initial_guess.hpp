#pragma once

#include "weft/core/ids.hpp"
#include "weft/core/span.hpp"
#include "weft/core/vec.hpp"
#include "weft/exec/launch.hpp"

namespace weft {

/// Initial guess of dv for the rows of one rank: the step's starting velocity less the iterate, so
/// that the residual of the guess is the right-hand side of P-Cloth eq. (3); prescribed vertices
/// get the velocity that takes them to their target. Later Newton iterations guess zero. Reads:
/// positions, velocities. Writes: x of its own row. Order: independent. Ghosts: none.
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
};

template <class T>
WEFT_HD void solve_initial_guess(const SolveInitialGuess<T>& a, Index i) noexcept {
  const auto v = static_cast<std::size_t>(a.row_begin + i);
  const Vec3<T> iterate = a.velocities.empty() ? Vec3<T>{} : a.velocities[v];
  if (a.fixed[v] != 0)
    a.x[v] = (T(1) / a.h) * (a.positions_t1[v] - a.base[v]) - iterate;
  else
    a.x[v] = a.start_velocities.empty() ? Vec3<T>{} : a.start_velocities[v] - iterate;
}

template <class T>
void run(OnHost, Queue& queue, const SolveInitialGuess<T>& args);
template <class T>
void run(OnCuda, Queue& queue, const SolveInitialGuess<T>& args);

}  // namespace weft
