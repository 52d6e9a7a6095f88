#pragma once

#include <cstddef>
#include <cstring>

#include "host/exec/host_device.hpp"
#include "weft/core/ids.hpp"

// Without AVX the compiler says that it passes such vectors in another way. All of these functions
// are inlined.
#pragma GCC diagnostic ignored "-Wpsabi"

namespace weft::pcg {

/// One component of vectors side by side, as many as a register of 32 bytes holds.
template <class T>
struct Simd;

template <>
struct Simd<float> {
  static constexpr Index width = 8;
  using Values [[gnu::vector_size(32)]] = float;
  using Vector [[gnu::vector_size(16)]] = float;
};

template <>
struct Simd<double> {
  static constexpr Index width = 4;
  using Values [[gnu::vector_size(32)]] = double;
  using Vector = Values;
};

template <class T>
typename Simd<T>::Values load_values(const T* from) noexcept {
  typename Simd<T>::Values values;
  std::memcpy(&values, from, sizeof values);
  return values;
}

template <class Values, class T>
void store_values(const Values& values, T* to) noexcept {
  std::memcpy(to, &values, sizeof values);
}

/// A vector of three numbers, and a fourth of no meaning: one load instead of two or three.
template <class T>
typename Simd<T>::Vector load_vector(const T* from) noexcept {
#if defined(__SANITIZE_THREAD__)
  // The fourth belongs to a vector that may be on its way from another rank.
  using Vector = typename Simd<T>::Vector;
  return Vector{from[0], from[1], from[2], T(0)};
#else
  static_assert(sizeof(T) <= HostDevice::readable_beyond);
  typename Simd<T>::Vector vector;
  std::memcpy(&vector, from, sizeof vector);
  return vector;
#endif
}

/// The components of vectors.
template <class T>
struct SimdVectors {
  typename Simd<T>::Values x, y, z;
};

/// Vectors number at[0] to at[width - 1] of those whose numbers begin at `all`.
inline SimdVectors<float> gather_vectors(const float* all, const Index* at) noexcept {
  const auto vector = [&](int k) { return load_vector(all + std::ptrdiff_t{3} * at[k]); };
  // Vectors k and k + 4, then a transpose of four by four in either half.
  const auto pair = [&](int k) {
    return __builtin_shufflevector(vector(k), vector(k + 4), 0, 1, 2, 3, 4, 5, 6, 7);
  };
  const auto a = pair(0), b = pair(1), c = pair(2), d = pair(3);
  const auto ab_xy = __builtin_shufflevector(a, b, 0, 8, 1, 9, 4, 12, 5, 13);
  const auto ab_z = __builtin_shufflevector(a, b, 2, 10, 3, 11, 6, 14, 7, 15);
  const auto cd_xy = __builtin_shufflevector(c, d, 0, 8, 1, 9, 4, 12, 5, 13);
  const auto cd_z = __builtin_shufflevector(c, d, 2, 10, 3, 11, 6, 14, 7, 15);
  return {__builtin_shufflevector(ab_xy, cd_xy, 0, 1, 8, 9, 4, 5, 12, 13),
          __builtin_shufflevector(ab_xy, cd_xy, 2, 3, 10, 11, 6, 7, 14, 15),
          __builtin_shufflevector(ab_z, cd_z, 0, 1, 8, 9, 4, 5, 12, 13)};
}
inline SimdVectors<double> gather_vectors(const double* all, const Index* at) noexcept {
  const auto vector = [&](int k) { return load_vector(all + std::ptrdiff_t{3} * at[k]); };
  const auto a = vector(0), b = vector(1), c = vector(2), d = vector(3);
  const auto ab_xz = __builtin_shufflevector(a, b, 0, 4, 2, 6);
  const auto ab_y = __builtin_shufflevector(a, b, 1, 5, 3, 7);
  const auto cd_xz = __builtin_shufflevector(c, d, 0, 4, 2, 6);
  const auto cd_y = __builtin_shufflevector(c, d, 1, 5, 3, 7);
  return {__builtin_shufflevector(ab_xz, cd_xz, 0, 1, 4, 5),
          __builtin_shufflevector(ab_y, cd_y, 0, 1, 4, 5),
          __builtin_shufflevector(ab_xz, cd_xz, 2, 3, 6, 7)};
}

}  // namespace weft::pcg
