#include "host/model/seam_stiffness.hpp"

#include <algorithm>
#include <cstddef>
#include <map>
#include <utility>

#include "weft/core/at.hpp"

namespace weft {
namespace {

/// [N/m^2] per length of seam. Edges of 1 cm give 1000 N/m per pair.
constexpr double stiffness_per_length = 1e5;
/// [N/m] of a pair without neighbours, such as a button.
constexpr double stiffness_alone = 1000;

/// Edges of a mesh by their ends, the lower first, and their rest lengths. [m]
using EdgeLengths = std::map<std::pair<Index, Index>, double>;

/// Those whose ends are both sewn.
/// @param sewn [vertices] 1: in a pair
EdgeLengths sewn_edges(const Mesh& mesh, const std::vector<unsigned char>& sewn) {
  EdgeLengths edges;
  const bool cut = !mesh.material_triangles.empty();
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    for (int j = 0; j < 3; ++j) {
      const int next = (j + 1) % 3;
      const Index a = mesh.triangles[t].v[j];
      const Index b = mesh.triangles[t].v[next];
      if (sewn[at(a)] == 0 || sewn[at(b)] == 0) continue;
      const Tri& m = cut ? mesh.material_triangles[t] : mesh.triangles[t];
      edges[std::minmax(a, b)] =
          mesh.material.empty() ? length(mesh.positions[at(a)] - mesh.positions[at(b)])
                                : length(mesh.material[at(m.v[j])] - mesh.material[at(m.v[next])]);
    }
  return edges;
}

/// @return [pairs of the seam] [m] half of the edges to neighbouring pairs
std::vector<double> lengths_of_side(const std::vector<Index>& vertices, const EdgeLengths& edges) {
  std::multimap<Index, std::size_t> pairs_of;
  for (std::size_t k = 0; k < vertices.size(); ++k) pairs_of.emplace(vertices[k], k);
  std::vector<double> lengths(vertices.size(), 0);
  for (const auto& [ends, size] : edges) {
    if (!pairs_of.contains(ends.first) || !pairs_of.contains(ends.second)) continue;
    for (const Index v : {ends.first, ends.second}) {
      const auto [begin, end] = pairs_of.equal_range(v);
      for (auto pair = begin; pair != end; ++pair) lengths[pair->second] += size / 2;
    }
  }
  return lengths;
}

}  // namespace

std::vector<double> seam_stiffness(const Scene& scene) {
  std::map<Index, std::vector<unsigned char>> sewn;  // by cloth
  for (const Seam& seam : scene.seams) {
    if (seam.stiffness) continue;
    for (std::size_t side = 0; side < 2; ++side) {
      std::vector<unsigned char>& of_cloth = sewn[seam.cloths[side]];
      of_cloth.resize(scene.cloths[at(seam.cloths[side])].mesh.positions.size(), 0);
      for (const Index v : seam.vertices[side]) of_cloth[at(v)] = 1;
    }
  }
  std::map<Index, EdgeLengths> edges;
  for (const auto& [cloth, of_cloth] : sewn)
    edges.emplace(cloth, sewn_edges(scene.cloths[at(cloth)].mesh, of_cloth));

  std::vector<double> stiffness;
  for (const Seam& seam : scene.seams) {
    if (seam.stiffness) {
      stiffness.insert(stiffness.end(), seam.vertices[0].size(), *seam.stiffness);
      continue;
    }
    const std::vector<double> lengths[] = {
        lengths_of_side(seam.vertices[0], edges.at(seam.cloths[0])),
        lengths_of_side(seam.vertices[1], edges.at(seam.cloths[1]))};
    for (std::size_t k = 0; k < seam.vertices[0].size(); ++k) {
      const double size = std::min(lengths[0][k], lengths[1][k]);
      stiffness.push_back(size > 0 ? stiffness_per_length * size : stiffness_alone);
    }
  }
  return stiffness;
}

}  // namespace weft
