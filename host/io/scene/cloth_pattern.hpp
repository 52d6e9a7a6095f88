#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "host/geometry/outline.hpp"
#include "host/geometry/ribbon.hpp"
#include "host/io/json/json_fields.hpp"
#include "host/io/scene/scene_parts.hpp"
#include "weft/shapes.hpp"

namespace weft::io {

/// A cloth that is made from numbers: its mesh follows once the number of cells is known.
struct ClothPattern {
  enum class Shape { grid, panel, disc, cylinder, ribbon };
  Shape shape = Shape::grid;
  /// [m] grid, panel: (mean) width and height; cylinder: around and height; ribbon: length and
  /// width
  Vec2<double> size{};
  double radius = 0;                ///< [m] disc and cylinder
  double inner_radius = 0;          ///< [m] disc; 0: no hole
  std::vector<PanelWidth> outline;  ///< panel
  Ribbon ribbon;
  std::optional<std::array<Index, 2>> cells;  ///< disc: the number of rings, twice
  Diagonals diagonals = Diagonals::alternating;

  double area() const;  ///< [m^2]
  /// @pre cells
  double triangles() const;
  /// @pre cells
  Mesh mesh() const;
  /// Chooses cells whose triangles have half the area of a square `cell`.
  /// @param scale of the cloth in the world   @param cell [m] in the world
  /// @param most  cells along a side
  void choose_cells(double scale, double cell, double most);
  /// Writes down what pins, handles and seams may call by name.
  /// @pre cells
  void name_edges(ClothGroup& group) const;

 private:
  Index start() const;
};

/// Keys of cloths that hold a pattern.
std::vector<std::string> pattern_shapes();
/// Reads the object of a pattern under one of pattern_shapes().
/// @param fields of the object, for what is written down later
ClothPattern read_pattern(Fields& cloth, const std::string& shape, Fields& fields);

}  // namespace weft::io
