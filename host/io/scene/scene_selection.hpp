#pragma once

#include <optional>
#include <string>
#include <vector>

#include "host/io/scene/scene_parts.hpp"

/// Which vertices an entry of "pins", "handles" or "seams" means. All throw SceneError.
namespace weft::io {

/// The cloths that a name stands for: all copies of an entry of "cloths", or one of them.
struct NamedCloths {
  const ClothGroup* group = nullptr;
  Index first = 0;  ///< into Scene::cloths
  Index count = 0;
};

/// @param name  as the scene gives it
/// @param field, key where it stands, for messages
NamedCloths named_cloths(const Fields& fields, const std::string& key, const std::string& name,
                         const std::vector<ClothGroup>& groups, const Scene& scene);

/// named_cloths() for the value of the key "cloth".
NamedCloths read_named_cloths(Fields& fields, const std::vector<ClothGroup>& groups,
                              const Scene& scene);

/// A named edge of a cloth, or a part of it.
struct EdgePart {
  const ClothEdge* edge = nullptr;
  double from = 0;           ///< [m] along the edge, where it starts in the world
  std::optional<double> to;  ///< [m] nothing: its end
};

/// The value of the key "edge".
EdgePart read_edge_part(Fields& fields, const NamedCloths& cloths);

/// Lengths from the first vertex of an edge to each of them, and around it if it is closed. [m]
/// @return [vertices], one more if it is closed
std::vector<double> lengths_along(const Mesh& mesh, const ClothEdge& edge);

/// vertices, corners, edge, box, group
std::vector<std::string> selection_keys();

/// Which vertices are meant in each of the cloths.
/// @param key which of selection_keys() is there
/// @return [cloths.count] numbers of vertices; with a box some may be empty, but not all
std::vector<std::vector<Index>> read_selection(Fields& fields, const std::string& key,
                                               const NamedCloths& cloths, const Scene& scene);

}  // namespace weft::io
