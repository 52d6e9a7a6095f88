#pragma once

#include <cstdint>

#include "weft/core/hd.hpp"
#include "weft/core/ids.hpp"
#include "weft/core/span.hpp"
#include "weft/exec/launch.hpp"
#include "weft/kernels/solve/pcg.hpp"
#include "weft/state/block_ell.hpp"

namespace weft {

/// Rows that are multiplied together, once the last of their columns has arrived.
constexpr Index pipelined_group_rows = 64;
static_assert(pipelined_group_rows % RowOrder::window == 0);
WEFT_HD constexpr Index pipelined_groups(Index rows) noexcept {
  return (rows + pipelined_group_rows - 1) / pipelined_group_rows;
}

/// What SolvePipelined does.
enum class PipelinedWork {
  begin,           ///< clears the state, and finds the stage of every group of own rows
  multiply_x,      ///< w = A x in own groups of `stage`
  multiply_u,      ///< w = A u in the same
  residual,        ///< r = b - w, u = P r
  update,          ///< one step along the direction that u gives, then u = P r
  products,        ///< own partial sums of (r, u), (w, u), (r, r)
  magnitudes,      ///< own partial sums of the square of |A| |x| + |b|
  take_magnitude,  ///< the scalars get the root of all those
  restart,         ///< the scalars take the products of a true residual; status, if that is all
  advance,         ///< the scalars take the products of an iteration
};

template <class T>
struct SolvePipelined;

/// Where a solve that the host drives stands. The same on every rank.
template <class T>
struct PipelinedState {
  PcgScalars<T> scalars;
  std::int32_t over = 0;  ///< 1: the status is final, or the solve has paused

  /// Takes sums over all ranks.
  /// @return whether the status is to be written
  WEFT_HD bool take(const SolvePipelined<T>& a, const double d[3]) noexcept {
    using std::sqrt;
    if (a.work == PipelinedWork::take_magnitude) {
      scalars.magnitude = sqrt(d[0]);
      return false;
    }
    if (a.work == PipelinedWork::advance) {
      scalars.advance(a.solve, d);
      over = scalars.status.paused;
    } else {
      over = scalars.restart(a.solve, d) ? 0 : 1;
    }
    return over != 0;
  }
};

/// One piece of work of one rank in preconditioned conjugate gradients (see SolvePcg) whose ranks
/// reach each other by copies alone, for machines whose GPUs cannot reach each other's memory: the
/// host moves vectors and partial sums between such pieces, see PipelinedSolve. A row is multiplied
/// whole, in the first stage in which all of its group's columns are there. Same bits as SolvePcg.
/// Reads and writes: own part, state and stages; x and u of others in its own copies. Ghosts: in
/// `x` or `u` by the stages in which they are multiplied; all partial sums before the scalars take
/// them. Flags: not converged, not finite.
template <class T>
struct SolvePipelined {
  PipelinedWork work = PipelinedWork::begin;
  int stage = 0;
  bool only_if_running = false;       ///< does nothing once the recurrence has come to its end
  SolvePcg<T> solve;                  ///< `parts` and `epoch` are not used
  SolvePcgPart<T> part;               ///< this rank's; ghosts, flags and receivers are not used
  Span<const unsigned char> arrival;  ///< [ranks] stage in which its rows are here; own: 0
  Span<unsigned char> group_stage;    ///< [pipelined_groups(rows)]
  Span<PipelinedState<T>> state;      ///< [1]
};

/// Stage in which a column arrives.
template <class T>
WEFT_HD int arrival_of(const SolvePipelined<T>& a, Index column) noexcept {
  const Index* begin = a.solve.row_begin.data();
  if (column >= begin[a.solve.rank] && column < begin[a.solve.rank + 1]) return 0;
  int owner = 0;
  while (begin[owner + 1] <= column) ++owner;
  return a.arrival.data()[owner];
}

/// Last stage in which a column of row `row` of a matrix arrives.
template <class T, class Matrix>
WEFT_HD int last_arrival(const SolvePipelined<T>& a, const Matrix& m, Index row) noexcept {
  if (m.row_count == 0) return 0;
  const Index place = m.order.place(row);
  const Offset* offset = m.slice_offset.data() + place / m.slice;
  int last = 0;
  for (Offset slot = offset[0]; slot < offset[1]; ++slot) {
    const int stage = arrival_of(a, m.column.data()[slot * m.slice + place % m.slice]);
    last = stage > last ? stage : last;
  }
  return last;
}

/// The same for the whole system.
template <class T>
WEFT_HD int last_arrival(const SolvePipelined<T>& a, Index row) noexcept {
  int last = 0;
  const auto take = [&last](int stage) { last = stage > last ? stage : last; };
  take(last_arrival(a, a.part.mesh, row));
  take(last_arrival(a, a.part.far, row));
  visit_contact_entries(a.part.contact, row, [&](Index column, T, const ContactOperatorEntry<T>&) {
    take(arrival_of(a, column));
  });
  return last;
}

template <class T>
void run(OnHost, Queue& queue, const SolvePipelined<T>& args);
template <class T>
void run(OnCuda, Queue& queue, const SolvePipelined<T>& args);

}  // namespace weft
