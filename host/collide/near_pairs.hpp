#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>

#include "weft/state/contact.hpp"

namespace weft {

/// Calls look(number) for the pairs that are not far, in their order. Few pairs of cloth at rest
/// are near, anywhere in memory and in the list: they are fetched while others are passed over, and
/// found without a branch.
/// @param is_far a cheap test, called once for each pair
/// @param done   whether to leave out the rest
template <class IsFar, class Look, class Done>
void visit_near_pairs(const Pair* pairs, std::size_t count, const IsFar& is_far, const Look& look,
                      const Done& done) {
  constexpr std::size_t chunk = 256;
  std::uint32_t near[chunk];
  for (std::size_t begin = 0; begin < count && !done(); begin += chunk) {
    const auto size = static_cast<std::uint32_t>(std::min(chunk, count - begin));
    std::size_t found = 0;
    for (std::uint32_t k = 0; k < size; ++k) {
      near[found] = k;
      found += is_far(begin + k) ? 0 : 1;
    }
    for (std::size_t k = 0; k < found; ++k) __builtin_prefetch(pairs + begin + near[k]);
    for (std::size_t k = 0; k < found && !done(); ++k) look(begin + near[k]);
  }
}

}  // namespace weft
