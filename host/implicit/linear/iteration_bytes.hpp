#pragma once

#include <cstddef>

#include "weft/core/ids.hpp"
#include "weft/scene.hpp"
#include "weft/state/contact_operator.hpp"

namespace weft {

/// Bytes per row that an iteration of conjugate gradients reads and writes, in single precision, on
/// a grid with bending as a plate: `weft_bench_pcg` counts them (iteration_bytes_per_row).
constexpr double iteration_bytes(Preconditioner preconditioner) noexcept {
  switch (preconditioner) {
    case Preconditioner::block_jacobi:
      return 658;
    case Preconditioner::multilevel:
      return 745;
  }
  return 745;
}

/// Bytes of a 3x3 block or a scalar of a matrix, including the column number.
template <class T>
constexpr double block_bytes = 9 * sizeof(T) + sizeof(Index);
template <class T>
constexpr double scalar_bytes = sizeof(T) + sizeof(Index);

/// Bytes of the contact operator: an end with the pull that it reads, a link with the pull that it
/// writes (see the glossary).
template <class T>
constexpr double end_bytes = sizeof(ContactScatter<T>) + sizeof(ContactGather<T>);
template <class T>
constexpr double link_bytes = sizeof(ContactOperatorEntry<T>) + sizeof(ContactGather<T>);

/// Bytes per row without the matrix: vectors and preconditioner.
template <class T>
constexpr double row_bytes(Preconditioner preconditioner) noexcept {
  constexpr double grid_blocks = 8, grid_scalars = 16;  // of a row, padding included
  const double others = iteration_bytes(preconditioner) - grid_blocks * block_bytes<float> -
                        grid_scalars * scalar_bytes<float>;
  return others * static_cast<double>(sizeof(T) / sizeof(float));
}

}  // namespace weft
