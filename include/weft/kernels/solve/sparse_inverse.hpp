#pragma once

#include <cmath>
#include <type_traits>

#include "weft/core/hd.hpp"
#include "weft/core/ids.hpp"
#include "weft/core/mat.hpp"
#include "weft/core/span.hpp"
#include "weft/exec/launch.hpp"
#include "weft/kernels/solve/precondition.hpp"
#include "weft/state/block_ell.hpp"
#include "weft/state/sparse_inverse.hpp"

namespace weft {

/// Factorised sparse approximate inverse (Kolotilina and Yeremin 1993): row i of G is that of the
/// inverse Cholesky factor of the matrix of row i and its entries' columns alone. Cloth moves
/// slowly towards where it bends without stretching; on curved cloth such moves have components in
/// the plane that match those across it, which aggregates that move as one or linearly cannot, and
/// neighbouring rows solved for together can.
/// Contacts count on the diagonal alone. A row whose matrix is not positive definite as rounded
/// gets block Jacobi. Reads: the matrices. Writes: entries of the rank's rows, and their
/// transposes. Order: independent. Ghosts: none, since entries stay within domains.
template <class T>
struct SolveSparseInverse {
  Index row_begin = 0;
  BlockEll<T> mesh;
  ScalarEll<T> far;  ///< see SolvePcgPart; row_count 0: none
  ContactPart<T> contact;
  Span<const unsigned char> fixed;  ///< [vertices] these rows get zeros
  SparseInverse factor;
};

/// The matrix of a row and its entries' columns: the lower triangle of blocks, the row itself last.
template <class T>
struct SparseInversePatch {
  int count = 0;
  Index row[sparse_inverse_width];
  Mat3<T> block[sparse_inverse_width * (sparse_inverse_width + 1) / 2];

  WEFT_HD Mat3<T>& at(int i, int j) noexcept { return block[i * (i + 1) / 2 + j]; }
};

/// Adds the entries that a matrix, of blocks or of multiples of the identity, has in row i of the
/// patch for the columns before that row.
/// @param begin the vertex of row 0
template <class T, class Matrix>
WEFT_HD void add_patch_row(const Matrix& m, Index begin, int i,
                           SparseInversePatch<T>& patch) noexcept {
  constexpr bool blocks = std::is_same_v<Matrix, BlockEll<T>>;
  const Index row = patch.row[i];
  const Index lane = row % m.slice;
  const Offset end = m.slice_offset.data()[row / m.slice + 1];
  for (Offset slot = m.slice_offset.data()[row / m.slice]; slot < end; ++slot) {
    const Index column = m.column.data()[slot * m.slice + lane] - begin;
    const T* value = m.value.data() + slot * (blocks ? 9 : 1) * m.slice + lane;
    for (int j = 0; j < i; ++j)
      if (patch.row[j] == column)
        for (int k = 0; k < 9; k += blocks ? 1 : 4)
          patch.at(i, j).e[k] += value[blocks ? k * m.slice : 0];
  }
}

/// The matrix of row `row` and the free ones among its entries' columns.
template <class T>
WEFT_HD void gather_patch(const SolveSparseInverse<T>& a, Index row,
                          SparseInversePatch<T>& patch) noexcept {
  patch.count = 0;
  for (int k = sparse_inverse_width - 1; k >= 0; --k) {
    const SparseInverseEntry& entry = a.factor.lower.data()[a.factor.lower_place(row, k)];
    const Index other = k == 0 ? row : entry.column;
    if ((k > 0 && other == row) || a.fixed.data()[a.row_begin + other] != 0) continue;
    patch.row[patch.count++] = other;
  }
  for (int k = 0; k < patch.count * (patch.count + 1) / 2; ++k) patch.block[k] = {};
  for (int i = 0; i < patch.count; ++i) {
    patch.at(i, i) = a.mesh.diagonal.data()[patch.row[i]];
    add_patch_row(a.mesh, a.row_begin, i, patch);
    if (a.far.row_count > 0) add_patch_row(a.far, a.row_begin, i, patch);
    add_diagonal(a.contact, patch.row[i], a.row_begin + patch.row[i], patch.at(i, i));
  }
}

/// Whether a symmetric block is positive definite, by its minors.
template <class T>
WEFT_HD bool positive(const Mat3<T>& m) noexcept {
  const T minor = m(0, 0) * m(1, 1) - m(0, 1) * m(0, 1);
  const T determinant = m(0, 0) * (m(1, 1) * m(2, 2) - m(1, 2) * m(1, 2)) -
                        m(0, 1) * (m(0, 1) * m(2, 2) - m(1, 2) * m(0, 2)) +
                        m(0, 2) * (m(0, 1) * m(1, 2) - m(1, 1) * m(0, 2));
  return m(0, 0) > T(0) && minor > T(0) && determinant > T(0);
}

/// Block L D L^T; L below the diagonal, D on it.
/// @return whether all pivots are positive
template <class T>
WEFT_HD bool factorise(SparseInversePatch<T>& patch) noexcept {
  for (int j = 0; j < patch.count; ++j) {
    if (!positive(patch.at(j, j))) return false;
    const Mat3<T> inverse = inverse_symmetric(patch.at(j, j));
    for (int i = j + 1; i < patch.count; ++i) {
      const Mat3<T> l = patch.at(i, j) * inverse;
      for (int k = j + 1; k <= i; ++k) patch.at(i, k) -= l * transpose(patch.at(k, j));
    }
    for (int i = j + 1; i < patch.count; ++i) patch.at(i, j) = patch.at(i, j) * inverse;
  }
  return true;
}

/// C, lower triangular, with C C^T the inverse of a positive definite block.
template <class T>
WEFT_HD Mat3<T> root_of_inverse(const Mat3<T>& block) noexcept {
  using std::sqrt;
  const Mat3<T> a = inverse_symmetric(block);
  Mat3<T> c{};
  for (int j = 0; j < 3; ++j) {
    T pivot = a(j, j);
    for (int k = 0; k < j; ++k) pivot -= c(j, k) * c(j, k);
    c(j, j) = pivot > T(0) ? sqrt(pivot) : T(0);
    for (int i = j + 1; i < 3; ++i) {
      T sum = a(i, j);
      for (int k = 0; k < j; ++k) sum -= c(i, k) * c(j, k);
      c(i, j) = c(j, j) > T(0) ? sum / c(j, j) : T(0);
    }
  }
  return c;
}

/// Stores G's block of row `row` and the patch's n-th vertex; those that are not in the patch get
/// zeros.
template <class T>
WEFT_HD void store_sparse_inverse_row(const SparseInverse& f, Index row,
                                      const SparseInversePatch<T>& patch,
                                      const Mat3<T>* g) noexcept {
  for (int k = 0; k < sparse_inverse_width; ++k) {
    const Offset at = f.lower_place(row, k);
    SparseInverseEntry& entry = f.lower.data()[at];
    if (f.place.data()[at] < 0) continue;
    Mat3<T> block{};
    for (int n = 0; n < patch.count; ++n)
      if (patch.row[n] == entry.column) block = g[n];
    entry = sparse_inverse_entry(entry.column, block);
    f.upper.data()[f.place.data()[at]] = transposed(entry, row);
  }
}

template <class T>
WEFT_HD void sparse_inverse_row(const SolveSparseInverse<T>& a, Index row) noexcept {
  SparseInversePatch<T> patch;
  Mat3<T> g[sparse_inverse_width] = {};
  if (a.fixed.data()[a.row_begin + row] != 0) {
    store_sparse_inverse_row(a.factor, row, patch, g);
    return;
  }
  gather_patch(a, row, patch);
  const int last = patch.count - 1;
  const Mat3<T> own = patch.at(last, last);
  const bool good = factorise(patch);
  // G = C^T [v_1^T ... v_last^T] where L^T v = the last unit vector.
  const Mat3<T> root = transpose(root_of_inverse(good ? patch.at(last, last) : own));
  g[last] = Mat3<T>::identity();
  for (int k = last - 1; k >= 0; --k) {
    g[k] = {};
    if (!good) continue;
    for (int i = k + 1; i <= last; ++i) g[k] -= transpose(patch.at(i, k)) * g[i];
  }
  for (int k = 0; k <= last; ++k) g[k] = root * transpose(g[k]);
  store_sparse_inverse_row(a.factor, row, patch, g);
}

template <class T>
void run(OnHost, Queue& queue, const SolveSparseInverse<T>& args);
template <class T>
void run(OnCuda, Queue& queue, const SolveSparseInverse<T>& args);

}  // namespace weft
