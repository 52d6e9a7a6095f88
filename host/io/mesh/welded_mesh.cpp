#include "host/io/mesh/welded_mesh.hpp"

#include <algorithm>
#include <cstddef>
#include <map>
#include <tuple>

#include "weft/core/at.hpp"

namespace weft::io {
namespace {

std::array<Index, 2> sorted(Index a, Index b) {
  return {std::min(a, b), std::max(a, b)};
}

/// An edge of the welded mesh.
struct WeldedEdge {
  std::array<Index, 2> before{};  ///< the edge of the first triangle, in the mesh as it was
  bool seam = false;              ///< another triangle has another edge there
};

}  // namespace

void Weld::add(const std::vector<Vec3<double>>& positions) {
  numbers_.resize(positions.size(), 0);  // of the first frame: all are one so far
  std::map<std::tuple<Index, double, double, double>, Index> found;
  for (std::size_t v = 0; v < positions.size(); ++v) {
    const Vec3<double>& x = positions[v];
    numbers_[v] = found
                      .try_emplace(std::tuple(numbers_[v], x[0], x[1], x[2]),
                                   static_cast<Index>(found.size()))
                      .first->second;
  }
}

WeldedMesh welded(const Mesh& mesh, const std::vector<Index>& number) {
  WeldedMesh result;
  Mesh& out = result.mesh;
  out = mesh;
  out.positions.clear();
  for (std::size_t v = 0; v < number.size(); ++v)
    if (at(number[v]) == out.positions.size()) out.positions.push_back(mesh.positions[v]);
  if (!mesh.material.empty() && mesh.material_triangles.empty() &&
      out.positions.size() < mesh.positions.size())
    out.material_triangles = mesh.triangles;
  std::map<std::array<Index, 2>, WeldedEdge> edges;
  std::vector<std::array<Index, 2>> order;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const Tri& before = mesh.triangles[t];
    for (int k = 0; k < 3; ++k) {
      out.triangles[t].v[k] = number[at(before.v[k])];
      const Index a = before.v[k], b = before.v[(k + 1) % 3];
      const std::array<Index, 2> edge = sorted(number[at(a)], number[at(b)]);
      const auto [entry, fresh] = edges.try_emplace(edge, WeldedEdge{sorted(a, b)});
      if (fresh) order.push_back(edge);
      entry->second.seam = entry->second.seam || entry->second.before != sorted(a, b);
    }
  }
  for (const auto& edge : order)
    if (edges.at(edge).seam) result.seam_edges.push_back(edge);
  return result;
}

}  // namespace weft::io
