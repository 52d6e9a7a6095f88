#include "host/geometry/mesh_groups.hpp"

#include <algorithm>
#include <cstddef>
#include <iterator>
#include <set>

namespace weft {
namespace {

/// Adds the vertices of the triangles with a label of this name.
/// @return whether there is such a label
bool add_labelled(const Mesh& mesh, const std::vector<Index>& labels,
                  const std::vector<std::string>& names, const std::string& name,
                  std::vector<Index>& vertices) {
  const auto found = std::find(names.begin(), names.end(), name);
  if (found == names.end()) return false;
  const auto number = static_cast<Index>(found - names.begin());
  for (std::size_t t = 0; t < labels.size(); ++t)
    if (labels[t] == number)
      vertices.insert(vertices.end(), std::begin(mesh.triangles[t].v),
                      std::end(mesh.triangles[t].v));
  return true;
}

}  // namespace

std::optional<std::vector<Index>> vertices_in_group(const Mesh& mesh, const std::string& name) {
  std::vector<Index> vertices;
  if (name.empty() || (!add_labelled(mesh, mesh.part, mesh.part_names, name, vertices) &&
                       !add_labelled(mesh, mesh.group, mesh.group_names, name, vertices)))
    return std::nullopt;
  std::sort(vertices.begin(), vertices.end());
  vertices.erase(std::unique(vertices.begin(), vertices.end()), vertices.end());
  return vertices;
}

std::vector<std::string> names_of_groups(const Mesh& mesh) {
  std::vector<std::string> names;
  std::set<std::string> taken{""};
  for (const auto* list : {&mesh.part_names, &mesh.group_names})
    for (const std::string& name : *list)
      if (taken.insert(name).second) names.push_back(name);
  return names;
}

}  // namespace weft
