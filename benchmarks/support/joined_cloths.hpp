#pragma once

#include <vector>

#include "weft/simulation.hpp"

namespace weft::bench {

/// All cloths of a running scene as one mesh, where they are now.
inline Mesh joined_cloths(const Simulation& simulation) {
  const Frame frame = simulation.frame();
  Mesh all;
  for (std::size_t c = 0; c < simulation.scene().cloths.size(); ++c) {
    const Mesh& mesh = simulation.scene().cloths[c].mesh;
    const auto vertex = static_cast<Index>(all.positions.size());
    const auto corner = static_cast<Index>(all.material.size());
    const auto moved = [](Tri t, Index by) {
      for (Index& v : t.v) v += by;
      return t;
    };
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
      all.triangles.push_back(moved(mesh.triangles[t], vertex));
      all.material_triangles.push_back(
          moved(mesh.material_triangles.empty() ? mesh.triangles[t] : mesh.material_triangles[t],
                corner));
    }
    const auto& x = frame.cloth_positions[c];
    all.positions.insert(all.positions.end(), x.begin(), x.end());
    all.material.insert(all.material.end(), mesh.material.begin(), mesh.material.end());
  }
  return all;
}

}  // namespace weft::bench
