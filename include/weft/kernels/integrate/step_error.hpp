#pragma once

#include <cmath>
#include <cstdint>

#include "weft/core/ids.hpp"
#include "weft/core/span.hpp"
#include "weft/core/vec.hpp"
#include "weft/exec/launch.hpp"

namespace weft {

/// Estimates the error of a time step: per component of cloth, the sum of the squared distances
/// between where free vertices end and where the trapezoidal rule puts them,
///   x_1 - (x_0 + dt / 2 (v_0 + v_1)).
/// For implicit Euler that is dt / 2 (v_1 - v_0), its error of the order dt^2; for BDF2 it is of
/// the order dt^3, as the error of both is. Reads: both ends of the step. Writes: sums.
/// Order: in fixed point, in any order. Ghosts: none (one rank does all vertices). Flags: none.
template <class T>
struct IntegrateStepError {
  Span<const Vec3<T>> positions_t0;       ///< [>= cloth vertices] [m]
  Span<const Vec3<T>> velocities_t0;      ///< [cloth vertices] [m/s]
  Span<const Vec3<T>> positions_t1;       ///< [>= cloth vertices] [m]
  Span<const Vec3<T>> velocities_t1;      ///< [cloth vertices] [m/s]
  Span<const unsigned char> fixed;        ///< [>= cloth vertices]
  Span<const Index> component_of_vertex;  ///< [cloth vertices]
  double dt;                              ///< [s]
  double inverse_tolerance;               ///< [1/m]
  /// [2 * components] squared distances in tolerances, times step_error_one; free vertices. Is
  /// added to.
  Span<std::int64_t> sums;
};

/// Fixed-point representation of one in IntegrateStepError::sums.
inline constexpr double step_error_one = 16777216;
/// What a vertex adds at most, so that sums over 2^26 vertices do not overflow: it is off by 64
/// tolerances, or is not a number.
inline constexpr double step_error_sq_max = 4096;

/// What a vertex adds to the sums of its component.
struct VertexStepError {
  Index component = -1;  ///< -1: nothing, it is held
  std::int64_t sum[2] = {};
};

template <class T>
WEFT_HD VertexStepError integrate_step_error(const IntegrateStepError<T>& a, Index i) noexcept {
  using std::rint;
  const auto v = static_cast<std::size_t>(i);
  VertexStepError result;
  if (a.fixed[v] != 0) return result;
  double sq = 0;
  for (int c = 0; c < 3; ++c) {
    const double moved =
        static_cast<double>(a.positions_t1[v][c]) - static_cast<double>(a.positions_t0[v][c]);
    const double speed =
        static_cast<double>(a.velocities_t0[v][c]) + static_cast<double>(a.velocities_t1[v][c]);
    const double error = (moved - 0.5 * a.dt * speed) * a.inverse_tolerance;
    sq += error * error;
  }
  const double kept = sq < step_error_sq_max ? sq : step_error_sq_max;
  result.component = a.component_of_vertex[v];
  result.sum[0] = static_cast<std::int64_t>(rint(kept * step_error_one));
  result.sum[1] = 1;
  return result;
}

template <class T>
void run(OnHost, Queue& queue, const IntegrateStepError<T>& args);
template <class T>
void run(OnCuda, Queue& queue, const IntegrateStepError<T>& args);

}  // namespace weft
