#pragma once

#include <optional>
#include <vector>

#include "host/implicit/step.hpp"
#include "host/scene/seams/sewing.hpp"

namespace weft {

/// Pairs of seams that can become one vertex, and the state in which they are.
template <class T>
struct Welding {
  std::vector<unsigned char> welded;      ///< [seam_pairs] as in Sewing, with those welded before
  std::vector<unsigned char> refused;     ///< [seam_pairs] as in Sewing, with those refused before
  std::optional<StateSnapshot<T>> state;  ///< in the order of the store; none: none are new
};

/// Finds pairs of seams that can be welded now: they are as close as their seam welds, and on their
/// way to one place nothing is hit but what they are welded to. This place is the mean weighted by
/// mass. If something is hit on the way there, as where a seam lies across an edge of a body, the
/// place is moved away from it, by up to three times the distance of the vertices from their mean.
/// Momentum is kept.
/// @param sewing of the store's scene; pairs that it has refused are left out
/// @param least  share of the pairs that have to be close enough; fewer wait
/// @param report of the step that ends, counts the searches for collisions
template <class T>
Welding<T> weld_close_pairs(Store<T>& store, ImplicitStep<T>& implicit, const Sewing& sewing,
                            double least, StepReport& report);

}  // namespace weft
