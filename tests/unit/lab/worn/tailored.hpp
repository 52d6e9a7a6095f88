#pragma once

#include <string>
#include <vector>

#include "tests/unit/lab/worn/level_surface.hpp"

namespace weft::lab::test {

enum class Cut {
  tshirt,
  long_shirt,
  vest,
  turtleneck,
  hoody_up,
  hoody_down,
  jumpsuit,
  trousers,
  shorts,
  pencil_skirt,
  wide_skirt,
  strapless_dress,
  long_dress,
  briefs,
  poncho
};

/// How a garment is made.
struct Tailoring {
  double ease = 0.015;       ///< [m] from the body
  double edge = 0.05;        ///< [m] cubes of the mesh; triangles are about half as large
  double length = 1;         ///< of sleeves, legs and hems, as a factor
  bool split_tubes = false;  ///< sleeves and legs have a front and a back
  bool unnamed = false;      ///< panels are called panel_0, panel_1, ...
};

/// A garment that was cut from a surface around a body.
struct Tailored {
  Cut cut{};
  std::vector<Point> positions;
  std::vector<Tri> triangles;
  std::vector<Index> group;         ///< [triangles] into names
  std::vector<std::string> names;   ///< of panels
  std::vector<std::string> labels;  ///< what panels are, also where their names do not say it
  unsigned parts = 0;               ///< of the body that it is around
};

/// Cuts a garment from a surface at some distance around the parts of the body that it covers.
/// Skirts, dresses and ponchos are cut from cones that stand away from the body.
Tailored tailored(Cut cut, const Sculpture& body, const Tailoring& how, Draw& draw);

}  // namespace weft::lab::test
