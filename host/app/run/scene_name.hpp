#pragma once

#include <string>

namespace weft::app {

/// The file of a scene that a command line names: the file itself, or else with ".json" behind it,
/// or else a shipped scene of that name, for names without a folder.
/// @throws SceneError with what was looked for, and the shipped scenes, nearest name first
std::string find_scene(const std::string& given);

}  // namespace weft::app
