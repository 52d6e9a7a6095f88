#include "host/io/mesh/mesh_file.hpp"
#include "host/io/scene/scene_file.hpp"
#include "host/io/usd/surface_file.hpp"
#include "weft/error.hpp"
#include "weft/io.hpp"

namespace weft {

Mesh load_mesh(const std::filesystem::path& file) {
  return io::read_surface(file, io::Uv::material, ReadableFolders(file));
}

void save_mesh(const std::filesystem::path& file, const Mesh& mesh) {
  const std::vector<io::NamedMesh> meshes{{file.stem().string(), mesh}};
  if (file.extension() == ".obj") return io::write_obj(file, meshes);
  if (file.extension() == ".ply") return io::write_ply(file, meshes);
  throw SceneError(file.string(), "format", "\"" + file.extension().string() + "\"", ".obj, .ply");
}

Scene load_scene(const std::filesystem::path& file, const std::vector<std::string>& overrides) {
  return io::read_scene(file, overrides);
}

}  // namespace weft
