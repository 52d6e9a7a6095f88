#pragma once

#include <functional>
#include <vector>

#include "weft/scene.hpp"

namespace weft {

/// Moves the cloths of a scene out of each other and out of obstacles, as these are at time 0.
/// Pinned vertices and obstacles stay. Where something was intersecting the cloths end at least
/// about the contact thickness apart, if there is room. Cloth that was not intersecting, and lies
/// not next to what was, keeps its positions to the bit, and a scene without intersections all of
/// them.
/// @pre validate(scene) passes
/// @param welded     see make_model(); vertices that are one go to one place
/// @param each_round see UntangleSettings
/// @throws TangledStart if contours remain: says what refuse_intersecting_start() does, and the
///         length of all contours, and length, meshes and place of the longest
void untangle_start(Scene& scene, const std::vector<unsigned char>& welded,
                    std::function<void()> each_round = {});

}  // namespace weft
