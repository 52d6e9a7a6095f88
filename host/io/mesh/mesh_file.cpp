#include "host/io/mesh/mesh_file.hpp"
#include "host/base/file_extension.hpp"

#include <algorithm>
#include <charconv>
#include <system_error>

#include "host/base/atomic_file.hpp"
#include "host/base/file_bytes.hpp"
#include "host/geometry/local_origin.hpp"
#include "host/io/mesh/mesh_formats.hpp"

namespace weft::io {
namespace {

template <class Number>
bool parse_whole(std::string_view token, Number& value) {
  if (token.size() > 1 && token[0] == '+' && token[1] != '-') token.remove_prefix(1);
  const char* end = token.data() + token.size();
  const auto [stop, error] = std::from_chars(token.data(), end, value);
  return error == std::errc() && stop == end;
}

}  // namespace

bool parse_number(std::string_view token, double& value) {
  return parse_whole(token, value);
}
bool parse_number(std::string_view token, long long& value) {
  return parse_whole(token, value);
}

bool has_panels(const Mesh& mesh) {
  return !mesh.part.empty() && (mesh.part_names.size() > 1 || !mesh.part_labels.empty());
}

void take_panel_labels(const std::map<std::string, std::string>& labels, Mesh& mesh) {
  const bool any = std::any_of(mesh.group_names.begin(), mesh.group_names.end(),
                               [&](const std::string& name) { return labels.contains(name); });
  if (!any || !mesh.part.empty()) return;
  mesh.part = mesh.group;
  mesh.part_names = mesh.group_names;
  for (const std::string& name : mesh.part_names) {
    const auto found = labels.find(name);
    mesh.part_labels.push_back(found == labels.end() ? std::string() : found->second);
  }
}

void move_origin(Mesh& mesh, const Vec3<double>& from, const Vec3<double>& to) {
  weft::move_origin(mesh.positions, from, to);
}

void move_origin(FrameMeshes& meshes, const Vec3<double>& to) {
  for (auto* list : {&meshes.cloths, &meshes.obstacles, &meshes.displaced})
    for (NamedMesh& mesh : *list) move_origin(mesh.mesh, meshes.origin, to);
  meshes.origin = to;
}

Vec3<double> local_origin(const FrameMeshes& first) {
  if (first.origin != Vec3<double>{0, 0, 0}) return first.origin;
  std::vector<const std::vector<Vec3<double>>*> positions;
  for (const NamedMesh& mesh : first.cloths.empty() ? first.obstacles : first.cloths)
    positions.push_back(&mesh.mesh.positions);
  return weft::local_origin(positions);
}

FrameMeshes in_world(FrameMeshes meshes) {
  move_origin(meshes, {0, 0, 0});
  return meshes;
}

Mesh read_mesh(const std::filesystem::path& path, Uv uv, const ReadableFolders& folders,
               std::vector<std::string>* warnings) {
  const std::string extension = lower_extension(path);
  if (extension == ".obj") return parse_obj(read_file_bytes(path), path.string(), uv, warnings);
  if (extension == ".ply") return parse_ply(read_file_bytes(path), path.string(), uv);
  return read_with_assimp(path, uv, folders);
}

void drop_incomplete_material(Mesh& mesh) {
  const auto& corners = mesh.material_triangles;
  if (std::none_of(corners.begin(), corners.end(), [](const Tri& t) { return t.v[0] < 0; })) return;
  mesh.material.clear();
  mesh.material_triangles.clear();
}

Mesh joined(const std::vector<NamedMesh>& meshes) {
  Mesh all;
  bool with_material = !meshes.empty();
  bool with_corners = false;  // of their own in material space
  for (const auto& [name, mesh] : meshes) {
    with_material = with_material && !mesh.material.empty();
    with_corners = with_corners || !mesh.material_triangles.empty();
  }
  const auto add = [](std::vector<Tri>& to, const std::vector<Tri>& from, std::size_t offset) {
    const auto first = static_cast<Index>(offset);
    for (const Tri& t : from) to.push_back(Tri{{t.v[0] + first, t.v[1] + first, t.v[2] + first}});
  };
  for (const auto& [name, mesh] : meshes) {
    add(all.triangles, mesh.triangles, all.positions.size());
    all.positions.insert(all.positions.end(), mesh.positions.begin(), mesh.positions.end());
    if (!with_material) continue;
    if (with_corners)
      add(all.material_triangles,
          mesh.material_triangles.empty() ? mesh.triangles : mesh.material_triangles,
          all.material.size());
    all.material.insert(all.material.end(), mesh.material.begin(), mesh.material.end());
  }
  return all;
}

void write_obj(const std::filesystem::path& path, const std::vector<NamedMesh>& meshes,
               Normals normals, Groups groups, const SeamEdges& seams) {
  write_file_atomically(path, format_obj(meshes, normals, groups, seams), Durability::none);
}

void write_ply(const std::filesystem::path& path, const std::vector<NamedMesh>& meshes,
               Precision precision, Normals normals, const SeamEdges& seams) {
  write_file_atomically(path, format_ply(meshes, precision, normals, seams), Durability::none);
}

}  // namespace weft::io
