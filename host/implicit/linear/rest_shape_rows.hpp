#pragma once

#include <vector>

#include "host/model/plate.hpp"
#include "host/state/partition.hpp"

namespace weft {

/// Data of a plate's curved rest shape for one rank: the triangles that act on its rows, and the
/// tables by which its rows gather, see AssembleRestShapeForces and AssembleRestShapeRows.
struct RestShapeRows {
  std::vector<Tri> corners;
  std::vector<Mat2<double>> inv_rest;
  std::vector<Offset> offset;
  std::vector<Index> vertex, entry_triangle;
  std::vector<Vec3<double>> force;
  std::vector<Offset> entry_offset, corner_offset;
  std::vector<Index> entry, corner;
};

/// @return empty if no triangle acts on the rank's rows
RestShapeRows make_rest_shape_rows(const PlateShape& shape, const Partition& partition, int rank);

}  // namespace weft
