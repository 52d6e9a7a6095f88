#include "host/model/model_part.hpp"

#include "host/scene/seams/groups.hpp"
#include "weft/core/at.hpp"

namespace weft {
namespace {

/// The items of `all` that `chosen` names; none of an empty list.
template <class V>
V pick(const V& all, const std::vector<Index>& chosen) {
  V out;
  if (all.empty()) return out;
  out.reserve(chosen.size());
  for (const Index i : chosen) out.push_back(all[at(i)]);
  return out;
}

/// Numbers in the part by numbers in the whole; -1: not in it.
std::vector<Index> inverse(const std::vector<Index>& numbers, Index count) {
  std::vector<Index> result(at(count), -1);
  for (std::size_t i = 0; i < numbers.size(); ++i) result[at(numbers[i])] = static_cast<Index>(i);
  return result;
}

/// The first `count` of `chosen`.
std::vector<Index> first_of(const std::vector<Index>& chosen, Index count) {
  return {chosen.begin(), chosen.begin() + count};
}

void take_vertices(const Model& whole, const std::vector<unsigned char>& kept, ModelPart& part) {
  Model& m = part.model;
  for (Index v = 0; v < whole.vertex_count; ++v)
    if (v >= whole.cloth_vertex_count || kept[at(v)] != 0) {
      if (v < whole.cloth_vertex_count) ++m.cloth_vertex_count;
      part.vertex.push_back(v);
    }
  m.vertex_count = static_cast<Index>(part.vertex.size());
  const std::vector<Index> cloth = first_of(part.vertex, m.cloth_vertex_count);
  m.to_input = pick(whole.to_input, cloth);
  m.cloth_of_vertex = pick(whole.cloth_of_vertex, cloth);
  m.input_offset = whole.input_offset;
  m.seam_stiffness = whole.seam_stiffness;
  m.positions = pick(whole.positions, part.vertex);
  m.velocities = pick(whole.velocities, part.vertex);
  m.material_points = pick(whole.material_points, cloth);
  m.mass = pick(whole.mass, cloth);
  m.damping_mass = pick(whole.damping_mass, cloth);
  m.rest_positions = whole.rest_positions;
  m.start_thickness = pick(whole.start_thickness, cloth);
  m.obstacle_of_vertex = whole.obstacle_of_vertex;
  m.obstacle_points = whole.obstacle_points;
  m.obstacle_offset = whole.obstacle_offset;
}

void take_triangles(const Model& whole, const std::vector<Index>& number, ModelPart& part) {
  Model& m = part.model;
  for (std::size_t t = 0; t < whole.triangles.size(); ++t) {
    Tri tri = whole.triangles[t];
    for (Index& v : tri.v) v = number[at(v)];
    if (tri.v[0] < 0) continue;
    if (static_cast<Index>(t) < whole.cloth_triangle_count) ++m.cloth_triangle_count;
    m.triangles.push_back(tri);
    part.triangle.push_back(static_cast<Index>(t));
  }
  const std::vector<Index> cloth = first_of(part.triangle, m.cloth_triangle_count);
  m.inv_rest = pick(whole.inv_rest, cloth);
  m.area = pick(whole.area, cloth);
  m.material = pick(whole.material, cloth);
  m.pressure = pick(whole.pressure, cloth);
  m.input_triangle = pick(whole.input_triangle, cloth);
  m.compression = pick(whole.compression, cloth);
  m.rest_corners = pick(whole.rest_corners, cloth);
  m.input_corners = pick(whole.input_corners, cloth);
  m.shaped = pick(whole.shaped, cloth);
  m.laws = whole.laws;
}

void take_edges(const Model& whole, const std::vector<Index>& number, ModelPart& part) {
  Model& m = part.model;
  for (std::size_t e = 0; e < whole.edges.size(); ++e) {
    Edge edge = whole.edges[e];
    for (Index& v : edge.v) v = number[at(v)];
    if (edge.v[0] < 0) continue;
    if (static_cast<Index>(e) < whole.cloth_edge_count) {
      ++m.cloth_edge_count;
      if (!whole.cut.empty()) m.cut.push_back(whole.cut[e]);
    }
    m.edges.push_back(edge);
    part.edge.push_back(static_cast<Index>(e));
  }
  std::vector<Index> hinges;
  for (std::size_t h = 0; h < whole.hinges.size(); ++h)
    if (number[at(whole.hinges[h].v[0])] >= 0) hinges.push_back(static_cast<Index>(h));
  m.hinges = pick(whole.hinges, hinges);
  for (Hinge& hinge : m.hinges)
    for (Index& v : hinge.v) v = number[at(v)];
  m.hinge_stiffness = pick(whole.hinge_stiffness, hinges);
  m.hinge_rest_angle = pick(whole.hinge_rest_angle, hinges);
  m.hinge_damping = pick(whole.hinge_damping, hinges);
}

}  // namespace

std::vector<Index> cloth_components(const Model& model) {
  Groups groups(at(model.cloth_vertex_count));
  for (Index t = 0; t < model.cloth_triangle_count; ++t)
    for (int j = 1; j < 3; ++j)
      groups.join(model.triangles[at(t)].v[0], model.triangles[at(t)].v[j]);
  for (std::size_t v = 0; v < model.tied.size(); ++v)
    groups.join(static_cast<Index>(v), model.tied[v]);
  std::vector<Index> piece = groups.lowest();
  Index count = 0;
  for (std::size_t v = 0; v < piece.size(); ++v)
    piece[v] = piece[v] == static_cast<Index>(v) ? count++ : piece[at(piece[v])];
  return piece;
}

ModelPart part_of(const Model& whole, const std::vector<unsigned char>& kept) {
  ModelPart part;
  take_vertices(whole, kept, part);
  const std::vector<Index> number = inverse(part.vertex, whole.vertex_count);
  Model& m = part.model;
  for (const Index v : whole.to_internal) m.to_internal.push_back(number[at(v)]);
  take_triangles(whole, number, part);
  take_edges(whole, number, part);
  for (Model::PinnedVertex p : whole.pinned) {
    p.vertex = number[at(p.vertex)];
    if (p.vertex >= 0) m.pinned.push_back(p);
  }
  for (Index v = 0; v < m.cloth_vertex_count; ++v)
    m.tied.push_back(number[at(whole.tied[at(part.vertex[at(v)])])]);
  // Margins, tolerances and all that is scaled by it must not depend on what else is in the part.
  m.mean_edge = whole.mean_edge;
  m.whole = whole.whole;
  return part;
}

}  // namespace weft
