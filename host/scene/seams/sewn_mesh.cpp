#include "host/scene/seams/sewn_mesh.hpp"

#include "weft/core/at.hpp"

#include <algorithm>

namespace weft {
namespace {

/// Corner of a triangle that a vertex is.
int corner_of(const Tri& t, Index vertex) {
  return t.v[0] == vertex ? 0 : t.v[1] == vertex ? 1 : 2;
}

template <class Point>
Point between(const Point& a, const Point& b, double share) {
  return (1 - share) * a + share * b;
}

}  // namespace

std::array<Index, 2> SewnMesh::key(Index a, Index b) {
  return {std::min(a, b), std::max(a, b)};
}

void SewnMesh::look_at(const std::vector<Index>& vertices) {
  const Mesh& mesh = cloth_->mesh;
  looked_at_.assign(mesh.positions.size(), false);
  for (const Index v : vertices) looked_at_[at(v)] = true;
  edges_.clear();
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) enter(static_cast<Index>(t));
}

void SewnMesh::enter(Index triangle) {
  const Tri& t = cloth_->mesh.triangles[at(triangle)];
  for (int j = 0; j < 3; ++j) {
    const Index a = t.v[j], b = t.v[(j + 1) % 3];
    if (looked_at_[at(a)] && looked_at_[at(b)]) edges_[key(a, b)].push_back(triangle);
  }
}

void SewnMesh::take_out(Index triangle) {
  const Tri& t = cloth_->mesh.triangles[at(triangle)];
  for (int j = 0; j < 3; ++j) {
    const auto edge = edges_.find(key(t.v[j], t.v[(j + 1) % 3]));
    if (edge == edges_.end()) continue;
    std::erase(edge->second, triangle);
    if (edge->second.empty()) edges_.erase(edge);
  }
}

double SewnMesh::rest_length(Index a, Index b) const {
  const Mesh& mesh = cloth_->mesh;
  const Index triangle = edges_.at(key(a, b)).front();
  const Tri& t = mesh.triangles[at(triangle)];
  const Tri& m = mesh.material_triangles.empty() ? t : mesh.material_triangles[at(triangle)];
  const auto place = [&](Index v) -> const Vec2<double>& {
    return mesh.material[at(m.v[corner_of(t, v)])];
  };
  if (mesh.material.empty()) return length(mesh.positions[at(b)] - mesh.positions[at(a)]);
  return length(place(b) - place(a));
}

/// Puts a point between two corners of a triangle in material space.
/// @param made points by the two that they lie between: both triangles of an edge may share one
Index SewnMesh::split_material(Index triangle, int from, int to, double share,
                               std::map<std::array<Index, 2>, Index>& made) {
  Mesh& mesh = cloth_->mesh;
  const Tri& t = mesh.material_triangles[at(triangle)];
  const auto [found, is_new] =
      made.try_emplace({t.v[from], t.v[to]}, static_cast<Index>(mesh.material.size()));
  if (is_new)
    mesh.material.push_back(
        between(mesh.material[at(t.v[from])], mesh.material[at(t.v[to])], share));
  return found->second;
}

Index SewnMesh::split(Index a, Index b, double share) {
  Mesh& mesh = cloth_->mesh;
  const auto made = static_cast<Index>(mesh.positions.size());
  mesh.positions.push_back(between(mesh.positions[at(a)], mesh.positions[at(b)], share));
  if (!cloth_->rest_positions.empty())
    cloth_->rest_positions.push_back(
        between(cloth_->rest_positions[at(a)], cloth_->rest_positions[at(b)], share));
  if (mesh.material_triangles.empty() && !mesh.material.empty())
    mesh.material.push_back(between(mesh.material[at(a)], mesh.material[at(b)], share));
  looked_at_.push_back(true);
  std::map<std::array<Index, 2>, Index> material_made;
  const std::vector<Index> triangles = edges_.at(key(a, b));
  for (const Index triangle : triangles) {
    take_out(triangle);
    const auto halve = [&](std::vector<Tri>& list, int keep, int other, Index middle) {
      Tri second = list[at(triangle)];
      list[at(triangle)].v[other] = middle;
      second.v[keep] = middle;
      list.push_back(second);
    };
    const Tri whole = mesh.triangles[at(triangle)];
    const int from = corner_of(whole, a), to = corner_of(whole, b);
    if (!mesh.material_triangles.empty())
      halve(mesh.material_triangles, from, to,
            split_material(triangle, from, to, share, material_made));
    halve(mesh.triangles, from, to, made);
    if (!mesh.group.empty()) mesh.group.push_back(mesh.group[at(triangle)]);
    if (!cloth_->triangle_material.empty())
      cloth_->triangle_material.push_back(cloth_->triangle_material[at(triangle)]);
    enter(triangle);
    enter(static_cast<Index>(mesh.triangles.size()) - 1);
  }
  added_.push_back({made, {a, b}});
  return made;
}

std::vector<Index> SewnMesh::with_added(std::vector<Index> vertices) const {
  if (added_.empty()) return vertices;
  std::vector<bool> chosen(cloth_->mesh.positions.size(), false);
  for (const Index v : vertices) chosen[at(v)] = true;
  for (const Added& one : added_) {
    if (chosen[at(one.vertex)] || !chosen[at(one.between[0])] || !chosen[at(one.between[1])])
      continue;
    chosen[at(one.vertex)] = true;
    vertices.push_back(one.vertex);
  }
  return vertices;
}

}  // namespace weft
