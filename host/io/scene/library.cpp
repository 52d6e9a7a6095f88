#include <algorithm>
#include <cstddef>
#include <utility>

#include "host/io/animation/mesh_sequence.hpp"
#include "host/io/mesh/mesh_file.hpp"
#include "host/io/mesh/split_objects.hpp"
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

std::vector<int> frame_numbers(const std::filesystem::path& run) {
  return io::open_sequence(run)->frames();
}

std::vector<FrameMesh> load_frame(const std::filesystem::path& run, int number) {
  const auto sequence = io::open_sequence(run);
  const std::vector<int>& numbers = sequence->frames();
  const auto found = std::lower_bound(numbers.begin(), numbers.end(), number);
  if (found == numbers.end() || *found != number)
    throw SceneError(run.string(), "frame", std::to_string(number),
                     "one of the " + std::to_string(numbers.size()) + " frames from " +
                         std::to_string(numbers.front()) + " to " + std::to_string(numbers.back()));
  io::FrameMeshes frame =
      io::in_world(sequence->read(static_cast<std::size_t>(found - numbers.begin())));
  std::vector<FrameMesh> meshes;
  for (const bool obstacle : {false, true})
    for (io::NamedMesh& joined : obstacle ? frame.obstacles : frame.cloths) {
      std::vector<io::NamedMesh> own;
      if (frame.joined)
        own = io::split_objects(std::move(joined));
      else
        own.push_back(std::move(joined));
      for (io::NamedMesh& mesh : own)
        meshes.push_back({std::move(mesh.name), obstacle, std::move(mesh.mesh)});
    }
  return meshes;
}

Scene load_scene(const std::filesystem::path& file, const std::vector<std::string>& overrides) {
  return io::read_scene(file, overrides);
}

}  // namespace weft
