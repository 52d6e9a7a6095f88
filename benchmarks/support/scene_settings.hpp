#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "host/io/scene/scene_file.hpp"

namespace weft::bench {

/// Reads a scene for a benchmark, whose `--set` takes the values for comparisons too that `weft`
/// takes by `--experimental` alone.
/// @param settings "path=value" each
/// @throws SceneError as io::read_scene_file() does
inline io::SceneFile read_scene_file(const std::filesystem::path& path,
                                     const std::vector<std::string>& settings) {
  std::vector<std::string> keys, experimental;
  for (const std::string& text : settings)
    (io::is_experimental(text.substr(0, text.find('='))) ? experimental : keys).push_back(text);
  return io::read_scene_file(path, keys, {}, experimental);
}

}  // namespace weft::bench
