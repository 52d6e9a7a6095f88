#pragma once

#include "weft/scene.hpp"

namespace weft {

/// Checks what a step computes from several numbers of a scene, each of which may be in its range:
/// masses of vertices, and stiffnesses in units of mass / step^2 and mass. They have to be far from
/// the ends of what a number of the run's precision can be. Also that remeshing to the largest size
/// does not make more triangles than there are numbers for.
/// @pre every number is in its range and meshes are good
/// @throws SceneError with the product and the number that it depends on most
void check_products(const Scene& scene);

}  // namespace weft
