#include "host/app/run/output_folder.hpp"

#include "host/input/safe_text.hpp"

namespace weft::app {

std::filesystem::path output_folder(const std::string& asked, const std::string& scene_name) {
  if (!asked.empty()) return asked;
  return std::filesystem::path("out") / safe_file_name(scene_name);
}

}  // namespace weft::app
