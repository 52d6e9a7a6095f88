#pragma once

#include <vector>

#include "host/model/model.hpp"

namespace weft {

/// Some pieces of a model's cloth, and all of its obstacles, as a model of their own in the same
/// order. Inputs that are not in it have the internal number -1.
struct ModelPart {
  Model model;
  std::vector<Index> vertex;    ///< [vertices] number in the whole, ascending
  std::vector<Index> triangle;  ///< [triangles] as above
  std::vector<Index> edge;      ///< [edges] as above
};

/// Pieces of the cloth: what triangles, seams and glue connect.
/// @return [cloth vertices] number of its piece; pieces count from 0 in the order of their first
///         vertices
std::vector<Index> cloth_components(const Model& model);

/// @param kept [cloth vertices] 1: in the part; the same for all of a piece
ModelPart part_of(const Model& whole, const std::vector<unsigned char>& kept);

}  // namespace weft
