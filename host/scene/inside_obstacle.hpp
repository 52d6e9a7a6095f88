#pragma once

#include <cstddef>
#include <optional>

#include "host/scene/surfaces.hpp"
#include "weft/scene.hpp"

namespace weft {

/// A vertex of cloth that lies inside an obstacle.
struct InsideObstacle {
  std::size_t obstacle;  ///< number in the scene
  Index vertex;          ///< number within the cloth, the lowest of its connected part
};

/// The first connected part of a cloth that lies inside a closed obstacle, by its lowest vertex.
/// @param surfaces of the scene; the cloth meets no obstacle, so a part with one vertex inside is
///                 inside as a whole
/// @param offset   [m] by which the cloth is moved before
std::optional<InsideObstacle> part_inside_obstacle(const Scene& scene, const Surfaces& surfaces,
                                                   std::size_t cloth,
                                                   const Vec3<double>& offset = {0, 0, 0});

}  // namespace weft
