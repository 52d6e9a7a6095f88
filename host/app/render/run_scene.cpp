#include "host/app/render/run_scene.hpp"

#include <fmt/format.h>

#include <cstdio>
#include <exception>

#include "host/base/file_operations.hpp"
#include "host/input/safe_text.hpp"
#include "host/io/scene/scene_file.hpp"
#include "weft/error.hpp"

namespace weft::app {

namespace fs = std::filesystem;

RunScene scene_of_run(const fs::path& input, const std::vector<std::string>& allowed) {
  const fs::path file = input / "scene.json";
  if (!is_there(file)) return {};
  std::string no_shapes;
  try {
    try {
      return {io::read_scene(file, {}, allowed), ""};
    } catch (const SceneError& e) {
      no_shapes = e.what();
    }
    return {io::read_scene_settings(file), no_shapes};
  } catch (const std::exception& e) {
    fmt::print(stderr, "weft: warning: without the scene's camera and names: {}\n",
               one_line(e.what()));
    return {};
  }
}

}  // namespace weft::app
