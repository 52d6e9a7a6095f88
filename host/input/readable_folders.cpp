#include "host/input/readable_folders.hpp"

#include <algorithm>
#include <optional>
#include <system_error>

#include "weft/error.hpp"

namespace weft {
namespace {

namespace fs = std::filesystem;

/// Of the package assimp-testmodels, which shipped scenes use.
constexpr const char* sample_models = "/usr/share/assimp/models";

/// Absolute, with all symbolic links followed.
/// @return nothing if that cannot be told
std::optional<fs::path> real_path(const fs::path& path) {
  // The system ends a name at a NUL; the rest would not be looked at.
  if (path.native().find('\0') != std::string::npos) return {};
  std::error_code error;
  fs::path real = fs::weakly_canonical(fs::absolute(path, error), error);
  if (error) return {};
  return real;
}

bool is_below(const fs::path& path, const fs::path& folder) {
  return std::mismatch(folder.begin(), folder.end(), path.begin(), path.end()).first ==
         folder.end();
}

}  // namespace

ReadableFolders::ReadableFolders(const fs::path& file, const std::vector<std::string>& allowed) {
  add(fs::absolute(file).parent_path());
  for (const std::string& folder : allowed) {
    std::error_code error;
    if (!fs::is_directory(folder, error))
      throw SceneError("", "--allow-path", folder, "a folder that is there");
    add(folder);
  }
}

void ReadableFolders::add(const fs::path& folder) {
  // One that cannot be told stands for itself alone, and holds no file that is there.
  folders_.push_back(real_path(folder).value_or(folder));
}

bool ReadableFolders::contain(const fs::path& path) const {
  const auto real = real_path(path);
  return real && (is_below(*real, sample_models) ||
                  std::any_of(folders_.begin(), folders_.end(),
                              [&](const fs::path& folder) { return is_below(*real, folder); }));
}

void ReadableFolders::require(const fs::path& path, const std::string& file,
                              const std::string& field) const {
  if (contain(path)) return;
  std::string allowed = "files below ";
  for (std::size_t k = 0; k < folders_.size(); ++k)
    allowed += (k > 0 ? " or " : "") + folders_[k].string();
  const auto real = real_path(path);
  throw SceneError(file, field, path.string(),
                   allowed + "; --allow-path " + (real ? real->parent_path().string() : "DIR") +
                       " allows another folder");
}

}  // namespace weft
