#pragma once

#include <cstddef>

#include "weft/core/ids.hpp"

namespace weft {

/// A number as the containers of the standard library take it.
constexpr std::size_t at(Index i) noexcept {
  return static_cast<std::size_t>(i);
}

}  // namespace weft
