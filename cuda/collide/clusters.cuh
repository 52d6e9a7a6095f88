#pragma once

#include "weft/kernels/collide/boxes.hpp"

namespace weft {

/// Submits the boxes of all primitives, around their clusters and around groups of these, from the
/// swept AABBs as they stand; those of obstacles if the last search made them.
template <class T>
void remake_clusters(Queue& queue, const CollideBoxes<T>& boxes);

}  // namespace weft
