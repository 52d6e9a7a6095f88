#pragma once

#include <array>
#include <vector>

#include "weft/scene.hpp"

namespace weft::io {

/// Finds which vertices of a mesh sewing has made one: those that stand at exactly one place.
class Weld {
 public:
  /// Vertices that are apart in this frame are apart for good.
  /// @param positions [vertices] as many as in the frames before
  void add(const std::vector<Vec3<double>>& positions);

  /// [vertices] numbers of what they become one with, from 0 in the order of the first vertices
  const std::vector<Index>& numbers() const { return numbers_; }

 private:
  std::vector<Index> numbers_;
};

/// A garment as one mesh.
struct WeldedMesh {
  /// Material coordinates, groups and parts are those of before: a vertex on a seam has material
  /// coordinates for each of its panels.
  Mesh mesh;
  /// [edges] vertices at both ends, of edges where triangles meet that shared none before; in the
  /// order of the triangles
  std::vector<std::array<Index, 2>> seam_edges;
};

/// @param mesh   with at least one vertex
/// @param number [vertices] as Weld::numbers()
WeldedMesh welded(const Mesh& mesh, const std::vector<Index>& number);

}  // namespace weft::io
