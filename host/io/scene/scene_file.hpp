#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "host/io/json/experimental_paths.hpp"
#include "weft/scene.hpp"

/// Scene files: JSON with `//` comments, described by scenes/scene.schema.json.
namespace weft::io {

/// A scene and the document it comes from.
struct SceneFile {
  Scene scene;
  /// Every default filled in, overrides applied, mesh paths absolute: reading it gives the same
  /// scene. Resolution is written out as cells and subdivisions.
  nlohmann::json resolved;
  std::string device;  ///< for parse_devices(), as the scene asks; "auto" unless it does
  /// Below which all files lie that it names: what `resolved` needs to be read from elsewhere.
  std::vector<std::string> folders;
};

/// Reads and validates a scene.
/// @param overrides "path=value" each, as `--set` takes them: dotted path with numbers for places
///                  in lists, value as JSON or else as text
/// @param allowed   folders beside the scene's own that files which it names may lie below
/// @param experimental "path=value" each, as `--experimental` takes them: values that are no part
///                     of the schema
/// @throws SceneError, one line, for anything wrong in the scene, its meshes or the overrides
SceneFile read_scene_file(const std::filesystem::path& path,
                          const std::vector<std::string>& overrides = {},
                          const std::vector<std::string>& allowed = {},
                          const std::vector<std::string>& experimental = {});

/// "path=value" each, as `--set` and as `--experimental` take them.
struct Settings {
  std::vector<std::string> keys;
  std::vector<std::string> experimental;
};
Settings split_settings(const std::vector<std::string>& settings);

/// read_scene_file().scene
Scene read_scene(const std::filesystem::path& path, const std::vector<std::string>& overrides = {},
                 const std::vector<std::string>& allowed = {},
                 const std::vector<std::string>& experimental = {});

/// read_scene_file().resolved, to be written as DIR/scene.json
nlohmann::json resolved_scene_json(const std::filesystem::path& path,
                                   const std::vector<std::string>& overrides = {});

/// What the scene.json of a run says beside its cloths and obstacles: name, time, contact, method,
/// camera. Reads no other file.
/// @throws SceneError for anything wrong in these
Scene read_scene_settings(const std::filesystem::path& path);

}  // namespace weft::io
