#pragma once

#include <cmath>

#include "host/solve/simd.hpp"
#include "weft/state/contact_operator.hpp"

namespace weft::pcg {

/// The pull of a link in a product with u; the fourth number has no meaning.
template <class T>
typename Simd<T>::Vector pull_of(const ContactOperatorEntry<T>& link, const T* u) noexcept {
  const auto corner = [&](int j) {
    return link.w[j] * load_vector(u + std::ptrdiff_t{3} * link.v[j]);
  };
  const auto d = corner(0) + corner(1) + corner(2) + corner(3);
  using Vector = typename Simd<T>::Vector;
  const T* b = link.block;
  return d[0] * Vector{b[0], b[1], b[2]} + d[1] * Vector{b[1], b[3], b[4]} +
         d[2] * Vector{b[2], b[4], b[5]};
}

/// Pulls of all links in a product with u.
template <class T>
void gather_contacts(const ContactOperator<T>& links, const T* u) noexcept {
  const Index count = links.count[0];
  for (Index n = 0; n < count; ++n)
    store_values(pull_of(links.link.data()[n], u), links.pull.data()[n].x.e);
}

/// y = y + rows [first, last) of the contact part times u, each in the order of its links.
/// @tparam pulled  gather_contacts() has been called; else each end recomputes the pull of its
///                 link, to the same bits
template <bool pulled, class T>
void add_contact_rows(const ContactOperator<T>& links, Index first, Index last, const T* u,
                      Vec3<T>* y) noexcept {
  for (Index row = first; row < last; ++row) {
    typename Simd<T>::Vector sum{};
    const Index end = links.end_offset.data()[row + 1];
    for (Index e = links.end_offset.data()[row]; e < end; ++e) {
      const ContactScatter<T> own = links.end.data()[e];
      if constexpr (pulled)
        sum += own.weight * load_vector(links.pull.data()[own.link].x.e);
      else
        sum += own.weight * pull_of(links.link.data()[own.link], u);
    }
    for (int c = 0; c < 3; ++c) y[row][c] += sum[c];
  }
}

/// y = y + |C| |u| with C the contact part, link by link.
template <class T>
void add_contact_magnitudes(const ContactOperator<T>& links, Index rows, Span<const Vec3<T>> u,
                            Span<Vec3<T>> y) {
  for (Index row = 0; row < rows; ++row)
    visit_contact_entries(
        links, row, [&](Index column, T weight, const ContactOperatorEntry<T>& link) {
          for (int k = 0; k < 9; ++k)
            y.data()[row][k / 3] += std::abs(weight * link.component(k) * u.data()[column][k % 3]);
        });
}

}  // namespace weft::pcg
