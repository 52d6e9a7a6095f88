#include "host/io/mesh/assimp_import.hpp"

#include <assimp/scene.h>
#include <fcntl.h>

#include <array>
#include <assimp/Importer.hpp>
#include <cstdint>
#include <fstream>
#include <string_view>

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

std::uint32_t little_endian(const unsigned char* bytes) {
  return static_cast<std::uint32_t>(bytes[0]) | static_cast<std::uint32_t>(bytes[1]) << 8 |
         static_cast<std::uint32_t>(bytes[2]) << 16 | static_cast<std::uint32_t>(bytes[3]) << 24;
}

/// Refuses binary glTF whose first chunk would go on after its end: assimp fills as much memory as
/// the chunk says, which takes seconds for gigabytes.
/// @throws SceneError
void refuse_cut_glb(const std::filesystem::path& path, const std::string& what) {
  std::ifstream in(path, std::ios::binary);
  std::array<unsigned char, 20> header{};  // of the file 12, of the chunk 8
  if (!in.read(reinterpret_cast<char*>(header.data()), header.size())) return;
  if (std::string_view(reinterpret_cast<char*>(header.data()), 4) != "glTF") return;
  const std::uint64_t chunk = little_endian(&header[12]);
  std::error_code error;
  const std::uintmax_t bytes = std::filesystem::file_size(path, error);
  if (error || header.size() + chunk <= bytes) return;
  throw SceneError(path.string() + ": cannot read as " + what + ": its first chunk has " +
                   std::to_string(chunk) + " bytes, of which the file has " +
                   std::to_string(bytes - header.size()));
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
  refuse_cut_glb(path, what);
  // It crashes on some damaged files, and on others it does not end.
  try_in_child(path, what, [&] {
    Assimp::Importer trial;
    read_with(trial, path, steps, folders, what);
  });
  return read_with(importer, path, steps, folders, what);
}

}  // namespace weft::io
