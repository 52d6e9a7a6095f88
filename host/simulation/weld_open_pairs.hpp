#pragma once

#include <functional>

#include "host/simulation/sew.hpp"

namespace weft {

/// Welds pairs of seams that springs could not close, as at corners where several seams meet. Each
/// becomes a vertex halfway, and intersections that this causes are resolved as at the start, see
/// untangle_start(). Pairs farther apart than half an edge stay open, and so do pairs with a
/// prescribed vertex.
/// @param scene      of the store
/// @param each_round see untangle_start()
/// @return           no state if there are no such pairs, or intersections remain
template <class T>
Welding<T> weld_open_pairs(const Store<T>& store, const Sewing& sewing,
                           std::function<void()> each_round);

}  // namespace weft
