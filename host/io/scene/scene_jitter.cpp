#include <cstdint>
#include <limits>

#include "host/base/random.hpp"
#include "host/io/scene/scene_parts.hpp"

namespace weft::io {
namespace {

/// Larger shifts would crumple cloth, not jitter it.
constexpr double amplitude_of_edge = 0.1;

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
