#pragma once

#include <functional>
#include <vector>

#include "benchmarks/physics/test.hpp"
#include "weft/scene.hpp"

namespace weft::physics {

/// A rectangle in the xy plane, 0 <= x <= length, |y| <= width / 2, front towards +z. Columns of
/// aligned cells may be added at either end: to clamp a slope, or to load an end.
struct SheetShape {
  double length = 1;  ///< [m] without the columns at the ends
  double width = 1;   ///< [m]
  int cells = 32;     ///< along the length
  int columns_before = 0;
  int columns_after = 0;
  /// Diagonals of aligned cells change sides at y = 0, so that nothing prefers a side.
  bool mirrored = false;
};

/// The keys `mesh`, `aspect`, `angle`, `jitter` and `seed`.
std::vector<Parameter> mesh_parameters();

/// The rectangle in the pattern that the parameters name; material coordinates are its own xy. A
/// pure function of its arguments.
/// @throws SceneError if the parameters are bad, or the file cannot be read or is not flat
Mesh make_sheet(const SheetShape& shape, const Parameters& parameters);

/// Numbers of the vertices for whose place (in material coordinates) the condition holds.
std::vector<Index> vertices_where(const Mesh& mesh,
                                  const std::function<bool(const Vec2<double>&)>& condition);

/// Vertices with x at most `limit`, and at least `limit`, up to a millionth of the mesh's size.
std::vector<Index> vertices_before(const Mesh& mesh, double limit);
std::vector<Index> vertices_after(const Mesh& mesh, double limit);
/// Vertices on the outline.
std::vector<Index> outline(const Mesh& mesh);

/// [m^2] a third of the area of the triangles around each vertex, in material space.
std::vector<double> vertex_areas(const Mesh& mesh);

}  // namespace weft::physics
