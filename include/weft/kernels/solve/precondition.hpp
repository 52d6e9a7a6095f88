#pragma once

#include "weft/core/ids.hpp"
#include "weft/core/mat.hpp"
#include "weft/core/span.hpp"
#include "weft/exec/element_wise.hpp"
#include "weft/state/contact_operator.hpp"
#include "weft/state/row_blocks.hpp"

namespace weft {

/// Adds what links make of row i in its own column to `sum`: all of a link is asked for at once,
/// since the row is one of its corners.
template <class T>
WEFT_HD void add_diagonal(const ContactOperator<T>& links, Index i, Index vertex,
                          Mat3<T>& sum) noexcept {
  if (links.count.empty()) return;
  const Index last = links.end_offset.data()[i + 1];
  for (Index e = links.end_offset.data()[i]; e < last; ++e) {
    const ContactScatter<T> end = links.end.data()[e];
    const ContactOperatorEntry<T> link = links.link.data()[end.link];
    T weight = T(0);
    for (int j = 0; j < 4; ++j) weight += link.v[j] == vertex ? link.w[j] : T(0);
    weight *= end.weight;
    for (int k = 0; k < 9; ++k) sum.e[k] += weight * link.component(k);
  }
}

/// Block-Jacobi preconditioner: the inverse of each row's diagonal block, mesh plus contact.
/// Rows whose velocity is prescribed get zero, which keeps them out of the solve.
/// Reads: both parts. Writes: inverse of its own row. Order: independent. Ghosts: none.
template <class T>
struct Precondition {
  Index row_begin = 0;
  Index row_count = 0;
  Span<const Mat3<T>> diagonal;  ///< [rows] [kg] of the mesh
  ContactOperator<T> contact;
  Span<const unsigned char> fixed;  ///< [vertices] 1 where the velocity is prescribed
  RowBlocks<T> inverse;             ///< [1/kg]

  WEFT_HD Index count() const noexcept { return row_count; }

  WEFT_HD void operator()(Index i) const noexcept {
    const Index vertex = row_begin + i;
    if (fixed[static_cast<std::size_t>(vertex)] != 0) {
      inverse.store(i, {});
      return;
    }
    Mat3<T> sum = diagonal[static_cast<std::size_t>(i)];
    add_diagonal(contact, i, vertex, sum);
    inverse.store(i, inverse_symmetric(sum));
  }
};

}  // namespace weft
