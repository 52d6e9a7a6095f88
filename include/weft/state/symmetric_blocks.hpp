#pragma once

#include "weft/core/hd.hpp"
#include "weft/core/ids.hpp"
#include "weft/core/mat.hpp"
#include "weft/core/vec.hpp"

namespace weft {

/// Layout of a symmetric matrix of n x n blocks of 3 x 3 numbers, n a power of two from 2 on, that
/// holds each pair of blocks once: block (a, a + d mod n) stands in row `a` of distance d, from 1
/// to n / 2. Of distance n / 2 both blocks of a pair are there. Numbers with the same component and
/// distance follow each other, row by row, so that lanes or vector registers take a row each.
/// Blocks on the diagonal come last, as xx, xy, xz, yy, yz, zz.
struct SymmetricBlocks {
  WEFT_HD static constexpr Index size(Index n) noexcept { return n * (9 * (n / 2) + 6); }
  /// Where component 3 i + j of the block of distance d in row a is.
  WEFT_HD static constexpr Index place(Index n, Index distance, int component, Index a) noexcept {
    return ((distance - 1) * 9 + component) * n + a;
  }
  /// Where number k of the block on the diagonal is.
  WEFT_HD static constexpr Index diagonal_place(Index n, int k, Index a) noexcept {
    return (n / 2 * 9 + k) * n + a;
  }

  /// Stores block (i, j), i >= j. Of a block on the diagonal the lower triangle counts.
  template <class T>
  WEFT_HD static void store(T* to, Index n, Index i, Index j, const Mat3<double>& block) noexcept {
    if (i == j) {
      constexpr int row[6] = {0, 1, 2, 1, 2, 2}, column[6] = {0, 0, 0, 1, 1, 2};
      for (int k = 0; k < 6; ++k)
        to[diagonal_place(n, k, i)] = static_cast<T>(block(row[k], column[k]));
      return;
    }
    const Index distance = i - j;
    for (int r = 0; r < 3; ++r)
      for (int k = 0; k < 3; ++k) {
        const T number = static_cast<T>(block(r, k));
        if (distance >= n / 2) to[place(n, n - distance, 3 * r + k, i)] = number;
        if (distance <= n / 2) to[place(n, distance, 3 * k + r, j)] = number;
      }
  }

  /// Row `a` of the matrix times x.
  /// @param x [3 n]
  template <class T>
  WEFT_HD static Vec3<T> multiply_row(const T* from, Index n, Index a, const T* x) noexcept {
    T d[6];
    for (int k = 0; k < 6; ++k) d[k] = from[diagonal_place(n, k, a)];
    const T* own = x + 3 * a;
    Vec3<T> y{d[0] * own[0] + d[1] * own[1] + d[2] * own[2],
              d[1] * own[0] + d[3] * own[1] + d[4] * own[2],
              d[2] * own[0] + d[4] * own[1] + d[5] * own[2]};
    for (Index distance = 1; distance <= n / 2; ++distance) {
      const Index after = (a + distance) % n, before = (a + n - distance) % n;
      for (int r = 0; r < 3; ++r)
        for (int k = 0; k < 3; ++k) {
          y[r] += from[place(n, distance, 3 * r + k, a)] * x[3 * after + k];
          if (distance < n / 2)
            y[r] += from[place(n, distance, 3 * k + r, before)] * x[3 * before + k];
        }
    }
    return y;
  }
};

}  // namespace weft
