#pragma once

#include <optional>

#include "host/render/picture_values.hpp"

/// Ends of a colour scale, from the values that it shows.
namespace weft::app {

struct Extent {
  double low = 0, high = 0;
};

/// The smallest and the largest finite value; nothing if there is none.
std::optional<Extent> extent_of(const io::CornerValues& values);

/// The 99.5th percentile of the finite values, so that a few torn triangles do not take the whole
/// scale.
/// @pre extent_of(values)
double torn_triangles_apart(const io::CornerValues& values);

/// Rounded up to two digits, so that a scale ends at a number that can be read.
double rounded_up(double value);

}  // namespace weft::app
