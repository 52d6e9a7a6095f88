#include "weft/kernels/solve/galerkin_product.hpp"

#include "cuda/exec/launch.cuh"
#include "cuda/solve/coarse_matrix.cuh"

namespace weft {
namespace {

using namespace cuda;

constexpr int targets_none = 0x7fffffff;
constexpr int block_size = coarse_dofs * coarse_dofs;

struct Projection {
  PackedMatrix matrix;                      ///< of the partial sum's units
  double block[coarse_domain][block_size];  ///< what each warp has for a target
  int next[coarse_domain];                  ///< lowest target that each warp has left
};

/// Adds a block, times the modes of its column, to `sum`: [component][mode][component].
/// @param value component (0, 0)   @param stride to the next component
template <class T>
__device__ void add_entry(const T* value, Index stride, const Modes<T>& column, double sum[27]) {
  const double modes[coarse_basis_count] = {1, static_cast<double>(column.u),
                                            static_cast<double>(column.v)};
#pragma unroll
  for (int k = 0; k < 9; ++k) {
    const auto x = static_cast<double>(value[k * stride]);
#pragma unroll
    for (int q = 0; q < coarse_basis_count; ++q) sum[9 * (k / 3) + 3 * q + k % 3] += modes[q] * x;
  }
}

/// The same of one entry.
template <class T>
__device__ void add_entry(const BlockEll<T>& m, Offset slot, Index lane, const Modes<T>& column,
                          double sum[27]) {
  add_entry(m.value.data() + slot * 9 * m.slice + lane, m.slice, column, sum);
}
template <class T>
__device__ void add_entry(const ScalarEll<T>& m, Offset slot, Index lane, const Modes<T>& column,
                          double sum[27]) {
  const double modes[coarse_basis_count] = {1, static_cast<double>(column.u),
                                            static_cast<double>(column.v)};
  const auto x = static_cast<double>(m.value.data()[slot * m.slice + lane]);
#pragma unroll
  for (int q = 0; q < coarse_basis_count; ++q)
#pragma unroll
    for (int c = 0; c < 3; ++c) sum[9 * c + 3 * q + c] += modes[q] * x;
}

/// The same of a corner of a link.
template <class T>
__device__ void add_entry(const ContactOperatorEntry<T>& link, T weight, const Modes<T>& column,
                          double sum[27]) {
  const double modes[coarse_basis_count] = {1, static_cast<double>(column.u),
                                            static_cast<double>(column.v)};
#pragma unroll
  for (int k = 0; k < 9; ++k) {
    const auto x = static_cast<double>(weight * link.component(k));
#pragma unroll
    for (int q = 0; q < coarse_basis_count; ++q) sum[9 * (k / 3) + 3 * q + k % 3] += modes[q] * x;
  }
}

/// What one block does: the rows of one reduction block, a warp a unit. An entry belongs to a
/// target: a unit of the partial sum, or an aggregate of a higher level. Targets take turns, in
/// ascending order; for each, lanes sum over their rows and are joined.
template <class T>
class Projector {
 public:
  __device__ Projector(const SolveGalerkinProduct<T>& args, Projection& shared)
      : a_(args), levels_(args.levels), s_(shared) {
    const auto own = static_cast<Index>(blockIdx.x);
    partial_ = a_.row_begin / levels_.partial_rows + own;
    first_ = partial_ * levels_.partial_rows;
    last_ = min(first_ + levels_.partial_rows, a_.row_begin + a_.mesh.row_count);
    strip_ = a_.strip.data() + Offset{own} * levels_.upper_count * coarse_dofs * coarse_domain_dofs;
    unit_begin_ = first_ + warp() * levels_.unit_rows;
    unit_end_ = warp() < levels_.units() ? min(last_, unit_begin_ + levels_.unit_rows) : 0;
  }

  __device__ void make() {
    for (int n = static_cast<int>(threadIdx.x);
         n < levels_.upper_count * coarse_dofs * coarse_domain_dofs; n += coarse_threads)
      strip_[n] = 0;
    clear(s_.matrix);
    int target = lowest_target();
    while (target < unit_targets) target = add_unit(target);
    __syncthreads();
    const auto units =
        static_cast<int>((last_ - first_ + levels_.unit_rows - 1) / levels_.unit_rows);
    restrict_matrix(s_.matrix, levels_.unit.data() + first_ / levels_.unit_rows, units,
                    strip_ + partial_ % coarse_domain * coarse_dofs, coarse_domain_dofs);
    add_others(target);
    if (!levels_.has_fine()) return;
    const auto size = static_cast<int>(levels_.fine_size());
    invert(s_.matrix, size);
    store(s_.matrix, size, levels_.fine_inverse.data() + Offset{blockIdx.x} * size * size, size);
  }

 private:
  /// Targets below this are units left of the row's own, or that one.
  static constexpr int unit_targets = static_cast<int>(coarse_domain);

  __device__ static int warp() { return static_cast<int>(threadIdx.x) / 32; }
  __device__ static int lane() { return static_cast<int>(threadIdx.x) % 32; }

  /// Number of the target that a column belongs to, for the warp's rows.
  __device__ int target_of(Index column) const {
    const Index other = column / levels_.partial_rows;
    if (other == partial_) {
      const auto unit = static_cast<int>((column - first_) / levels_.unit_rows);
      return unit <= warp() ? unit : targets_none;  // the lower triangle is enough
    }
    const int level = coarse_meeting_level(partial_, other);
    Index aggregate = other;
    for (int k = 0; k < level; ++k) aggregate /= coarse_domain;
    return unit_targets + level * static_cast<int>(coarse_domain) +
           static_cast<int>(aggregate % coarse_domain);
  }

  /// Calls use(column, slot, lane of the slice) for each entry of a row with a free column.
  template <class Matrix, class Use>
  __device__ void visit(const Matrix& m, Index vertex, const Use& use) const {
    if (m.row_count == 0) return;
    const Index row = vertex - a_.row_begin;
    const Index place = row % m.slice;
    const Offset end = m.slice_offset.data()[row / m.slice + 1];
    for (Offset slot = m.slice_offset.data()[row / m.slice]; slot < end; ++slot) {
      const Index column = m.column.data()[slot * m.slice + place];
      if (a_.fixed.data()[column] == 0) use(column, slot, place);
    }
  }

  /// The same for links: calls use(column, weight, link).
  template <class Use>
  __device__ void visit_contacts(Index vertex, const Use& use) const {
    visit_contact_entries(a_.contact.links, vertex - a_.row_begin,
                          [&](Index column, T weight, const ContactOperatorEntry<T>& link) {
                            if (a_.fixed.data()[column] == 0) use(column, weight, link);
                          });
  }

  /// Lowest target that the warp's rows have.
  __device__ int lowest_target() const {
    int lowest = targets_none;
    const auto look = [&](Index column, auto&&...) { lowest = min(lowest, target_of(column)); };
    for (Index vertex = unit_begin_ + lane(); vertex < unit_end_; vertex += 32) {
      if (a_.fixed.data()[vertex] != 0) continue;
      look(vertex);
      visit(a_.mesh, vertex, look);
      visit(a_.far, vertex, look);
      visit_contacts(vertex, look);
    }
    return __reduce_min_sync(whole_warp, lowest);
  }

  /// The warp's sums for a target, 32 rows at a time: add(i, j, sum) on lane 0 for each of the
  /// block's components.
  /// @return the lowest target above this one that the warp's rows have
  template <class RowModes, class ColumnModes, class Add>
  __device__ int sum_target(int target, const RowModes& row_modes, const ColumnModes& column_modes,
                            const Add& add) const {
    int next = targets_none;
    const auto is_here = [&](Index column) {
      const int of_column = target_of(column);
      if (of_column > target) next = min(next, of_column);
      return of_column == target;
    };
#pragma unroll 1
    for (Index base = unit_begin_; base < unit_end_; base += 32) {
      const Index vertex = base + lane();
      double sum[27] = {};
      double modes[coarse_basis_count] = {};
      if (vertex < unit_end_ && a_.fixed.data()[vertex] == 0) {
        const Modes<T> m = row_modes(vertex);
        modes[0] = 1;
        modes[1] = static_cast<double>(m.u);
        modes[2] = static_cast<double>(m.v);
        const auto take = [&](const auto& matrix) {
          visit(matrix, vertex, [&](Index column, Offset slot, Index place) {
            if (is_here(column)) add_entry(matrix, slot, place, column_modes(column), sum);
          });
        };
        if (is_here(vertex))
          add_entry(a_.mesh.diagonal.data()[vertex - a_.row_begin].e, 1, column_modes(vertex), sum);
        take(a_.mesh);
        take(a_.far);
        visit_contacts(vertex, [&](Index column, T weight, const ContactOperatorEntry<T>& link) {
          if (is_here(column)) add_entry(link, weight, column_modes(column), sum);
        });
      }
#pragma unroll
      for (int p = 0; p < coarse_basis_count; ++p)
#pragma unroll
        for (int k = 0; k < 27; ++k) {
          const double all = sum_lanes(modes[p] * sum[k]);
          if (lane() == 0) add(3 * p + k / 9, k % 9, all);
        }
    }
    return __reduce_min_sync(whole_warp, next);
  }

  /// @return as sum_target()
  __device__ int add_unit(int unit) {
    const auto modes = [&](Index vertex) {
      return coarse_basis_of<T>(levels_.point.data()[vertex]);
    };
    const int next = sum_target(unit, modes, modes, [&](int i, int j, double sum) {
      const int row = coarse_dofs * warp() + i;
      const int column = coarse_dofs * unit + j;
      if (row >= column) s_.matrix.at(row, column) += sum;
    });
    __syncwarp();
    return next;
  }

  /// The entries that leave the partial sum, target by target, over all warps.
  /// @param mine the warp's lowest target
  __device__ void add_others(int mine) {
    while (true) {
      if (lane() == 0) s_.next[warp()] = mine;
      __syncthreads();
      int target = targets_none;
      for (int w = 0; w < unit_targets; ++w) target = min(target, s_.next[w]);
      if (target == targets_none) break;
      if (mine == target) mine = add_block(target);
      __syncthreads();
      store_block(target);
      __syncthreads();
    }
  }

  /// @return as sum_target()
  __device__ int add_block(int target) {
    const int level = (target - unit_targets) / static_cast<int>(coarse_domain);
    double* block = s_.block[warp()];
    for (int n = lane(); n < block_size; n += 32) block[n] = 0;
    __syncwarp();
    return sum_target(
        target, [&](Index vertex) { return coarse_basis_at(levels_, vertex, 0); },
        [&](Index vertex) { return coarse_basis_at(levels_, vertex, level); },
        [&](int i, int j, double sum) { block[coarse_dofs * i + j] += sum; });
  }

  /// The strip's block of a target: what the warps that have it came to, in order.
  __device__ void store_block(int target) {
    const auto n = static_cast<int>(threadIdx.x);
    if (n >= block_size) return;
    double all = 0;
    for (int w = 0; w < unit_targets; ++w)
      if (s_.next[w] == target) all += s_.block[w][n];
    const int place = target - unit_targets;
    double* strip = strip_ +
                    place / static_cast<int>(coarse_domain) * coarse_dofs * coarse_domain_dofs +
                    place % static_cast<int>(coarse_domain) * coarse_dofs;
    strip[n / coarse_dofs * coarse_domain_dofs + n % coarse_dofs] = all;
  }

  const SolveGalerkinProduct<T>& a_;
  const CoarseBasisLevels<T>& levels_;
  Projection& s_;
  Index partial_, first_, last_;
  Index unit_begin_, unit_end_;  ///< the warp's rows
  double* strip_;
};

/// One block a partial sum.
template <class T>
__global__ void __launch_bounds__(coarse_threads)
    solve_galerkin_product(const __grid_constant__ SolveGalerkinProduct<T> a) {
  extern __shared__ double memory[];
  Projector<T>(a, *reinterpret_cast<Projection*>(memory)).make();
}

}  // namespace

template <class T>
void run(OnCuda, Queue& queue, const SolveGalerkinProduct<T>& args) {
  const Index rows = args.mesh.row_count;
  if (rows <= 0) return;
  const auto& cuda_queue = static_cast<const CudaQueue&>(queue);
  cuda_queue.make_current();
  const auto bytes = static_cast<int>(sizeof(Projection));
  cuda::check(cudaFuncSetAttribute(solve_galerkin_product<T>,
                                   cudaFuncAttributeMaxDynamicSharedMemorySize, bytes),
              "cudaFuncSetAttribute", cuda_queue.rank());
  const Index step = args.levels.partial_rows;
  const auto blocks = static_cast<unsigned>((rows + step - 1) / step);
  solve_galerkin_product<<<blocks, coarse_threads, bytes, cuda_queue.stream()>>>(args);
  cuda::check(cudaGetLastError(), "kernel launch", cuda_queue.rank());
}

template void run(OnCuda, Queue&, const SolveGalerkinProduct<float>&);
template void run(OnCuda, Queue&, const SolveGalerkinProduct<double>&);

}  // namespace weft
