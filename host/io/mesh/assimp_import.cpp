#include "host/io/mesh/assimp_import.hpp"

#include <assimp/scene.h>
#include <fcntl.h>

#include <assimp/Importer.hpp>

#include "host/base/file_descriptor.hpp"
#include "host/input/safe_text.hpp"
#include "host/io/mesh/assimp_files.hpp"
#include "host/io/mesh/child_trial.hpp"
#include "weft/error.hpp"

namespace weft::io {

namespace {

/// @throws SceneError as import_with_assimp
const aiScene& read_with(Assimp::Importer& importer, const std::filesystem::path& path,
                         unsigned steps, const ReadableFolders& folders, const std::string& what) {
  const std::string file = path.string();
  auto* files = new AssimpFiles(path, folders);
  importer.SetIOHandler(files);  // which owns it from here on
  const aiScene* scene = importer.ReadFile(file, steps);
  if (!files->refusal().empty()) throw SceneError(files->refusal());
  if (!scene || !scene->mRootNode || !scene->HasMeshes()) {
    const std::string reason = one_line(importer.GetErrorString());
    throw SceneError(file + ": cannot read as " + what + ": " +
                     (reason.empty() ? "no mesh" : reason));
  }
  return *scene;
}

}  // namespace

const aiScene& import_with_assimp(Assimp::Importer& importer, const std::filesystem::path& path,
                                  unsigned steps, const ReadableFolders& folders,
                                  const std::string& what, const std::string& formats) {
  const std::string file = path.string();
  // For the message if the file is missing or no regular file; assimp has none worth showing.
  (void)open_regular_file(path, O_RDONLY, "read");
  if (path.extension().empty() || !importer.IsExtensionSupported(path.extension().string()))
    throw SceneError(file, "format", "\"" + path.extension().string() + "\"", formats);
  // It crashes on some damaged files, and on others it does not end.
  try_in_child(path, what, [&] {
    Assimp::Importer trial;
    read_with(trial, path, steps, folders, what);
  });
  return read_with(importer, path, steps, folders, what);
}

}  // namespace weft::io
