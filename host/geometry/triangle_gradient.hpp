#pragma once

#include "weft/core/mat.hpp"
#include "weft/core/vec.hpp"

namespace weft {

/// Gradient of what is linear over a triangle: [y1 - y0, y2 - y0] [u1 - u0, u2 - u0]^-1.
template <int N>
Mat<double, N, 2> gradient(const Vec<double, N> y[3], const Vec2<double> u[3]) {
  const Vec2<double> a = u[1] - u[0];
  const Vec2<double> b = u[2] - u[0];
  const double det = a[0] * b[1] - a[1] * b[0];
  const Vec<double, N> p = y[1] - y[0];
  const Vec<double, N> q = y[2] - y[0];
  Mat<double, N, 2> g{};
  for (int r = 0; r < N; ++r) {
    g(r, 0) = (p[r] * b[1] - q[r] * a[1]) / det;
    g(r, 1) = (q[r] * a[0] - p[r] * b[0]) / det;
  }
  return g;
}

}  // namespace weft
