#pragma once

#include <optional>
#include <string>
#include <vector>

#include "weft/scene.hpp"

namespace weft {

/// The vertices of the triangles in a group or a part of a mesh.
/// @return numbers in increasing order, none if no triangle is in it; nothing: no such name
std::optional<std::vector<Index>> vertices_in_group(const Mesh& mesh, const std::string& name);

/// Names of the groups and parts of a mesh, each once, without empty ones.
std::vector<std::string> names_of_groups(const Mesh& mesh);

}  // namespace weft
