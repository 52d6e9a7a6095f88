#pragma once

#include "weft/core/ids.hpp"
#include "weft/core/mat.hpp"
#include "weft/core/span.hpp"
#include "weft/core/vec.hpp"
#include "weft/exec/launch.hpp"

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
};

/// Force that one entry of row `vertex` exerts.
template <class T>
WEFT_HD Vec3<T> plate_force(const AssemblePlate<T>& a, std::size_t vertex, Index column,
                            T stiffness, T damping) noexcept {
  const auto other = static_cast<std::size_t>(column);
  Vec3<T> force = stiffness * (a.positions[vertex] - a.positions[other]);
  if (!a.velocities.empty()) force += damping * (a.velocities[vertex] - a.velocities[other]);
  return force;
}

template <class T>
WEFT_HD void assemble_plate(const AssemblePlate<T>& a, Index i) noexcept {
  const auto row = static_cast<std::size_t>(i);
  const auto vertex = static_cast<std::size_t>(a.row_begin + i);
  Vec3<T> force{};
  T sum = T(0);
  for (auto e = static_cast<std::size_t>(a.in_pattern_offset[row]);
       e < static_cast<std::size_t>(a.in_pattern_offset[row + 1]); ++e) {
    const T k = a.in_pattern_stiffness[e];
    const T b = a.in_pattern_damping[e];
    force += plate_force(a, vertex, a.in_pattern_column[e], k, b);
    const T value = a.h * (a.h * k + b);
    for (Offset c = 0; c < 3; ++c)
      a.mesh_value[static_cast<std::size_t>(a.in_pattern_place[e] + 4 * c * a.slice)] += value;
    sum += value;
  }
  const auto slice = static_cast<std::size_t>(i / a.slice);
  const Index lane = i % a.slice;
  for (Offset slot = a.off_pattern_slice_offset[slice];
       slot < a.off_pattern_slice_offset[slice + 1]; ++slot) {
    const auto e = static_cast<std::size_t>(slot * a.slice + lane);
    const T k = a.off_pattern_stiffness[e];
    const T b = a.off_pattern_damping[e];
    force += plate_force(a, vertex, a.off_pattern_column[e], k, b);
    a.off_pattern_value[e] = a.h * (a.h * k + b);
    sum += a.off_pattern_value[e];
  }
  for (int c = 0; c < 3; ++c) a.diagonal[row](c, c) -= sum;
  a.rhs[row] += a.h * force;
}

template <class T>
void run(OnHost, Queue& queue, const AssemblePlate<T>& args);
template <class T>
void run(OnCuda, Queue& queue, const AssemblePlate<T>& args);

}  // namespace weft
