#pragma once

#include "weft/core/hd.hpp"
#include "weft/core/ids.hpp"
#include "weft/core/span.hpp"
#include "weft/core/vec.hpp"

namespace weft {

/// A contact or a spring in a product with a vector x of vertices: its pull is B d with
/// d = sum_j w[j] x[v[j]], and corner j of it adds w[j] times that to its row.
template <class T>
struct alignas(16) ContactOperatorEntry {
  Index v[4];  ///< of the cloth; corners that it does not have repeat one of those it has
  T w[4];      ///< 0 at corners that it does not have
  T block[6];  ///< [kg] B, symmetric: xx, xy, xz, yy, yz, zz

  /// Where component 3 i + j of B is in `block`.
  WEFT_HD static constexpr int place(int k) noexcept {
    constexpr int places[9] = {0, 1, 2, 1, 3, 4, 2, 4, 5};
    return places[k];
  }
  /// Component 3 i + j of B.
  WEFT_HD T component(int k) const noexcept { return block[place(k)]; }
};

/// What a link comes to, in as few loads as there can be.
template <class T>
struct alignas(4 * sizeof(T)) ContactGather {
  Vec3<T> x;
};

/// A corner in the row that it adds to.
template <class T>
struct alignas(2 * sizeof(T)) ContactScatter {
  Index link;
  T weight;
};

/// The contact part of a rank's rows as a product of factors. In single precision a contact of four
/// corners has sixteen entries of 40 bytes in a matrix, while a link and its pull have 80 bytes,
/// and an end 8. Every link moves the same number of bytes, however many of them a row has.
template <class T>
struct ContactOperator {
  Span<const ContactOperatorEntry<T>>
      link;                           ///< with a corner in own rows, in the order of contacts
  Span<const Index> count;            ///< [1] links that there are; empty: none
  Span<const Index> end_offset;       ///< [rows + 1]
  Span<const ContactScatter<T>> end;  ///< row by row, in the order of links
  Span<ContactGather<T>> pull;        ///< [links] scratch of products
};

/// Calls use(column, weight, link) for each corner of each link of a row, in stored order: `weight`
/// times the link's block adds to the entry of row and column.
template <class T, class Use>
WEFT_HD void visit_contact_entries(const ContactOperator<T>& links, Index row,
                                   const Use& use) noexcept {
  if (links.count.empty()) return;
  const Index last = links.end_offset.data()[row + 1];
  for (Index e = links.end_offset.data()[row]; e < last; ++e) {
    const ContactScatter<T> end = links.end.data()[e];
    const ContactOperatorEntry<T>& link = links.link.data()[end.link];
    for (int j = 0; j < 4; ++j) use(link.v[j], end.weight * link.w[j], link);
  }
}

}  // namespace weft
