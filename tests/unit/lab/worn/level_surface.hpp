#pragma once

#include <functional>
#include <vector>

#include "tests/unit/lab/worn/sculpture.hpp"

namespace weft::lab::test {

using Field = std::function<double(Point)>;
/// A field that also gives its gradient, if asked for.
using SmoothField = std::function<double(Point, Point*)>;

/// Triangles that can be cut; each bears the sides of the cuts it is on.
struct LevelSurface {
  std::vector<Point> positions;
  std::vector<Tri> triangles;
  std::vector<unsigned> sides;  ///< [triangles] bit i: on the positive side of cut i

  /// Cuts along `field` = 0 and sets a bit of the triangles where it is positive. Vertices close
  /// to the cut move onto it, so that it leaves no slivers.
  void cut(const Field& field, int bit);
  /// Removes triangles that bear any bit of `bits`, all but the largest component, and vertices
  /// without triangles.
  void remove(unsigned bits);
};

/// The surface where `field` is 0, by marching tetrahedra: closed, with triangles that face where
/// `field` is positive.
/// @param low, high of a box around the surface
/// @param size [m] of the cubes
/// @param lattice axes of the cubes; its place is the middle of the box
LevelSurface polygonised(const SmoothField& field, Point low, Point high, double size,
                         const Frame& lattice);

/// Makes triangles more even: vertices move to the middle of their neighbours, then back onto
/// `field` = 0.
/// @param jitter share of the distance to the neighbours by which vertices then move at random
void even_out(LevelSurface& surface, const SmoothField& field, int rounds, double jitter,
              Draw& draw);

/// Edges of the triangles, each once, and how many triangles meet there.
struct MeshEdges {
  std::vector<Edge> edges;
  std::vector<int> triangles;  ///< [edges]
};
MeshEdges edges_of(const std::vector<Tri>& triangles);

}  // namespace weft::lab::test
