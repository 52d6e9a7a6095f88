#include <atomic>
#include <cstdint>
#include <initializer_list>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "host/geometry/mesh_groups.hpp"
#include "host/input/checker.hpp"
#include "host/scene/part_check.hpp"
#include "host/scene/required_fabric.hpp"
#include "weft/core/at.hpp"
#include "weft/error.hpp"
#include "weft/scene.hpp"

namespace weft {
namespace {

template <class Part>
Id<Part> append(Part part, const char* kind, std::vector<Part>& list, const Scene& scene) {
  if (part.name.empty()) part.name = kind + (" " + std::to_string(list.size()));
  list.push_back(std::move(part));
  return {static_cast<Index>(list.size() - 1), scene.identity.number()};
}

}  // namespace

SceneIdentity::SceneIdentity() {
  static std::atomic<std::uint64_t> last{0};
  number_ = ++last;
}

MaterialId Scene::add(Material material) {
  return append(std::move(material), "material", materials, *this);
}

ClothId Scene::add(Cloth cloth) {
  return append(std::move(cloth), "cloth", cloths, *this);
}

ObstacleId Scene::add(Obstacle obstacle) {
  // A body has no pattern; a file may have one, with seams that mean nothing here.
  obstacle.mesh.material.clear();
  obstacle.mesh.material_triangles.clear();
  return append(std::move(obstacle), "obstacle", obstacles, *this);
}

PinId Scene::add(Pin pin) {
  pins.push_back(std::move(pin));
  return {static_cast<Index>(pins.size() - 1), identity.number()};
}

PinId Scene::pin(ClothId cloth, std::vector<Index> vertices) {
  refuse_foreign(*this, cloth, cloths.size(), "cloths");
  Pin pin;
  pin.cloth = cloth;
  pin.vertices = std::move(vertices);
  return add(std::move(pin));
}

PinId Scene::pin(ClothId cloth, std::initializer_list<Index> vertices) {
  return pin(cloth, std::vector<Index>(vertices));
}

PinId Scene::pin(ClothId cloth, const VertexGroup& group) {
  refuse_foreign(*this, cloth, cloths.size(), "cloths");
  const Mesh& mesh = cloths[at(cloth.index)].mesh;
  std::optional<std::vector<Index>> vertices = vertices_in_group(mesh, group.name);
  if (!vertices) {
    std::string names;
    for (const std::string& known : names_of_groups(mesh))
      names += (names.empty() ? "" : ", ") + known;
    throw SceneError(file, numbered("cloths", at(cloth.index)) + " group", "\"" + group.name + "\"",
                     names.empty() ? "a mesh with groups" : names);
  }
  return pin(cloth, std::move(*vertices));
}

Material fabric(const std::string& name) {
  Material material = required_fabric(name, "fabric").material;
  material.name = name;
  return material;
}

}  // namespace weft
