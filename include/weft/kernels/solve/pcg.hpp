#pragma once

#include <atomic>
#include <cmath>
#include <cstdint>
#include <vector>

#include "weft/core/hd.hpp"
#include "weft/core/ids.hpp"
#include "weft/core/mat.hpp"
#include "weft/core/span.hpp"
#include "weft/exec/launch.hpp"
#include "weft/kernels/solve/schwarz_levels.hpp"
#include "weft/state/block_ell.hpp"
#include "weft/state/contact_operator.hpp"
#include "weft/state/tracked_rows.hpp"
#include "weft/state/vertex_part.hpp"

namespace weft {

/// What a solve came to. The same on every rank.
struct SolveStatus {
  std::int32_t iterations = 0;
  std::int32_t converged = 0;  ///< 1 if residual <= tolerance
  std::int32_t finite = 1;     ///< 0 if a NaN or infinity appeared
  double reference = 0;        ///< [N s] what the residual was checked against in the 2-norm
  double scale = 0;            ///< [sqrt(J)] the same in the preconditioned norm
  double residual = 0;         ///< true residual over the one or over the other, the larger share
  std::int32_t paused = 0;     ///< 1: SolvePcg::pause has been reached, but not the end
  // Of the iteration that comes next, see PcgScalars:
  double alpha = 0, beta = 0, gamma = 0;
};

/// Most rows of a reduction block. If the caller asks for more, the kernels use this.
constexpr Index pcg_partial_rows_max = 1024;
/// The same where no domain of a preconditioner needs more: the shares of processors are whole
/// partial sums.
constexpr Index pcg_plain_partial_rows_max = 512;

/// Partial sums that a solve needs room for, with `rows` rows over all ranks.
WEFT_HD constexpr Index pcg_partials(Index rows, Index partial_rows) noexcept {
  const Index step = partial_rows < pcg_partial_rows_max ? partial_rows : pcg_partial_rows_max;
  return (rows + step - 1) / step;
}

/// Words of SolvePcgPart::ready. Each backend uses them in its own way.
constexpr int pcg_flags = 256;

/// One rank's part of a collective solve. All ranks read all parts.
template <class T>
struct SolvePcgPart {
  BlockEll<T> mesh;  ///< slices of host_slice or of cuda_slice rows
  ScalarEll<T> far;  ///< bending between other vertices; row_count 0: none
  VertexPart<T> vertex;
  ContactOperator<T> contact;
  RowBlocks<const T> inverse;       ///< block Jacobi, zero in fixed rows
  FineLevel<T> fine;                ///< added to it, if in use
  WideLevel<T> wide;                ///< the same
  Span<const unsigned char> fixed;  ///< [vertices]
  Span<const Vec3<T>> rhs;          ///< [rows] b
  Span<const Index> ghost;          ///< vertices of others that these rows multiply
  Span<const Index> ghost_offset;   ///< [ranks + 1] part of `ghost` that each owner has
  Span<Vec3<T>> x;            ///< [vertices] in: own rows of the initial guess; out: own rows of dv
  Span<Vec3<T>> u;            ///< [vertices] exchanged vector, own rows and ghosts valid
  Span<Vec3<T>> r, w, p, s;   ///< [rows]
  Span<double> partial;       ///< [2 * 3 * pcg_partials() of the whole system], two epochs
  Span<std::uint32_t> ready;  ///< [pcg_flags] epoch flags, zero before the first solve
  Span<std::uint32_t> receivers;  ///< [rows] scratch where there are several ranks
  Span<SolveStatus> status;       ///< [1]
  TrackedRows tracked{};  ///< sums that dv has to have; on the host only, with a single rank
};

/// Preconditioned conjugate gradients with one reduction an iteration (Chronopoulos & Gear 1989) on
/// A dv = b, over all ranks at once, by launch_collective() with the same `parts` for each.
/// Dot products: partials of `partial_rows` rows in double, combined by one tree over the number of
/// partials; rank boundaries are multiples of partial_rows, so the bits do not depend on the number
/// of ranks. A row's product adds its vertex part, mesh, far and contact entries, in stored order;
/// on CUDA ends of links in place of contact entries. Mesh and far entries multiply differences to
/// the row's own vertex, see VertexPart: the diagonal of the mesh's matrix serves preconditioners
/// and bounds of rounding alone. Stops when the true residual r is at most `tolerance` times that
/// of the initial guess, both in the 2-norm and in the norm sqrt(r . P r) with P the
/// preconditioner, that of Baraff & Witkin (1998). In the 2-norm alone the few stiff rows of
/// pressed contacts outweigh all others, and cloth under load is left unsolved.
/// - A residual of the initial guess below `reference_min` counts as `reference_min`, and its
///   preconditioned norm grows by the same ratio: near rest nothing is left to solve for.
/// - A solve that repeats another need not go further than that one had to: it has a `scale_min`.
///   Nor may it end earlier, if it is to `keep_references`: where contacts that throw sheets at
///   each other change from solve to solve, residuals grow, and a share of them is more than all
///   momentum.
/// - Where cloth falls freely, its motion as a whole counts, however large the forces within it are
///   in comparison: the preconditioned norm is compared with `scale_max` at most.
/// - As long as there are iterations left, a solve goes on until the preconditioned norm is at most
///   `left_max`: where contacts press hard, a small share still throws cloth through them.
/// - Whatever else is asked for, a residual of the share `gain` of that of the initial guess will
///   do, in both norms: an iteration of Newton's method changes the system anyway.
/// - A solve may pause once both norms of its residual, as the recurrence has it, are the share
///   `pause` of the initial guess's, and be resumed on the same system: with the status, the
///   vectors of the part and the arguments as they were, but for `epoch` and when to pause. Without
///   a `gain`, it has the same bits as one that does not pause.
/// - Where a tolerance is out of rounding's reach, a residual that a restart does not halve counts
///   as converged if it is no more than what rounding makes of A x and b, see PcgScalars::rounding.
///
/// Launches of two solves on the same parts are separated by events over all ranks.
/// Reads: all parts. Writes: own part; on CUDA ghosts of u and x, partial sums and flags into the
/// parts of others. Ghosts: u and x, by peer loads or stores. Flags: not converged, not finite.
template <class T>
struct SolvePcg {
  int rank = 0;
  Span<const SolvePcgPart<T>> parts;
  Span<const Index> row_begin;  ///< [ranks + 1], multiples of partial_rows but the last
  Index partial_rows = 1024;
  std::uint32_t epoch = 0;  ///< flags are at most this on entry, on every rank
  double tolerance = 1e-3;
  double reference_min = 0;  ///< [N s]
  double scale_min = 0;      ///< [sqrt(J)], 0: none
  double left_max = 0;       ///< [sqrt(J)], 0: any
  std::int32_t max_iterations = 1000;
  Index rows = 0;        ///< of this rank, as row_begin says too
  bool levelled = true;  ///< parts may have levels of aggregates
  bool linked = false;   ///< parts have links of contacts: all of them, or none
  /// Once true, the solve ends as if it had met a number that is not finite; null: never. On the
  /// host alone.
  const std::atomic<bool>* stop = nullptr;
  /// An initial guess whose residual is at most this share of both references is the solution.
  double accept = 0;
  double gain = 0;               ///< 0: as much as `tolerance` and `left_max` ask for
  double scale_max = 0;          ///< [sqrt(J)], 0: none
  bool keep_references = false;  ///< of `reference_min` and `scale_min`, see above
  double pause = 0;              ///< 0: never
  bool resume = false;           ///< resumes the latest solve of these parts, which has paused
  /// [sqrt(J)] Also pauses at the tolerance with no more than this left in the preconditioned norm,
  /// if `left_max` asks for more; 0: does not.
  double pause_left = 0;
};

/// Epochs that one solve may use up: callers advance SolvePcg::epoch by this.
constexpr std::uint32_t pcg_epochs(std::int32_t max_iterations) noexcept {
  return 4u * static_cast<std::uint32_t>(max_iterations) + 128u;
}

/// Scalars of the recurrence, and its decisions: the same on every rank and every
/// backend. Products are d = (r, u), (w, u), (r, r).
template <class T>
struct PcgScalars {
  static constexpr int restarts_max = 20;
  /// A residual that does not fall any more counts as converged up to this share of |A| |x| + |b|,
  /// 2-norms: a row's product is some fifty numbers that are rounded, as is each component of x.
  static constexpr double rounding = 8 * (sizeof(T) == sizeof(float) ? 0x1p-23 : 0x1p-52);
  /// Share of its own residual that is enough for a solve which keeps references.
  static constexpr double kept_share = 1e-3;
  /// Share of its reference that a residual may keep on account of rounding, where there is weight.
  static constexpr double hidden_max = 0.01;

  SolveStatus status;
  double magnitude = 0;  ///< [N s] 2-norm of |A| |x| + |b|, once asks_for_magnitude()
  double alpha = 0;
  double beta = 0;
  double gamma = 0;
  double checked = 0;                  ///< residual of the last restart but the first
  double target = 0;                   ///< [N s] residual to reach
  double scaled_enough = 0;            ///< [sqrt(J)] preconditioned norm that counts as converged
  double scaled_target = 0;            ///< [sqrt(J)] preconditioned norm to reach
  double pause = 0, scaled_pause = 0;  ///< [N s], [sqrt(J)] norms at which to pause
  int restarts = 0;
  bool running = false;  ///< another iteration is due

  /// The next residual may be the last one, and is then checked against what it is rounded from.
  WEFT_HD bool asks_for_magnitude() const noexcept { return restarts > 1; }

  /// Goes on where a solve has paused, in the place of the first restart().
  WEFT_HD void resume(const SolvePcg<T>& a, const SolveStatus& paused) noexcept {
    status = paused;
    status.paused = 0;
    alpha = status.alpha;
    beta = status.beta;
    gamma = status.gamma;
    set_targets(a, 0, 0);
    restarts = 1;
    running = true;
  }

  /// Takes the products of a true residual.
  /// @return whether to go on with the recurrence; if not, the solve is over
  WEFT_HD bool restart(const SolvePcg<T>& a, const double d[3]) noexcept {
    using std::sqrt;
    const double norm = sqrt(d[2]);
    // Rounding may leave a preconditioner that is not positive for the last bits of r.
    const double scaled = sqrt(abs(d[0]));
    const bool first = restarts == 0;
    if (first) {
      const double own = a.keep_references ? kept_share : 1;
      status.reference = larger(own * norm, a.reference_min);
      if (a.scale_min > 0)
        status.scale = larger(own * scaled, a.scale_min);
      else
        status.scale = norm > 0 ? scaled * (status.reference / norm) : 0;
      if (a.scale_max > 0 && status.scale > a.scale_max) status.scale = a.scale_max;
      set_targets(a, a.gain * norm, a.gain * scaled);
      pause = a.pause * norm;
      scaled_pause = a.pause * scaled;
    }
    const double share = status.reference > 0 ? norm / status.reference : 0;
    const double scaled_share = status.scale > 0 ? scaled / status.scale : 0;
    status.residual = larger(share, scaled_share);
    status.finite = finite(norm) && finite(scaled) ? 1 : 0;
    if (first && status.residual <= a.accept && status.finite == 1) {
      status.converged = 1;
      return false;
    }
    status.converged = norm <= target && scaled <= scaled_enough && status.finite == 1 ? 1 : 0;
    if (status.finite == 0 || (status.converged == 1 && scaled <= scaled_target)) return false;
    // Rounding sets a floor under the residual: a restart that does not halve it has reached it.
    const bool floor = restarts > 1 && status.residual > 0.5 * checked;
    // Where the weight of the cloth is hidden by rounding the outcome is no solution.
    const bool matters = a.reference_min > 0 && share > hidden_max;
    if (floor && norm <= rounding * magnitude && !matters) status.converged = 1;
    if (floor || status.iterations >= a.max_iterations || restarts >= restarts_max) return false;
    checked = status.residual;
    ++restarts;
    alpha = d[0] / d[1];
    beta = 0;
    gamma = d[0];
    settle(a);
    return true;
  }

  /// Takes the products of an iteration.
  WEFT_HD void advance(const SolvePcg<T>& a, const double d[3]) noexcept {
    ++status.iterations;
    // What the recurrence takes for solved; the true residual is looked at then.
    if (!(d[2] > target * target || d[0] > scaled_target * scaled_target)) {
      running = false;
      return;
    }
    beta = d[0] / gamma;
    gamma = d[0];
    alpha = gamma / (d[1] - beta * gamma / alpha);
    settle(a);
    const bool early = !(d[2] > pause * pause || d[0] > scaled_pause * scaled_pause);
    const bool at_tolerance = !(d[2] > target * target) &&
                              !(d[0] > scaled_enough * scaled_enough) &&
                              !(d[0] > a.pause_left * a.pause_left);
    if (!running || !(early || at_tolerance)) return;
    running = false;
    status.paused = 1;
    status.alpha = alpha;
    status.beta = beta;
    status.gamma = gamma;
  }

 private:
  /// @param will_do, scaled_will_do norms that will do, whatever else is asked for
  WEFT_HD void set_targets(const SolvePcg<T>& a, double will_do, double scaled_will_do) noexcept {
    target = larger(a.tolerance * status.reference, will_do);
    scaled_enough = larger(a.tolerance * status.scale, scaled_will_do);
    scaled_target = a.left_max > 0 && a.left_max < scaled_enough
                        ? larger(a.left_max, scaled_will_do)
                        : scaled_enough;
  }
  WEFT_HD static bool finite(double x) noexcept { return x - x == 0; }
  WEFT_HD static double abs(double x) noexcept { return x < 0 ? -x : x; }
  WEFT_HD static double larger(double x, double y) noexcept { return x < y ? y : x; }

  WEFT_HD void settle(const SolvePcg<T>& a) noexcept {
    running = status.iterations < a.max_iterations && finite(alpha) && alpha > 0;
    // A breakdown counts, so that restarts are bounded.
    if (!running && !(alpha > 0)) ++status.iterations;
  }
};

template <class T>
void run(OnHost, Queue& queue, const SolvePcg<T>& args);
/// All ranks at once; those of one GPU are one launch.
template <class T>
void run(OnCuda, DeviceSet& devices, const std::vector<SolvePcg<T>>& args);

}  // namespace weft
