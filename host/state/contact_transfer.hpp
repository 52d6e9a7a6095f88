#pragma once

#include <vector>

#include "host/state/store.hpp"

namespace weft {

/// Gives a state the contact cache of another topology, in the numbers of its own. A contact stays
/// if all of its vertices and both of its primitives still exist and have no vertex in common.
/// Contacts that become one bear the sum of their forces: a welded vertex or edge is pressed as
/// hard as its parts were.
/// @param state  of `from`
/// @param vertex [vertices of from] number in `to`; -1: none
/// @param keep_self whether contacts of cloth with cloth stay too
/// @param result of `to`; its contacts are replaced
template <class T>
void transfer_contacts(const Model& from, const StateSnapshot<T>& state,
                       const std::vector<Index>& vertex, const Model& to, bool keep_self,
                       StateSnapshot<T>& result);

}  // namespace weft
