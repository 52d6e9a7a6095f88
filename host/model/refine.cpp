#include "host/model/refine.hpp"

#include <algorithm>
#include <map>
#include <utility>

#include "host/scene/seams/sewing.hpp"
#include "weft/core/at.hpp"

namespace weft {
namespace {

/// Numbers for the midpoints of all edges of a list of triangles.
class Midpoints {
 public:
  Midpoints(std::size_t vertex_count, const std::vector<Tri>& triangles)
      : first_(static_cast<Index>(vertex_count)) {
    edges_.reserve(3 * triangles.size());
    for (const Tri& t : triangles)
      for (int j = 0; j < 3; ++j) edges_.push_back(sorted(t.v[j], t.v[(j + 1) % 3]));
    std::sort(edges_.begin(), edges_.end());
    edges_.erase(std::unique(edges_.begin(), edges_.end()), edges_.end());
  }

  const std::vector<std::array<Index, 2>>& edges() const { return edges_; }

  Index between(Index a, Index b) const {
    const auto place = std::lower_bound(edges_.begin(), edges_.end(), sorted(a, b));
    return first_ + static_cast<Index>(place - edges_.begin());
  }

  void append_split(const Tri& t, std::vector<Tri>& out) const {
    const Index a = between(t.v[0], t.v[1]);
    const Index b = between(t.v[1], t.v[2]);
    const Index c = between(t.v[2], t.v[0]);
    out.push_back({{t.v[0], a, c}});
    out.push_back({{t.v[1], b, a}});
    out.push_back({{t.v[2], c, b}});
    out.push_back({{a, b, c}});
  }

 private:
  static std::array<Index, 2> sorted(Index a, Index b) { return {std::min(a, b), std::max(a, b)}; }

  Index first_;
  std::vector<std::array<Index, 2>> edges_;
};

template <class Point>
void append_means(const std::vector<std::array<Index, 2>>& edges, std::vector<Point>& points) {
  for (const auto& [a, b] : edges) points.push_back(0.5 * (points[at(a)] + points[at(b)]));
}

template <class T>
std::vector<T> four_times(const std::vector<T>& values) {
  std::vector<T> out;
  for (const T& value : values) out.insert(out.end(), 4, value);
  return out;
}

/// Adds the midpoints between vertices of `chosen`.
void add_midpoints(const std::vector<std::array<Index, 2>>& parents, std::vector<Index>& chosen) {
  std::vector<bool> is_chosen(parents.size(), false);
  for (const Index v : chosen) is_chosen[at(v)] = true;
  for (std::size_t v = 0; v < parents.size(); ++v) {
    const auto [a, b] = parents[v];
    if (a != b && is_chosen[at(a)] && is_chosen[at(b)]) chosen.push_back(static_cast<Index>(v));
  }
}

/// Seams that join each vertex to the first that it is one with.
std::vector<Seam> seams_that_join(const Scene& scene, const std::vector<Index>& joined) {
  const std::vector<Index> offsets = input_offsets(scene);
  const auto cloth_of = [&](Index input) {
    return static_cast<Index>(std::upper_bound(offsets.begin(), offsets.end(), input) -
                              offsets.begin() - 1);
  };
  std::map<std::pair<Index, Index>, Seam> by_cloths;
  for (std::size_t i = 0; i < joined.size(); ++i) {
    if (joined[i] == static_cast<Index>(i)) continue;
    const Index cloths[2] = {cloth_of(joined[i]), cloth_of(static_cast<Index>(i))};
    Seam& seam = by_cloths[{cloths[0], cloths[1]}];
    seam.weld_distance = contact_thickness(scene.contact);
    for (int side = 0; side < 2; ++side) seam.cloths[side] = cloths[side];
    seam.vertices[0].push_back(joined[i] - offsets[at(cloths[0])]);
    seam.vertices[1].push_back(static_cast<Index>(i) - offsets[at(cloths[1])]);
  }
  std::vector<Seam> seams;
  for (auto& [cloths, seam] : by_cloths) seams.push_back(std::move(seam));
  return seams;
}

}  // namespace

RefinedMesh refine_mesh(const Mesh& mesh) {
  RefinedMesh out;
  const Midpoints midpoints(mesh.positions.size(), mesh.triangles);
  for (Index v = 0; v < static_cast<Index>(mesh.positions.size()); ++v)
    out.parents.push_back({v, v});
  out.parents.insert(out.parents.end(), midpoints.edges().begin(), midpoints.edges().end());
  out.mesh.positions = mesh.positions;
  append_means(midpoints.edges(), out.mesh.positions);
  for (const Tri& t : mesh.triangles) midpoints.append_split(t, out.mesh.triangles);
  out.mesh.material = mesh.material;
  if (mesh.material_triangles.empty()) {
    if (!mesh.material.empty()) append_means(midpoints.edges(), out.mesh.material);
  } else {
    const Midpoints of_material(mesh.material.size(), mesh.material_triangles);
    append_means(of_material.edges(), out.mesh.material);
    for (const Tri& t : mesh.material_triangles)
      of_material.append_split(t, out.mesh.material_triangles);
  }
  out.mesh.group = four_times(mesh.group);
  out.mesh.group_names = mesh.group_names;
  out.mesh.part = four_times(mesh.part);
  out.mesh.part_names = mesh.part_names;
  out.mesh.part_labels = mesh.part_labels;
  return out;
}

RefinedScene refine_cloths(const Scene& before, const std::vector<Index>& joined) {
  const std::vector<Index> coarse = input_offsets(before);
  RefinedScene result{before, {}};
  Scene& scene = result.scene;
  std::vector<std::vector<std::array<Index, 2>>> parents;
  for (Cloth& cloth : scene.cloths) {
    RefinedMesh refined = refine_mesh(cloth.mesh);
    cloth.mesh = std::move(refined.mesh);
    cloth.triangle_material = four_times(cloth.triangle_material);
    if (!cloth.rest_positions.empty()) {
      const std::vector<Vec3<double>> coarse_rest = std::move(cloth.rest_positions);
      cloth.rest_positions.clear();
      for (const auto& [a, b] : refined.parents)
        cloth.rest_positions.push_back(a == b ? coarse_rest[at(a)]
                                              : 0.5 * (coarse_rest[at(a)] + coarse_rest[at(b)]));
    }
    parents.push_back(std::move(refined.parents));
  }
  for (Pin& pin : scene.pins) add_midpoints(parents[at(pin.cloth)], pin.vertices);
  for (Handle& handle : scene.handles)
    if (handle.shape != Handle::Shape::glue)
      add_midpoints(parents[at(handle.cloth)], handle.vertices);
  std::vector<std::array<Index, 2>>& all = result.parents;
  for (std::size_t c = 0; c < parents.size(); ++c)
    for (const auto& [a, b] : parents[c]) all.push_back({coarse[c] + a, coarse[c] + b});
  // New vertices are one if the vertices that they lie between are.
  std::map<std::array<Index, 2>, Index> first;
  std::vector<Index> joined_now;
  for (std::size_t i = 0; i < all.size(); ++i) {
    const Index a = joined[at(all[i][0])];
    const Index b = joined[at(all[i][1])];
    const auto found = first.try_emplace({std::min(a, b), std::max(a, b)}, static_cast<Index>(i));
    joined_now.push_back(found.first->second);
  }
  scene.seams = seams_that_join(scene, joined_now);
  return result;
}

}  // namespace weft
