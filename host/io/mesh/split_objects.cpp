#include "host/io/mesh/split_objects.hpp"

#include "weft/core/at.hpp"

#include <algorithm>
#include <cstddef>
#include <optional>
#include <utility>

namespace weft::io {
namespace {

/// Group of each entry that triangles refer to.
/// @param triangles with corners of -1 where they refer to none
/// @param count     of entries
/// @return nothing if one belongs to several groups, or to none
std::optional<std::vector<Index>> owners(const std::vector<Tri>& triangles,
                                         const std::vector<Index>& group, std::size_t count) {
  std::vector<Index> owner(count, -1);
  for (std::size_t t = 0; t < triangles.size(); ++t)
    for (const Index v : triangles[t].v) {
      if (v < 0) continue;
      if (owner[at(v)] >= 0 && owner[at(v)] != group[t]) return {};
      owner[at(v)] = group[t];
    }
  if (std::find(owner.begin(), owner.end(), -1) != owner.end()) return {};
  return owner;
}

/// Hands the entries of each group to its part.
/// @return [entries] number within the part
template <class Value, class Target>
std::vector<Index> hand_out(const std::vector<Value>& values, const std::vector<Index>& owner,
                            const Target& target) {
  std::vector<Index> number;
  number.reserve(values.size());
  for (std::size_t i = 0; i < values.size(); ++i) {
    std::vector<Value>& part = target(owner[i]);
    number.push_back(static_cast<Index>(part.size()));
    part.push_back(values[i]);
  }
  return number;
}

Tri renumbered(const Tri& tri, const std::vector<Index>& number) {
  const auto of = [&](Index v) { return v < 0 ? v : number[at(v)]; };
  return {{of(tri.v[0]), of(tri.v[1]), of(tri.v[2])}};
}

/// Drops material coordinates that not all corners have, and corners in material space that say no
/// more than the triangles do.
void finish_material(Mesh& mesh) {
  drop_incomplete_material(mesh);
  const auto same = [](const Tri& a, const Tri& b) { return std::equal(a.v, a.v + 3, b.v); };
  if (mesh.material.size() == mesh.positions.size() &&
      std::equal(mesh.material_triangles.begin(), mesh.material_triangles.end(),
                 mesh.triangles.begin(), mesh.triangles.end(), same))
    mesh.material_triangles.clear();
}

}  // namespace

std::vector<NamedMesh> split_objects(NamedMesh joined) {
  const Mesh& mesh = joined.mesh;
  const auto whole = [&] {
    std::vector<NamedMesh> one;
    one.push_back(std::move(joined));
    finish_material(one.front().mesh);
    return one;
  };
  const bool with_panels = !mesh.object.empty();
  const std::vector<Index>& object = with_panels ? mesh.object : mesh.group;
  const auto& names = with_panels ? mesh.object_names : mesh.group_names;
  if (object.empty()) return whole();
  const auto owner = owners(mesh.triangles, object, mesh.positions.size());
  if (!owner) return whole();
  const bool own_corners = !mesh.material_triangles.empty();
  const std::vector<Tri>& corners = own_corners ? mesh.material_triangles : mesh.triangles;
  const auto material_owner =
      mesh.material.empty() ? std::vector<Index>() : owners(corners, object, mesh.material.size());
  if (!material_owner) return whole();

  std::vector<NamedMesh> parts;
  std::vector<Index> part_of(names.size(), -1);
  for (const Index number : *owner) {
    if (part_of[at(number)] >= 0) continue;
    if (names[at(number)].empty()) return whole();
    part_of[at(number)] = static_cast<Index>(parts.size());
    parts.push_back({names[at(number)], {}});
    if (!with_panels) continue;
    parts.back().mesh.group_names = mesh.group_names;
    parts.back().mesh.part_names = mesh.part_names;
    parts.back().mesh.part_labels = mesh.part_labels;
  }
  const auto part = [&](Index number) -> Mesh& { return parts[at(part_of[at(number)])].mesh; };
  const auto vertex = hand_out(
      mesh.positions, *owner, [&](Index number) -> auto& { return part(number).positions; });
  const auto corner = hand_out(
      mesh.material, *material_owner, [&](Index number) -> auto& { return part(number).material; });
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    Mesh& own = part(object[t]);
    own.triangles.push_back(renumbered(mesh.triangles[t], vertex));
    if (own_corners) own.material_triangles.push_back(renumbered(corners[t], corner));
    if (!with_panels) continue;
    own.group.push_back(mesh.group[t]);
    if (!mesh.part.empty()) own.part.push_back(mesh.part[t]);
  }
  for (NamedMesh& each : parts) finish_material(each.mesh);
  return parts;
}

}  // namespace weft::io
