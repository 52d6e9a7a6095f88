// How far what is prescribed gives way to cloth in between.
#include <algorithm>
#include <cstddef>
#include <vector>

#include "host/implicit/parallel/exchange.hpp"
#include "host/implicit/step.hpp"

namespace weft {

template <class T>
typename ImplicitStep<T>::ObstacleCompliance ImplicitStep<T>::measure_compliance() {
  const Model& model = store_.model();
  const Scene& scene = store_.scene();
  Queue& master = store_.devices()[0].compute();
  const std::vector<unsigned char>& compliant = zones_.compliant();
  const std::vector<Vec3<T>> x0 = download(master, store_.rank(0).positions);
  const std::vector<Vec3<T>> x1 = download(master, motion_[0].positions_t1);
  ObstacleCompliance all;
  all.count = static_cast<int>(compliant.size()) -
              static_cast<int>(std::count(compliant.begin(), compliant.end(), 0));
  const auto look = [&](std::size_t v, const Vec3<double>& wanted_t0, const Vec3<T>& wanted_t1) {
    if (compliant[v] == 0) return;
    const auto distance = static_cast<double>(length(x1[v] - wanted_t1));
    all.distance = std::max(all.distance, distance);
    all.farther = std::max(all.farther, distance - length(vec_cast<double>(x0[v]) - wanted_t0));
  };
  std::vector<Vec3<double>> placed_t0;
  place_obstacles(scene, model, store_.time, placed_t0);
  for (std::size_t i = 0; i < placed_t0.size(); ++i)
    look(static_cast<std::size_t>(model.cloth_vertex_count) + i, placed_t0[i], placed_rounded_[i]);
  auto target = targets_.begin();
  for (const Model::PinnedVertex& p : model.pinned) {
    const auto v = static_cast<std::size_t>(p.vertex);
    if (fixed_[v] == 0) continue;
    look(v, pinned_position(scene, p, store_.time, placed_t0), target->position);
    ++target;
  }
  return all;
}

template ImplicitStep<float>::ObstacleCompliance ImplicitStep<float>::measure_compliance();
template ImplicitStep<double>::ObstacleCompliance ImplicitStep<double>::measure_compliance();

}  // namespace weft
