#include "weft/kernels/solve/schwarz_level.hpp"

#include <algorithm>

#include "cuda/exec/launch.cuh"

namespace weft {
namespace {

constexpr int side = static_cast<int>(schwarz_aggregates_max);
constexpr int size_max = 3 * side;
constexpr int pair_count = side * (side + 1) / 2;
constexpr Index domain_rows_max = schwarz_aggregates_max << schwarz_shift(schwarz_level_count - 1);

/// Number of a pair of aggregates i >= j.
__device__ int pair_of(int i, int j) {
  return i * (i + 1) / 2 + j;
}

/// @tparam parts that the rows of an aggregate are summed in
template <int parts>
struct Domain {
  double sum[parts][pair_count][9];  ///< component 3 row + column of each pair's block
  double pivot_row[2][size_max];
  double pivot_column[2][size_max];
  double pivot_inverse[2];
  unsigned char fixed[domain_rows_max];
};

/// Sums one component of the blocks of a part of an aggregate's rows, entry by entry in stored
/// order: neighbouring threads have the other components of the same entries.
template <class T, int parts>
class BlockSums {
 public:
  /// @param first of the domain's rows, of which there are `rows`
  /// @param thread of the domain; the first 9 `parts` of each aggregate take part
  __device__ BlockSums(const SolveSchwarzLevel<T>& a, Domain<parts>& domain, Index first,
                       Index rows, int thread)
      : a_(a),
        domain_(domain),
        component_(thread % 9),
        link_place_(ContactOperatorEntry<T>::place(component_)),
        part_(thread / 9 % parts),
        aggregate_(thread / 9 / parts),
        first_(first),
        rows_(rows) {
    const Index share = (Index{1} << a.level.shift) / parts;
    begin_ = min(rows, (static_cast<Index>(aggregate_) << a.level.shift) + part_ * share);
    end_ = aggregate_ < a.level.aggregates ? min(rows, begin_ + share) : begin_;
  }

  __device__ void add_all() {
    for_rows([&](Index row) {
      add(row - first_, static_cast<double>(a_.mesh.diagonal.data()[row].e[component_]));
    });
    add_entries(a_.mesh);
    if (component_ % 4 == 0 && a_.far.row_count > 0) add_entries(a_.far);
    if (a_.contact.count.empty()) return;
    for_rows([&](Index row) { add_links(row); });
  }

 private:
  template <class Use>
  __device__ void for_rows(const Use& use) const {
    for (Index place = begin_; place < end_; ++place)
      if (domain_.fixed[place] == 0) use(first_ + place);
  }

  /// @param column counted from the domain's first row: there, or outside
  __device__ void add(Index column, double value) {
    if (column < 0 || column >= rows_ || domain_.fixed[column] != 0) return;
    const auto other = static_cast<int>(column >> a_.level.shift);
    if (other <= aggregate_) domain_.sum[part_][pair_of(aggregate_, other)][component_] += value;
  }

  __device__ T value(const BlockEll<T>& m, Offset slot, Index lane) const {
    return __ldg(m.value.data() + (slot * 9 + component_) * m.slice + lane);
  }
  __device__ T value(const ScalarEll<T>& m, Offset slot, Index lane) const {
    return __ldg(m.value.data() + slot * m.slice + lane);
  }
  /// Some entries at a time are asked for before any is added.
  template <class Matrix>
  __device__ void add_entries(const Matrix& m) {
    constexpr int at_once = 5;
    for_rows([&](Index row) {
      const Index lane = row % m.slice;
      const Offset* offset = m.slice_offset.data() + row / m.slice;
      const Offset end = __ldg(offset + 1);
      for (Offset slot = __ldg(offset); slot < end; slot += at_once) {
        Index column[at_once];
        T entry[at_once];
#pragma unroll
        for (int n = 0; n < at_once; ++n) {
          if (slot + n >= end) continue;
          column[n] = __ldg(m.column.data() + (slot + n) * m.slice + lane);
          entry[n] = value(m, slot + n, lane);
        }
#pragma unroll
        for (int n = 0; n < at_once; ++n)
          if (slot + n < end) add(column[n] - a_.row_begin - first_, static_cast<double>(entry[n]));
      }
    });
  }

  /// As visit_contact_entries(), with all of a link asked for before any is added.
  __device__ void add_links(Index row) {
    const ContactOperator<T>& links = a_.contact;
    const Index* offset = links.end_offset.data() + row;
    const Index last = __ldg(offset + 1);
    for (Index e = __ldg(offset); e < last; ++e) {
      const Index number = __ldg(&links.end.data()[e].link);
      const T end_weight = __ldg(&links.end.data()[e].weight);
      const ContactOperatorEntry<T>& link = links.link.data()[number];
      const T entry = __ldg(link.block + link_place_);
      Index corner[4];
      T weight[4];
#pragma unroll
      for (int n = 0; n < 4; ++n) {
        corner[n] = __ldg(link.v + n);
        weight[n] = __ldg(link.w + n);
      }
#pragma unroll
      for (int n = 0; n < 4; ++n)
        add(corner[n] - a_.row_begin - first_, static_cast<double>(end_weight * weight[n] * entry));
    }
  }

  const SolveSchwarzLevel<T>& a_;
  Domain<parts>& domain_;
  int component_, link_place_, part_, aggregate_;
  Index first_, rows_, begin_, end_;  ///< begin and end counted from the first
};

/// Inverts a symmetric positive definite matrix in place (Gauss-Jordan, which needs no pivots
/// there), of which a thread holds the block of aggregates (i, j), if `holds`. Row and column of
/// the pivot go round by shared memory, two sets by turns.
template <int parts>
__device__ void invert(Domain<parts>& domain, int aggregates, bool holds, int i, int j,
                       double (&m)[3][3]) {
  for (int block = 0; block < aggregates; ++block)
#pragma unroll
    for (int c = 0; c < 3; ++c) {
      double* row = domain.pivot_row[(block + c) % 2];
      double* column = domain.pivot_column[(block + c) % 2];
      if (holds && i == block && j == block) domain.pivot_inverse[(block + c) % 2] = 1 / m[c][c];
      for (int k = 0; holds && k < 3; ++k) {
        if (i == block) row[3 * j + k] = m[c][k];
        if (j == block) column[3 * i + k] = m[k][c];
      }
      __syncthreads();
      if (!holds) continue;
      const double scale = domain.pivot_inverse[(block + c) % 2];
      for (int r = 0; r < 3; ++r)
        for (int k = 0; k < 3; ++k) {
          const bool in_row = i == block && r == c;
          const bool in_column = j == block && k == c;
          const double scaled = row[3 * j + k] * scale;
          if (in_row)
            m[r][k] = in_column ? scale : scaled;
          else if (in_column)
            m[r][k] = -column[3 * i + r] * scale;
          else
            m[r][k] -= column[3 * i + r] * scaled;
        }
    }
}

/// Component (row, column) of the block of aggregates (i, j), of all parts.
template <int parts>
__device__ double joined(const Domain<parts>& domain, int i, int j, int row, int column) {
  // Above the diagonal stands the transposed block below it.
  const int pair = i >= j ? pair_of(i, j) : pair_of(j, i);
  const int component = i >= j ? 3 * row + column : 3 * column + row;
  const auto& sum = domain.sum;
  static_assert(parts == 1 || parts == 4);
  if constexpr (parts == 1)
    return sum[0][pair][component];
  else
    return (sum[0][pair][component] + sum[1][pair][component]) +
           (sum[2][pair][component] + sum[3][pair][component]);
}

template <int parts>
constexpr int threads_of = std::max(side* side, (9 * side * parts + 31) / 32 * 32);

/// One block a domain.
template <class T, int parts>
__global__ void __launch_bounds__(threads_of<parts>)
    solve_schwarz_level(const __grid_constant__ SolveSchwarzLevel<T> a) {
  __shared__ Domain<parts> domain;
  constexpr int threads = threads_of<parts>;
  const auto thread = static_cast<int>(threadIdx.x);
  const Index first = static_cast<Index>(blockIdx.x) * a.level.domain_rows();
  const Index rows = min(a.level.domain_rows(), a.mesh.row_count - first);
  for (Index row = thread; row < rows; row += threads)
    domain.fixed[row] = a.fixed.data()[a.row_begin + first + row];
  for (int n = thread; n < parts * pair_count * 9; n += threads)
    domain.sum[n / (pair_count * 9)][n / 9 % pair_count][n % 9] = 0;
  __syncthreads();
  BlockSums<T, parts>(a, domain, first, rows, thread).add_all();
  __syncthreads();
  const auto aggregates = static_cast<int>(a.level.aggregates);
  const int i = thread / side;
  const int j = thread % side;
  const bool holds = i < aggregates && j < aggregates;
  double m[3][3] = {};
  for (int r = 0; holds && r < 3; ++r)
    for (int k = 0; k < 3; ++k) {
      m[r][k] = joined(domain, i, j, r, k);
      if (i == j && r == k && m[r][k] == 0) m[r][k] = 1;
    }
  invert(domain, aggregates, holds, i, j, m);
  if (!holds || i < j) return;
  // Conjugate gradients need a symmetric preconditioner, to the bit.
  const int size = static_cast<int>(a.level.size());
  T* out = a.level.inverse.data() + static_cast<std::size_t>(blockIdx.x) * size * size;
  for (int r = 0; r < 3; ++r)
    for (int k = 0; k < 3; ++k) {
      const int row = 3 * i + r;
      const int column = 3 * j + k;
      if (row < column) continue;
      out[row * size + column] = static_cast<T>(m[r][k]);
      out[column * size + row] = static_cast<T>(m[r][k]);
    }
}

}  // namespace

template <class T>
void run(OnCuda, Queue& queue, const SolveSchwarzLevel<T>& args) {
  const Index rows = args.mesh.row_count;
  if (rows <= 0) return;
  const auto& cuda_queue = static_cast<const CudaQueue&>(queue);
  cuda_queue.make_current();
  const Index step = args.level.domain_rows();
  const auto blocks = static_cast<unsigned>((rows + step - 1) / step);
  if (args.level.shift <= schwarz_shift(0))
    solve_schwarz_level<T, 1><<<blocks, threads_of<1>, 0, cuda_queue.stream()>>>(args);
  else
    solve_schwarz_level<T, 4><<<blocks, threads_of<4>, 0, cuda_queue.stream()>>>(args);
  cuda::check(cudaGetLastError(), "kernel launch", cuda_queue.rank());
}

template void run(OnCuda, Queue&, const SolveSchwarzLevel<float>&);
template void run(OnCuda, Queue&, const SolveSchwarzLevel<double>&);

}  // namespace weft
