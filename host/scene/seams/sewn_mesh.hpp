#pragma once

#include <array>
#include <cstddef>
#include <map>
#include <vector>

#include "weft/scene.hpp"

namespace weft {

/// The mesh of a cloth while its seams are made: edges can get more vertices, so that each vertex
/// of a seam has a partner. Vertices keep their numbers; new ones follow them.
class SewnMesh {
 public:
  /// A vertex that has been put on the edge between two others.
  struct Added {
    Index vertex;
    std::array<Index, 2> between;
  };

  /// @param cloth kept by reference
  explicit SewnMesh(Cloth& cloth) : cloth_(&cloth) {}

  const Cloth& cloth() const { return *cloth_; }
  const std::vector<Added>& added() const { return added_; }

  /// Finds the edges between these vertices. Those of earlier calls are forgotten.
  void look_at(const std::vector<Index>& vertices);
  /// Edges between the vertices of look_at() and those added since, lower vertex first, with their
  /// triangles.
  const std::map<std::array<Index, 2>, std::vector<Index>>& edges() const { return edges_; }
  bool has_edge(Index a, Index b) const { return edges_.contains(key(a, b)); }
  /// [m] at rest, in the first of its triangles
  /// @pre has_edge(a, b)
  double rest_length(Index a, Index b) const;
  /// Puts a vertex on an edge and splits its triangles.
  /// @param share of the way from a to b, between 0 and 1
  /// @return its number
  /// @pre has_edge(a, b)
  Index split(Index a, Index b, double share);
  /// Some vertices, and those that have been added between two of them.
  std::vector<Index> with_added(std::vector<Index> vertices) const;

 private:
  static std::array<Index, 2> key(Index a, Index b);
  void enter(Index triangle);
  void take_out(Index triangle);
  Index split_material(Index triangle, int from, int to, double share,
                       std::map<std::array<Index, 2>, Index>& made);

  Cloth* cloth_;
  std::vector<bool> looked_at_;  ///< [vertices]
  std::map<std::array<Index, 2>, std::vector<Index>> edges_;
  std::vector<Added> added_;
};

}  // namespace weft
