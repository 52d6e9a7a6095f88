#include "host/app/view/pin_distances.hpp"

#include <cstddef>

namespace weft::app {

std::vector<std::vector<float>> pin_distances(const Scene& scene,
                                              const std::vector<io::NamedMesh>& cloths,
                                              double time) {
  if (cloths.size() != scene.cloths.size()) return {};
  std::vector<std::vector<float>> distances;
  for (std::size_t c = 0; c < cloths.size(); ++c) {
    const std::size_t count = cloths[c].mesh.positions.size();
    if (count != scene.cloths[c].mesh.positions.size()) return {};
    distances.emplace_back(count, std::nanf(""));
  }
  bool any = false;
  for (const Pin& pin : scene.pins) {
    if (pin.obstacle >= 0 || time >= pin.release_time) continue;
    const auto cloth = static_cast<std::size_t>(pin.cloth);
    for (const Index vertex : pin.vertices) {
      const auto v = static_cast<std::size_t>(vertex);
      const Vec3<double>& start = scene.cloths[cloth].mesh.positions[v];
      const Vec3<double> place =
          pin.motion.empty() ? start : apply(transform_at(pin.motion, time), start);
      distances[cloth][v] = static_cast<float>(length(cloths[cloth].mesh.positions[v] - place));
      any = true;
    }
  }
  if (!any) return {};
  return distances;
}

}  // namespace weft::app
