#pragma once

#include <cstddef>

#include "host/solve/simd.hpp"
#include "weft/core/vec.hpp"

namespace weft::pcg {

/// Four vectors of three numbers, as they follow each other in memory.
template <class T>
struct FourVectors {
  using Vector = typename Simd<T>::Vector;
  Vector part[3];

  static FourVectors load(const T* from) noexcept {
    FourVectors four;
    std::memcpy(&four, from, sizeof four);
    return four;
  }
  static FourVectors all(const Vec3<T>& v) noexcept {
    return {{Vector{v[0], v[1], v[2], v[0]}, Vector{v[1], v[2], v[0], v[1]},
             Vector{v[2], v[0], v[1], v[2]}}};
  }
  void store(T* to) const noexcept { std::memcpy(to, this, sizeof *this); }
  FourVectors& operator+=(const FourVectors& other) noexcept {
    for (int k = 0; k < 3; ++k) part[k] += other.part[k];
    return *this;
  }
};

/// Sum of `count` vectors; the fourth number has no meaning.
template <class T>
typename Simd<T>::Vector sum_of(const Vec3<T>* vectors, std::size_t count) noexcept {
  typename Simd<T>::Vector sum{};
  for (std::size_t i = 0; i < count; ++i) sum += load_vector(vectors[i].e);
  return sum;
}

/// Adds the same to `count` vectors but those that are fixed.
template <class T>
void add_to_all(const Vec3<T>& by, const unsigned char* fixed, std::size_t count,
                Vec3<T>* vectors) noexcept {
  const auto fours = FourVectors<T>::all(by);
  std::size_t i = 0;
  for (; i + 4 <= count; i += 4) {
    std::uint32_t any;
    std::memcpy(&any, fixed + i, sizeof any);
    if (any == 0) {
      auto own = FourVectors<T>::load(vectors[i].e);
      own += fours;
      own.store(vectors[i].e);
    } else {
      for (std::size_t k = i; k < i + 4; ++k)
        if (fixed[k] == 0) vectors[k] += by;
    }
  }
  for (; i < count; ++i)
    if (fixed[i] == 0) vectors[i] += by;
}

}  // namespace weft::pcg
