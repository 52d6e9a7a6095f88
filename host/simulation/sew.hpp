#pragma once

#include <optional>
#include <vector>

#include "host/implicit/step.hpp"
#include "host/scene/sewing.hpp"

namespace weft {

/// Pairs of seams that can become one vertex, and the state in which they are.
template <class T>
struct Welding {
  std::vector<unsigned char> welded;  ///< [seam_pairs] as in Sewing, with those welded before
  StateSnapshot<T> state;             ///< in the order that the store has; momentum is kept
};

/// Finds pairs of seams that can be welded now: they are as close as their seam welds, and on their
/// way to one place nothing is hit but what they are welded to. This place is the mean weighted by
/// mass. If something is hit on the way there, as where a seam lies across an edge of a body, the
/// place is moved away from it, by up to three times the distance of the vertices from their mean.
/// @param sewing of the store's scene
/// @return none if there is no such pair
template <class T>
std::optional<Welding<T>> weld_close_pairs(Store<T>& store, ImplicitStep<T>& implicit,
                                           const Sewing& sewing);

}  // namespace weft
