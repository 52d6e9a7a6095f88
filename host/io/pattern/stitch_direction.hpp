#pragma once

#include <string>
#include <vector>

#include "host/io/pattern/sewing_pattern.hpp"

namespace weft::io {

/// How the panels of a pattern come together.
struct StitchDirections {
  /// [stitches] true: the beginning of one side meets the end of the other
  std::vector<bool> opposite;
  /// [panels] true: the front is where the outline runs clockwise
  std::vector<bool> turned;
  std::vector<std::string> notes;  ///< a line for each stitch that differs from the file,
                                   ///< and for panels whose stitches are not sure
};

/// Chooses directions by where the panels stand: ends that meet must be near. The two sides of a
/// dart meet in the vertex that they share. Panels are then turned over until front meets front
/// along these stitches. Where ends do not tell clearly, panels that are turned over do, and else
/// the file. If front cannot meet front, or ends are farther apart in sum, all is as the file says.
/// @throws SceneError naming the stitch for which it cannot be
StitchDirections choose_directions(const SewingPattern& pattern);

}  // namespace weft::io
