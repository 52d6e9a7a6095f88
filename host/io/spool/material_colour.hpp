#pragma once

#include <cstddef>
#include <iterator>

#include "weft/core/vec.hpp"

namespace weft::io {

/// A colour, linear RGB, so that materials can be told apart before anybody shades them.
/// @param number of the material
inline Vec3<double> material_colour(std::size_t number) {
  constexpr Vec3<double> palette[] = {{0.55, 0.62, 0.78}, {0.80, 0.55, 0.45}, {0.52, 0.70, 0.52},
                                      {0.78, 0.72, 0.48}, {0.66, 0.54, 0.74}, {0.50, 0.70, 0.72}};
  return palette[number % std::size(palette)];
}

}  // namespace weft::io
