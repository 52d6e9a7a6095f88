#pragma once

#include <vector>

#include "host/implicit/step.hpp"
#include "host/scene/sewing.hpp"

namespace weft {

/// Finds pairs of seams that can become one vertex now: they are as close as their seam welds, and
/// on their way to each other nothing is hit but what they are welded to.
/// @param sewing of the store's scene
/// @return [seam_pairs] as in Sewing, with those that are welded already
template <class T>
std::vector<unsigned char> weldable_pairs(Store<T>& store, ImplicitStep<T>& implicit,
                                          const Sewing& sewing);

/// The state of the store with the pairs that `welded` names in one place, in the order that the
/// store has. Momentum is kept.
template <class T>
StateSnapshot<T> welded_state(Store<T>& store, const std::vector<unsigned char>& welded);

}  // namespace weft
