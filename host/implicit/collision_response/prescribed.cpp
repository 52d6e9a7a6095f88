#include "host/implicit/collision_response/prescribed.hpp"

#include <cstddef>
#include <set>

namespace weft {
namespace {

/// Most names on a line.
constexpr std::size_t names_max = 4;

/// The obstacle of vertex v; null: it is of a cloth.
const Obstacle* obstacle_of(const Scene& scene, const Model& model, Index v) {
  if (v < model.cloth_vertex_count) return nullptr;
  const Index number =
      model.obstacle_of_vertex[static_cast<std::size_t>(v - model.cloth_vertex_count)];
  return &scene.obstacles[static_cast<std::size_t>(number)];
}

}  // namespace

std::string prescribed_names(const Scene& scene, const Model& model,
                             const std::vector<Index>& vertices) {
  std::set<std::string> names;
  for (const Index v : vertices) {
    if (const Obstacle* obstacle = obstacle_of(scene, model, v))
      names.insert(obstacle->name);
    else
      names.insert(
          "a pin of " +
          scene.cloths[static_cast<std::size_t>(model.cloth_of_vertex[static_cast<std::size_t>(v)])]
              .name);
  }
  std::string text;
  std::size_t count = 0;
  for (const std::string& name : names) {
    if (++count > names_max) return text + " and others";
    text += (text.empty() ? "" : ", ") + name;
  }
  return text;
}

}  // namespace weft
