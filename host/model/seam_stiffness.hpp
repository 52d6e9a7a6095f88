#pragma once

#include <vector>

#include "weft/scene.hpp"

namespace weft {

/// Of the springs of all pairs at the end of their ramp, in the order of seam_pairs(): what the
/// seam says, else in proportion to the length of seam that the pair stands for, so that a seam
/// pulls a panel as hard on any mesh. That is half of the mesh's edges to the neighbouring pairs,
/// on the side where these are shorter.
/// @return [seam_pairs] [N/m]
std::vector<double> seam_stiffness(const Scene& scene);

}  // namespace weft
