#pragma once

#include <string>
#include <vector>

#include "host/io/scene/scene_file.hpp"

namespace CLI {
class App;
}

namespace weft::app {

/// A scene that a command line names, and what it sets in it.
struct SceneRequest {
  std::string scene;                      ///< the file
  std::vector<std::string> overrides;     ///< "path=value" each
  std::vector<std::string> experimental;  ///< the same, but no keys of scenes
  std::vector<std::string> allowed;       ///< folders of files that the scene names, beside its own

  /// Adds `--set`, `--experimental` and `--allow-path`, each of which may be repeated.
  /// @param subcommand must not outlive this
  void add_options(CLI::App& subcommand);

  /// @throws SceneError for anything wrong in the scene
  Scene read() const;

  /// A command of this program: `words`, the settings and folders, and more settings of both kinds.
  std::vector<std::string> command(std::vector<std::string> words,
                                   const std::vector<std::string>& more = {}) const;
};

/// Values as words of a command of this program: `--experimental` before those that are no keys of
/// scenes, `--set` before the others.
std::vector<std::string> setting_words(const std::vector<std::string>& values);

}  // namespace weft::app
