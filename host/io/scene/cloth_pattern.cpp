#include "host/io/scene/cloth_pattern.hpp"
#include "host/input/counted.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <numbers>

namespace weft::io {
namespace {

ClothPattern read_grid(Fields& fields) {
  ClothPattern grid;
  grid.size = fields.vector<2>("size", quantity::length);
  if (fields.has("cells")) {
    const auto cells = fields.integers("cells", 1, std::numeric_limits<Index>::max(), 2);
    grid.cells = {static_cast<Index>(cells[0]), static_cast<Index>(cells[1])};
  }
  grid.diagonals = fields.choice("diagonals", {"alternating", "same"}, 0) == 0
                       ? Diagonals::alternating
                       : Diagonals::same;
  return grid;
}

ClothPattern read_disc(Fields& fields) {
  ClothPattern disc;
  disc.shape = ClothPattern::Shape::disc;
  disc.radius = fields.number("radius", quantity::length);
  disc.inner_radius = fields.number("inner_radius", quantity::length_or_zero, 0);
  if (!(disc.inner_radius >= 0 && disc.inner_radius < disc.radius))
    fields.refuse("inner_radius", "a number >= 0 and < radius");
  if (fields.has("cells")) {
    const auto rings = static_cast<Index>(fields.integer("cells", {}, 1, 10000));
    disc.cells = {rings, rings};
  }
  return disc;
}

/// Of a panel: no more than any resolution has rows for.
constexpr std::size_t max_panel_heights = 100;

/// Entries [height, half width] or [height, left, right].
ClothPattern read_panel(Fields& fields) {
  ClothPattern panel;
  panel.shape = ClothPattern::Shape::panel;
  for (const std::vector<double>& entry : fields.number_lists("outline", 2, 3))
    panel.outline.push_back(entry.size() == 2 ? PanelWidth{entry[0], -entry[1], entry[1]}
                                              : PanelWidth{entry[0], entry[1], entry[2]});
  if (panel.outline.size() < 2 || panel.outline.size() > max_panel_heights)
    fields.refuse("outline", std::to_string(panel.outline.size()) + " heights",
                  "2 to " + std::to_string(max_panel_heights) + " heights");
  for (std::size_t k = 0; k < panel.outline.size(); ++k) {
    const std::string entry = "outline[" + std::to_string(k) + "]";
    const PanelWidth& at = panel.outline[k];
    for (const double x : {at.height, at.left, at.right})
      if (!quantity::coordinate.holds(x))
        fields.refuse(entry, short_text(x), quantity::coordinate.allowed());
    if (!(at.right - at.left >= quantity::least_length))
      fields.refuse(entry, short_text(at.right - at.left) + " wide",
                    "a width > 0, " + quantity::length.allowed());
    if (k > 0 && !(at.height - panel.outline[k - 1].height >= quantity::least_length))
      fields.refuse(entry, short_text(at.height), "heights that increase from entry to entry");
  }
  const double height = panel.outline.back().height - panel.outline.front().height;
  panel.size = {panel_area(panel.outline) / height, height};
  if (fields.has("cells")) {
    const auto cells = fields.integers("cells", 1, std::numeric_limits<Index>::max(), 2);
    panel.cells = {static_cast<Index>(cells[0]), static_cast<Index>(cells[1])};
    if (cells[1] + 1 < static_cast<std::int64_t>(panel.outline.size()))
      fields.refuse("cells", "at least one row between two heights of the outline");
  }
  return panel;
}

ClothPattern read_cylinder(Fields& fields) {
  ClothPattern tube;
  tube.shape = ClothPattern::Shape::cylinder;
  tube.radius = fields.number("radius", quantity::length);
  tube.size = {2 * std::numbers::pi * tube.radius, fields.number("height", quantity::length)};
  if (fields.has("cells")) {
    const auto cells = fields.integers("cells", 1, std::numeric_limits<Index>::max(), 2);
    if (cells[0] < 3) fields.refuse("cells", "at least 3 around");
    tube.cells = {static_cast<Index>(cells[0]), static_cast<Index>(cells[1])};
  }
  return tube;
}

constexpr std::size_t max_ribbon_points = 10000;
/// Sine of the least angle between path and width.
constexpr double least_ribbon_steepness = 0.2;

void read_ribbon_path(Fields& fields, Ribbon& ribbon) {
  for (const std::vector<double>& x : fields.number_lists("path", 3, 3)) {
    const std::string entry = "path[" + std::to_string(ribbon.path.size()) + "]";
    for (const double coordinate : x)
      if (!quantity::coordinate.holds(coordinate))
        fields.refuse(entry, short_text(nlohmann::json(x)),
                      "each " + quantity::coordinate.allowed());
    const Vec3<double> point{x[0], x[1], x[2]};
    if (!ribbon.path.empty() && !(length(point - ribbon.path.back()) >= quantity::least_length))
      fields.refuse(entry, short_text(nlohmann::json(x)),
                    "a point at least 1e-9 m from the one before");
    ribbon.path.push_back(point);
  }
  if (ribbon.path.size() < 2 || ribbon.path.size() > max_ribbon_points)
    fields.refuse("path", counted(ribbon.path.size(), "point"),
                  "2 to " + std::to_string(max_ribbon_points) + " points");
}

Ribbon read_ribbon(Fields& fields) {
  Ribbon ribbon;
  ribbon.width = fields.number("width", quantity::length);
  read_ribbon_path(fields, ribbon);
  ribbon.across = fields.direction("across", ribbon.across);
  if (!(ribbon_steepness(ribbon) > least_ribbon_steepness))
    fields.refuse("across", "a direction that the path nowhere comes within 12 degrees of");
  return ribbon;
}

ClothPattern read_ribbon_pattern(Fields& fields) {
  ClothPattern pattern;
  pattern.shape = ClothPattern::Shape::ribbon;
  pattern.ribbon = read_ribbon(fields);
  pattern.size = {ribbon_length(pattern.ribbon), pattern.ribbon.width};
  if (fields.has("cells")) {
    const auto cells = fields.integers("cells", 1, std::numeric_limits<Index>::max(), 2);
    pattern.cells = {static_cast<Index>(cells[0]), static_cast<Index>(cells[1])};
  }
  return pattern;
}

/// Vertices from `first` on, `step` apart.
std::vector<Index> run_of(Index first, Index count, Index step = 1) {
  std::vector<Index> run;
  for (Index i = 0; i < count; ++i) run.push_back(first + i * step);
  return run;
}

}  // namespace

double ClothPattern::area() const {
  return shape == Shape::disc ? std::numbers::pi * (radius * radius - inner_radius * inner_radius)
                              : size[0] * size[1];
}

double ClothPattern::triangles() const {
  const double n = (*cells)[0];
  if (shape != Shape::disc) return 2 * n * (*cells)[1];
  return 6 * n * (n + (inner_radius > 0 ? 2.0 * start() : 0));
}

/// Sixths of the ring around the hole.
Index ClothPattern::start() const {
  return annulus_start(inner_radius, radius, (*cells)[0]);
}

Mesh ClothPattern::mesh() const {
  if (shape == Shape::disc)
    return inner_radius > 0 ? make_annulus(inner_radius, radius, (*cells)[0])
                            : make_disc(radius, (*cells)[0]);
  if (shape == Shape::panel) return make_panel(outline, *cells);
  if (shape == Shape::cylinder) return make_tube(radius, size[1], *cells);
  if (shape == Shape::ribbon) return make_ribbon(ribbon, *cells);
  return make_grid(size, *cells, diagonals);
}

void ClothPattern::choose_cells(double scale, double cell, double most) {
  const auto count_of = [&](double length, double least) {
    // One row of a strip cannot use up more than the whole budget. In this order because areas
    // may overflow: of inf / inf, `least` is taken.
    return static_cast<Index>(std::max(least, std::min(std::round(length * scale / cell), most)));
  };
  if (shape == Shape::disc) {
    // So that 6 rings^2 triangles have the area of half a cell each.
    const double width = radius - inner_radius;
    const Index rings = count_of(width * std::sqrt(std::numbers::pi / 3), 1);
    cells = {rings, rings};
  } else {
    const double around = shape == Shape::cylinder ? 3 : 1;
    const double along = std::max<double>(1, static_cast<double>(outline.size()) - 1);
    cells = {count_of(size[0], around), count_of(size[1], along)};
  }
}

void ClothPattern::name_edges(ClothGroup& group) const {
  const auto [nx, ny] = *cells;
  if (shape == Shape::disc) {
    constexpr Index sectors = 6;
    if (inner_radius > 0) {
      const Index first = start();
      group.edges["inner"] = {run_of(0, sectors * first), true};
      // Rings first .. first + nx - 1 stand before the last one.
      group.edges["outer"] = {
          run_of(sectors * (nx * first + nx * (nx - 1) / 2), sectors * (first + nx)), true};
    } else {
      group.edges["outer"] = {run_of(1 + sectors * (nx * (nx - 1) / 2), sectors * nx), true};
    }
  } else if (shape == Shape::cylinder) {
    group.edges["bottom"] = {run_of(0, nx), true};
    group.edges["top"] = {run_of(nx * ny, nx), true};
  } else {
    group.cells = cells;
    group.edges["left"] = {run_of(0, ny + 1, nx + 1), false};
    group.edges["right"] = {run_of(nx, ny + 1, nx + 1), false};
    group.edges["bottom"] = {run_of(0, nx + 1), false};
    group.edges["top"] = {run_of(grid_vertex(nx, 0, ny), nx + 1), false};
  }
}

std::vector<std::string> pattern_shapes() {
  return {"grid", "panel", "disc", "cylinder", "ribbon"};
}

ClothPattern read_pattern(Fields& cloth, const std::string& shape, Fields& fields) {
  if (shape == "grid") {
    fields = cloth.object("grid", {"size", "cells", "diagonals"});
    return read_grid(fields);
  }
  if (shape == "panel") {
    fields = cloth.object("panel", {"outline", "cells"});
    return read_panel(fields);
  }
  if (shape == "disc") {
    fields = cloth.object("disc", {"radius", "inner_radius", "cells"});
    return read_disc(fields);
  }
  if (shape == "cylinder") {
    fields = cloth.object("cylinder", {"radius", "height", "cells"});
    return read_cylinder(fields);
  }
  fields = cloth.object("ribbon", {"width", "path", "across", "cells"});
  return read_ribbon_pattern(fields);
}

}  // namespace weft::io
