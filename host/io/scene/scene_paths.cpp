#include <system_error>

#include "host/base/file_operations.hpp"
#include "host/io/scene/scene_parts.hpp"

namespace weft::io {
namespace {

namespace fs = std::filesystem;

/// Where a scene names a file that a package brings, what to install.
std::string package_hint(const fs::path& path) {
  return path.string().starts_with("/usr/share/assimp/models/")
             ? ", which the package assimp-testmodels of Debian and Ubuntu brings"
             : "";
}

}  // namespace

fs::path resolved_path(const Fields& fields, const fs::path& given) {
  const fs::path directory = fs::absolute(fs::path(fields.file())).parent_path();
  return (directory / given).lexically_normal();
}

fs::path read_path(Fields& fields, const std::string& key, const ReadableFolders& folders) {
  const fs::path given = fields.text(key);
  // The system ends a name at a NUL.
  if (given.empty() || given.native().find('\0') != std::string::npos)
    fields.refuse(key, "the name of a file");
  const fs::path path = resolved_path(fields, given);
  folders.require(path, fields.file(), fields.path_of(key));
  if (!is_there(path))
    fields.refuse(
        key, "the name of a file that is there; looked for " + path.string() + package_hint(path));
  fields.record(key, path.string());
  return path;
}

}  // namespace weft::io
