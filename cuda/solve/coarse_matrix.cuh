#pragma once

#include "cuda/exec/sums.cuh"
#include "weft/state/coarse_basis.hpp"

namespace weft::cuda {

/// Threads of a block that works on a domain's matrix, a warp for each of its aggregates.
inline constexpr int coarse_threads = 32 * static_cast<int>(coarse_domain);

/// A symmetric matrix of at most coarse_domain_dofs rows in shared memory, by its lower triangle:
/// whole, it would fill that of a processor of H100 and exceed that of others.
struct PackedMatrix {
  double entry[coarse_domain_dofs * (coarse_domain_dofs + 1) / 2];
  double column[coarse_domain_dofs];
  double half[coarse_dofs][coarse_dofs];

  __device__ double& at(int i, int j) {
    return i >= j ? entry[i * (i + 1) / 2 + j] : entry[j * (j + 1) / 2 + i];
  }
};
/// Shared memory to ask for: more than a launch gets unasked.
inline constexpr int packed_bytes = static_cast<int>(sizeof(PackedMatrix));

/// All zero. The whole block calls it, as all that follows.
__device__ inline void clear(PackedMatrix& m) {
  for (int n = static_cast<int>(threadIdx.x); n < coarse_domain_dofs * (coarse_domain_dofs + 1) / 2;
       n += coarse_threads)
    m.entry[n] = 0;
  __syncthreads();
}

/// What the matrix of `count` aggregates is on the larger one around them, to out[9][stride]:
/// products step^T block step, summed in order.
/// @param larger [count] steps to that aggregate
template <class T>
__device__ void restrict_matrix(PackedMatrix& m, const CoarseBasisStep<T>* larger, int count,
                                double* out, int stride) {
  const auto thread = static_cast<int>(threadIdx.x);
  if (thread < coarse_dofs * coarse_dofs) {
    const int i = thread / coarse_dofs;
    const int j = thread % coarse_dofs;
    double all = 0;
    for (int row = 0; row < count; ++row)
      for (int column = 0; column < count; ++column) {
        const auto entry = [&](int p, int q) {
          return m.at(coarse_dofs * row + p, coarse_dofs * column + q);
        };
        // Of each side two numbers count at most: the component's translation, and its own.
        const auto along = [&](int p) {
          double sum = entry(p, j);
          if (j < 3) return sum;
          const CoarseBasisStep<T>& step = larger[column];
          sum *= static_cast<double>(step.scale);
          return sum + static_cast<double>(j < 6 ? step.u : step.v) * entry(p, j % 3);
        };
        double sum = along(i);
        if (i >= 3) {
          const CoarseBasisStep<T>& step = larger[row];
          sum = static_cast<double>(i < 6 ? step.u : step.v) * along(i % 3) +
                static_cast<double>(step.scale) * sum;
        }
        all += sum;
      }
    out[i * stride + j] = all;
  }
  __syncthreads();
}

/// Inverts the first `size` rows, after coarse_shift of the diagonal has been added to it: a sweep
/// of each row by turns, which keeps the matrix symmetric and needs no pivots where it is positive
/// definite. A warp has every 16th row.
__device__ inline void invert(PackedMatrix& m, int size) {
  const auto thread = static_cast<int>(threadIdx.x);
  const int warp = thread / 32;
  const int lane = thread % 32;
  if (thread < size) {
    const double d = m.at(thread, thread);
    m.at(thread, thread) = d > 0 ? (1 + coarse_shift) * d : 1;
  }
  __syncthreads();
  for (int k = 0; k < size; ++k) {
    for (int i = thread; i < size; i += coarse_threads) m.column[i] = m.at(i, k);
    __syncthreads();
    const double pivot = 1 / m.column[k];
    for (int i = warp; i < size; i += coarse_threads / 32) {
      double* row = m.entry + i * (i + 1) / 2;
      const double factor = pivot * m.column[i];
      for (int j = lane; j <= i; j += 32) {
        if (i == k)
          row[j] = j == k ? -pivot : pivot * m.column[j];
        else if (j == k)
          row[j] = factor;
        else
          row[j] -= factor * m.column[j];
      }
    }
    __syncthreads();
  }
  for (int n = thread; n < size * (size + 1) / 2; n += coarse_threads) m.entry[n] = -m.entry[n];
  __syncthreads();
}

/// Writes the first `size` rows to out[width][width], zero beyond them.
template <class T>
__device__ void store(PackedMatrix& m, int size, T* out, int width) {
  for (int n = static_cast<int>(threadIdx.x); n < width * width; n += coarse_threads) {
    const int i = n / width;
    const int j = n % width;
    out[n] = i < size && j < size ? static_cast<T>(m.at(i, j)) : T(0);
  }
}

}  // namespace weft::cuda
