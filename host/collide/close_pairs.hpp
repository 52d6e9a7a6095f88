#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

#include "weft/core/ids.hpp"
#include "weft/core/span.hpp"
#include "weft/core/vec.hpp"

namespace weft {

/// Pairs side by side that neither boxes nor planes keep apart: mostly neighbours in one sheet.
/// Written so that compilers keep a lane of a vector register for each pair.
/// @tparam First corners of the first primitive: 1 vertex and face, 2 two edges
template <class T, int First>
class ClosePairs {
 public:
  static constexpr int width = 8;
  struct Item {
    std::size_t number;  ///< of the pair
    Index v[4];
    T closing;  ///< [m] see PairLanes
    T reach;    ///< [m] farther apart than this it is left alone
    T size;     ///< [m] of the coordinates
  };

  bool full() const noexcept { return count_ == width; }
  int count() const noexcept { return count_; }
  void clear() noexcept { count_ = 0; }
  const Item& item(int lane) const noexcept { return items_[lane]; }

  void add(const Item& item, Span<const Vec3<T>> positions) noexcept {
    for (int j = 0; j < 4; ++j)
      for (int c = 0; c < 3; ++c) x_[j][c][count_] = positions.data()[item.v[j]][c];
    items_[count_++] = item;
  }

  /// Lower bounds of the distances: the gap along the direction between the closest points of which
  /// one is on the boundary of its primitive. However inaccurate that direction is, the gap along
  /// it is one. Where both are inside, the bound is of no use, but that of the plane has been seen.
  void distance_bounds(T out[width]) const noexcept {
    for (int k = 0; k < width; ++k) {
      T n[3], gap, size;
      if constexpr (First == 1)
        look_at_face(k, n, gap, size);
      else
        look_at_edges(k, n, gap, size);
      const T n_sq = dot(n, n);
      const T rounding =
          16 * epsilon * (std::fabs(n[0]) + std::fabs(n[1]) + std::fabs(n[2])) * size;
      const T bound = (1 - 8 * epsilon) * (gap - rounding) / std::sqrt(n_sq);
      // Relative error bounds do not hold where squares underflow.
      out[k] = n_sq > tiny / epsilon ? bound : T(0);
    }
  }

 private:
  static constexpr T tiny = std::numeric_limits<T>::min();
  static constexpr T epsilon = std::numeric_limits<T>::epsilon();

  static T dot(const T a[3], const T b[3]) noexcept {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
  }
  static T norm1(const T a[3]) noexcept {
    return std::fabs(a[0]) + std::fabs(a[1]) + std::fabs(a[2]);
  }
  /// a / b in [0, 1]; 0 if b is none.
  static T share(T a, T b) noexcept {
    const T q = a / (b > tiny ? b : T(1));
    const T low = q > T(0) ? q : T(0);
    return low < T(1) ? low : T(1);
  }
  void between(int k, int i, int j, T out[3]) const noexcept {
    for (int c = 0; c < 3; ++c) out[c] = x_[j][c][k] - x_[i][c][k];
  }
  /// r - s a + t b, in place of `best` where it is shorter.
  static void keep_shorter(const T r[3], T s, const T a[3], T t, const T b[3], T best[3],
                           T& best_sq) noexcept {
    T w[3];
    for (int c = 0; c < 3; ++c) w[c] = r[c] - s * a[c] + t * b[c];
    const T sq = dot(w, w);
    const bool shorter = sq < best_sq;
    for (int c = 0; c < 3; ++c) best[c] = shorter ? w[c] : best[c];
    best_sq = shorter ? sq : best_sq;
  }

  void look_at_face(int k, T n[3], T& gap, T& size) const noexcept {
    T e1[3], e2[3], e3[3], r[3], q[3];
    between(k, 1, 2, e1);
    between(k, 1, 3, e2);
    between(k, 2, 3, e3);
    between(k, 1, 0, r);
    between(k, 2, 0, q);
    T best_sq = std::numeric_limits<T>::max();
    n[0] = n[1] = n[2] = T(0);
    keep_shorter(r, share(dot(r, e1), dot(e1, e1)), e1, T(0), e1, n, best_sq);
    keep_shorter(r, share(dot(r, e2), dot(e2, e2)), e2, T(0), e2, n, best_sq);
    keep_shorter(q, share(dot(q, e3), dot(e3, e3)), e3, T(0), e3, n, best_sq);
    const T a = dot(n, e1), b = dot(n, e2);
    const T far = a > b ? a : b;
    gap = dot(n, r) - (far > T(0) ? far : T(0));
    size = norm1(r) + norm1(e1) + norm1(e2);
  }

  void look_at_edges(int k, T n[3], T& gap, T& size) const noexcept {
    T d1[3], d2[3], r[3];
    between(k, 0, 1, d1);
    between(k, 2, 3, d2);
    between(k, 2, 0, r);
    const T d1_sq = dot(d1, d1), d2_sq = dot(d2, d2), along = dot(d1, d2);
    const T r1 = dot(r, d1), r2 = dot(r, d2);
    T best_sq = std::numeric_limits<T>::max();
    n[0] = n[1] = n[2] = T(0);
    keep_shorter(r, share(r2, d2_sq), d2, T(0), d1, n, best_sq);
    keep_shorter(r, share(r2 + along, d2_sq), d2, T(1), d1, n, best_sq);
    keep_shorter(r, T(0), d2, share(-r1, d1_sq), d1, n, best_sq);
    keep_shorter(r, T(1), d2, share(along - r1, d1_sq), d1, n, best_sq);
    const T a = dot(n, d1), b = dot(n, d2);
    gap = dot(n, r) + (a < T(0) ? a : T(0)) - (b > T(0) ? b : T(0));
    size = norm1(r) + norm1(d1) + norm1(d2);
  }

  T x_[4][3][width] = {};  ///< [m]
  Item items_[width] = {};
  int count_ = 0;
};

}  // namespace weft
