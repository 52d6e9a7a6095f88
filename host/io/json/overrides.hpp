#pragma once

#include <nlohmann/json.hpp>
#include <string>

namespace weft::io {

/// The value of a `path=value` on the command line: JSON if it is JSON, else text.
/// @param file, path for messages
/// @throws SceneError for text that is not UTF-8
nlohmann::json override_value(const std::string& text, const std::string& file,
                              const std::string& path);

/// Sets one value of a scene that is not read yet, as `--set path=value` asks. The path is dotted,
/// with numbers for places in lists: `time.step=0.002`, `cloths.0.material=denim`. The value is
/// taken as JSON if it is JSON, else as text. Objects on the way are made; whether their keys exist
/// is found when the scene is read. `method=adaptive` is short for `method.type=adaptive`.
/// @param file for messages
/// @throws SceneError if there is no "=", or the path leads through a value that is no object or
///         list, or past the end of a list
void apply_override(nlohmann::json& scene, const std::string& override_text,
                    const std::string& file);

}  // namespace weft::io
