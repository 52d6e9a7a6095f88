#pragma once

#include <functional>

#include "host/simulation/sew.hpp"

namespace weft {

/// Welds pairs of seams that springs could not close, as at corners where several seams meet, at
/// the mean of their places, and moves cloth out of all that it intersects then, as at the start
/// (see untangle_start()). Pairs farther apart than most_open_gap, and
/// those of vertices that something prescribes, stay open.
/// @param scene      of the store
/// @param each_round see untangle_start()
/// @return           no state if there are no such pairs, or intersections remain
template <class T>
Welding<T> weld_open_pairs(const Store<T>& store, const Sewing& sewing,
                           std::function<void()> each_round);

/// [weld distances of the seam] Half the length of an edge where weft sews garments.
inline constexpr double most_open_gap = 5;

}  // namespace weft
