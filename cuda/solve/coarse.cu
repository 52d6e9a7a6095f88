#include "weft/kernels/solve/coarse.hpp"

#include "cuda/exec/launch.cuh"
#include "cuda/solve/reduce.cuh"

namespace weft {
namespace {

/// A thread for each pair of aggregates, which keeps their block while the matrix is inverted.
constexpr int side = static_cast<int>(coarse_aggregates_max);
constexpr int coarse_threads = side * side;
constexpr int size_max = 3 * side;
constexpr Index domain_rows_max = coarse_aggregates_max << coarse_shift(coarse_level_count - 1);

struct Domain {
  double matrix[size_max][size_max + 1];  ///< a column more, so that columns use all banks
  double pivot_row[2][size_max];
  double pivot_column[2][size_max];
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

/// Calls use(aggregate, slot) for each entry of a row whose column is a free row of the domain.
template <class T, class Matrix, class Use>
__device__ void visit_row(const SolveCoarse<T>& a, const Matrix& m, Index row, Index first,
                          Index last, const Domain& domain, const Use& use) {
  const Index lane = row % m.slice;
  const Offset end = m.slice_offset.data()[row / m.slice + 1];
  for (Offset slot = m.slice_offset.data()[row / m.slice]; slot < end; ++slot) {
    const Index column = m.column.data()[slot * m.slice + lane] - a.row_begin;
    if (column >= first && column < last && domain.fixed[column - first] == 0)
      use((column - first) >> a.level.shift, slot);
  }
}

/// Adds the entries of `m` in 32 rows of the domain, a lane a row: for each aggregate that any of
/// them reaches, lanes sum what is theirs, and those of one aggregate are joined.
template <class T, class Matrix>
__device__ void add_group(const SolveCoarse<T>& a, const Matrix& m, Index first, Index last,
                          Index group, Domain& domain) {
  const int lane = static_cast<int>(threadIdx.x) % 32;
  const Index place = 32 * group + lane;
  const Index row = first + place;
  const bool free = row < last && domain.fixed[place] == 0;
  unsigned reached = 0;
  if (free)
    visit_row(a, m, row, first, last, domain,
              [&](Index aggregate, Offset) { reached |= 1u << aggregate; });
  const int width = min(32, 1 << a.level.shift);
  for (unsigned left = __reduce_or_sync(cuda::whole_warp, reached); left != 0; left &= left - 1) {
    const Index target = __ffs(static_cast<int>(left)) - 1;
    double sum[9] = {};
    if (free)
      visit_row(a, m, row, first, last, domain, [&](Index aggregate, Offset slot) {
        if (aggregate != target) return;
        for (int k = 0; k < 9; ++k)
          sum[k] += static_cast<double>(component(m, slot, row % m.slice, k));
      });
    for (int k = 0; k < 9; ++k) {
      const double all = cuda::sum_lanes(sum[k], width);
      if (lane % width == 0 && row < last)
        domain.matrix[3 * (place >> a.level.shift) + k / 3][3 * target + k % 3] += all;
    }
  }
}

/// Adds the entries of `m` in the domain's rows [first, last) whose columns are among them. Groups
/// of 32 rows that share an aggregate take turns, in row order.
template <class T, class Matrix>
__device__ void add_entries(const SolveCoarse<T>& a, const Matrix& m, Index first, Index last,
                            Domain& domain) {
  if (m.row_count == 0) return;
  constexpr int warps = coarse_threads / 32;
  const int warp = static_cast<int>(threadIdx.x) / 32;
  const int turns = max(1, (1 << a.level.shift) / 32);
  for (int turn = 0; turn < turns; ++turn) {
    for (Index group = warp * turns + turn; 32 * group < last - first; group += warps * turns)
      add_group(a, m, first, last, group, domain);
    __syncthreads();
  }
}

/// Inverts a symmetric positive definite matrix in place (Gauss-Jordan, which needs no pivots
/// there). Row and column of the pivot go round by shared memory, two sets by turns.
__device__ void invert(Domain& domain, int aggregates) {
  const int ti = static_cast<int>(threadIdx.x) / side;
  const int tj = static_cast<int>(threadIdx.x) % side;
  double m[3][3];
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) m[i][j] = domain.matrix[3 * ti + i][3 * tj + j];
  for (int block = 0; block < aggregates; ++block)
#pragma unroll
    for (int c = 0; c < 3; ++c) {
      double* row = domain.pivot_row[(block + c) % 2];
      double* column = domain.pivot_column[(block + c) % 2];
      for (int k = 0; k < 3; ++k) {
        if (ti == block) row[3 * tj + k] = m[c][k];
        if (tj == block) column[3 * ti + k] = m[k][c];
      }
      __syncthreads();
      const double scale = 1 / row[3 * block + c];
      for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) {
          const bool in_row = ti == block && i == c;
          const bool in_column = tj == block && j == c;
          const double scaled = row[3 * tj + j] * scale;
          if (in_row)
            m[i][j] = in_column ? scale : scaled;
          else if (in_column)
            m[i][j] = -column[3 * ti + i] * scale;
          else
            m[i][j] -= column[3 * ti + i] * scaled;
        }
    }
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) domain.matrix[3 * ti + i][3 * tj + j] = m[i][j];
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
  if (thread < size && domain.matrix[thread][thread] == 0) domain.matrix[thread][thread] = 1;
  __syncthreads();
  invert(domain, static_cast<int>(a.level.aggregates));
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
