#pragma once

#include "cuda/solve/reduce.cuh"
#include "weft/kernels/solve/coarse.hpp"

namespace weft::cuda {

/// Rows that a warp works on at a time, two a lane. They are the domain of the finest level of
/// aggregates, if that is whole, and an aggregate of the next.
inline constexpr Index warp_rows = 64;
/// Rows that a block works on at a time: a domain of the coarsest level, if that is whole.
inline constexpr Index tile_rows = 1024;
inline constexpr int tile_warps = tile_rows / warp_rows;

/// Shared memory that the levels of a block need.
template <class T>
struct AggregateSums {
  static constexpr int wide_load = 16 / sizeof(T);  ///< numbers in a load of 16 bytes
  static constexpr int fine_size = 3 * static_cast<int>(coarse_aggregates_max);
  alignas(16) T piece[tile_warps][3 * 32 * wide_load];
  T fine[tile_warps][fine_size];
  T wide[2][tile_warps][3];
};

/// What a warp's part of the tile is about.
struct WarpRows {
  int warp;  ///< in the block
  int lane;
  Index first;  ///< local row of lane 0; lane's rows: first + lane, first + 32 + lane
  bool any;     ///< some of them exist
};

/// Sums of residuals over the aggregates of four rows, to shared memory; those over the warp's 64
/// rows, as an aggregate of the next level, too.
template <class T>
__device__ void sum_aggregates(const WarpRows& at, const Vec3<T> r[2], AggregateSums<T>& sums,
                               int parity) {
#pragma unroll
  for (int c = 0; c < 3; ++c) {
    T all = 0;
    for (int j = 0; j < 2; ++j) {
      T sum = sum_lanes(r[j][c], 4);
      if (at.lane % 4 == 0) sums.fine[at.warp][3 * (8 * j + at.lane / 4) + c] = sum;
      for (int step = 4; step < 32; step *= 2) sum += __shfl_xor_sync(whole_warp, sum, step);
      all += sum;
    }
    if (at.lane == 0) sums.wide[parity][at.warp][c] = all;
  }
  __syncwarp();
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
/// there goes to shared memory and is added up column by column. Sums become moves.
template <class T>
__device__ void multiply_domain(const WarpRows& at, const T* inverse, AggregateSums<T>& sums) {
  constexpr int wide = AggregateSums<T>::wide_load;
  constexpr int size = AggregateSums<T>::fine_size;
  constexpr int columns = size / wide;
  static_assert(32 % columns == 8 && 3 * 8 % columns == 0);
  using Wide = WideLoad<T>;
  const auto* matrix = reinterpret_cast<const Wide*>(inverse) + at.lane;
  T* sum = sums.fine[at.warp];
#pragma unroll
  for (int j = 0; j < 3; ++j) {
    Wide gathered{};
    const T* factor = sum + (32 * j + at.lane) / columns;
#pragma unroll 6
    for (int m = 0; m < size * columns / 96; ++m) {
      const Wide entry = load_once(matrix + 96 * m + 32 * j);
      for (int k = 0; k < wide; ++k) gathered.e[k] += entry.e[k] * factor[96 / columns * m];
    }
    reinterpret_cast<Wide*>(sums.piece[at.warp])[32 * j + at.lane] = gathered;
  }
  __syncwarp();
  for (int i = at.lane; i < size; i += 32) {
    T move = 0;
    for (int j = 0; j < 3; ++j)
      for (int lane = (i / wide + 2 * columns - 8 * j) % columns; lane < 32; lane += columns)
        move += sums.piece[at.warp][(32 * j + lane) * wide + i % wide];
    sum[i] = move;
  }
  __syncwarp();
}

/// u += weight R^T (R A R^T)^-1 R r on the finest level, after sum_aggregates().
template <class T>
__device__ void correct_fine(const WarpRows& at, const CoarseLevel<T>& level, Index rows,
                             AggregateSums<T>& sums, Vec3<T> u[2]) {
  if (!at.any) return;
  const Index size = level.size();
  const T* inverse = level.inverse.data();
  const bool whole = level.aggregates == coarse_aggregates_max;
  if (whole) multiply_domain(at, inverse + Offset{at.first / warp_rows} * size * size, sums);
  const T* sum = sums.fine[at.warp];
#pragma unroll
  for (int j = 0; j < 2; ++j) {
    if (at.first + 32 * j + at.lane >= rows) continue;
    const Index aggregate = 8 * j + at.lane / 4;
    if (whole) {
      for (int c = 0; c < 3; ++c) u[j][c] += T(coarse_weight) * sum[3 * aggregate + c];
      continue;
    }
    // Domains of systems of less than a thousand rows.
    const Index domain = aggregate / level.aggregates;
    const T* matrix = inverse + Offset{at.first / level.domain_rows() + domain} * size * size +
                      3 * (aggregate % level.aggregates) * size;
    for (int c = 0; c < 3; ++c) {
      T move = 0;
      for (Index k = 0; k < size; ++k) move += matrix[c * size + k] * sum[domain * size + k];
      u[j][c] += T(coarse_weight) * move;
    }
  }
}

/// The same on the next level, whose aggregates are the warps' rows. The whole block calls it.
template <class T>
__device__ void correct_wide(const WarpRows& at, const CoarseLevel<T>& level, int parity,
                             const AggregateSums<T>& sums, Vec3<T> u[2]) {
  const Index size = level.size();
  const Index domain = at.first / warp_rows / level.aggregates;
  const Index aggregate = at.first / warp_rows % level.aggregates;
  const T* matrix =
      level.inverse.data() + Offset{domain} * size * size + 3 * aggregate * size + at.lane;
  T entry[3][2] = {};
#pragma unroll
  for (int c = 0; c < 3; ++c)
#pragma unroll
    for (int half = 0; half < 2; ++half)
      if (at.any && at.lane + 32 * half < size) entry[c][half] = matrix[c * size + 32 * half];
  // Two sets of sums by turns: whoever writes one again has passed the barrier in between.
  __syncthreads();
  const T* sum = &sums.wide[parity][at.warp / level.aggregates * level.aggregates][0] + at.lane;
#pragma unroll
  for (int c = 0; c < 3; ++c) {
    T move = 0;
    for (int half = 0; half < 2; ++half)
      if (at.lane + 32 * half < size) move += entry[c][half] * sum[32 * half];
    move = T(coarse_weight) * sum_lanes(move);
    u[0][c] += move;
    u[1][c] += move;
  }
}

}  // namespace weft::cuda
