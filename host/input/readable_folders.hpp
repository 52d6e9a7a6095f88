#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace weft {

/// Where files may lie that another file names: below the folder of that file, below folders that
/// the user allows, and below the sample models that a package installs. Symbolic links count as
/// what they lead to.
class ReadableFolders {
 public:
  /// @param file    that names others, such as a scene
  /// @param allowed further folders, as `--allow-path` gives them
  /// @throws SceneError if one of these is no folder
  explicit ReadableFolders(const std::filesystem::path& file,
                           const std::vector<std::string>& allowed = {});

  /// Allows one more.
  void add(const std::filesystem::path& folder);

  /// In the order in which they were given, symbolic links followed; at least one.
  const std::vector<std::filesystem::path>& folders() const { return folders_; }

  /// Whether a file lies below one of the folders. A missing file counts by where it would lie.
  bool contain(const std::filesystem::path& path) const;

  /// @param path  that is to be read
  /// @param file  that names it
  /// @param field where
  /// @throws SceneError unless contain()
  void require(const std::filesystem::path& path, const std::string& file,
               const std::string& field) const;

 private:
  std::vector<std::filesystem::path> folders_;
};

}  // namespace weft
