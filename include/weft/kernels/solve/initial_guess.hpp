#pragma once

#include "weft/core/ids.hpp"
#include "weft/core/span.hpp"
#include "weft/core/vec.hpp"
#include "weft/exec/launch.hpp"

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
};

template <class T>
WEFT_HD bool falls(const SolveInitialGuess<T>& a, std::size_t v) noexcept {
  return !a.held.empty() && a.held[static_cast<std::size_t>(a.component_of_vertex[v])] == 0;
}

template <class T>
WEFT_HD void solve_initial_guess(const SolveInitialGuess<T>& a, Index i) noexcept {
  const auto v = static_cast<std::size_t>(a.row_begin + i);
  const Vec3<T> iterate = a.velocities.empty() ? Vec3<T>{} : a.velocities[v];
  if (a.fixed[v] != 0)
    a.x[v] = (T(1) / a.h) * (a.positions_t1[v] - a.base[v]) - iterate;
  else if (a.start_velocities.empty())
    a.x[v] = {};
  else if (falls(a, v))
    a.x[v] = (T(1) / (T(1) + a.h * a.damping_mass[v])) * (a.base_velocities[v] + a.h * a.gravity) -
             iterate;
  else
    a.x[v] = a.start_velocities[v] - iterate;
}

template <class T>
void run(OnHost, Queue& queue, const SolveInitialGuess<T>& args);
template <class T>
void run(OnCuda, Queue& queue, const SolveInitialGuess<T>& args);

}  // namespace weft
