#include "host/app/run/frame_parts.hpp"

#include <cstddef>
#include <numeric>
#include <string>
#include <utility>
#include <vector>

#include "host/io/mesh/split_objects.hpp"

namespace weft::app {
namespace {

using io::NamedMesh;

constexpr Index nowhere = -1;

std::size_t place(Index i) {
  return static_cast<std::size_t>(i);
}

/// @param piece [vertices] number of the part that a vertex belongs to, or nowhere
/// @param parts empty meshes with their names
std::vector<NamedMesh> distributed(const Mesh& mesh, const std::vector<Index>& piece,
                                   std::vector<NamedMesh> parts) {
  const bool uv_by_vertex =
      mesh.material_triangles.empty() && mesh.material.size() == mesh.positions.size();
  std::vector<Index> number(mesh.positions.size());
  for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
    if (piece[v] == nowhere) continue;
    Mesh& part = parts[place(piece[v])].mesh;
    number[v] = static_cast<Index>(part.positions.size());
    part.positions.push_back(mesh.positions[v]);
    if (uv_by_vertex) part.material.push_back(mesh.material[v]);
  }
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const Index* t = mesh.triangles[i].v;
    Mesh& part = parts[place(piece[place(t[0])])].mesh;
    part.triangles.push_back({{number[place(t[0])], number[place(t[1])], number[place(t[2])]}});
    if (uv_by_vertex || mesh.material_triangles.empty()) continue;
    // Corners with material coordinates of their own: three for each triangle.
    const auto first = static_cast<Index>(part.material.size());
    for (const Index m : mesh.material_triangles[i].v)
      part.material.push_back(mesh.material[place(m)]);
    part.material_triangles.push_back({{first, first + 1, first + 2}});
  }
  return parts;
}

/// Whether no triangle has corners in two parts.
bool keeps_triangles(const Mesh& mesh, const std::vector<Index>& piece) {
  for (const Tri& t : mesh.triangles)
    if (piece[place(t.v[0])] != piece[place(t.v[1])] ||
        piece[place(t.v[0])] != piece[place(t.v[2])])
      return false;
  return true;
}

/// Parts of the scene, of `list`, in whose order a run writes them.
/// @return false if they do not fit
template <class T>
bool part_by_scene(std::vector<NamedMesh>& meshes, const std::vector<T>& list) {
  if (meshes.size() != 1 || list.empty()) return false;
  std::vector<Index> piece;
  std::vector<NamedMesh> parts;
  for (const T& entry : list) {
    piece.insert(piece.end(), entry.mesh.positions.size(), static_cast<Index>(parts.size()));
    parts.push_back({entry.name, {}});
  }
  const Mesh& mesh = meshes.front().mesh;
  if (piece.size() != mesh.positions.size() || !keeps_triangles(mesh, piece)) return false;
  meshes = distributed(mesh, piece, std::move(parts));
  return true;
}

/// Objects of a file that names them.
/// @return false if it does not
bool part_by_objects(std::vector<NamedMesh>& meshes, bool joined) {
  if (!joined) return false;  // groups are materials
  if (meshes.size() != 1) return false;
  const Mesh& mesh = meshes.front().mesh;
  const std::vector<std::string>& names =
      mesh.object_names.empty() ? mesh.group_names : mesh.object_names;
  const bool one = names.size() == 1 && !names.front().empty();
  std::vector<NamedMesh> parts = io::split_objects(meshes.front());
  if (parts.size() < 2 && !one) return false;
  meshes = std::move(parts);
  return true;
}

Index root_of(std::vector<Index>& parent, Index v) {
  while (parent[place(v)] != v) {
    parent[place(v)] = parent[place(parent[place(v)])];
    v = parent[place(v)];
  }
  return v;
}

/// Each connected piece a mesh, in the order of their first triangles.
void part_by_components(std::vector<NamedMesh>& meshes) {
  const Mesh& mesh = meshes.front().mesh;
  std::vector<Index> parent(mesh.positions.size());
  std::iota(parent.begin(), parent.end(), Index{0});
  for (const Tri& t : mesh.triangles)
    for (int k = 1; k < 3; ++k) parent[place(root_of(parent, t.v[k]))] = root_of(parent, t.v[0]);
  std::vector<Index> number(parent.size(), nowhere), piece(parent.size(), nowhere);
  std::vector<NamedMesh> parts;
  for (const Tri& t : mesh.triangles) {
    Index& n = number[place(root_of(parent, t.v[0]))];
    if (n != nowhere) continue;
    n = static_cast<Index>(parts.size());
    parts.push_back({"cloth_" + std::to_string(n), {}});
  }
  for (std::size_t v = 0; v < parent.size(); ++v)
    piece[v] = number[place(root_of(parent, static_cast<Index>(v)))];
  meshes = distributed(mesh, piece, std::move(parts));
}

}  // namespace

io::FrameMeshes parted(io::FrameMeshes meshes, const Scene* scene) {
  const bool known = scene != nullptr && part_by_scene(meshes.cloths, scene->cloths);
  if (!known && !part_by_objects(meshes.cloths, meshes.joined) && meshes.cloths.size() == 1)
    part_by_components(meshes.cloths);
  if (scene == nullptr || !part_by_scene(meshes.obstacles, scene->obstacles))
    part_by_objects(meshes.obstacles, meshes.joined);
  return meshes;
}

}  // namespace weft::app
