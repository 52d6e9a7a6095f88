#include "host/app/run/run_output.hpp"

#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <system_error>

#include "weft/error.hpp"

namespace weft::app {

namespace fs = std::filesystem;

std::unique_ptr<RunLock> lock_existing(const RunDirectory& directory, const RunRequest& request) {
  std::error_code error;
  if (!fs::is_directory(directory.path(), error)) return nullptr;
  auto lock = std::make_unique<RunLock>(directory.path());
  if (request.resume.empty() && !request.overwrite) directory.refuse_run();
  directory.refuse_links();
  return lock;
}

void refuse_unwritable(const std::string& file, const std::string& option) {
  if (file.empty()) return;
  std::error_code error;
  const fs::path path(file);
  const fs::path parent = path.has_parent_path() ? path.parent_path() : fs::path(".");
  const char* reason = nullptr;
  if (fs::is_directory(path, error))
    reason = "a directory";
  else if (fs::exists(path, error) ? ::access(path.c_str(), W_OK) != 0
                                   : ::access(parent.c_str(), W_OK | X_OK) != 0)
    reason = std::strerror(errno);
  if (reason != nullptr)
    throw SceneError("", option, file + " (" + reason + ")", "a file that can be written");
}

}  // namespace weft::app
