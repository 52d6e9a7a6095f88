#pragma once

#include <cstdint>

namespace weft {

/// The next of a sequence of pseudorandom numbers, the same everywhere: SplitMix64 (Steele, Lea &
/// Flood 2014, "Fast splittable pseudorandom number generators").
/// @return in [-1, 1)
inline double next_random(std::uint64_t& state) {
  std::uint64_t z = (state += 0x9e3779b97f4a7c15u);
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
  z ^= z >> 31;
  return static_cast<double>(z >> 11) * 0x1p-52 - 1;
}

}  // namespace weft
