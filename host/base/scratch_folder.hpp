#pragma once

#include <stdlib.h>

#include <filesystem>
#include <string>
#include <system_error>

#include "host/base/file_operations.hpp"

namespace weft {

/// A folder that no other process has, removed at the end with all that is in it.
class ScratchFolder {
 public:
  /// @throws SceneError if it cannot be made
  ScratchFolder() {
    std::string name = (std::filesystem::temp_directory_path() / "weft_XXXXXX").string();
    if (::mkdtemp(name.data()) == nullptr) fail_on(name, "create");
    path_ = name;
  }
  ~ScratchFolder() {
    std::error_code ignored;
    if (!kept_) std::filesystem::remove_all(path_, ignored);
  }
  ScratchFolder(const ScratchFolder&) = delete;
  ScratchFolder& operator=(const ScratchFolder&) = delete;

  const std::filesystem::path& path() const { return path_; }
  /// Leaves it on the disk, for whoever looks at a failure.
  void keep() { kept_ = true; }

 private:
  std::filesystem::path path_;
  bool kept_ = false;
};

inline std::filesystem::path operator/(const ScratchFolder& folder,
                                       const std::filesystem::path& name) {
  return folder.path() / name;
}

}  // namespace weft
