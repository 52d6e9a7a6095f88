#pragma once

#include "weft/core/ids.hpp"
#include "weft/core/mat.hpp"
#include "weft/core/span.hpp"
#include "weft/elements/scalar.hpp"
#include "weft/exec/element_wise.hpp"
#include "weft/state/block_ell.hpp"
#include "weft/state/row_blocks.hpp"

namespace weft {

/// Names the block that one element adds to one entry of the matrix. Triangles: 9 n + 3 i + j for
/// block (i, j) of triangle n. Hinges: -1 - (16 n + 4 i + j).
using BlockSource = Index;

/// Twice the rounding of a block's largest component. Across a stiff sheet, the rounding of what it
/// does in its plane may exceed mass; without this, it may have either sign.
template <class T>
inline constexpr T block_rounding = T(2) * epsilon<T>;

/// Largest component of a block, by magnitude.
template <class T>
WEFT_HD T largest_component(const Mat3<T>& block) noexcept {
  using std::fabs;
  T largest = T(0);
  for (int k = 0; k < 9; ++k) largest = greater(largest, static_cast<T>(fabs(block.e[k])));
  return largest;
}

/// Mesh part of the system (M - h^2 J) dv = b (P-Cloth eq. (3)) for the rows of one rank: each
/// entry gathers its element blocks through a table made once, each right-hand side its element
/// impulses.
///   b = M (v~ - v_k) + h (f - M a v_k) + h M gravity
/// Components on the diagonal of a block between two vertices are lowered by block_rounding of its
/// size, so that rounding leaves no negative eigenvalue. The row's own block is what products of
/// differences make of it: its vertex part less all its other blocks.
/// Reads: outputs of AssembleMembrane, AssembleWind and AssembleBending. Writes: value, diagonal,
/// rhs and vertex part of its own row.
/// Order: elements in ascending global number, triangles before hinges, so that the sum is the same
/// for every partition. Ghosts: none. Flags: none.
template <class T>
struct AssembleRows {
  Index row_begin = 0;                     ///< first global row of this rank
  BlockEllOut<T> matrix;                   ///< mesh pattern; columns are not read
  Span<const Offset> block_source_offset;  ///< [slots * slice + 1]
  Span<const BlockSource> block_source;
  Span<const Offset> corner_source_offset;  ///< [rows + 1]
  Span<const Index> corner_source;          ///< triangles: 3 n + i; hinges: -1 - (4 n + i)
  Span<const Mat3<T>> triangle_block;       ///< see AssembleMembrane
  Span<const Vec3<T>> triangle_impulse;
  Span<const Vec3<T>> hinge_direction;  ///< see AssembleBending
  Span<const T> hinge_impulse_scale;
  Span<const T> hinge_curvature;
  Span<const T> mass;                   ///< [vertices] [kg] global
  Span<const T> damping_mass;           ///< [vertices] [1/s] global
  Span<const Vec3<T>> base_velocities;  ///< [vertices] [m/s] v~, global
  Span<const Vec3<T>> velocities;       ///< [vertices] [m/s] v_k, global; empty: zero
  Vec3<T> gravity;                      ///< [m/s^2]
  T h;                                  ///< [s]
  Span<Vec3<T>> rhs;                    ///< [rows] [N s] local
  Span<T> vertex_mass;                  ///< [rows] see VertexPart
  Span<const Mat3<T>> corner_drag{};    ///< see AssembleWind; empty: no wind
  RowBlocks<T> vertex_drag{};           ///< see VertexPart; not used without wind

  WEFT_HD Mat3<T> element_block(BlockSource source) const noexcept {
    if (source >= 0) {
      const auto n = static_cast<std::size_t>(source / 9);
      const int i = (source % 9) / 3;
      const int j = source % 3;
      // Blocks are stored for i <= j in the order 00 01 02 11 12 22.
      constexpr int place[9] = {0, 1, 2, 1, 3, 4, 2, 4, 5};
      const Mat3<T>& b = triangle_block[6 * n + static_cast<std::size_t>(place[3 * i + j])];
      return i <= j ? b : transpose(b);
    }
    const Index code = -1 - source;
    const auto n = static_cast<std::size_t>(code / 16);
    const auto i = static_cast<std::size_t>((code % 16) / 4);
    const auto j = static_cast<std::size_t>(code % 4);
    return outer(hinge_curvature[n] * hinge_direction[4 * n + i], hinge_direction[4 * n + j]);
  }

  WEFT_HD Vec3<T> element_impulse(Index source) const noexcept {
    if (source >= 0) return triangle_impulse[static_cast<std::size_t>(source)];
    const auto code = static_cast<std::size_t>(-1 - source);
    return hinge_impulse_scale[code / 4] * hinge_direction[code];
  }

  /// Drag on the corners of triangles that row `row` of this rank has.
  WEFT_HD Mat3<T> sum_corner_drag(std::size_t row) const noexcept {
    Mat3<T> sum{};
    for (Offset s = corner_source_offset[row]; s < corner_source_offset[row + 1]; ++s) {
      const Index source = corner_source[static_cast<std::size_t>(s)];
      if (source >= 0) sum += corner_drag[static_cast<std::size_t>(source / 3)];
    }
    return sum;
  }

  WEFT_HD Index count() const noexcept { return matrix.row_count; }

  WEFT_HD void operator()(Index i) const noexcept {
    const auto row = static_cast<std::size_t>(i);
    const auto vertex = static_cast<std::size_t>(row_begin + i);
    const T own_mass = mass[vertex];
    const T damped = own_mass * (T(1) + h * damping_mass[vertex]);
    vertex_mass[row] = damped;

    Vec3<T> impulse = own_mass * (base_velocities[vertex] + h * gravity);
    if (!velocities.empty()) impulse -= damped * velocities[vertex];
    for (Offset s = corner_source_offset[row]; s < corner_source_offset[row + 1]; ++s)
      impulse += element_impulse(corner_source[static_cast<std::size_t>(s)]);
    rhs[row] = impulse;
    Mat3<T> diagonal = damped * Mat3<T>::identity();
    if (!corner_drag.empty()) {
      const Mat3<T> drag = sum_corner_drag(row);
      vertex_drag.store(i, drag);
      diagonal += drag;
    }

    const Index width = matrix.slice;
    const Index place = matrix.order.place(i);
    const Index slice = place / width;
    const Index lane = place % width;
    for (Offset slot = matrix.slice_offset[static_cast<std::size_t>(slice)];
         slot < matrix.slice_offset[static_cast<std::size_t>(slice) + 1]; ++slot) {
      const auto entry = static_cast<std::size_t>(slot * width + lane);
      const Offset first = block_source_offset[entry];
      const Offset last = block_source_offset[entry + 1];
      Mat3<T> sum{};
      for (Offset s = first; s < last; ++s)
        sum += element_block(block_source[static_cast<std::size_t>(s)]);
      // Padding has no sources, and stays zero.
      const T rounding = block_rounding<T> * largest_component(sum);
      for (int c = 0; c < 3; ++c) sum(c, c) -= rounding;
      diagonal -= sum;
      for (int k = 0; k < 9; ++k)
        matrix.value[static_cast<std::size_t>((slot * 9 + k) * width + lane)] = sum.e[k];
    }
    // Rounding must not leave it without the symmetry that preconditioners need.
    matrix.diagonal[row] = T(0.5) * (diagonal + transpose(diagonal));
  }
};

}  // namespace weft
