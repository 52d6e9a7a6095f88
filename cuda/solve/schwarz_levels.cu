#include "weft/kernels/solve/schwarz_levels.hpp"

#include "cuda/exec/launch.cuh"
#include "weft/state/link_blocks.hpp"

namespace weft {
namespace {

constexpr int side = static_cast<int>(schwarz_aggregates_max);
constexpr int pair_count = side * (side + 1) / 2;
constexpr int fine_rows_max = 64;
static_assert(FineLevel<float>::of(Index{1} << 20).domain_rows() == fine_rows_max);
/// A thread per component of an aggregate's blocks, or per pair of aggregates: whole warps.
constexpr int threads = 160;
static_assert(9 * side <= threads && pair_count <= threads && threads % 32 == 0);

/// Number of a pair of aggregates i >= j.
__device__ constexpr int pair_of(int i, int j) {
  return i * (i + 1) / 2 + j;
}

/// Blocks between each aggregate and the pivot's, (aggregate, pivot), where that of the pivot
/// stands inverted; two sets by turns.
struct PivotColumns {
  Mat3<double> block[2][side];
};

/// Inverts a symmetric positive definite matrix of blocks in place, of which a thread holds block
/// (i, j), i >= j, if `holds`. By sweeps (Goodnight 1979), a row of blocks at a time: each
/// exchanges three unknowns with their right-hand sides, and the matrix stays symmetric. Needs no
/// pivots. The whole block calls it.
__device__ Mat3<double> inverse(PivotColumns& columns, int aggregates, bool holds, int i, int j,
                                Mat3<double> m) {
  for (int p = 0; p < aggregates; ++p) {
    Mat3<double>* column = columns.block[p % 2];
    if (holds && i == p && j == p) {
      for (int r = 0; r < 3; ++r)
        for (int c = r + 1; c < 3; ++c) m(r, c) = m(c, r);
      m = inverse_symmetric(m);
      column[p] = m;
      m = -1.0 * m;
    } else if (holds && j == p) {
      column[i] = m;
    } else if (holds && i == p) {
      column[j] = transpose(m);
    }
    // Two sets by turns: whoever writes one again has passed the barrier in between.
    __syncthreads();
    if (!holds || (i == p && j == p)) continue;
    const Mat3<double> scaled = column[i == p ? j : i] * column[p];
    if (i == p)
      m = transpose(scaled);
    else if (j == p)
      m = scaled;
    else
      m -= scaled * transpose(column[j]);
  }
  return -1.0 * m;
}

/// Aggregates without rows that move get the identity.
__device__ void fill_empty(Mat3<double>& diagonal) {
  for (int k = 0; k < 3; ++k)
    if (diagonal(k, k) == 0) diagonal(k, k) = 1;
}

/// The pair of aggregates that a thread holds the block of.
struct Pair {
  int i, j;
  __device__ static Pair of(int thread) {
    auto i = static_cast<int>((sqrtf(8.0f * static_cast<float>(thread) + 1.0f) - 1.0f) / 2.0f);
    while (pair_of(i + 1, 0) <= thread) ++i;
    while (pair_of(i, 0) > thread) --i;
    return {i, thread - pair_of(i, 0)};
  }
};

/// Where an entry is added: a pair of aggregates of the domain, or what lies left of it.
constexpr int left_place = pair_count;  ///< of aggregate 0 and of the first domain to the left
constexpr int place_count = left_place + side * side;
constexpr short nowhere = LinkBlocks<float>::nowhere;

constexpr int slots_at_once = 8;
constexpr int links_at_once = threads / side;  ///< of an aggregate

template <class T>
struct EntryPlaces {
  short place[slots_at_once][fine_rows_max];
};

template <class T>
struct LinkPlaces {
  int count[threads];
  short place[threads][4];
  T weight[threads][4];
  T block[threads][6];
};

template <class T>
struct Domain {
  double sum[place_count][9];
  union {
    EntryPlaces<T> entries;
    LinkPlaces<T> links;
    PivotColumns columns;
    double row_total[side][9];
  };
  Index end_offset[fine_rows_max + 1];
  unsigned char fixed[fine_rows_max];
};

/// Adds up the blocks of a fine domain. Each thread adds one component of the blocks in an
/// aggregate's rows, entry by entry in stored order.
template <class T>
class BlockSums {
 public:
  /// @param first of the domain's rows, of which there are `rows`
  __device__ BlockSums(const SolveSchwarzLevels<T>& a, Domain<T>& domain, Index first, Index rows)
      : a_(a),
        domain_(domain),
        component_(static_cast<int>(threadIdx.x) % 9),
        aggregate_(static_cast<int>(threadIdx.x) / 9),
        first_(first),
        rows_(rows),
        begin_(a.wide.aggregates > 0 ? first / a.wide.domain_rows() * a.wide.domain_rows()
                                     : first) {
    const Index share = Index{1} << a.fine.shift;
    own_begin_ = min(rows, aggregate_ * share);
    own_end_ = aggregate_ < a.fine.aggregates ? min(rows, own_begin_ + share) : own_begin_;
  }

  __device__ void add_all() {
    for (Index row = own_begin_; row < own_end_; ++row)
      if (domain_.fixed[row] == 0)
        add(pair_of(aggregate_, aggregate_),
            static_cast<double>(a_.mesh.diagonal.data()[first_ + row].e[component_]));
    add_entries(a_.mesh, true);
    if (a_.far.row_count > 0) add_entries(a_.far, component_ % 4 == 0);
    if (!a_.contact.count.empty()) add_links();
  }

 private:
  __device__ void add(int place, double value) { domain_.sum[place][component_] += value; }

  /// Where the entry of a row, counted from the first, and a column goes.
  __device__ short place_of(Index row, Index column) const {
    column -= a_.row_begin;
    if (column < begin_ || column >= first_ + rows_) return nowhere;
    if (domain_.fixed[row] != 0 || a_.fixed.data()[a_.row_begin + column] != 0) return nowhere;
    const auto aggregate = static_cast<int>(row >> a_.fine.shift);
    if (column < first_)
      return static_cast<short>(left_place + side * aggregate +
                                ((column - begin_) >> a_.wide.shift));
    const auto other = static_cast<int>((column - first_) >> a_.fine.shift);
    return static_cast<short>(other <= aggregate ? pair_of(aggregate, other) : nowhere);
  }

  __device__ T value(const BlockEll<T>& m, Offset slot, Index lane) const {
    return __ldg(m.value.data() + (slot * 9 + component_) * m.slice + lane);
  }
  __device__ T value(const ScalarEll<T>& m, Offset slot, Index lane) const {
    return __ldg(m.value.data() + slot * m.slice + lane);
  }
  /// The whole block calls it. Where entries go is found once for all components, some slots of
  /// each row at a time.
  template <class Matrix>
  __device__ void add_entries(const Matrix& m, bool adds) {
    const Offset* offset = m.slice_offset.data();
    Offset longest = 0;
    // Rows may be anywhere in their windows of the order.
    constexpr Index window = RowOrder::window;
    const Index begin_place = first_ / window * window;
    const Index end_place = min(m.row_count, (first_ + rows_ + window - 1) / window * window);
    for (Index slice = begin_place / m.slice; slice <= (end_place - 1) / m.slice; ++slice)
      longest = max(longest, offset[slice + 1] - offset[slice]);
    for (Offset begin = 0; begin < longest; begin += slots_at_once) {
#pragma unroll
      for (int turn = 0; turn < (slots_at_once * fine_rows_max + threads - 1) / threads; ++turn) {
        const int n = turn * threads + static_cast<int>(threadIdx.x);
        if (n >= slots_at_once * fine_rows_max) continue;
        const Index row = n % fine_rows_max;
        if (row >= rows_) continue;
        const Index place = m.order.place(first_ + row);
        const Index slice = place / m.slice, lane = place % m.slice;
        const Offset slot = offset[slice] + begin + n / fine_rows_max;
        domain_.entries.place[n / fine_rows_max][row] =
            slot < offset[slice + 1] ? place_of(row, __ldg(m.column.data() + slot * m.slice + lane))
                                     : nowhere;
      }
      __syncthreads();
      for (Index row = own_begin_; adds && row < own_end_; ++row) {
        const Index place = m.order.place(first_ + row);
        const Index lane = place % m.slice;
        const Offset slot = offset[place / m.slice] + begin;
        T entry[slots_at_once];
#pragma unroll
        for (int n = 0; n < slots_at_once; ++n)
          if (domain_.entries.place[n][row] != nowhere) entry[n] = value(m, slot + n, lane);
#pragma unroll
        for (int n = 0; n < slots_at_once; ++n)
          if (const short place = domain_.entries.place[n][row]; place != nowhere)
            add(place, static_cast<double>(entry[n]));
      }
      __syncthreads();
    }
  }

  /// What the ends of links add, a share of each aggregate's at a time: ends stand row by row. The
  /// whole block calls it.
  __device__ void add_links() {
    LinkPlaces<T>& staged = domain_.links;
    for (Index row = static_cast<Index>(threadIdx.x); row <= rows_; row += threads)
      domain_.end_offset[row] = a_.contact.end_offset.data()[first_ + row];
    __syncthreads();
    const Index* offset = domain_.end_offset;
    const Index share = Index{1} << a_.fine.shift;
    Index most = 0;
    for (Index row = 0; row < rows_; row += share)
      most = max(most, offset[min(rows_, row + share)] - offset[row]);
    const int k = ContactOperatorEntry<T>::place(component_);
    for (Index done = 0; done < most; done += links_at_once) {
      const auto n = static_cast<int>(threadIdx.x);
      const Index row = n / links_at_once * share;
      if (row < rows_) stage(done + n % links_at_once, row, n);
      __syncthreads();
      const Index left = offset[own_end_] - offset[own_begin_] - done;
      for (int i = 0; i < min(left, Index{links_at_once}); ++i) {
        const int place = aggregate_ * links_at_once + i;
        const T entry = staged.block[place][k];
        for (int j = 0; j < staged.count[place]; ++j)
          add(staged.place[place][j], static_cast<double>(staged.weight[place][j] * entry));
      }
      __syncthreads();
    }
  }
  /// What an end of a link adds, to number n of shared memory.
  /// @param e number of those that an aggregate's rows have, from `row` on
  __device__ void stage(Index e, Index row, int n) {
    const Index* offset = domain_.end_offset;
    const Index last = min(rows_, row + (Index{1} << a_.fine.shift));
    e += offset[row];
    if (e >= offset[last]) return;
    while (offset[row + 1] <= e) ++row;
    LinkPlaces<T>& staged = domain_.links;
    const ContactOperatorEntry<T> link =
        a_.contact.link.data()[__ldg(&a_.contact.end.data()[e].link)];
    int place[4];
#pragma unroll
    for (int j = 0; j < 4; ++j) place[j] = place_of(row, link.v[j]);
    const auto aggregate = static_cast<int>(row >> a_.fine.shift);
    const auto blocks =
        LinkBlocks<T>::of(link, a_.row_begin + first_ + row, place, pair_of(aggregate, aggregate));
    int count = 0;
#pragma unroll
    for (int j = 0; j < 4; ++j) {
      if (blocks.weight[j] == T(0)) continue;
      staged.place[n][count] = static_cast<short>(place[j]);
      staged.weight[n][count++] = blocks.weight[j];
    }
    staged.count[n] = count;
    for (int c = 0; c < 6; ++c) staged.block[n][c] = link.block[c];
  }

  const SolveSchwarzLevels<T>& a_;
  Domain<T>& domain_;
  int component_, aggregate_;
  Index first_, rows_;
  Index begin_;                ///< of the wide domain around this one, if there is one
  Index own_begin_, own_end_;  ///< of the aggregate's rows, counted from the first
};

/// Leaves to the wide level what it takes over from a fine domain. The whole block calls it, with
/// sums complete.
template <class T>
__device__ void store_wide_sums(const SolveSchwarzLevels<T>& a, Domain<T>& domain, int own) {
  const int component = static_cast<int>(threadIdx.x) % 9;
  const int n = static_cast<int>(threadIdx.x) / 9;
  double* to = a.wide_sum.data() + std::size_t{blockIdx.x} * FineLevel<T>::wide_sums;
  if (n < side) {
    // Of the pairs of aggregates those below the diagonal count twice, as they are and transposed.
    const int transposed = component % 3 * 3 + component / 3;
    double total = domain.sum[pair_of(n, n)][component];
    for (int j = 0; j < n; ++j) {
      const double* sum = domain.sum[pair_of(n, j)];
      total += sum[component] + sum[transposed];
    }
    domain.row_total[n][component] = total;
    if (n < own) {
      double left = 0;
      for (int i = 0; i < side; ++i) left += domain.sum[left_place + side * i + n][component];
      to[9 * n + component] = left;
    }
  }
  __syncthreads();
  if (threadIdx.x >= 9) return;
  double total = 0;
  for (int i = 0; i < side; ++i) total += domain.row_total[i][component];
  to[9 * own + component] = total;
}

/// One block a fine domain.
template <class T>
__global__ void __launch_bounds__(threads, 5)
    solve_fine_level(const __grid_constant__ SolveSchwarzLevels<T> a) {
  __shared__ Domain<T> domain;
  const auto thread = static_cast<int>(threadIdx.x);
  const Index first = static_cast<Index>(blockIdx.x) * a.fine.domain_rows();
  const Index rows = min(a.fine.domain_rows(), a.mesh.row_count - first);
  for (Index row = thread; row < rows; row += threads)
    domain.fixed[row] = a.fixed.data()[a.row_begin + first + row];
  for (int n = thread; n < place_count * 9; n += threads) domain.sum[n / 9][n % 9] = 0;
  __syncthreads();
  BlockSums<T>(a, domain, first, rows).add_all();
  __syncthreads();
  if (a.wide.aggregates > 0) {
    store_wide_sums(a, domain, static_cast<int>(blockIdx.x) % static_cast<int>(a.wide.aggregates));
    __syncthreads();
  }
  const auto aggregates = static_cast<int>(a.fine.aggregates);
  const auto [i, j] = Pair::of(thread);
  const bool holds = i < aggregates;
  Mat3<double> m{};
  for (int k = 0; holds && k < 9; ++k) m.e[k] = domain.sum[thread][k];
  if (holds && i == j) fill_empty(m);
  m = inverse(domain.columns, aggregates, holds, i, j, m);
  if (holds)
    SymmetricBlocks::store(
        a.fine.inverse.data() + std::size_t{blockIdx.x} * a.fine.domain_numbers(),
        a.fine.aggregates, i, j, m);
}

/// One block a wide domain.
template <class T>
__global__ void __launch_bounds__(threads)
    solve_wide_level(const __grid_constant__ SolveSchwarzLevels<T> a) {
  __shared__ PivotColumns columns;
  const auto aggregates = static_cast<int>(a.wide.aggregates);
  const Index first = static_cast<Index>(blockIdx.x) * a.wide.aggregates;
  const auto [i, j] = Pair::of(static_cast<int>(threadIdx.x));
  const bool holds = i < aggregates;
  Mat3<double> m{};
  if (holds && first + i < a.fine.domains(a.mesh.row_count)) {
    const double* sum = a.wide_sum.data() + std::size_t(first + i) * FineLevel<T>::wide_sums;
    for (int k = 0; k < 9; ++k) m.e[k] = sum[9 * j + k];
  }
  if (i == j) fill_empty(m);
  m = inverse(columns, aggregates, holds, i, j, m);
  if (!holds) return;
  // Conjugate gradients need a symmetric preconditioner, to the bit.
  const Index size = a.wide.size();
  T* out = a.wide.inverse.data() + std::size_t{blockIdx.x} * a.wide.domain_numbers();
  for (int r = 0; r < 3; ++r)
    for (int k = 0; k < (i == j ? r + 1 : 3); ++k) {
      const Index row = 3 * i + r, column = 3 * j + k;
      out[row * size + column] = out[column * size + row] = static_cast<T>(m(r, k));
    }
}

}  // namespace

template <class T>
void run(OnCuda, Queue& queue, const SolveSchwarzLevels<T>& args) {
  const Index rows = args.mesh.row_count;
  if (rows <= 0) return;
  const auto& cuda_queue = static_cast<const CudaQueue&>(queue);
  cuda_queue.make_current();
  solve_fine_level<T>
      <<<static_cast<unsigned>(args.fine.domains(rows)), threads, 0, cuda_queue.stream()>>>(args);
  cuda::check(cudaGetLastError(), "kernel launch", cuda_queue.rank());
  if (args.wide.aggregates == 0) return;
  solve_wide_level<T>
      <<<static_cast<unsigned>(args.wide.domains(rows)), threads, 0, cuda_queue.stream()>>>(args);
  cuda::check(cudaGetLastError(), "kernel launch", cuda_queue.rank());
}

template void run(OnCuda, Queue&, const SolveSchwarzLevels<float>&);
template void run(OnCuda, Queue&, const SolveSchwarzLevels<double>&);

}  // namespace weft
