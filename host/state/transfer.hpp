#pragma once

#include <array>
#include <vector>

#include "host/state/store.hpp"

namespace weft {

/// Gives all vertices of a group one position, one velocity and one history: the means weighted by
/// mass, which preserves momentum. A group with prescribed vertices gets the values of the first of
/// these. Impact zones have moved the group as often as they have moved any of its vertices.
/// @param group [cloth vertices] lowest vertex number in the group of each vertex
/// @param fixed [vertices] 1 where the position is prescribed
template <class T>
StateSnapshot<T> merged_state(const Model& model, const std::vector<Index>& group,
                              const std::vector<unsigned char>& fixed, StateSnapshot<T> state);

/// Transfers a state to another topology. Each vertex of the new one is a vertex of the old one or
/// lies halfway between two. If no vertices are new, the history and the contact cache are kept, of
/// cloth with cloth only if no seam or glue pulls at other vertices. Otherwise
/// the result has none, and the next step of BDF2 is a step of implicit Euler.
/// @param state   of `from`; vertices that are one vertex in `to` must be at one place
/// @param parents for each refinement in between: [inputs after it] the two inputs before it that
///                each one lies between; twice the same: a vertex that existed before
template <class T>
StateSnapshot<T> transferred(const Model& from, const StateSnapshot<T>& state,
                             const std::vector<std::vector<std::array<Index, 2>>>& parents,
                             const Model& to);

}  // namespace weft
