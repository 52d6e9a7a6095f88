#pragma once

#include <limits>

#include "weft/core/hd.hpp"

namespace weft {

/// Distance from 1 to the next larger T: twice the largest relative error of one rounding.
template <class T>
inline constexpr T epsilon = std::numeric_limits<T>::epsilon();

/// Smallest T with full precision; below it relative error bounds do not hold.
template <class T>
inline constexpr T smallest_normal = std::numeric_limits<T>::min();

/// The lesser of two numbers, b if either is NaN. One instruction, where fmin is a call.
template <class T>
WEFT_HD constexpr T lesser(T a, T b) noexcept {
  return a < b ? a : b;
}

/// The greater of two numbers, b if either is NaN. One instruction, where fmax is a call.
template <class T>
WEFT_HD constexpr T greater(T a, T b) noexcept {
  return a > b ? a : b;
}

}  // namespace weft
