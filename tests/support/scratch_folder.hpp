#pragma once

#include <stdlib.h>

#include <filesystem>
#include <stdexcept>
#include <string>
#include <system_error>

namespace weft::test {

/// A folder that no other test or process has, removed at the end with all that is in it.
class ScratchFolder {
 public:
  /// @throws std::runtime_error if it cannot be made
  ScratchFolder() {
    std::string name = (std::filesystem::temp_directory_path() / "weft_XXXXXX").string();
    if (!::mkdtemp(name.data())) throw std::runtime_error("no folder " + name);
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

}  // namespace weft::test
