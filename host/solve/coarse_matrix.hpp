#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Core>

#include "weft/state/coarse_basis.hpp"

namespace weft {

using CoarseMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

/// Makes the upper triangle that of the lower one: the two are sums of other numbers, in another
/// order.
inline void mirror(CoarseMatrix& matrix) {
  matrix.triangularView<Eigen::StrictlyUpper>() = matrix.transpose();
}

/// Inverse of a Galerkin matrix: shifted by coarse_shift of its diagonal, with the identity where
/// an aggregate has no free vertex. Symmetric to the bit, as conjugate gradients need it.
/// @param matrix lower triangle counts; overwritten
/// @param out    [rows][width], width >= rows; what is beyond rows stays
template <class T>
void invert_coarse(CoarseMatrix& matrix, T* out, Eigen::Index width) {
  const Eigen::Index n = matrix.rows();
  for (Eigen::Index k = 0; k < n; ++k)
    matrix(k, k) = matrix(k, k) > 0 ? (1 + coarse_shift) * matrix(k, k) : 1;
  const Eigen::LLT<Eigen::Ref<CoarseMatrix>> factor(matrix);
  const CoarseMatrix inverse = factor.solve(CoarseMatrix::Identity(n, n));
  for (Eigen::Index i = 0; i < n; ++i)
    for (Eigen::Index j = 0; j <= i; ++j)
      out[i * width + j] = out[j * width + i] = static_cast<T>(inverse(i, j));
}

/// larger += step^T matrix step, of 9 x 9 blocks.
template <class T>
void add_restricted(const CoarseBasisStep<T>& row_step, const CoarseBasisStep<T>& column_step,
                    const double* matrix, std::size_t width, double* larger,
                    std::size_t larger_width) {
  double half[coarse_dofs][coarse_dofs] = {};
  for (std::size_t i = 0; i < coarse_dofs; ++i) add_sums(column_step, matrix + i * width, half[i]);
  for (std::size_t j = 0; j < coarse_dofs; ++j) {
    double column[coarse_dofs];
    double sums[coarse_dofs] = {};
    for (std::size_t i = 0; i < coarse_dofs; ++i) column[i] = half[i][j];
    add_sums(row_step, column, sums);
    for (std::size_t i = 0; i < coarse_dofs; ++i) larger[i * larger_width + j] += sums[i];
  }
}

}  // namespace weft
