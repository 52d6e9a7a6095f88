#pragma once

// How a ZoneQp finds the change of a small face's multipliers: by factors of the matrix.

#include "weft/kernels/respond/zone/qp.hpp"

namespace weft {

/// Whether the face is small enough. All blocks of a GPU together would wait for each other in
/// every column.
template <class Team>
WEFT_HD bool ZoneQp<Team>::has_factors() const {
  return !Team::at_once && face_count_ <= zone_factor_max && face_count_ <= collisions_;
}

/// a M^-1 b^T [1/kg]
template <class Team>
WEFT_HD double ZoneQp<Team>::coupling(const ZoneConstraint& a, const ZoneConstraint& b) const {
  double sum = 0;
  for (int j = 0; j < 4; ++j)
    for (int k = 0; k < 4; ++k)
      if (a.v[j] == b.v[k]) sum += a.w[j] * b.w[k] * m_.mass_inv[a.v[j]];
  return sum * dot(a.n, b.n);
}

/// S = L D L^T for S = A M^-1 A^T of the face, with a ridge, and b = what its constraints miss. Of
/// column k below the diagonal stays L D; the last row becomes (L^-1 b)^T.
template <class Team>
WEFT_HD_CALL void ZoneQp<Team>::factorize() {
  const Index n = face_count_;
  const auto row = [&](Index i) { return m_.factor + i * (i + 1) / 2; };
  for_each(team_, (n + 1) * n, [&](Index e) {
    const Index i = e / n;
    const Index j = e % n;
    if (j > i) return;
    const ZoneConstraint& b = m_.constraint[m_.face[j]];
    if (i == n)
      row(i)[j] = b.wanted - gap(b, m_.u);
    else if (i == j)
      row(i)[j] = (1 + ridge) * b.diagonal;
    else
      row(i)[j] = coupling(m_.constraint[m_.face[i]], b);
  });
  double* column = m_.product;
  for (Index k = 0; k < n; ++k) {
    const double inverse = 1 / row(k)[k];
    for_each(team_, n - k, [&](Index e) { column[k + 1 + e] = row(k + 1 + e)[k] * inverse; });
    if constexpr (Team::alone) {
      for (Index i = k + 1; i <= n; ++i) {
        double* a = row(i);
        const double scaled = a[k];
        const Index end = i < n ? i + 1 : n;
        for (Index j = k + 1; j < end; ++j) a[j] -= scaled * column[j];
      }
    } else {
      const Index width = n - k - 1;
      for_each(team_, (width + 1) * width, [&](Index e) {
        const Index i = k + 1 + e / width;
        const Index j = k + 1 + e % width;
        if (j <= i) row(i)[j] -= row(i)[k] * column[j];
      });
    }
  }
}

/// The change d = (S + ridge)^-1 b. It climbs the dual all the way: b . d - 1/2 d . S d > 0.
template <class Team>
WEFT_HD_CALL void ZoneQp<Team>::find_direction_by_factors() {
  const Index n = face_count_;
  const auto row = [&](Index i) { return m_.factor + i * (i + 1) / 2; };
  factorize();
  ++passes_;
  double* x = m_.residual;
  for_each(team_, n, [&](Index i) { x[i] = row(n)[i] / row(i)[i]; });
  for (Index k = n - 1; k > 0; --k)
    for_each(team_, k, [&](Index i) { x[i] -= row(k)[i] / row(i)[i] * x[k]; });
  for_each(team_, n, [&](Index k) { m_.direction[m_.face[k]] = x[k]; });
}

}  // namespace weft
