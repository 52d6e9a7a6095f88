#pragma once

#include "host/solve/simd.hpp"
#include "weft/kernels/solve/schwarz_levels.hpp"

namespace weft::pcg {

/// y = A x for SymmetricBlocks of schwarz_aggregates_max rows. A lane has a row: the block of each
/// distance is used for its row and, transposed, for the row at that distance.
template <class T>
void multiply_whole_blocks(const T* from, const T* x, T* y) noexcept {
  using Values = typename Simd<T>::Values;
  constexpr int n = static_cast<int>(schwarz_aggregates_max);
  constexpr int width = static_cast<int>(Simd<T>::width);
  T turned[3][2 * n];  // x component by component, twice
  for (int c = 0; c < 3; ++c)
    for (int a = 0; a < n; ++a) turned[c][a] = turned[c][a + n] = x[3 * a + c];
  T own[3][n];
  T behind[n / 2][3][2 * n];  // what rows do to those at a distance, twice
  for (int first = 0; first < n; first += width) {
    const Values mine[3] = {load_values(turned[0] + first), load_values(turned[1] + first),
                            load_values(turned[2] + first)};
    const auto diagonal = [&](int k) {
      return load_values(from + SymmetricBlocks::diagonal_place(n, k, first));
    };
    Values sum[3] = {diagonal(0) * mine[0] + diagonal(1) * mine[1] + diagonal(2) * mine[2],
                     diagonal(1) * mine[0] + diagonal(3) * mine[1] + diagonal(4) * mine[2],
                     diagonal(2) * mine[0] + diagonal(4) * mine[1] + diagonal(5) * mine[2]};
    for (int distance = 1; distance < n / 2; ++distance) {
      const T* block = from + SymmetricBlocks::place(n, distance, 0, first);
      Values transposed[3] = {};
      for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) {
          const Values entries = load_values(block + (3 * i + j) * n);
          sum[i] += entries * load_values(turned[j] + first + distance);
          transposed[j] += entries * mine[i];
        }
      for (int c = 0; c < 3; ++c) {
        store_values(transposed[c], behind[distance][c] + first);
        store_values(transposed[c], behind[distance][c] + first + n);
      }
    }
    const T* block = from + SymmetricBlocks::place(n, n / 2, 0, first);
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j)
        sum[i] += load_values(block + (3 * i + j) * n) * load_values(turned[j] + first + n / 2);
    for (int c = 0; c < 3; ++c) store_values(sum[c], own[c] + first);
  }
  for (int c = 0; c < 3; ++c)
    for (int first = 0; first < n; first += width) {
      Values sum = load_values(own[c] + first);
      for (int distance = 1; distance < n / 2; ++distance)
        sum += load_values(behind[distance][c] + first + n - distance);
      store_values(sum, own[c] + first);
    }
  for (int c = 0; c < 3; ++c)
    for (int a = 0; a < n; ++a) y[3 * a + c] = own[c][a];
}

}  // namespace weft::pcg
