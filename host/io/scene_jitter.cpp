#include <cstdint>
#include <limits>

#include "host/io/scene_parts.hpp"

namespace weft::io {
namespace {

/// Larger shifts would crumple cloth, not jitter it.
constexpr double amplitude_of_edge = 0.1;

/// Steele, Lea & Flood 2014, "Fast splittable pseudorandom number generators" (SplitMix64).
/// @return in [-1, 1)
double next_random(std::uint64_t& state) {
  std::uint64_t z = (state += 0x9e3779b97f4a7c15u);
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
  z ^= z >> 31;
  return static_cast<double>(z >> 11) * 0x1p-52 - 1;
}

}  // namespace

void read_jitter(Fields& root, double edge, Scene& scene) {
  Fields fields = root.object("jitter", {"seed", "amplitude"});
  const std::int64_t seed = fields.integer("seed", 0, 0, std::numeric_limits<std::int32_t>::max());
  const double amplitude = fields.number("amplitude", 0.0);
  if (!(amplitude >= 0 && amplitude <= amplitude_of_edge * edge))
    fields.refuse("amplitude", "a length from 0 to a tenth of the cloths' cell size");
  if (amplitude == 0) return;
  auto state = static_cast<std::uint64_t>(seed);
  for (Cloth& cloth : scene.cloths)
    for (Vec3<double>& x : cloth.mesh.positions)
      for (int c = 0; c < 3; ++c) x[c] += amplitude * next_random(state);
}

}  // namespace weft::io
