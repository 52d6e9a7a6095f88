#include "host/app/output_folder.hpp"

#include "host/io/safe_text.hpp"

namespace weft::app {

std::filesystem::path output_folder(const std::string& asked, const std::string& scene_name) {
  if (!asked.empty()) return asked;
  return std::filesystem::path("out") / io::safe_file_name(scene_name);
}

}  // namespace weft::app
