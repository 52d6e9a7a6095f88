#pragma once

#include "cuda/exec/sums.cuh"
#include "weft/kernels/solve/schwarz_level.hpp"

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
template <class T>
struct AggregateSums {
  static constexpr int wide_load = 16 / sizeof(T);  ///< numbers in a load of 16 bytes
  static constexpr int fine_size = 3 * static_cast<int>(schwarz_aggregates_max);
  alignas(16) T piece[tile_units][3 * 32 * wide_load];
  T fine[tile_units][fine_size];
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
__device__ void sum_aggregates(const WarpRows& at, const Vec3<T>* r, AggregateSums<T>& sums,
                               int parity) {
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

/// 16 bytes that are used once, so that they leave the caches first.
template <class T>
struct alignas(16) WideLoad {
  T e[AggregateSums<T>::wide_load];
};
__device__ inline WideLoad<float> load_once(const WideLoad<float>* from) {
  const float4 x = __ldcs(reinterpret_cast<const float4*>(from));
  return {{x.x, x.y, x.z, x.w}};
}
__device__ inline WideLoad<double> load_once(const WideLoad<double>* from) {
  const double2 x = __ldcs(reinterpret_cast<const double2*>(from));
  return {{x.x, x.y}};
}

/// inverse times the sums of a whole domain: 48 x 48 numbers, read once, in loads of 16 bytes, by
/// all lanes alike. A lane's loads stand in three columns of such loads by turns; what it gathers
/// there goes to shared memory and is added up column by column. Sums become moves, where the unit
/// has any rows.
template <int lane_rows, class T>
__device__ void multiply_domain(const WarpRows& at, const T* inverse, AggregateSums<T>& sums) {
  constexpr int warps = 3 - lane_rows;  // of the unit
  constexpr int wide = AggregateSums<T>::wide_load;
  constexpr int size = AggregateSums<T>::fine_size;
  constexpr int columns = size / wide;
  static_assert(32 % columns == 8 && 3 * 8 % columns == 0);
  using Wide = WideLoad<T>;
  const auto* matrix = reinterpret_cast<const Wide*>(inverse) + at.lane;
  T* sum = sums.fine[at.unit];
#pragma unroll
  for (int j = 0; j < 3; ++j) {
    if (!at.any || j % warps != at.half) continue;
    Wide gathered{};
    const T* factor = sum + (32 * j + at.lane) / columns;
#pragma unroll 6
    for (int m = 0; m < size * columns / 96; ++m) {
      const Wide entry = load_once(matrix + 96 * m + 32 * j);
      for (int k = 0; k < wide; ++k) gathered.e[k] += entry.e[k] * factor[96 / columns * m];
    }
    reinterpret_cast<Wide*>(sums.piece[at.unit])[32 * j + at.lane] = gathered;
  }
  sync_unit<lane_rows>();
  for (int i = at.lane + 32 * at.half; at.any && i < size; i += 32 * warps) {
    T move = 0;
    for (int j = 0; j < 3; ++j)
      for (int lane = (i / wide + 2 * columns - 8 * j) % columns; lane < 32; lane += columns)
        move += sums.piece[at.unit][(32 * j + lane) * wide + i % wide];
    sum[i] = move;
  }
  sync_unit<lane_rows>();
}

/// u += weight R^T (R A R^T)^-1 R r on the finest level, after sum_aggregates().
template <int lane_rows, class T>
__device__ void correct_fine(const WarpRows& at, const SchwarzLevel<T>& level, Index rows,
                             AggregateSums<T>& sums, Vec3<T>* u) {
  const Index size = level.size();
  const T* inverse = level.inverse.data();
  const bool whole = level.aggregates == schwarz_aggregates_max;
  if (whole)
    multiply_domain<lane_rows>(at, inverse + Offset{at.first / unit_rows} * size * size, sums);
  const T* sum = sums.fine[at.unit];
#pragma unroll
  for (int j = 0; j < lane_rows; ++j) {
    if (at.first + 32 * j + at.lane >= rows) continue;
    const Index aggregate = 8 * (at.half + j) + at.lane / 4;
    if (whole) {
      for (int c = 0; c < 3; ++c) u[j][c] += T(schwarz_weight) * sum[3 * aggregate + c];
      continue;
    }
    // Domains of systems of less than a thousand rows.
    const Index domain = aggregate / level.aggregates;
    const Index unit = at.first / unit_rows;
    const T* matrix = inverse +
                      Offset{unit * unit_rows / level.domain_rows() + domain} * size * size +
                      3 * (aggregate % level.aggregates) * size;
    for (int c = 0; c < 3; ++c) {
      T move = 0;
      for (Index k = 0; k < size; ++k) move += matrix[c * size + k] * sum[domain * size + k];
      u[j][c] += T(schwarz_weight) * move;
    }
  }
  // The unit's other warp may still need sums that the next tile's will replace.
  sync_unit<lane_rows>();
}

/// The same on the next level, whose aggregates are units. The whole block calls it.
template <int lane_rows, class T>
__device__ void correct_wide(const WarpRows& at, const SchwarzLevel<T>& level, int parity,
                             const AggregateSums<T>& sums, Vec3<T>* u) {
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
