#pragma once

#include <array>
#include <optional>
#include <vector>

#include "host/meshing/grid_point.hpp"
#include "weft/core/ids.hpp"

namespace weft {

/// A Delaunay triangulation of points in the plane that keeps given edges (Lawson's incremental
/// insertion; edges as in Sloan 1993). All decisions rest on exact signs, so it is the same on
/// every machine, and no loop can go round forever.
class ConstrainedDelaunay {
 public:
  /// A triangle, counter-clockwise. Side k lies opposite corner k.
  struct Face {
    std::array<Index, 3> v;
    std::array<Index, 3> next{-1, -1, -1};           ///< the face beyond side k; -1: none
    std::array<bool, 3> fixed{false, false, false};  ///< side k is a given edge
    bool inside = true;
  };

  /// Points must lie within this.
  static constexpr std::int64_t limit = grid_limit / 4;

  ConstrainedDelaunay();

  /// Adds a point. Within the edges only, once remove_outside() has been called.
  /// @return the number of its vertex, or that of the vertex which is there already; -1: it lies
  ///         outside, or on a given edge
  Index insert(const GridPoint& point);
  /// Makes the line between two vertices an edge, for good.
  /// @return false: another vertex or given edge is in the way
  bool fix_edge(Index a, Index b);
  /// Marks what can be reached from outside without crossing a given edge.
  void remove_outside();
  /// Flips edges within until all that are not given are Delaunay.
  void restore_delaunay();

  /// Moves a vertex if all its triangles stay counter-clockwise.
  /// @pre no given edge ends in it
  /// @return whether it was moved
  bool move(Index vertex, const GridPoint& to);

  const std::vector<Face>& faces() const { return faces_; }
  const GridPoint& point(Index vertex) const { return points_[static_cast<std::size_t>(vertex)]; }
  Index vertex_count() const { return static_cast<Index>(points_.size()); }
  /// The first vertices stand around the plane, outside all that is inserted.
  static constexpr Index first_vertex = 3;
  /// Faces around a vertex, counter-clockwise.
  /// @pre none of its edges is a border
  std::vector<Index> faces_around(Index vertex) const;
  /// Corner of a face that is this vertex.
  int corner_of(Index face, Index vertex) const;

 private:
  Face& face(Index f) { return faces_[static_cast<std::size_t>(f)]; }
  const Face& face(Index f) const { return faces_[static_cast<std::size_t>(f)]; }
  int side_towards(Index f, Index neighbour) const;
  void link(Index f, int side, Index neighbour, Index before);
  void flip(Index f, int side);
  void split(Index f, Index vertex);
  void legalize(Index vertex, std::vector<Index>& around);
  std::optional<Index> find(const GridPoint& point) const;
  /// The face and side of an edge, or nothing.
  std::optional<std::array<Index, 2>> side_of(Index a, Index b) const;
  std::optional<std::vector<std::array<Index, 2>>> crossed(Index a, Index b) const;

  std::vector<GridPoint> points_;
  std::vector<Face> faces_;
  std::vector<Index> face_of_;  ///< [vertices] one of its faces
  Index last_ = 0;              ///< where find() starts
  bool bounded_ = false;        ///< remove_outside() has been called
};

}  // namespace weft
