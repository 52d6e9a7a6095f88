#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "weft/scene.hpp"

namespace weft::app {

/// What is known of the scene of a run.
struct RunScene {
  std::optional<Scene> scene;  ///< nothing where its scene.json is missing or broken
  /// Why its cloths and obstacles are not known, which are files elsewhere; empty: they are.
  std::string no_shapes;
};

/// Reads scene.json of a run, and warns in a line where it cannot be read.
/// @param input   directory of a run, or anything else that holds frames: then no scene is known
/// @param allowed folders of files that the scene names, beside its own
RunScene scene_of_run(const std::filesystem::path& input, const std::vector<std::string>& allowed);

}  // namespace weft::app
