#pragma once

#include <filesystem>
#include <string>

#include "host/input/readable_folders.hpp"

struct aiScene;
namespace Assimp {
class Importer;
}

namespace weft::io {

/// Reads a file with assimp.
/// @param importer  owns the result
/// @param steps     aiProcess_* flags
/// @param folders   of the files that it names
/// @param what      "a mesh", for the message
/// @param formats   that are allowed, for the message
/// @return with a root node and at least one mesh
/// @throws SceneError if it cannot be read, or names a file that must not be
const aiScene& import_with_assimp(Assimp::Importer& importer, const std::filesystem::path& path,
                                  unsigned steps, const ReadableFolders& folders,
                                  const std::string& what, const std::string& formats);

}  // namespace weft::io
