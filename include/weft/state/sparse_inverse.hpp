#pragma once

#include <cmath>
#include <cstdint>
#include <cstring>

#include "weft/core/hd.hpp"
#include "weft/core/ids.hpp"
#include "weft/core/mat.hpp"
#include "weft/core/span.hpp"
#include "weft/core/vec.hpp"

namespace weft {

/// Entries of a row of a sparse factor: the row itself and up to seven rows before it.
constexpr int sparse_inverse_width = 8;

/// Rows that a factor joins: groups of so many from a rank's first row on have none in common. Bits
/// then do not depend on the number of ranks, whose boundaries are multiples of `partial_rows`, and
/// one processor of a GPU has all that a product with a group needs.
WEFT_HD constexpr Index sparse_inverse_domain(Index partial_rows) noexcept {
  return partial_rows < 1024 ? partial_rows : 1024;
}

/// A block of a sparse factor in 16 bytes, one load of a lane. A preconditioner may be coarse: with
/// 8 bits a component iterations are as many as with 52.
struct alignas(16) SparseInverseEntry {
  Index column = 0;            ///< a row of the same rank
  std::uint8_t value[9] = {};  ///< scale * (value - sparse_inverse_zero); row by row
  std::uint16_t scale = 0;     ///< upper half of a float
};
static_assert(sizeof(SparseInverseEntry) == 16);

/// The code of zero: without signs numbers become floats by a permutation of bytes.
constexpr int sparse_inverse_zero = 128;

/// What a component's integer counts.
WEFT_HD inline float sparse_inverse_scale(const SparseInverseEntry& e) noexcept {
  const std::uint32_t bits = std::uint32_t{e.scale} << 16;
  float scale;
  std::memcpy(&scale, &bits, sizeof scale);
  return scale;
}

/// A block rounded to what an entry holds.
template <class T>
WEFT_HD SparseInverseEntry sparse_inverse_entry(Index column, const Mat3<T>& block) noexcept {
  SparseInverseEntry entry;
  entry.column = column;
  float largest = 0;
  for (int k = 0; k < 9; ++k) {
    const auto size = static_cast<float>(block.e[k] < T(0) ? -block.e[k] : block.e[k]);
    if (!(size <= largest)) largest = size;
    if (!(size < 1e37F)) break;
  }
  // Cut, not rounded: so 127 may stand for less than the largest, but for 125 at least.
  const float step = largest * (1.0F / 125);
  std::uint32_t bits;
  std::memcpy(&bits, &step, sizeof bits);
  entry.scale = static_cast<std::uint16_t>(bits >> 16);
  const float scale = sparse_inverse_scale(entry);
  // Cut, a subnormal one could lose half of itself, and integers would overflow.
  if (!(scale >= 0x1p-126F) || !(largest < 1e37F)) {
    entry.scale = 0;
    return entry;
  }
  for (int k = 0; k < 9; ++k) {
    const float steps = static_cast<float>(block.e[k]) / scale;
    entry.value[k] = static_cast<std::uint8_t>(steps + (sparse_inverse_zero + 0.5F));
  }
  return entry;
}

/// The entry of the transpose, which stands in row entry.column.
WEFT_HD inline SparseInverseEntry transposed(const SparseInverseEntry& entry, Index row) noexcept {
  SparseInverseEntry t = entry;
  t.column = row;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) t.value[3 * j + i] = entry.value[3 * i + j];
  return t;
}

/// Adds an entry times x to `sum`.
template <class T>
WEFT_HD void add_entry(const SparseInverseEntry& entry, const Vec3<T>& x, Vec3<T>& sum) noexcept {
  const auto scale = static_cast<T>(sparse_inverse_scale(entry));
  for (int i = 0; i < 3; ++i) {
    T row = 0;
    for (int j = 0; j < 3; ++j)
      row += static_cast<T>(entry.value[3 * i + j] - sparse_inverse_zero) * x[j];
    sum[i] += scale * row;
  }
}

/// G, lower triangular, with G^T G close to the inverse of the matrix, and its transpose. Both in
/// slices as those of BlockEll; what is not in use are zeros in the row's own column.
struct SparseInverse {
  Index row_count = 0;  ///< 0: not in use
  Index slice = 1;
  Span<SparseInverseEntry>
      lower;  ///< [slices][sparse_inverse_width][slice]; a row's own entry first
  Span<const Offset> upper_offset;  ///< [slices + 1] slots
  Span<SparseInverseEntry> upper;   ///< [slots][slice]
  Span<const Offset> place;         ///< as lower: where the entry stands in upper; -1: not in use

  WEFT_HD bool any() const noexcept { return row_count > 0; }
  WEFT_HD Offset lower_place(Index row, int k) const noexcept {
    return (Offset{row / slice} * sparse_inverse_width + k) * slice + row % slice;
  }
};

/// Row `row` of G times x.
template <class T>
WEFT_HD Vec3<T> lower_row(const SparseInverse& f, Index row, const Vec3<T>* x) noexcept {
  Vec3<T> sum{};
  const SparseInverseEntry* entry = f.lower.data() + f.lower_place(row, 0);
  for (int k = 0; k < sparse_inverse_width; ++k, entry += f.slice) {
    const SparseInverseEntry e = *entry;
    add_entry(e, x[e.column], sum);
  }
  return sum;
}

/// Row `row` of the transpose times x, whose first number is that of row `first`.
template <class T>
WEFT_HD Vec3<T> upper_row(const SparseInverse& f, Index row, const Vec3<T>* x,
                          Index first) noexcept {
  const Index n = row / f.slice;
  const Offset begin = f.upper_offset.data()[n];
  const auto slots = static_cast<int>(f.upper_offset.data()[n + 1] - begin);
  const SparseInverseEntry* entry = f.upper.data() + begin * f.slice + row % f.slice;
  Vec3<T> sum{};
  for (int k = 0; k < slots; ++k, entry += f.slice) {
    const SparseInverseEntry e = *entry;
    add_entry(e, x[e.column - first], sum);
  }
  return sum;
}

}  // namespace weft
