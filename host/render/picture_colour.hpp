#pragma once

#include <cstdint>

#include "weft/core/vec.hpp"

/// Numbers as colours.
namespace weft::io {

/// Colour map from dark violet through blue and green to light yellow, made in Oklab (Ottosson
/// 2020): lightness rises evenly, and so equal steps of the number look equally far apart; it holds
/// in print without colour and for the colour-blind.
/// @param t place on the map, clamped to 0..1; not a number: grey
/// @return sRGB, each channel 0..1
Vec3<float> colour_of(float t);

/// Oklab lightness of an sRGB colour, 0..1.
float lightness(const Vec3<float>& srgb);

/// Rounds to 0..255.
Vec<std::uint8_t, 3> bytes_of(const Vec3<float>& srgb);

namespace shading {

/// Filmic tone curve with a toe and a shoulder (Narkowicz 2015), from light to the share of white.
inline float filmic(float x) {
  return x * (2.51f * x + 0.03f) / (x * (2.43f * x + 0.59f) + 0.14f);
}

/// Light that the tone curve and a gamma of 2.2 turn into colour_of(t).
Vec3<float> mapped_light(float t);

}  // namespace shading
}  // namespace weft::io
