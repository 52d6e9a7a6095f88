#include "weft/kernels/solve/coarse.hpp"

#include "cuda/exec/launch.cuh"

namespace weft {
namespace {

constexpr int coarse_threads = 256;
constexpr int size_max = 3 * static_cast<int>(coarse_aggregates_max);
constexpr Index domain_rows_max = coarse_aggregates_max << coarse_shift(coarse_level_count - 1);

struct Domain {
  double matrix[size_max][size_max + 1];  ///< a column more, so that columns use all banks
  unsigned char fixed[domain_rows_max];
};

/// Component k, 3 i + j, of one entry's block.
template <class T>
__device__ T component(const BlockEll<T>& m, Offset slot, Index lane, int k) {
  return m.value.data()[(slot * 9 + k) * m.slice + lane];
}
template <class T>
__device__ T component(const ScalarEll<T>& m, Offset slot, Index lane, int k) {
  return k % 4 == 0 ? m.value.data()[slot * m.slice + lane] : T(0);
}

/// Adds the entries of `m` in the domain's rows [first, last) whose columns are among them. A
/// thread owns component k of all blocks in the block row of one aggregate, so that it needs no
/// atomics and adds in row order.
template <class T, class Matrix>
__device__ void add_entries(const SolveCoarse<T>& a, const Matrix& m, Index first, Index last,
                            Domain& domain) {
  const auto thread = static_cast<int>(threadIdx.x);
  const int aggregate = thread / 9;
  const int k = thread % 9;
  if (m.row_count == 0 || aggregate >= a.level.aggregates) return;
  double* sums = &domain.matrix[3 * aggregate + k / 3][k % 3];
  const Index begin = first + (static_cast<Index>(aggregate) << a.level.shift);
  const Index end = min(last, begin + (Index{1} << a.level.shift));
  for (Index row = begin; row < end; ++row) {
    if (domain.fixed[row - first] != 0) continue;
    const Index lane = row % m.slice;
    const Offset slot_end = m.slice_offset.data()[row / m.slice + 1];
#pragma unroll 4
    for (Offset slot = m.slice_offset.data()[row / m.slice]; slot < slot_end; ++slot) {
      const Index column = m.column.data()[slot * m.slice + lane] - a.row_begin;
      const T value = component(m, slot, lane, k);
      if (column >= first && column < last && domain.fixed[column - first] == 0)
        sums[3 * ((column - first) >> a.level.shift)] += static_cast<double>(value);
    }
  }
}

/// Inverts a symmetric positive definite matrix in place (Gauss-Jordan, which needs no pivots
/// there).
__device__ void invert(Domain& domain, int size) {
  auto& m = domain.matrix;
  const auto thread = static_cast<int>(threadIdx.x);
  for (int p = 0; p < size; ++p) {
    __syncthreads();
    const double scale = 1 / m[p][p];
    for (int n = thread; n < size * size; n += coarse_threads) {
      const int i = n / size;
      const int j = n % size;
      if (i != p && j != p) m[i][j] -= m[i][p] * (m[p][j] * scale);
    }
    __syncthreads();
    if (thread < size && thread != p) {
      m[p][thread] *= scale;
      m[thread][p] *= -scale;
    }
    if (thread == p) m[p][p] = scale;
  }
  __syncthreads();
}

/// One block a domain.
template <class T>
__global__ void __launch_bounds__(coarse_threads)
    solve_coarse(const __grid_constant__ SolveCoarse<T> a) {
  __shared__ Domain domain;
  const auto thread = static_cast<int>(threadIdx.x);
  const Index first = static_cast<Index>(blockIdx.x) * a.level.domain_rows();
  const Index last = min(a.mesh.row_count, first + a.level.domain_rows());
  const int size = a.level.size();
  for (Index row = first + thread; row < last; row += coarse_threads)
    domain.fixed[row - first] = a.fixed.data()[a.row_begin + row];
  for (int n = thread; n < size * size; n += coarse_threads) domain.matrix[n / size][n % size] = 0;
  __syncthreads();
  add_entries(a, a.mesh, first, last, domain);
  add_entries(a, a.far, first, last, domain);
  add_entries(a, a.contact, first, last, domain);
  __syncthreads();
  if (thread < size && domain.matrix[thread][thread] == 0) domain.matrix[thread][thread] = 1;
  invert(domain, size);
  // Conjugate gradients need a symmetric preconditioner, to the bit.
  T* out = a.level.inverse.data() + static_cast<std::size_t>(blockIdx.x) * size * size;
  for (int n = thread; n < size * size; n += coarse_threads) {
    const int i = n / size;
    const int j = n % size;
    out[n] = static_cast<T>(i >= j ? domain.matrix[i][j] : domain.matrix[j][i]);
  }
}

}  // namespace

template <class T>
void run(OnCuda, Queue& queue, const SolveCoarse<T>& args) {
  const Index rows = args.mesh.row_count;
  if (rows <= 0) return;
  const auto& cuda_queue = static_cast<const CudaQueue&>(queue);
  cuda_queue.make_current();
  const Index step = args.level.domain_rows();
  const auto blocks = static_cast<unsigned>((rows + step - 1) / step);
  solve_coarse<<<blocks, coarse_threads, 0, cuda_queue.stream()>>>(args);
  cuda::check(cudaGetLastError(), "kernel launch", cuda_queue.rank());
}

template void run(OnCuda, Queue&, const SolveCoarse<float>&);
template void run(OnCuda, Queue&, const SolveCoarse<double>&);

}  // namespace weft
