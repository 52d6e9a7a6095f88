#pragma once

#include <vector>

#include "host/model/model.hpp"
#include "weft/report.hpp"
#include "weft/state/contact.hpp"

namespace weft {

/// Energy of a state, summed in double in a fixed order.
/// @param positions  [vertices] [m] internal order
/// @param velocities [cloth vertices] [m/s]
/// @param springs    of handles and seams, see springs_at(); their energy is elastic
/// @param plate      bending as a plate, see make_plate()
Energy measure_energy(const Scene& scene, const Model& model,
                      const std::vector<Vec3<double>>& positions,
                      const std::vector<Vec3<double>>& velocities,
                      const std::vector<Spring<double>>& springs = {},
                      const PlateMatrix& plate = {});

/// The largest limit_excess() of all triangles; 0 if no material has strain limits. [1]
/// @param positions [vertices] [m] internal order
double largest_limit_excess(const Model& model, const std::vector<Vec3<double>>& positions);

}  // namespace weft
