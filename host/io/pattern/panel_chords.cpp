#include "host/io/pattern/panel_chords.hpp"

#include <algorithm>
#include <cstddef>
#include <map>

#include "host/io/pattern/joined_numbers.hpp"
#include "weft/core/at.hpp"

namespace weft::io {
namespace {

/// An edge of a panel's mesh with an end on its outline.
struct Chord {
  std::array<Index, 2> ends;  ///< of the panel, lower first
  std::size_t panel = 0;
  std::vector<std::size_t> triangles;  ///< of the panel
};

void split(PlanarMesh& mesh, const Chord& chord) {
  const auto [a, b] = chord.ends;
  const auto middle = static_cast<Index>(mesh.points.size());
  mesh.points.push_back((mesh.points[at(a)] + mesh.points[at(b)]) * 0.5);
  // An earlier split may have given a side of the chord to a triangle made then, so all are asked.
  const std::size_t count = mesh.triangles.size();
  for (std::size_t t = 0; t < count; ++t) {
    const Tri old = mesh.triangles[t];
    for (int k = 0; k < 3; ++k) {
      const Index from = old.v[k], to = old.v[(k + 1) % 3], apex = old.v[(k + 2) % 3];
      if (std::min(from, to) != a || std::max(from, to) != b) continue;
      mesh.triangles[t] = {{from, middle, apex}};
      mesh.triangles.push_back({{middle, to, apex}});
      break;
    }
  }
}

}  // namespace

void split_chords(std::vector<PlanarMesh>& meshes, const std::vector<Index>& outlines,
                  const std::vector<Index>& first, const std::vector<std::array<Index, 2>>& pairs) {
  JoinedNumbers same(at(first.back()));
  for (const auto& [a, b] : pairs) same.join(at(a), at(b));
  // By what their ends become.
  std::map<std::array<std::size_t, 2>, std::vector<Chord>> by_ends;
  for (std::size_t p = 0; p < meshes.size(); ++p) {
    std::map<std::array<Index, 2>, std::vector<std::size_t>> edges;
    for (std::size_t t = 0; t < meshes[p].triangles.size(); ++t)
      for (int k = 0; k < 3; ++k) {
        const auto [a, b] =
            std::minmax({meshes[p].triangles[t].v[k], meshes[p].triangles[t].v[(k + 1) % 3]});
        if (a < outlines[p]) edges[{a, b}].push_back(t);
      }
    for (const auto& [ends, triangles] : edges) {
      const auto [a, b] =
          std::minmax({same.find(at(first[p] + ends[0])), same.find(at(first[p] + ends[1]))});
      by_ends[{a, b}].push_back({ends, p, triangles});
    }
  }
  for (const auto& [ends, chords] : by_ends) {
    if (chords.size() < 2 && ends[0] != ends[1]) continue;
    for (const Chord& chord : chords)
      if (chord.triangles.size() == 2) split(meshes[chord.panel], chord);
  }
}

}  // namespace weft::io
