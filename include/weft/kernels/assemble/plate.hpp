#pragma once

#include "weft/core/ids.hpp"
#include "weft/core/mat.hpp"
#include "weft/core/span.hpp"
#include "weft/core/vec.hpp"
#include "weft/exec/element_wise.hpp"
#include "weft/state/row_order.hpp"

namespace weft {

/// Bending as a plate (host/model/plate.hpp), which is linear in the positions, and its damping,
/// for the rows of one rank: the matrix h^2 K + h B, of multiples of the identity, and the impulse
/// -h (K x_k + B v_k). Entries where the mesh matrix has one too - those of the vertices that share
/// a triangle with the row's - are added there, the others make a matrix of scalars. Patterns, K
/// and B never change. Rows sum to zero, so differences to a row's own vertex are taken, which lose
/// nothing to rounding, and the row's own entry is minus the sum of the others. Reads: positions
/// and velocities of the columns. Writes: off_pattern_value of its own row; mesh_value, diagonal
/// and rhs of its own row (adds). Order: near columns ascending, then far ones. Ghosts: positions
/// and velocities. Flags: none.
template <class T>
struct AssemblePlate {
  Index row_begin = 0;
  Index row_count = 0;
  Index slice = 1;                       ///< rows of one, in both matrices
  Span<const Offset> in_pattern_offset;  ///< [rows + 1]
  Span<const Offset> in_pattern_place;   ///< into mesh_value, of component (0, 0)
  Span<const Index> in_pattern_column;
  Span<const T> in_pattern_stiffness;  ///< [N/m] K
  Span<const T> in_pattern_damping;    ///< [N s/m] B
  Span<const Offset> off_pattern_slice_offset;
  Span<const Index> off_pattern_column;  ///< padding repeats the row's own, with zeros
  Span<const T> off_pattern_stiffness;
  Span<const T> off_pattern_damping;
  Span<const Vec3<T>> positions;   ///< [m] iterate x_k
  Span<const Vec3<T>> velocities;  ///< [m/s] iterate v_k; empty: zero
  T h;                             ///< [s] effective time step
  Span<T> mesh_value;              ///< [kg] as in BlockEll
  Span<Mat3<T>> diagonal;          ///< [rows] [kg] as in BlockEll
  Span<T> off_pattern_value;       ///< [kg] as in ScalarEll
  Span<Vec3<T>> rhs;               ///< [rows] [N s]
  RowOrder order{};                ///< of both matrices

  /// Force that one entry of row `vertex` exerts.
  WEFT_HD Vec3<T> plate_force(std::size_t vertex, Index column, T stiffness,
                              T damping) const noexcept {
    const auto other = static_cast<std::size_t>(column);
    Vec3<T> force = stiffness * (positions[vertex] - positions[other]);
    if (!velocities.empty()) force += damping * (velocities[vertex] - velocities[other]);
    return force;
  }

  WEFT_HD Index count() const noexcept { return row_count; }

  WEFT_HD void operator()(Index i) const noexcept {
    const auto row = static_cast<std::size_t>(i);
    const auto vertex = static_cast<std::size_t>(row_begin + i);
    Vec3<T> force{};
    T sum = T(0);
    for (auto e = static_cast<std::size_t>(in_pattern_offset[row]);
         e < static_cast<std::size_t>(in_pattern_offset[row + 1]); ++e) {
      const T k = in_pattern_stiffness[e];
      const T b = in_pattern_damping[e];
      force += plate_force(vertex, in_pattern_column[e], k, b);
      const T value = h * (h * k + b);
      for (Offset c = 0; c < 3; ++c)
        mesh_value[static_cast<std::size_t>(in_pattern_place[e] + 4 * c * slice)] += value;
      sum += value;
    }
    const Index place = order.place(i);
    const auto own_slice = static_cast<std::size_t>(place / slice);
    const Index lane = place % slice;
    for (Offset slot = off_pattern_slice_offset[own_slice];
         slot < off_pattern_slice_offset[own_slice + 1]; ++slot) {
      const auto e = static_cast<std::size_t>(slot * slice + lane);
      const T k = off_pattern_stiffness[e];
      const T b = off_pattern_damping[e];
      force += plate_force(vertex, off_pattern_column[e], k, b);
      off_pattern_value[e] = h * (h * k + b);
      sum += off_pattern_value[e];
    }
    for (int c = 0; c < 3; ++c) diagonal[row](c, c) -= sum;
    rhs[row] += h * force;
  }
};

}  // namespace weft
