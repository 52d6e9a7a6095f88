#include "host/app/run/run_output.hpp"

#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <system_error>

#include "host/base/file_operations.hpp"
#include "weft/error.hpp"

namespace weft::app {

namespace fs = std::filesystem;

std::unique_ptr<RunLock> lock_existing(const RunDirectory& directory, const RunRequest& request) {
  if (!is_folder(directory.path())) return nullptr;
  auto lock = std::make_unique<RunLock>(directory.path());
  if (request.resume.empty() && !request.overwrite) directory.refuse_run();
  directory.refuse_links();
  return lock;
}

void refuse_unwritable(const std::string& file, const std::string& option,
                       const std::string& scene) {
  if (file.empty()) return;
  const fs::path path(file);
  if (std::error_code error; fs::equivalent(path, scene, error))
    throw SceneError("", option, "the scene", "another file");
  const fs::path parent = path.has_parent_path() ? path.parent_path() : fs::path(".");
  const char* reason = nullptr;
  if (is_folder(path))
    reason = "a directory";
  else if (is_there(path) ? ::access(path.c_str(), W_OK) != 0
                          : ::access(parent.c_str(), W_OK | X_OK) != 0)
    reason = std::strerror(errno);
  if (reason != nullptr)
    throw SceneError("", option, file + " (" + reason + ")", "a file that can be written");
}

}  // namespace weft::app
