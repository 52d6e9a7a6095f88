#include "host/app/run/output_folder.hpp"

#include <system_error>

#include "host/base/file_operations.hpp"
#include "host/input/safe_text.hpp"
#include "weft/error.hpp"

namespace weft::app {

std::filesystem::path output_folder(const std::string& asked, const std::string& scene_name) {
  if (!asked.empty()) return asked;
  return std::filesystem::path("out") / safe_file_name(scene_name);
}

void make_output_folder(const std::filesystem::path& path, const std::string& option) {
  std::error_code error;
  std::filesystem::create_directories(path, error);
  if (error || !is_folder(path))
    throw SceneError(path.string(), option, error ? error.message() : "no directory",
                     "a directory that can be made and written");
}

}  // namespace weft::app
