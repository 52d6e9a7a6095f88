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
  const io::Settings split = io::split_settings(settings);
  return io::read_scene_file(path, split.keys, {}, split.experimental);
}

}  // namespace weft::bench
