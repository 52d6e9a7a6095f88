#include "host/io/assimp_import.hpp"

#include <assimp/scene.h>
#include <fcntl.h>

#include <assimp/Importer.hpp>

#include "host/io/assimp_files.hpp"
#include "host/io/safe_text.hpp"
#include "host/scene/file_descriptor.hpp"
#include "weft/error.hpp"

namespace weft::io {

const aiScene& import_with_assimp(Assimp::Importer& importer, const std::filesystem::path& path,
                                  unsigned steps, const ReadableFolders& folders,
                                  const std::string& what, const std::string& formats) {
  const std::string file = path.string();
  // For the message if the file is missing or no regular file; assimp has none worth showing.
  (void)open_regular_file(path, O_RDONLY, "read");
  if (path.extension().empty() || !importer.IsExtensionSupported(path.extension().string()))
    throw SceneError(file, "format", "\"" + path.extension().string() + "\"", formats);
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

}  // namespace weft::io
