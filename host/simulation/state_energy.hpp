#pragma once

#include "host/state/store.hpp"
#include "weft/report.hpp"

namespace weft {

/// Of the state that the store has, for its scene. [J]
template <class T>
Energy energy_of(Store<T>& store);

}  // namespace weft
