#pragma once

#include <cmath>

#include "weft/core/hd.hpp"

namespace weft {

/// Column vector of N numbers. Aggregate: Vec3<double>{{x, y, z}} or Vec3<double>{x, y, z}.
template <class T, int N>
struct Vec {
  T e[N];

  WEFT_HD constexpr T& operator[](int i) noexcept { return e[i]; }
  WEFT_HD constexpr const T& operator[](int i) const noexcept { return e[i]; }

  WEFT_HD constexpr Vec& operator+=(const Vec& b) noexcept {
    for (int i = 0; i < N; ++i) e[i] += b.e[i];
    return *this;
  }
  WEFT_HD constexpr Vec& operator-=(const Vec& b) noexcept {
    for (int i = 0; i < N; ++i) e[i] -= b.e[i];
    return *this;
  }
  WEFT_HD constexpr Vec& operator*=(T s) noexcept {
    for (int i = 0; i < N; ++i) e[i] *= s;
    return *this;
  }
  WEFT_HD friend constexpr Vec operator+(Vec a, const Vec& b) noexcept { return a += b; }
  WEFT_HD friend constexpr Vec operator-(Vec a, const Vec& b) noexcept { return a -= b; }
  WEFT_HD friend constexpr Vec operator-(Vec a) noexcept {
    for (int i = 0; i < N; ++i) a.e[i] = -a.e[i];
    return a;
  }
  WEFT_HD friend constexpr Vec operator*(Vec a, T s) noexcept { return a *= s; }
  WEFT_HD friend constexpr Vec operator*(T s, Vec a) noexcept { return a *= s; }
  WEFT_HD friend constexpr bool operator==(const Vec& a, const Vec& b) noexcept {
    for (int i = 0; i < N; ++i)
      if (a.e[i] != b.e[i]) return false;
    return true;
  }
};

template <class T>
using Vec2 = Vec<T, 2>;
template <class T>
using Vec3 = Vec<T, 3>;
using Vec3f = Vec3<float>;
using Vec3d = Vec3<double>;

template <class T, int N>
WEFT_HD constexpr T dot(const Vec<T, N>& a, const Vec<T, N>& b) noexcept {
  T s = a[0] * b[0];
  for (int i = 1; i < N; ++i) s += a[i] * b[i];
  return s;
}

template <class T>
WEFT_HD constexpr Vec3<T> cross(const Vec3<T>& a, const Vec3<T>& b) noexcept {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

template <class T, int N>
WEFT_HD constexpr T length_sq(const Vec<T, N>& a) noexcept {
  return dot(a, a);
}

template <class T, int N>
WEFT_HD T length(const Vec<T, N>& a) noexcept {
  using std::sqrt;
  return sqrt(dot(a, a));
}

template <class To, class From, int N>
WEFT_HD constexpr Vec<To, N> vec_cast(const Vec<From, N>& a) noexcept {
  Vec<To, N> r{};
  for (int i = 0; i < N; ++i) r[i] = static_cast<To>(a[i]);
  return r;
}

}  // namespace weft
