#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "host/geometry/aabb.hpp"

/// Numbers as the few bytes that a page holds them in.
namespace weft::app {

/// Number of steps that a side of the box has that positions are stored relative to.
inline constexpr int position_steps = 65535;

/// [m] The largest by which a stored coordinate differs from the true one.
double largest_error(const Aabb& box);

/// Appends 16 bits per coordinate, little endian: the nearest of the box's steps. Positions outside
/// of the box go to its surface.
void append_positions(std::string& bytes, const std::vector<Vec3<double>>& positions,
                      const Aabb& box);

/// A stored coordinate; the page computes the same.
inline double stored_coordinate(std::uint16_t step, double low, double high) {
  return low + (high - low) * step / position_steps;
}

/// Level of what is no number.
inline constexpr int no_level = 255;

/// Appends 8 bits per value: 0 for `low` and less, 254 for `high` and more, no_level for NaN.
/// @pre low < high
void append_levels(std::string& bytes, const std::vector<float>& values, double low, double high);

/// RFC 4648, with padding.
std::string base64(std::string_view bytes);

}  // namespace weft::app
