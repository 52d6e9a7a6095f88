#include "host/simulation/weld_open_pairs.hpp"

#include <cstddef>
#include <utility>

#include "host/scene/intersection_check.hpp"
#include "host/state/transfer.hpp"
#include "host/untangle/untangle_scene.hpp"
#include "weft/core/at.hpp"
#include "weft/error.hpp"

namespace weft {
namespace {

/// [weld distances of the seam] Half the length of an edge where weft sews garments.
constexpr double most_open_gap = 5;

/// The scene as it is in a state, with obstacles that stand still.
template <class T>
Scene starting_at(const StateSnapshot<T>& state, const Scene& scene, const Model& model) {
  Scene start = scene;
  for (std::size_t c = 0; c < start.cloths.size(); ++c)
    for (std::size_t v = 0; v < start.cloths[c].mesh.positions.size(); ++v)
      start.cloths[c].mesh.positions[v] =
          vec_cast<double>(state.positions[at(model.to_internal[at(model.input_offset[c]) + v])]);
  for (Obstacle& obstacle : start.obstacles) {
    obstacle.mesh.positions.clear();
    obstacle.deformation.reset();
    obstacle.motion.clear();
    obstacle.transform = {};
  }
  for (std::size_t i = 0; i < model.obstacle_of_vertex.size(); ++i)
    start.obstacles[at(model.obstacle_of_vertex[i])].mesh.positions.push_back(
        vec_cast<double>(state.positions[at(model.cloth_vertex_count) + i]));
  return start;
}

}  // namespace

template <class T>
Welding<T> weld_open_pairs(const Store<T>& store, const Sewing& sewing,
                           std::function<void()> each_round) {
  const Scene& scene = store.scene();
  const Model& model = store.model();
  StateSnapshot<T> state = store.snapshot();
  Welding<T> result{sewing.welded, sewing.refused, {}};
  const std::vector<unsigned char> fixed = fixed_vertices(scene, model, store.time);
  std::vector<SeamPair> pairs = seam_pairs(scene);
  std::vector<SeamPair> joined;
  for (std::size_t k = 0; k < pairs.size(); ++k) {
    for (Index& v : pairs[k].v) v = model.to_internal[at(v)];
    const auto [a, b] = pairs[k].v;
    const auto gap = static_cast<double>(length(state.positions[at(b)] - state.positions[at(a)]));
    if (fixed[at(a)] == 0 && fixed[at(b)] == 0 && pairs[k].weld_distance > 0 &&
        gap <= most_open_gap * pairs[k].weld_distance)
      result.welded[k] = 1;
    if (result.welded[k] != 0) joined.push_back(pairs[k]);
  }
  if (result.welded == sewing.welded) return result;
  state = merged_state(model, grouped(model.to_input.size(), joined), fixed, std::move(state));
  Scene apart = starting_at(state, scene, model);
  try {
    untangle_start(apart, result.welded, std::move(each_round));
    for (Cloth& cloth : apart.cloths)
      for (Vec3<double>& x : cloth.mesh.positions) x = vec_cast<double>(vec_cast<T>(x));
    refuse_intersecting_start(apart, result.welded);
  } catch (const SceneError&) {
    result.welded = sewing.welded;
    return result;
  }
  for (std::size_t c = 0; c < apart.cloths.size(); ++c)
    for (std::size_t v = 0; v < apart.cloths[c].mesh.positions.size(); ++v) {
      const auto moved = at(model.to_internal[at(model.input_offset[c]) + v]);
      const Vec3<T> place = vec_cast<T>(apart.cloths[c].mesh.positions[v]);
      // Resolving intersections gives no velocity.
      state.previous_positions[moved] += place - state.positions[moved];
      state.positions[moved] = place;
    }
  // Contacts may be on the wrong side of a layer now.
  state.contacts.clear();
  state.face_contacts = 0;
  result.refused.clear();
  result.state = std::move(state);
  return result;
}

template Welding<float> weld_open_pairs(const Store<float>&, const Sewing&, std::function<void()>);
template Welding<double> weld_open_pairs(const Store<double>&, const Sewing&,
                                         std::function<void()>);

}  // namespace weft
