#pragma once

#include <string>
#include <vector>

#include "weft/scene.hpp"

namespace weft::app {

/// How far leaving out bending would move the cloth.
struct BendingError {
  bool known = false;
  double error = 0;  ///< over the diagonal, if known
  std::string how;   ///< one line: where the figure comes from, or why there is none
};

/// By a chart of the scene that has a point without bending: the whole error of that point. Else by
/// runs of all frames with and without it, at two reduced sizes of the mesh: how far they differ at
/// the finer one, and by as much more as the two sizes differ. Nothing is known where a run fails
/// or takes longer than a minute, or where the mesh cannot be had smaller and is not small.
/// @param file      of the scene
/// @param overrides of the scene's values
/// @param chart     a chart.json, its directory, or empty
/// @throws SceneError if the chart cannot be read or the runs have no place to be written to
BendingError bending_error(const Scene& scene, const std::string& file,
                           const std::vector<std::string>& overrides, const std::string& chart);

}  // namespace weft::app
