#pragma once

#include "cuda/exec/sums.cuh"
#include "weft/kernels/solve/schwarz_levels.hpp"

namespace weft::cuda {

/// Rows of a unit: the domain of the finest level of aggregates, if that is whole, and an aggregate
/// of the next. A warp works on a unit, two rows a lane, or two warps do, one row a lane: the sums
/// are the same, added in the same order.
inline constexpr Index unit_rows = 64;
/// Rows that a block works on at a time where there are levels: a domain of the coarsest, if that
/// is whole.
inline constexpr Index tile_rows = 1024;
inline constexpr int tile_units = tile_rows / unit_rows;

/// Shared memory that the levels of a block need.
template <class T, int lane_rows>
struct AggregateSums {
  static constexpr int fine_size = 3 * static_cast<int>(schwarz_aggregates_max);
  T fine[tile_units][fine_size];
  T piece[lane_rows == 1 ? tile_units : 1][2][fine_size];  ///< of a unit's two warps
  T wide[2][tile_units][2][3];  ///< of halves of the units, two sets by turns
};

/// What a warp's part of the tile is about.
struct WarpRows {
  int unit;  ///< in the tile
  int half;  ///< of the unit, where it has two warps, else 0
  int lane;
  Index first;  ///< local row of lane 0; lane's rows: first + lane, and first + 32 + lane if two
  bool any;     ///< the unit has rows
};

/// Until all warps of a unit are here. Where there are two, the whole block calls it.
template <int lane_rows>
__device__ void sync_unit() {
  if constexpr (lane_rows == 2)
    __syncwarp();
  else
    __syncthreads();
}

/// Sums of residuals over the aggregates of four rows, to shared memory; those over halves of the
/// unit, which is an aggregate of the next level, too.
template <int lane_rows, class T>
__device__ void sum_aggregates(const WarpRows& at, const Vec3<T>* r,
                               AggregateSums<T, lane_rows>& sums, int parity) {
#pragma unroll
  for (int c = 0; c < 3; ++c)
    for (int j = 0; j < lane_rows; ++j) {
      const int half = at.half + j;
      T sum = sum_lanes(r[j][c], 4);
      if (at.lane % 4 == 0) sums.fine[at.unit][3 * (8 * half + at.lane / 4) + c] = sum;
      for (int step = 4; step < 32; step *= 2) sum += __shfl_xor_sync(whole_warp, sum, step);
      if (at.lane == 0) sums.wide[parity][at.unit][half][c] = sum;
    }
  sync_unit<lane_rows>();
}

/// Part 0 or 1 of the inverse of a whole domain times the sums of its aggregates, three numbers per
/// aggregate. Lane a + 16 h has aggregate a and the blocks of the distances 4 h + 2 part + 1 and
/// + 2, read once by all lanes side by side; each is used for its row and, transposed, for the row
/// at that distance. Part 0 has the diagonal too. Lanes a and a + 16 get the same.
template <class T>
__device__ Vec3<T> multiply_part(int part, int lane, const T* inverse, const T* x) {
  constexpr Index n = schwarz_aggregates_max;
  static_assert(n == 16);
  const Index a = lane % 16, half = lane / 16;
  const Vec3<T> own{x[3 * a], x[3 * a + 1], x[3 * a + 2]};
  Vec3<T> y{};
  if (part == 0) {
    T d[3];
    for (int k = 0; k < 3; ++k)
      d[k] = __ldcs(inverse + SymmetricBlocks::diagonal_place(n, 0, a) + (3 * half + k) * n);
    if (half == 0)
      y = {d[0] * own[0] + d[1] * own[1] + d[2] * own[2], d[1] * own[0], d[2] * own[0]};
    else
      y = {T(0), d[0] * own[1] + d[1] * own[2], d[1] * own[1] + d[2] * own[2]};
  }
#pragma unroll
  for (int step = 1; step <= 2; ++step) {
    const Index distance = 4 * half + 2 * part + step;
    const T* block = inverse + SymmetricBlocks::place(n, distance, 0, a);
    T e[9];
    for (int k = 0; k < 9; ++k) e[k] = __ldcs(block + k * n);
    const T* other = x + 3 * ((a + distance) % n);
    for (int i = 0; i < 3; ++i)
      y[i] += e[3 * i] * other[0] + e[3 * i + 1] * other[1] + e[3 * i + 2] * other[2];
    for (int j = 0; j < 3; ++j) {
      const T behind = e[j] * own[0] + e[3 + j] * own[1] + e[6 + j] * own[2];
      const T ahead =
          __shfl_sync(whole_warp, behind, static_cast<int>(16 * half + (a + n - distance) % n));
      if (distance < n / 2) y[j] += ahead;
    }
  }
  for (int c = 0; c < 3; ++c) y[c] += __shfl_xor_sync(whole_warp, y[c], 16);
  return y;
}

/// inverse times the sums of a whole domain. Sums become moves, where the unit has any rows. Never
/// inlined, as multiply_rows().
template <int lane_rows, class T>
__device__ __noinline__ void multiply_domain(const WarpRows& at, const T* inverse,
                                             AggregateSums<T, lane_rows>& sums) {
  T* x = sums.fine[at.unit];
  const auto keep = [&](T* to, const Vec3<T>& y) {
    if (at.lane < 16)
      for (int c = 0; c < 3; ++c) to[3 * at.lane + c] = y[c];
  };
  if constexpr (lane_rows == 2) {
    if (!at.any) return;
    Vec3<T> y = multiply_part(0, at.lane, inverse, x);
    y += multiply_part(1, at.lane, inverse, x);
    __syncwarp();
    keep(x, y);
    __syncwarp();
  } else {
    if (at.any) keep(sums.piece[at.unit][at.half], multiply_part(at.half, at.lane, inverse, x));
    sync_unit<lane_rows>();
    for (int i = at.lane + 32 * at.half; at.any && i < sums.fine_size; i += 64)
      x[i] = sums.piece[at.unit][0][i] + sums.piece[at.unit][1][i];
    sync_unit<lane_rows>();
  }
}

/// u += weight R^T (R A R^T)^-1 R r on the finest level, after sum_aggregates().
template <int lane_rows, class T>
__device__ void correct_fine(const WarpRows& at, const FineLevel<T>& level, Index rows,
                             AggregateSums<T, lane_rows>& sums, Vec3<T>* u) {
  const T* inverse = level.inverse.data();
  const bool whole = level.aggregates == schwarz_aggregates_max;
  if (whole)
    multiply_domain(at, inverse + Offset{at.first / unit_rows} * level.domain_numbers(), sums);
  const T* sum = sums.fine[at.unit];
#pragma unroll
  for (int j = 0; j < lane_rows; ++j) {
    if (at.first + 32 * j + at.lane >= rows) continue;
    const Index aggregate = 8 * (at.half + j) + at.lane / 4;
    Vec3<T> move;
    if (whole) {
      for (int c = 0; c < 3; ++c) move[c] = sum[3 * aggregate + c];
    } else {
      // Domains of systems of less than a thousand rows.
      const Index domain = aggregate / level.aggregates;
      const Offset unit = at.first / unit_rows * (unit_rows / level.domain_rows());
      move = SymmetricBlocks::multiply_row(inverse + (unit + domain) * level.domain_numbers(),
                                           level.aggregates, aggregate % level.aggregates,
                                           sum + domain * level.size());
    }
    u[j] += T(schwarz_weight) * move;
  }
  // The unit's other warp may still need sums that the next tile's will replace.
  sync_unit<lane_rows>();
}

/// The same on the next level, whose aggregates are units. The whole block calls it.
template <int lane_rows, class T>
__device__ void correct_wide(const WarpRows& at, const WideLevel<T>& level, int parity,
                             const AggregateSums<T, lane_rows>& sums, Vec3<T>* u) {
  const Index size = level.size();
  const Index domain = at.first / unit_rows / level.aggregates;
  const Index aggregate = at.first / unit_rows % level.aggregates;
  const T* matrix =
      level.inverse.data() + Offset{domain} * size * size + 3 * aggregate * size + at.lane;
  T entry[3][2] = {};
#pragma unroll
  for (int c = 0; c < 3; ++c)
#pragma unroll
    for (int part = 0; part < 2; ++part)
      if (at.any && at.lane + 32 * part < size) entry[c][part] = matrix[c * size + 32 * part];
  // Two sets of sums by turns: whoever writes one again has passed the barrier in between.
  __syncthreads();
  T sum[2] = {};
#pragma unroll
  for (int part = 0; part < 2; ++part) {
    const int n = at.lane + 32 * part;
    if (n >= size) continue;
    const auto& halves = sums.wide[parity][at.unit / level.aggregates * level.aggregates + n / 3];
    sum[part] = halves[0][n % 3] + halves[1][n % 3];
  }
#pragma unroll
  for (int c = 0; c < 3; ++c) {
    T move = 0;
    for (int part = 0; part < 2; ++part) move += entry[c][part] * sum[part];
    move = T(schwarz_weight) * sum_lanes(move);
    for (int j = 0; j < lane_rows; ++j) u[j][c] += move;
  }
}

}  // namespace weft::cuda
