#include "weft/kernels/solve/schwarz_level.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Core>

#include "host/exec/host_device.hpp"

namespace weft {
namespace {

constexpr int size_max = 3 * static_cast<int>(schwarz_aggregates_max);
using Dense = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, size_max, size_max>;

/// Adds what entry (slot, lane) of a matrix comes to.
template <class T>
void add_block(const BlockEll<T>& m, Offset slot, Index lane, Index row, Index column, Dense& sum) {
  const T* value = m.value.data() + slot * 9 * m.slice + lane;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      sum(row + i, column + j) += static_cast<double>(value[(3 * i + j) * m.slice]);
}
template <class T>
void add_block(const ScalarEll<T>& m, Offset slot, Index lane, Index row, Index column,
               Dense& sum) {
  const auto value = static_cast<double>(m.value.data()[slot * m.slice + lane]);
  for (int i = 0; i < 3; ++i) sum(row + i, column + i) += value;
}

/// Adds the entries of `m` in rows [first, last) whose columns are among the same rows.
template <class T, class Matrix>
void add_entries(const SolveSchwarzLevel<T>& a, const Matrix& m, Index first, Index last,
                 Dense& sum) {
  const auto aggregate = [&](Index row) { return 3 * ((row - first) >> a.level.shift); };
  for (Index row = first; row < last; ++row) {
    if (a.fixed.data()[a.row_begin + row] != 0) continue;
    const auto slice = static_cast<std::size_t>(row / m.slice);
    const Index lane = row % m.slice;
    for (Offset slot = m.slice_offset[slice]; slot < m.slice_offset[slice + 1]; ++slot) {
      const Index vertex = m.column.data()[slot * m.slice + lane];
      const Index column = vertex - a.row_begin;
      if (column < first || column >= last || a.fixed.data()[vertex] != 0) continue;
      add_block(m, slot, lane, aggregate(row), aggregate(column), sum);
    }
  }
}

/// The same of the blocks on the mesh's diagonal.
template <class T>
void add_diagonal(const SolveSchwarzLevel<T>& a, Index first, Index last, Dense& sum) {
  for (Index row = first; row < last; ++row) {
    if (a.fixed.data()[a.row_begin + row] != 0) continue;
    const Mat3<T>& block = a.mesh.diagonal.data()[row];
    const Index place = 3 * ((row - first) >> a.level.shift);
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) sum(place + i, place + j) += static_cast<double>(block(i, j));
  }
}

template <class T>
void invert_domains(const SolveSchwarzLevel<T>& a) {
  const Index rows = a.mesh.row_count;
  const Index step = a.level.domain_rows();
  const Index n = a.level.size();
  T* out = a.level.inverse.data();
  Dense matrix(n, n);
  for (Index first = 0; first < rows; first += step, out += n * n) {
    const Index last = std::min(rows, first + step);
    matrix.setZero();
    add_diagonal(a, first, last, matrix);
    add_entries(a, a.mesh, first, last, matrix);
    if (a.far.row_count > 0) add_entries(a, a.far, first, last, matrix);
    if (a.contact.matrix.row_count > 0) add_entries(a, a.contact.matrix, first, last, matrix);
    for (Index k = 0; k < n; ++k)
      if (matrix(k, k) == 0) matrix(k, k) = 1;
    const Dense inverse = matrix.llt().solve(Dense::Identity(n, n));
    // Conjugate gradients need a symmetric preconditioner, to the bit.
    for (Index i = 0; i < n; ++i)
      for (Index j = 0; j <= i; ++j)
        out[i * n + j] = out[j * n + i] = static_cast<T>(inverse(i, j));
  }
}

}  // namespace

template <class T>
void run(OnHost, Queue& queue, const SolveSchwarzLevel<T>& args) {
  submit_host(queue, [args] { invert_domains(args); });
}

template void run(OnHost, Queue&, const SolveSchwarzLevel<float>&);
template void run(OnHost, Queue&, const SolveSchwarzLevel<double>&);

}  // namespace weft
