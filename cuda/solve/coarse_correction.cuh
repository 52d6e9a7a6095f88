#pragma once

#include "cuda/solve/aggregates.cuh"
#include "weft/kernels/solve/pcg.hpp"

namespace weft::cuda {

/// Shared memory of a block's part in the levels with linear modes.
template <class T>
struct CoarseBasisSums {
  static constexpr int products_max =
      coarse_dofs * (static_cast<int>(coarse_domain) + coarse_levels_max - 1);
  T fine[2][tile_units * coarse_dofs];  ///< of residuals over units, two tiles by turns
  double sum[coarse_levels_max][coarse_domain_dofs];  ///< over the aggregates of one domain a level
  double product[products_max];
  double larger[coarse_levels_max][coarse_dofs];  ///< moves of the aggregates around
  double unit[tile_units][coarse_dofs];
};

/// What a block does for the part of the preconditioner that aggregates with linear modes add; see
/// CoarseCorrection of the host. Units are the rows of a warp, or fewer if partial sums are
/// smaller.
template <class T>
class CoarseBlock {
 public:
  /// @param begin first row of the rank   @param block, blocks of the rank
  __device__ CoarseBlock(const SolvePcg<T>& args, const SolvePcgPart<T>& part,
                         CoarseBasisSums<T>& shared, int rank, int block, int blocks)
      : a_(args), part_(part), s_(shared), block_(block), blocks_(blocks) {
    begin_ = a_.row_begin.data()[rank];
    rows_ = a_.row_begin.data()[rank + 1] - begin_;
  }

  /// Partial sums of less than a warp's rows are written lane by lane.
  __device__ bool small() const { return levels().partial_rows < unit_rows; }

  /// Adds what row `row` has of a vector to the lane's sums.
  __device__ void add(Index row, const Vec3<T>& x, T sum[coarse_dofs]) const {
    add_coarse_basis(coarse_basis_of<T>(levels().point.data()[begin_ + row]), x, sum);
  }

  /// Joins the lanes' sums of a warp's rows; out[9] gets those of the aggregate around. The warp
  /// calls it, for partial sums of at least its rows.
  __device__ void join(const WarpRows& at, const T sum[coarse_dofs], double* out) const {
    double all[coarse_dofs];
#pragma unroll
    for (int k = 0; k < coarse_dofs; ++k) all[k] = static_cast<double>(sum_lanes(sum[k]));
    if (at.lane != 0) return;
    double larger[coarse_dofs] = {};
    if (at.any) add_sums(unit_step(at.first), all, larger);
    for (int k = 0; k < coarse_dofs; ++k) out[k] = larger[k];
  }

  /// The same for smaller partial sums: groups of lanes, whose sums are complete.
  __device__ void store_small(Index row, const T sum[coarse_dofs], int parity) const {
    const int width = static_cast<int>(levels().partial_rows);
    double all[coarse_dofs];
    for (int k = 0; k < coarse_dofs; ++k) all[k] = static_cast<double>(sum_lanes(sum[k], width));
    if (static_cast<int>(threadIdx.x) % width != 0 || row >= rows_) return;
    double larger[coarse_dofs] = {};
    add_sums(unit_step(row), all, larger);
    for (int k = 0; k < coarse_dofs; ++k) own_sum(row, parity)[k] = larger[k];
  }

  /// Sums of the partial sum that begins at own row `row`, to be written.
  __device__ double* own_sum(Index row, int parity) const {
    return sums_of(part_, (begin_ + row) / levels().partial_rows, parity);
  }

  /// Sums of a whole tile's rows of r to global memory. The block calls it.
  __device__ void store_tile(const WarpRows& at, Index tile, const Vec3<T> r[2], int parity) {
    T sum[coarse_dofs] = {};
    for (int j = 0; j < 2; ++j) {
      const Index row = at.first + 32 * j + at.lane;
      if (row < rows_) add(row, r[j], sum);
      if (!small()) continue;
      store_small(row, sum, parity);
      for (T& x : sum) x = 0;
    }
    if (small()) return;
    join(at, sum, s_.unit[at.unit]);
    __syncthreads();
    const auto group = static_cast<int>(levels().partial_rows / unit_rows);
    const auto n = static_cast<int>(threadIdx.x);
    const Index row = tile * tile_rows + n / coarse_dofs * levels().partial_rows;
    if (n < coarse_dofs * tile_units / group && row < rows_) {
      double all = 0;
      for (int m = 0; m < group; ++m) all += s_.unit[n / coarse_dofs * group + m][n % coarse_dofs];
      own_sum(row, parity)[n % coarse_dofs] = all;
    }
    __syncthreads();
  }

  /// Moves of own partial sums from the sums of all ranks, as they stand in a set. Block calls it.
  __device__ __noinline__ void solve(int parity) {
    Index domain[coarse_levels_max];
    for (Index& d : domain) d = -1;
    const Index step = levels().partial_rows;
    const Index each = coarse_domain * step < tile_rows ? coarse_domain * step : tile_rows;
    for (Index tile = block_; tile * tile_rows < rows_; tile += blocks_)
      for (Index row = tile * tile_rows; row < min(rows_, (tile + 1) * tile_rows); row += each) {
        const Index first = (begin_ + row) / step;
        const Index end = (begin_ + min(rows_, row + each) + step - 1) / step;
        for (Index from = first, to; from < end; from = to) {
          to = min(end, (from / coarse_domain + 1) * coarse_domain);
          sum_domains(from, parity, domain);
          multiply(from, static_cast<int>(to - from));
          combine(from, static_cast<int>(to - from));
        }
      }
  }

  /// Own moves by the recurrence of r, from those of w: s = w + beta s, r -= alpha s. Those of r
  /// themselves if `restart`. Block calls it.
  __device__ void advance(double alpha, double beta, bool restart) const {
    const Index step = levels().partial_rows;
    const int each = coarse_dofs * static_cast<int>(tile_rows / step);
    for (Index tile = block_; tile * tile_rows < rows_; tile += blocks_)
      for (int n = static_cast<int>(threadIdx.x); n < each; n += 32 * tile_units) {
        const Index row = tile * tile_rows + n / coarse_dofs * step;
        if (row >= rows_) continue;
        double* r = moves_of(row) + n % coarse_dofs;
        double* s = r + coarse_dofs;
        const double w = s[coarse_dofs];
        if (restart) {
          *r = w;
          continue;
        }
        *s = w + (beta == 0 ? 0 : beta * *s);
        *r -= alpha * *s;
      }
    __syncthreads();
  }

  /// u += what all levels make of r. Block calls it.
  __device__ void correct(const WarpRows& at, int parity, const Vec3<T> r[2], Vec3<T> u[2]) {
    T moves[coarse_dofs] = {};
    if (levels().has_fine()) solve_fine(at, parity, r, moves);
    if (!small() && at.any) add_upper(at.first, moves);
#pragma unroll
    for (int j = 0; j < 2; ++j) {
      const Index row = at.first + 32 * j + at.lane;
      if (row >= rows_) continue;
      if (small()) {
        for (T& x : moves) x = 0;
        add_upper(row, moves);
      }
      u[j] += T(coarse_weight) *
              move_at(coarse_basis_of<T>(levels().point.data()[begin_ + row]), moves);
    }
  }

 private:
  __device__ const CoarseBasisLevels<T>& levels() const {
    return part_.modes;
  }
  __device__ CoarseBasisStep<T> unit_step(Index row) const {
    return levels().unit.data()[(begin_ + row) / levels().unit_rows];
  }
  __device__ double* moves_of(Index row) const {
    return levels().move.data() + Offset{row / levels().partial_rows} * 3 * coarse_dofs;
  }
  __device__ double* sums_of(const SolvePcgPart<T>& part, Index partial, int parity) const {
    return part.modes.sum.data() +
           (Offset{parity} * levels().upper[0].aggregates + partial) * coarse_dofs;
  }
  /// Sums of a reduction block, by whichever rank has it.
  __device__ const double* sums_of_owner(Index partial, int parity) const {
    int peer = 0;
    while (a_.row_begin.data()[peer + 1] <= partial * levels().partial_rows) ++peer;
    return sums_of(a_.parts.data()[peer], partial, parity);
  }

  /// Adds the moves of the levels above to those of the unit that an own row is in.
  __device__ void add_upper(Index row, T moves[coarse_dofs]) const {
    T upper[coarse_dofs];
    for (int k = 0; k < coarse_dofs; ++k) upper[k] = static_cast<T>(moves_of(row)[k]);
    add_coarse_correction(unit_step(row), upper, moves);
  }

  /// Moves of the warp's unit within its reduction block's matrix: nine rows of it, a lane a
  /// column.
  __device__ void solve_fine(const WarpRows& at, int parity, const Vec3<T> r[2],
                             T moves[coarse_dofs]) {
    T sum[coarse_dofs] = {};
#pragma unroll
    for (int j = 0; j < 2; ++j) {
      const Index row = at.first + 32 * j + at.lane;
      if (row < rows_) add(row, r[j], sum);
    }
#pragma unroll
    for (int k = 0; k < coarse_dofs; ++k) {
      sum[k] = sum_lanes(sum[k]);
      if (at.lane == k) s_.fine[parity][at.unit * coarse_dofs + k] = sum[k];
    }
    // Two sets of sums by turns: whoever writes one again has passed the barrier in between.
    __syncthreads();
    if (!at.any) return;
    const auto units = static_cast<int>(levels().units());
    const int size = coarse_dofs * units;
    const T* factor = s_.fine[parity] + at.unit / units * size;
    const T* matrix = levels().fine_inverse.data() +
                      Offset{at.first / levels().partial_rows} * size * size +
                      coarse_dofs * (at.unit % units) * size;
#pragma unroll 2
    for (int column = at.lane; column < size; column += 32)
#pragma unroll
      for (int k = 0; k < coarse_dofs; ++k)
        moves[k] += __ldcs(matrix + k * size + column) * factor[column];
#pragma unroll
    for (int k = 0; k < coarse_dofs; ++k) moves[k] = sum_lanes(moves[k]);
  }

  /// Sums over the aggregates of the domains, of all levels, that a partial sum is in.
  /// @param domain those that the sums in shared memory are of
  __device__ void sum_domains(Index partial, int parity, Index domain[coarse_levels_max]) {
    Index aggregate = partial;
    for (int k = 0; k < levels().upper_count; ++k) {
      aggregate /= coarse_domain;
      if (domain[k] == aggregate) continue;
      domain[k] = aggregate;
      if (k == 0)
        take_sums(aggregate, parity);
      else
        join_sums(k, aggregate, parity);
    }
    __syncthreads();
  }
  __device__ void take_sums(Index domain, int parity) {
    for (int n = static_cast<int>(threadIdx.x); n < coarse_domain_dofs; n += 32 * tile_units) {
      const Index partial = domain * coarse_domain + n / coarse_dofs;
      s_.sum[0][n] = partial < levels().upper[0].aggregates
                         ? sums_of_owner(partial, parity)[n % coarse_dofs]
                         : 0;
    }
  }
  /// A warp an aggregate, a lane every 32nd of its partial sums.
  __device__ void join_sums(int level, Index domain, int parity) {
    static_assert(tile_units == coarse_domain);
    const auto warp = static_cast<int>(threadIdx.x) / 32;
    const auto lane = static_cast<int>(threadIdx.x) % 32;
    Offset each = 1;
    for (int k = 0; k < level; ++k) each *= coarse_domain;
    const Offset begin = (Offset{domain} * coarse_domain + warp) * each;
    const Offset end = min(begin + each, Offset{levels().upper[0].aggregates});
    double all[coarse_dofs] = {};
    for (Offset partial = begin + lane; partial < end; partial += 32) {
      double sums[coarse_dofs];
      auto aggregate = static_cast<Index>(partial);
      const double* from = sums_of_owner(aggregate, parity);
      for (int n = 0; n < coarse_dofs; ++n) sums[n] = from[n];
      for (int k = 0; k < level; ++k, aggregate /= coarse_domain) {
        double larger[coarse_dofs] = {};
        add_sums(levels().upper[k].larger.data()[aggregate], sums, larger);
        for (int n = 0; n < coarse_dofs; ++n) sums[n] = larger[n];
      }
      for (int n = 0; n < coarse_dofs; ++n) all[n] += sums[n];
    }
    for (int n = 0; n < coarse_dofs; ++n) {
      const double sum = sum_lanes(all[n]);
      if (lane == 0) s_.sum[level][warp * coarse_dofs + n] = sum;
    }
  }

  /// Inverses times sums: rows of `count` partial sums from `first` on, then those of the
  /// aggregates around, level by level; a warp a row.
  __device__ void multiply(Index first, int count) {
    const auto warp = static_cast<int>(threadIdx.x) / 32;
    const auto lane = static_cast<int>(threadIdx.x) % 32;
    const int rows = coarse_dofs * (count + levels().upper_count - 1);
    for (int n = warp; n < rows; n += tile_units) {
      const int level = max(0, n / coarse_dofs - count + 1);
      Index aggregate = level == 0 ? first + n / coarse_dofs : first;
      for (int k = 0; k < level; ++k) aggregate /= coarse_domain;
      const Index domain = aggregate / coarse_domain;
      const T* row =
          levels().upper[level].inverse.data() +
          Offset{domain} * coarse_domain_dofs * coarse_domain_dofs +
          (aggregate % coarse_domain * coarse_dofs + n % coarse_dofs) * coarse_domain_dofs;
      double sum = 0;
      for (int column = lane; column < coarse_domain_dofs; column += 32)
        sum += static_cast<double>(row[column]) * s_.sum[level][column];
      sum = sum_lanes(sum);
      if (lane == 0) s_.product[n] = sum;
    }
    __syncthreads();
  }

  /// Component n of the motion of a smaller aggregate that lies within a larger one.
  /// @param larger coefficients of the motion of the larger aggregate
  __device__ static double inner_move(const CoarseBasisStep<T>& step, const double* larger, int n) {
    if (n >= 3) return static_cast<double>(step.scale) * larger[n];
    return larger[n] + static_cast<double>(step.u) * larger[3 + n] +
           static_cast<double>(step.v) * larger[6 + n];
  }

  /// Adds up the products from the highest level down; moves of w of the partial sums result.
  __device__ void combine(Index first, int count) {
    const auto n = static_cast<int>(threadIdx.x);
    const int top = levels().upper_count - 1;
    if (n < 32) {
      for (int level = top; level > 0; --level) {
        Index aggregate = first;
        for (int k = 0; k < level; ++k) aggregate /= coarse_domain;
        if (n < coarse_dofs) {
          double x = s_.product[coarse_dofs * (count + level - 1) + n];
          if (level < top)
            x +=
                inner_move(levels().upper[level].larger.data()[aggregate], s_.larger[level + 1], n);
          s_.larger[level][n] = x;
        }
        __syncwarp();
      }
    }
    __syncthreads();
    if (n < coarse_dofs * count) {
      const Index partial = first + n / coarse_dofs;
      double x = s_.product[n];
      if (top > 0)
        x += inner_move(levels().upper[0].larger.data()[partial], s_.larger[1], n % coarse_dofs);
      moves_of(partial * levels().partial_rows - begin_)[2 * coarse_dofs + n % coarse_dofs] = x;
    }
    __syncthreads();
  }

  const SolvePcg<T>& a_;
  const SolvePcgPart<T>& part_;
  CoarseBasisSums<T>& s_;
  Index begin_, rows_;
  int block_, blocks_;
};

}  // namespace weft::cuda
