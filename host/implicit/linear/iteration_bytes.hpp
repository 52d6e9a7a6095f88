#pragma once

#include <cstddef>

#include "weft/core/ids.hpp"
#include "weft/scene.hpp"
#include "weft/state/contact_operator.hpp"

namespace weft {

/// Bytes per row that an iteration of conjugate gradients reads and writes, in single precision, on
/// a grid with bending as a plate, on CUDA: `weft_bench_pcg` counts them (iteration_bytes_per_row).
constexpr double iteration_bytes(Preconditioner preconditioner) noexcept {
  switch (preconditioner) {
    case Preconditioner::block_jacobi:
      return 573;
    case Preconditioner::multilevel:
      return 660;
  }
  return 660;
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

/// Bytes per row without the matrix: vectors and preconditioner, see PcgBlock.
template <class T>
constexpr double row_bytes(Preconditioner preconditioner) noexcept {
  const double single = preconditioner == Preconditioner::multilevel ? 301 : 214;
  return single * static_cast<double>(sizeof(T) / sizeof(float));
}

}  // namespace weft
