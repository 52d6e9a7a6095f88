#include "weft/kernels/solve/coarse_inverse.hpp"

#include "cuda/exec/launch.cuh"
#include "cuda/solve/coarse_matrix.cuh"

namespace weft {
namespace {

using namespace cuda;

/// Adds the strips of an aggregate's partial sums to its rows of the domain's matrix, left of and
/// on the diagonal, a lane a column. The warp is the aggregate's.
template <class T>
__device__ void add_strips(const SolveCoarseInverse<T>& a, Index aggregate, int n,
                           PackedMatrix& matrix) {
  const int lane = static_cast<int>(threadIdx.x) % 32;
  Offset partials_each = 1;
  for (int k = 0; k < a.level; ++k) partials_each *= coarse_domain;
  const Offset begin = aggregate * partials_each;
  const Offset end = min(begin + partials_each, Offset{a.levels.upper[0].aggregates});
  for (int j = lane; j < coarse_dofs * (n + 1); j += 32) {
    double all[coarse_dofs] = {};
    for (Offset partial = begin; partial < end; ++partial) {
      const double* strip =
          a.strip.data() +
          (partial * a.levels.upper_count + a.level) * coarse_dofs * coarse_domain_dofs + j;
      double sums[coarse_dofs];
      for (int i = 0; i < coarse_dofs; ++i) sums[i] = strip[i * coarse_domain_dofs];
      auto inner = static_cast<Index>(partial);
      for (int k = 0; k < a.level; ++k, inner /= coarse_domain) {
        double larger[coarse_dofs] = {};
        add_sums(a.levels.upper[k].larger.data()[inner], sums, larger);
        for (int i = 0; i < coarse_dofs; ++i) sums[i] = larger[i];
      }
      for (int i = 0; i < coarse_dofs; ++i) all[i] += sums[i];
    }
    for (int i = 0; i < coarse_dofs; ++i)
      if (j <= coarse_dofs * n + i) matrix.at(coarse_dofs * n + i, j) += all[i];
  }
}

/// One block a domain.
template <class T>
__global__ void __launch_bounds__(coarse_threads)
    solve_coarse_inverse(const __grid_constant__ SolveCoarseInverse<T> a) {
  extern __shared__ double memory[];
  PackedMatrix& matrix = *reinterpret_cast<PackedMatrix*>(memory);
  const CoarseBasisLevel<T>& level = a.levels.upper[a.level];
  const auto thread = static_cast<int>(threadIdx.x);
  const auto domain = static_cast<Index>(blockIdx.x);
  const Index first = domain * coarse_domain;
  const int count = min(coarse_domain, level.aggregates - first);
  const int size = coarse_dofs * count;
  clear(matrix);
  const int warp = thread / 32;
  if (warp < count) add_strips(a, first + warp, warp, matrix);
  __syncthreads();
  constexpr int block = coarse_dofs * coarse_dofs;
  if (a.level > 0)
    for (int n = thread; n < count * block; n += coarse_threads) {
      const int i = n % block / coarse_dofs;
      const int j = n % coarse_dofs;
      const int place = n / block * coarse_dofs;
      if (i >= j) matrix.at(place + i, place + j) += a.diagonal.data()[Offset{first} * block + n];
    }
  __syncthreads();
  if (a.level + 1 < a.levels.upper_count)
    restrict_matrix(matrix, level.larger.data() + first, count,
                    a.next_diagonal.data() + Offset{domain} * block, coarse_dofs);
  invert(matrix, size);
  store(matrix, size,
        level.inverse.data() + Offset{domain} * coarse_domain_dofs * coarse_domain_dofs,
        coarse_domain_dofs);
}

}  // namespace

template <class T>
void run(OnCuda, Queue& queue, const SolveCoarseInverse<T>& args) {
  const auto& cuda_queue = static_cast<const CudaQueue&>(queue);
  cuda_queue.make_current();
  const auto blocks = static_cast<unsigned>(args.levels.upper[args.level].domains());
  cuda::check(cudaFuncSetAttribute(solve_coarse_inverse<T>,
                                   cudaFuncAttributeMaxDynamicSharedMemorySize, packed_bytes),
              "cudaFuncSetAttribute", cuda_queue.rank());
  solve_coarse_inverse<<<blocks, coarse_threads, packed_bytes, cuda_queue.stream()>>>(args);
  cuda::check(cudaGetLastError(), "kernel launch", cuda_queue.rank());
}

template void run(OnCuda, Queue&, const SolveCoarseInverse<float>&);
template void run(OnCuda, Queue&, const SolveCoarseInverse<double>&);

}  // namespace weft
