#include "host/app/run/scene_name.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <system_error>
#include <vector>

#include "host/base/file_operations.hpp"
#include "host/input/nearest_word.hpp"
#include "weft/error.hpp"

namespace weft::app {
namespace {

namespace fs = std::filesystem;

bool is_scene_file(const fs::path& path) {
  return is_there(path) && !is_folder(path);
}

/// Beside the installed program, or else those of the sources; empty: neither is there.
fs::path shipped_folder() {
  std::error_code error;
  const fs::path program = fs::read_symlink("/proc/self/exe", error);
  const fs::path installed = (program.parent_path() / WEFT_SCENES_FROM_BIN).lexically_normal();
  for (const fs::path& folder : {installed, fs::path(WEFT_SOURCE_SCENES)})
    if (is_scene_file(folder / "scene.schema.json")) return folder;
  return {};
}

std::vector<std::string> shipped_names(const fs::path& folder) {
  std::vector<std::string> names;
  for (const fs::path& file : files_in(folder))
    if (file.extension() == ".json" && file.stem().extension() != ".schema")
      names.push_back(file.stem().string());
  std::sort(names.begin(), names.end());
  return names;
}

}  // namespace

std::string find_scene(const std::string& given) {
  if (is_scene_file(given)) return given;
  if (const std::string file = given + ".json"; is_scene_file(file)) return file;
  const bool bare = given.find('/') == std::string::npos && !given.empty();
  const fs::path shipped = shipped_folder();
  std::string name = given;
  if (name.ends_with(".json")) name.erase(name.size() - 5);
  if (bare && !shipped.empty())
    if (const fs::path file = shipped / (name + ".json"); is_scene_file(file)) return file.string();

  const std::string what =
      nlohmann::json(given).dump(-1, ' ', true, nlohmann::json::error_handler_t::replace);
  std::string looked_for = is_folder(given) ? "a folder, no file" : "no file of that name";
  if (!given.ends_with(".json")) looked_for += ", nor with .json";
  if (bare && !shipped.empty()) looked_for += ", nor in " + shipped.string();
  const std::vector<std::string> names = shipped_names(shipped);
  throw SceneError("", "scene", what + " (" + looked_for + ")",
                   names.empty() ? std::string("the name of a scene file")
                                 : fmt::format("a scene file, or one of the shipped scenes: {}{}",
                                               fmt::join(names, ", "), did_you_mean(name, names)));
}

}  // namespace weft::app
