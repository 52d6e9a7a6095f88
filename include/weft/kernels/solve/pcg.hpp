#pragma once

#include <cstdint>

#include "weft/core/ids.hpp"
#include "weft/core/mat.hpp"
#include "weft/core/span.hpp"
#include "weft/exec/launch.hpp"
#include "weft/kernels/solve/coarse.hpp"
#include "weft/state/block_ell.hpp"

namespace weft {

/// What a solve came to. The same on every rank.
struct SolveStatus {
  std::int32_t iterations = 0;
  std::int32_t converged = 0;  ///< 1 if residual <= tolerance
  std::int32_t finite = 1;     ///< 0 if a NaN or infinity appeared
  double reference = 0;        ///< [N s] what the residual was judged against
  double residual = 0;         ///< true residual over its reference, 2-norms
};

/// One rank's part of a collective solve. All ranks read all parts.
template <class T>
struct SolvePcgPart {
  BlockEll<T> mesh;
  ScalarEll<T> far;                           ///< bending between other vertices; row_count 0: none
  BlockEll<T> contact;                        ///< row_count 0: none
  Span<const Mat3<T>> inverse;                ///< [rows] block Jacobi, zero in fixed rows
  CoarseLevel<T> coarse[coarse_level_count];  ///< added to it; no aggregates: level not in use
  Span<const unsigned char> fixed;            ///< [vertices]
  Span<const Vec3<T>> rhs;                    ///< [rows] b
  Span<const Index> ghost;                    ///< vertices of others that these rows multiply
  Span<const Index> ghost_offset;             ///< [ranks + 1] part of `ghost` that each owner has
  Span<Vec3<T>> x;            ///< [vertices] in: own rows of the first guess; out: own rows of dv
  Span<Vec3<T>> u;            ///< [vertices] exchanged vector, own rows and ghosts valid
  Span<Vec3<T>> r, w, p, s;   ///< [rows]
  Span<double> partial;       ///< [2 * 3 * partials of the whole system], two epochs
  Span<std::uint32_t> ready;  ///< [2] epoch flags: vector ready, partials ready
  Span<SolveStatus> status;   ///< [1]
};

/// Preconditioned conjugate gradients with one reduction an iteration (Chronopoulos & Gear 1989) on
/// A dv = b, over all ranks at once. Every rank launches it with the same `parts`.
/// Dot products: partials of `partial_rows` rows in double, combined by one tree over the number of
/// partials; rank boundaries are multiples of partial_rows, so the bits do not depend on the number
/// of ranks. A row's product adds its mesh, far and contact entries, in stored order.
/// Stops when the true residual is at most `tolerance` times that of the first guess, or times
/// `reference_min` if that is larger: near rest nothing is left to solve for.
/// Where a tolerance is out of rounding's reach, a residual that a restart does not halve counts as
/// converged if it is below 1e-4 in float, 1e-12 in double.
/// Launches of two solves on the same parts are separated by events over all ranks.
/// Reads: all parts. Writes: own part. Ghosts: u, by peer loads. Flags: not converged, not finite.
template <class T>
struct SolvePcg {
  int rank = 0;
  Span<const SolvePcgPart<T>> parts;
  Span<const Index> row_begin;  ///< [ranks + 1], multiples of partial_rows but the last
  Index partial_rows = 1024;
  std::uint32_t epoch = 0;  ///< flags hold this value on entry, on every rank
  double tolerance = 1e-3;
  double reference_min = 0;  ///< [N s]
  std::int32_t max_iterations = 1000;
};

/// Epochs that one solve may use up: callers advance SolvePcg::epoch by this.
constexpr std::uint32_t pcg_epochs(std::int32_t max_iterations) noexcept {
  return 4u * static_cast<std::uint32_t>(max_iterations) + 64u;
}

template <class T>
void run(OnHost, Queue& queue, const SolvePcg<T>& args);

}  // namespace weft
