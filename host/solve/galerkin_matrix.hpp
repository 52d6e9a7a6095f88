#pragma once

#include <algorithm>

#include "weft/core/ids.hpp"
#include "weft/kernels/solve/schwarz_levels.hpp"

namespace weft {

/// Galerkin matrix of a domain's aggregates: its lower triangle, in rows of the whole width.
class GalerkinMatrix {
 public:
  explicit GalerkinMatrix(Index size) noexcept : size_(size) {}

  void clear() noexcept {
    for (Index i = 0; i < size_; ++i) std::fill_n(entry_[i], width, 0.0);
    for (auto& row : scalar_) std::fill_n(row, schwarz_aggregates_max, 0.0);
  }

  /// Adds component(3 i + j) to entry (i, j) of the block of two aggregates; those above the
  /// diagonal are left out.
  template <class Component>
  void add_block(Index row, Index column, const Component& component) noexcept {
    if (column > row) return;
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j)
        entry_[3 * row + i][3 * column + j] += static_cast<double>(component(3 * i + j));
  }
  /// The same of a multiple of the identity.
  void add_scalar(Index row, Index column, double value) noexcept { scalar_[row][column] += value; }

  /// Makes this its inverse, with 1 in place of empty diagonal entries. By sweeps (Goodnight 1979):
  /// each exchanges one unknown with its right-hand side, and the matrix stays symmetric.
  void invert() noexcept {
    for (Index i = 0; i < size_; ++i)
      for (Index j = i % 3; j <= i; j += 3) entry_[i][j] += scalar_[i / 3][j / 3];
    for (Index k = 0; k < size_; ++k)
      if (entry_[k][k] == 0) entry_[k][k] = 1;
    for (Index k = 0; k < size_; ++k) sweep(k);
    for (Index i = 0; i < size_; ++i)
      for (Index j = 0; j <= i; ++j) entry_[i][j] = -entry_[i][j];
  }

  /// The sum of all blocks, of both triangles: what the aggregates together are one block of.
  Mat3<double> total() const noexcept {
    Mat3<double> sum{};
    for (Index i = 0; i < size_; ++i)
      for (Index j = 0; j <= i; ++j) {
        sum(i % 3, j % 3) += entry_[i][j];
        if (j < i) sum(j % 3, i % 3) += entry_[i][j];
      }
    double scalars = 0;
    for (const auto& row : scalar_)
      for (const double value : row) scalars += value;
    return sum + scalars * Mat3<double>::identity();
  }

  template <class T>
  void store_blocks(T* to) const noexcept {
    const Index n = size_ / 3;
    for (Index i = 0; i < n; ++i)
      for (Index j = 0; j <= i; ++j) {
        Mat3<double> block;
        for (int k = 0; k < 9; ++k) block.e[k] = entry_[3 * i + k / 3][3 * j + k % 3];
        SymmetricBlocks::store(to, n, i, j, block);
      }
  }

  /// Writes both triangles, with the same bits: conjugate gradients need a symmetric
  /// preconditioner.
  /// @param to [size][size]
  template <class T>
  void store_dense(T* to) const noexcept {
    for (Index i = 0; i < size_; ++i)
      for (Index j = 0; j <= i; ++j)
        to[i * size_ + j] = to[j * size_ + i] = static_cast<T>(entry_[i][j]);
  }

 private:
  static constexpr Index width = 3 * schwarz_aggregates_max;

  void sweep(Index k) noexcept {
    double column[width] = {};
    for (Index j = 0; j < k; ++j) column[j] = entry_[k][j];
    for (Index i = k; i < size_; ++i) column[i] = entry_[i][k];
    const double pivot = 1 / column[k];
    for (Index i = 0; i < size_; ++i) {
      const double factor = column[i] * pivot;
      double* row = entry_[i];
      // Rounded up to whole vector registers: entries above the diagonal are never read.
      const Index end = std::min(width, (i + 4) / 4 * 4);
      for (Index j = 0; j < end; ++j) row[j] -= factor * column[j];
      if (i > k) row[k] = factor;
    }
    for (Index j = 0; j < k; ++j) entry_[k][j] = column[j] * pivot;
    entry_[k][k] = -pivot;
  }

  Index size_;
  double scalar_[schwarz_aggregates_max][schwarz_aggregates_max];  ///< multiples of the identity
  alignas(64) double entry_[width][width];
};

}  // namespace weft
