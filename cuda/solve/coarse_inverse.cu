#include "weft/kernels/solve/coarse_inverse.hpp"

#include "cuda/exec/launch.cuh"
#include "cuda/solve/coarse_matrix.cuh"

namespace weft {
namespace {

using namespace cuda;

/// Adds the strips of an aggregate's partial sums to its rows of the domain's matrix, left of and
/// on the diagonal, a lane a column. The warp is the aggregate's.
template <class T>
__device__ void add_strips(const SolveUpper<T>& a, Index aggregate, int n, PackedMatrix& matrix) {
  const int lane = static_cast<int>(threadIdx.x) % 32;
  Offset partials_each = 1;
  for (int k = 0; k < a.level; ++k) partials_each *= mode_domain;
  const Offset begin = aggregate * partials_each;
  const Offset end = min(begin + partials_each, Offset{a.levels.upper[0].aggregates});
  for (int j = lane; j < mode_numbers * (n + 1); j += 32) {
    double all[mode_numbers] = {};
    for (Offset partial = begin; partial < end; ++partial) {
      const double* strip = a.strip.data() +
                            (partial * a.levels.upper_count + a.level) * mode_numbers * mode_size +
                            j;
      double sums[mode_numbers];
      for (int i = 0; i < mode_numbers; ++i) sums[i] = strip[i * mode_size];
      auto inner = static_cast<Index>(partial);
      for (int k = 0; k < a.level; ++k, inner /= mode_domain) {
        double larger[mode_numbers] = {};
        add_sums(a.levels.upper[k].larger.data()[inner], sums, larger);
        for (int i = 0; i < mode_numbers; ++i) sums[i] = larger[i];
      }
      for (int i = 0; i < mode_numbers; ++i) all[i] += sums[i];
    }
    for (int i = 0; i < mode_numbers; ++i)
      if (j <= mode_numbers * n + i) matrix.at(mode_numbers * n + i, j) += all[i];
  }
}

/// One block a domain.
template <class T>
__global__ void __launch_bounds__(mode_threads)
    solve_upper(const __grid_constant__ SolveUpper<T> a) {
  extern __shared__ double memory[];
  PackedMatrix& matrix = *reinterpret_cast<PackedMatrix*>(memory);
  const ModeLevel<T>& level = a.levels.upper[a.level];
  const auto thread = static_cast<int>(threadIdx.x);
  const auto domain = static_cast<Index>(blockIdx.x);
  const Index first = domain * mode_domain;
  const int count = min(mode_domain, level.aggregates - first);
  const int size = mode_numbers * count;
  clear(matrix);
  const int warp = thread / 32;
  if (warp < count) add_strips(a, first + warp, warp, matrix);
  __syncthreads();
  constexpr int block = mode_numbers * mode_numbers;
  if (a.level > 0)
    for (int n = thread; n < count * block; n += mode_threads) {
      const int i = n % block / mode_numbers;
      const int j = n % mode_numbers;
      const int place = n / block * mode_numbers;
      if (i >= j) matrix.at(place + i, place + j) += a.diagonal.data()[Offset{first} * block + n];
    }
  __syncthreads();
  if (a.level + 1 < a.levels.upper_count)
    restrict_matrix(matrix, level.larger.data() + first, count,
                    a.next_diagonal.data() + Offset{domain} * block, mode_numbers);
  invert(matrix, size);
  store(matrix, size, level.inverse.data() + Offset{domain} * mode_size * mode_size, mode_size);
}

}  // namespace

template <class T>
void run(OnCuda, Queue& queue, const SolveUpper<T>& args) {
  const auto& cuda_queue = static_cast<const CudaQueue&>(queue);
  cuda_queue.make_current();
  const auto blocks = static_cast<unsigned>(args.levels.upper[args.level].domains());
  cuda::check(cudaFuncSetAttribute(solve_upper<T>, cudaFuncAttributeMaxDynamicSharedMemorySize,
                                   packed_bytes),
              "cudaFuncSetAttribute", cuda_queue.rank());
  solve_upper<<<blocks, mode_threads, packed_bytes, cuda_queue.stream()>>>(args);
  cuda::check(cudaGetLastError(), "kernel launch", cuda_queue.rank());
}

template void run(OnCuda, Queue&, const SolveUpper<float>&);
template void run(OnCuda, Queue&, const SolveUpper<double>&);

}  // namespace weft
