#pragma once

#include "host/model/model.hpp"
#include "weft/frame.hpp"

namespace weft {

/// Separates obstacles that cloth has displaced from their prescribed places. On entry
/// frame.obstacle_positions holds the simulated positions; on return the prescribed ones, and
/// frame.displaced_obstacle_positions the simulated ones of each displaced obstacle. An obstacle
/// counts as displaced if a vertex is off by more than rounding and a millionth of the contact
/// thickness. Others keep their positions to the bit.
/// @param precision of the simulated positions
void separate_displaced(const Scene& scene, const Model& model, Frame& frame, Precision precision);

}  // namespace weft
