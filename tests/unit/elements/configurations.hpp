#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <random>

#include "weft/core/mat.hpp"
#include "weft/core/vec.hpp"

// Random input and finite differences that the element tests share.

namespace weft::test {

using Real = double;
using Long = long double;  // where a reference must be finer than the double under test

/// Seeded source of numbers, points and rotations; the same on every platform.
class Random {
 public:
  explicit Random(std::uint64_t seed) : engine_(seed) {}

  /// In [lo, hi).
  double uniform(double lo, double hi) {
    return lo + (hi - lo) * static_cast<double>(engine_() >> 11) * 0x1p-53;
  }
  /// Uniform in its logarithm to base 10.
  double decade(double lo, double hi) { return std::pow(10.0, uniform(lo, hi)); }
  int below(int n) { return static_cast<int>(engine_() % static_cast<std::uint64_t>(n)); }

  template <class T = double>
  Vec3<T> point(double size = 1) {
    const double x = uniform(-size, size), y = uniform(-size, size), z = uniform(-size, size);
    return {T(x), T(y), T(z)};
  }
  template <class T = double>
  Vec3<T> unit() {
    for (;;) {
      const Vec3<T> p = point<T>();
      const T l = length(p);
      if (l > T(0.1) && l <= T(1)) return p * (T(1) / l);
    }
  }
  /// A rotation, as the three images of the axes.
  template <class T = double>
  Mat3<T> rotation() {
    const Vec3<T> a = unit<T>();
    for (;;) {
      const Vec3<T> other = unit<T>();
      Vec3<T> b = other - a * dot(a, other);
      if (length(b) < T(0.1)) continue;
      b *= T(1) / length(b);
      const Vec3<T> c = cross(a, b);
      return {{a[0], b[0], c[0], a[1], b[1], c[1], a[2], b[2], c[2]}};
    }
  }

 private:
  std::mt19937_64 engine_;
};

template <class To, class From, std::size_t N>
void cast(const Vec3<From> (&from)[N], Vec3<To> (&to)[N]) {
  for (std::size_t i = 0; i < N; ++i) to[i] = vec_cast<To>(from[i]);
}

/// Derivative of f at zero by central differences of fourth order: exact for polynomials of degree
/// four, such as the energies of a membrane.
template <class F>
auto derivative(const F& f, Long step) {
  return ((f(step) - f(-step)) * 8.0L - (f(2 * step) - f(-2 * step))) * (1 / (12 * step));
}

/// Central differences of energy(x) -> Long at x.
template <std::size_t N, class Energy>
void difference_gradient(const Energy& energy, const Vec3<Real> (&x)[N], Long step,
                         Vec3<Real> (&g)[N]) {
  Vec3<Long> y[N];
  cast(x, y);
  for (std::size_t i = 0; i < N; ++i)
    for (int k = 0; k < 3; ++k) {
      const Long at = y[i][k];
      const auto moved = [&](Long by) {
        y[i][k] = at + by;
        const Long e = energy(y);
        y[i][k] = at;
        return e;
      };
      g[i][k] = static_cast<Real>(derivative(moved, step));
    }
}

/// Central differences of gradient(x, g): h[i][j](a, b) = d g[i][a] / d x[j][b].
template <std::size_t N, class Gradient>
void difference_hessian(const Gradient& gradient, const Vec3<Real> (&x)[N], Long step,
                        Mat3<Real> (&h)[N][N]) {
  Vec3<Long> y[N];
  cast(x, y);
  for (std::size_t j = 0; j < N; ++j)
    for (int b = 0; b < 3; ++b) {
      const Long at = y[j][b];
      const auto moved = [&](Long by) {
        Vec3<Long> g[N];
        y[j][b] = at + by;
        gradient(y, g);
        y[j][b] = at;
        Vec<Long, 3 * static_cast<int>(N)> flat{};
        for (std::size_t i = 0; i < 3 * N; ++i) flat.e[i] = g[i / 3].e[i % 3];
        return flat;
      };
      const auto column = derivative(moved, step);
      for (std::size_t i = 0; i < 3 * N; ++i)
        h[i / 3][j](static_cast<int>(i % 3), b) = static_cast<Real>(column.e[i]);
    }
}

/// The full matrix of blocks from its upper half, stored row by row.
template <std::size_t N, class T, std::size_t Blocks>
void unfold(const Mat3<T> (&upper)[Blocks], Mat3<T> (&full)[N][N]) {
  static_assert(Blocks == N * (N + 1) / 2);
  std::size_t block = 0;
  for (std::size_t i = 0; i < N; ++i)
    for (std::size_t j = i; j < N; ++j, ++block) {
      full[i][j] = upper[block];
      full[j][i] = transpose(upper[block]);
    }
}

template <std::size_t N, class T>
T largest(const Vec3<T> (&v)[N]) {
  T m = 0;
  for (const auto& p : v)
    for (const T e : p.e) m = std::fmax(m, std::fabs(e));
  return m;
}

template <std::size_t N, class T>
T largest_difference(const Vec3<T> (&a)[N], const Vec3<T> (&b)[N]) {
  Vec3<T> d[N];
  for (std::size_t i = 0; i < N; ++i) d[i] = a[i] - b[i];
  return largest(d);
}

template <std::size_t N, class T>
T largest(const Mat3<T> (&h)[N][N]) {
  T m = 0;
  for (const auto& row : h)
    for (const auto& block : row)
      for (const T e : block.e) m = std::fmax(m, std::fabs(e));
  return m;
}

template <std::size_t N, class T>
T largest_difference(const Mat3<T> (&a)[N][N], const Mat3<T> (&b)[N][N]) {
  Mat3<T> d[N][N];
  for (std::size_t i = 0; i < N; ++i)
    for (std::size_t j = 0; j < N; ++j) d[i][j] = a[i][j] - b[i][j];
  return largest(d);
}

}  // namespace weft::test
