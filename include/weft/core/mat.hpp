#pragma once

#include "weft/core/vec.hpp"

namespace weft {

/// Matrix of R rows and C columns, stored row by row.
template <class T, int R, int C>
struct Mat {
  T e[R * C];

  WEFT_HD constexpr T& operator()(int r, int c) noexcept { return e[r * C + c]; }
  WEFT_HD constexpr const T& operator()(int r, int c) const noexcept { return e[r * C + c]; }

  WEFT_HD constexpr Mat& operator+=(const Mat& b) noexcept {
    for (int i = 0; i < R * C; ++i) e[i] += b.e[i];
    return *this;
  }
  WEFT_HD constexpr Mat& operator-=(const Mat& b) noexcept {
    for (int i = 0; i < R * C; ++i) e[i] -= b.e[i];
    return *this;
  }
  WEFT_HD constexpr Mat& operator*=(T s) noexcept {
    for (int i = 0; i < R * C; ++i) e[i] *= s;
    return *this;
  }
  WEFT_HD friend constexpr Mat operator+(Mat a, const Mat& b) noexcept { return a += b; }
  WEFT_HD friend constexpr Mat operator-(Mat a, const Mat& b) noexcept { return a -= b; }
  WEFT_HD friend constexpr Mat operator*(Mat a, T s) noexcept { return a *= s; }
  WEFT_HD friend constexpr Mat operator*(T s, Mat a) noexcept { return a *= s; }

  WEFT_HD static constexpr Mat identity() noexcept requires(R == C) {
    Mat m{};
    for (int i = 0; i < R; ++i) m(i, i) = T(1);
    return m;
  }
};

template <class T>
using Mat2 = Mat<T, 2, 2>;
template <class T>
using Mat3 = Mat<T, 3, 3>;

template <class T, int R, int K, int C>
WEFT_HD constexpr Mat<T, R, C> operator*(const Mat<T, R, K>& a, const Mat<T, K, C>& b) noexcept {
  Mat<T, R, C> m{};
  for (int r = 0; r < R; ++r)
    for (int c = 0; c < C; ++c) {
      T s = a(r, 0) * b(0, c);
      for (int k = 1; k < K; ++k) s += a(r, k) * b(k, c);
      m(r, c) = s;
    }
  return m;
}

template <class T, int R, int C>
WEFT_HD constexpr Vec<T, R> operator*(const Mat<T, R, C>& a, const Vec<T, C>& x) noexcept {
  Vec<T, R> y{};
  for (int r = 0; r < R; ++r) {
    T s = a(r, 0) * x[0];
    for (int c = 1; c < C; ++c) s += a(r, c) * x[c];
    y[r] = s;
  }
  return y;
}

template <class T, int R, int C>
WEFT_HD constexpr Mat<T, C, R> transpose(const Mat<T, R, C>& a) noexcept {
  Mat<T, C, R> m{};
  for (int r = 0; r < R; ++r)
    for (int c = 0; c < C; ++c) m(c, r) = a(r, c);
  return m;
}

/// a b^T
template <class T, int R, int C>
WEFT_HD constexpr Mat<T, R, C> outer(const Vec<T, R>& a, const Vec<T, C>& b) noexcept {
  Mat<T, R, C> m{};
  for (int r = 0; r < R; ++r)
    for (int c = 0; c < C; ++c) m(r, c) = a[r] * b[c];
  return m;
}

/// Inverse of a symmetric positive definite 3x3 matrix by cofactors; zero where it is singular.
template <class T>
WEFT_HD constexpr Mat3<T> inverse_symmetric(const Mat3<T>& a) noexcept {
  const T c00 = a(1, 1) * a(2, 2) - a(1, 2) * a(2, 1);
  const T c01 = a(1, 2) * a(2, 0) - a(1, 0) * a(2, 2);
  const T c02 = a(1, 0) * a(2, 1) - a(1, 1) * a(2, 0);
  const T det = a(0, 0) * c00 + a(0, 1) * c01 + a(0, 2) * c02;
  if (!(det > T(0))) return {};
  const T s = T(1) / det;
  const T c11 = a(0, 0) * a(2, 2) - a(0, 2) * a(2, 0);
  const T c12 = a(0, 1) * a(2, 0) - a(0, 0) * a(2, 1);
  const T c22 = a(0, 0) * a(1, 1) - a(0, 1) * a(1, 0);
  return {{c00 * s, c01 * s, c02 * s, c01 * s, c11 * s, c12 * s, c02 * s, c12 * s, c22 * s}};
}

}  // namespace weft
