#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

#include "weft/core/hd.hpp"
#include "weft/core/ids.hpp"
#include "weft/core/span.hpp"
#include "weft/core/vec.hpp"
#include "weft/elements/distance.hpp"

namespace weft {

/// Closest points of two primitives, given by their corners.
/// @tparam First as in PairLanes   @param x [m] [4] x Vec3
template <int First, class T>
WEFT_HD Proximity<T> closest_points(const Vec3<T> x[4]) noexcept {
  if constexpr (First == 1)
    return vertex_triangle(x);
  else
    return edge_edge(x);
}

/// Pairs side by side, for the tests that most pairs fail: written so that compilers keep a lane of
/// a vector register for each pair. A thread of a GPU takes one pair.
/// @tparam First corners of the first primitive: 1 vertex and face, 2 two edges
template <class T, int First, int Width = 8>
class PairLanes {
 public:
  static constexpr int width = Width;

  WEFT_HD bool full() const noexcept { return count_ == width; }
  WEFT_HD int count() const noexcept { return count_; }
  WEFT_HD void clear() noexcept { count_ = 0; }
  WEFT_HD const Index* corners(int lane) const noexcept { return v_[lane]; }
  WEFT_HD std::size_t number(int lane) const noexcept { return number_[lane]; }

  /// @param number of the pair
  WEFT_HD void add(const Index v[4], std::size_t number, Span<const Vec3<T>> positions_t0,
                   Span<const Vec3<T>> positions_t1) noexcept {
    const int lane = width == 1 ? 0 : count_;  // a lane known to the compiler needs no memory
    for (int j = 0; j < 4; ++j) {
      v_[lane][j] = v[j];
      const Vec3<T>& x = positions_t0.data()[v[j]];
      const Vec3<T>& y = positions_t1.data()[v[j]];
      for (int c = 0; c < 3; ++c) {
        x_[j][c][lane] = x[c];
        u_[j][c][lane] = y[c] - x[c];
      }
    }
    number_[lane] = number;
    ++count_;
  }

  /// Largest coordinate of a corner at the start, or end, to within the primitive's size. [m]
  WEFT_HD T size(int lane) const noexcept {
    T most = T(0);
    for (int c = 0; c < 3; ++c)
      most = std::max(most, std::fabs(x_[0][c][lane]) + std::fabs(u_[0][c][lane]));
    return most;
  }

  /// Most that the two primitives of each pair can come closer during the motion: their largest
  /// displacements about the mean of all four corners'. [m]
  WEFT_HD void closing(T out[width]) const noexcept {
    T most[2][width] = {};
    T mean[3][width];
    for (int c = 0; c < 3; ++c)
      for (int k = 0; k < width; ++k)
        mean[c][k] = T(0.25) * (u_[0][c][k] + u_[1][c][k] + u_[2][c][k] + u_[3][c][k]);
    for (int j = 0; j < 4; ++j)
      for (int k = 0; k < width; ++k) {
        const T a = u_[j][0][k] - mean[0][k];
        const T b = u_[j][1][k] - mean[1][k];
        const T c = u_[j][2][k] - mean[2][k];
        T& m = most[j < First ? 0 : 1][k];
        m = std::max(m, a * a + b * b + c * c);
      }
    for (int k = 0; k < width; ++k) out[k] = std::sqrt(most[0][k]) + std::sqrt(most[1][k]);
  }

  /// Largest gap between the boxes of the two primitives along an axis, at the start; a lower bound
  /// of their distance to within rounding of one subtraction. [m]
  WEFT_HD void box_gap(T out[width]) const noexcept {
    for (int k = 0; k < width; ++k) out[k] = -std::numeric_limits<T>::infinity();
    for (int c = 0; c < 3; ++c)
      for (int k = 0; k < width; ++k) {
        T lo_a = x_[0][c][k];
        T hi_a = lo_a;
        if constexpr (First == 2) {
          lo_a = std::min(lo_a, x_[1][c][k]);
          hi_a = std::max(hi_a, x_[1][c][k]);
        }
        T lo_b = std::min(x_[2][c][k], x_[3][c][k]);
        T hi_b = std::max(x_[2][c][k], x_[3][c][k]);
        if constexpr (First == 1) {
          lo_b = std::min(lo_b, x_[1][c][k]);
          hi_b = std::max(hi_b, x_[1][c][k]);
        }
        out[k] = std::max(out[k], std::max(lo_a - hi_b, lo_b - hi_a));
      }
  }

  /// Gap between the planes through each face and its vertex, or through both edges: lower bounds
  /// of their distances at the start, in spite of rounding. [m]
  WEFT_HD void plane_gap(T out[width]) const noexcept {
    constexpr T tiny = std::numeric_limits<T>::min();
    constexpr T epsilon = std::numeric_limits<T>::epsilon();
    for (int k = 0; k < width; ++k) {
      T e[2][3];
      T r[3];
      for (int c = 0; c < 3; ++c) {
        e[0][c] = First == 1 ? x_[2][c][k] - x_[1][c][k] : x_[1][c][k] - x_[0][c][k];
        e[1][c] = x_[3][c][k] - x_[First][c][k];
        r[c] = x_[0][c][k] - x_[First][c][k];
      }
      const T n0 = e[0][1] * e[1][2] - e[0][2] * e[1][1];
      const T n1 = e[0][2] * e[1][0] - e[0][0] * e[1][2];
      const T n2 = e[0][0] * e[1][1] - e[0][1] * e[1][0];
      const T n_sq = n0 * n0 + n1 * n1 + n2 * n2;
      const T size = (std::fabs(e[0][0]) + std::fabs(e[0][1]) + std::fabs(e[0][2])) *
                     (std::fabs(e[1][0]) + std::fabs(e[1][1]) + std::fabs(e[1][2]));
      const T far = std::fabs(r[0]) + std::fabs(r[1]) + std::fabs(r[2]);
      const T gap = std::fabs(n0 * r[0] + n1 * r[1] + n2 * r[2]) - T(16) * epsilon * size * far;
      const T distance = (T(1) - T(8) * epsilon) * (gap - tiny) / std::sqrt(n_sq);
      // Relative error bounds do not hold where squares underflow.
      out[k] = n_sq > tiny / epsilon ? distance : T(0);
    }
  }

 private:
  T x_[4][3][width] = {};  ///< [m] at the start
  T u_[4][3][width] = {};  ///< [m] displacement
  Index v_[width][4] = {};
  std::size_t number_[width] = {};
  int count_ = 0;
};

}  // namespace weft
