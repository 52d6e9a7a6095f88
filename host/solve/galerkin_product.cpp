#include "weft/kernels/solve/galerkin_product.hpp"

#include <algorithm>

#include "host/exec/host_device.hpp"
#include "host/solve/coarse_matrix.hpp"

namespace weft {
namespace {

/// Block of an entry.
template <class T>
Mat3<double> block(const BlockEll<T>& m, Offset slot, Index lane) {
  const T* value = m.value.data() + slot * 9 * m.slice + lane;
  Mat3<double> b;
  for (int k = 0; k < 9; ++k) b.e[k] = static_cast<double>(value[k * m.slice]);
  return b;
}
template <class T>
Mat3<double> block(const ScalarEll<T>& m, Offset slot, Index lane) {
  return static_cast<double>(m.value.data()[slot * m.slice + lane]) * Mat3<double>::identity();
}

/// Adds modes times block times modes at (row, column) of a matrix of `width` columns.
void add_product(const Modes<double>& row_modes, const Mat3<double>& b,
                 const Modes<double>& column_modes, double* to, std::size_t width) {
  const double row[coarse_basis_count] = {1, row_modes.u, row_modes.v};
  const double column[coarse_basis_count] = {1, column_modes.u, column_modes.v};
  for (std::size_t p = 0; p < coarse_basis_count; ++p)
    for (std::size_t q = 0; q < coarse_basis_count; ++q) {
      const double weight = row[p] * column[q];
      for (std::size_t i = 0; i < 3; ++i)
        for (std::size_t j = 0; j < 3; ++j)
          to[(3 * p + i) * width + 3 * q + j] += weight * b.e[3 * i + j];
    }
}

/// The rows of one reduction block.
template <class T>
class Projection {
 public:
  Projection(const SolveGalerkinProduct<T>& args, Index partial)
      : a_(args),
        levels_(args.levels),
        partial_(partial),
        first_(partial * levels_.partial_rows),
        last_(std::min(first_ + levels_.partial_rows, args.row_begin + args.mesh.row_count)),
        own_(static_cast<std::size_t>(partial - args.row_begin / levels_.partial_rows)),
        units_(levels_.fine_size(), levels_.fine_size()) {}

  void make() {
    const std::size_t size = strip_size() * static_cast<std::size_t>(levels_.upper_count);
    strip_ = a_.strip.data() + own_ * size;
    std::fill(strip_, strip_ + size, 0.0);
    units_.setZero();
    add_diagonal();
    add_entries(a_.mesh);
    if (a_.far.row_count > 0) add_entries(a_.far);
    if (a_.contact.matrix.row_count > 0) add_entries(a_.contact.matrix);
    mirror(units_);
    restrict_units();
    if (!levels_.has_fine()) return;
    const auto n = static_cast<std::size_t>(units_.rows());
    invert_coarse(units_, levels_.fine_inverse.data() + own_ * n * n, units_.rows());
  }

 private:
  static constexpr std::size_t strip_size() { return coarse_dofs * coarse_domain_dofs; }

  void add_diagonal() {
    for (Index vertex = first_; vertex < last_; ++vertex) {
      if (a_.fixed.data()[vertex] != 0) continue;
      const Mat3<T>& block = a_.mesh.diagonal.data()[vertex - a_.row_begin];
      Mat3<double> b;
      for (int k = 0; k < 9; ++k) b.e[k] = static_cast<double>(block.e[k]);
      add_entry(vertex, vertex, b);
    }
  }

  template <class Matrix>
  void add_entries(const Matrix& m) {
    for (Index vertex = first_; vertex < last_; ++vertex) {
      if (a_.fixed.data()[vertex] != 0) continue;
      const Index row = vertex - a_.row_begin;
      const auto slice = static_cast<std::size_t>(row / m.slice);
      const Index lane = row % m.slice;
      for (Offset slot = m.slice_offset[slice]; slot < m.slice_offset[slice + 1]; ++slot) {
        const Index column = m.column.data()[slot * m.slice + lane];
        if (a_.fixed.data()[column] == 0) add_entry(vertex, column, block(m, slot, lane));
      }
    }
  }

  void add_entry(Index row, Index column, const Mat3<double>& b) {
    const Index other = column / levels_.partial_rows;
    if (other == partial_) {
      const auto place = [&](Index vertex) {
        return coarse_dofs * static_cast<std::size_t>((vertex - first_) / levels_.unit_rows);
      };
      const auto width = static_cast<std::size_t>(units_.cols());
      add_product(coarse_basis_of<double>(levels_.point.data()[row]), b,
                  coarse_basis_of<double>(levels_.point.data()[column]),
                  units_.data() + place(row) * width + place(column), width);
      return;
    }
    const int level = coarse_meeting_level(partial_, other);
    Index aggregate = other;
    for (int k = 0; k < level; ++k) aggregate /= coarse_domain;
    add_product(widened(coarse_basis_at(levels_, row, 0)), b,
                widened(coarse_basis_at(levels_, column, level)),
                strip_ + static_cast<std::size_t>(level) * strip_size() +
                    coarse_dofs * static_cast<std::size_t>(aggregate % coarse_domain),
                coarse_domain_dofs);
  }
  static Modes<double> widened(const Modes<T>& m) {
    return {static_cast<double>(m.u), static_cast<double>(m.v)};
  }

  /// The strip's diagonal block: what the units' matrix is on the whole aggregate.
  void restrict_units() {
    double* diagonal = strip_ + coarse_dofs * static_cast<std::size_t>(partial_ % coarse_domain);
    const auto width = static_cast<std::size_t>(units_.cols());
    const Index first_unit = first_ / levels_.unit_rows;
    const Index end_unit = (last_ + levels_.unit_rows - 1) / levels_.unit_rows;
    for (Index i = first_unit; i < end_unit; ++i)
      for (Index j = first_unit; j < end_unit; ++j) {
        const auto row = static_cast<std::size_t>(i - first_unit);
        const auto column = static_cast<std::size_t>(j - first_unit);
        add_restricted(levels_.unit.data()[i], levels_.unit.data()[j],
                       units_.data() + coarse_dofs * (row * width + column), width, diagonal,
                       coarse_domain_dofs);
      }
  }

  const SolveGalerkinProduct<T>& a_;
  const CoarseBasisLevels<T>& levels_;
  Index partial_, first_, last_;
  std::size_t own_;
  CoarseMatrix units_;
  double* strip_ = nullptr;
};

template <class T>
void project(const SolveGalerkinProduct<T>& a) {
  const Index step = a.levels.partial_rows;
  for (Index row = 0; row < a.mesh.row_count; row += step)
    Projection<T>(a, (a.row_begin + row) / step).make();
}

}  // namespace

template <class T>
void run(OnHost, Queue& queue, const SolveGalerkinProduct<T>& args) {
  submit_host(queue, [args] { project(args); });
}

template void run(OnHost, Queue&, const SolveGalerkinProduct<float>&);
template void run(OnHost, Queue&, const SolveGalerkinProduct<double>&);

}  // namespace weft
