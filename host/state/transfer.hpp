#pragma once

#include <array>
#include <vector>

#include "host/state/store.hpp"

namespace weft {

/// The state with groups of cloth vertices at one place and of one velocity: the means by mass, so
/// that momentum is kept; of a group with prescribed vertices those of the first of them.
/// @param group [cloth vertices] lowest number of each one's group
/// @param fixed [vertices] 1 where the position is prescribed
template <class T>
StateSnapshot<T> merged_state(const Model& model, const std::vector<Index>& group,
                              const std::vector<unsigned char>& fixed, StateSnapshot<T> state);

/// The state of one topology in another whose vertices are one, or lie between, vertices of the
/// first. Starts without history, so that the next step of BDF2 is one of implicit Euler.
/// @param state   of `from`, in which vertices that are one in `to` stand in one place
/// @param parents for each refinement in between [inputs after it] the two inputs before it that
///                each lies between
template <class T>
StateSnapshot<T> transferred(const Model& from, const StateSnapshot<T>& state,
                             const std::vector<std::vector<std::array<Index, 2>>>& parents,
                             const Model& to);

}  // namespace weft
