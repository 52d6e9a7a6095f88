#pragma once

#include <vector>

#include "host/state/store.hpp"
#include "weft/handle_state.hpp"

namespace weft {

/// What each handle of the store's scene does now.
template <class T>
std::vector<HandleState> handle_states(const Store<T>& store);

}  // namespace weft
