#include "host/implicit/collision_response/zone_energy.hpp"

#include <algorithm>
#include <cmath>

#include "host/implicit/parallel/exchange.hpp"
#include "host/model/material_rows.hpp"
#include "host/model/springs.hpp"
#include "host/state/energy.hpp"

namespace weft {
namespace {

/// Of what a step has to turn into other forms, its kinetic energy at the start and what gravity
/// does: no step of an integrator that dissipates gains any of it.
constexpr double gain_max = 0.01;
/// Over the size of the cloth: what gravity alone does in a short step. What zones do there the
/// next solve mostly makes good.
constexpr double fall_min = 0.002;
/// Nor does it make good what a short step gains beyond this share: edges longer than what they lie
/// on let zones hold back whole triangles, and the next solve throws these, several times as fast,
/// into each other.
constexpr double short_gain_max = 0.25;
/// Impacts a vertex of the cloth from which a short step is looked at: with fewer, zones hold back
/// too little of it for such a share, and looking takes fine meshes longer than the whole step.
constexpr double impacts_min = 1.0 / 32;
/// Below this motion, in mean edges, it is not looked for either.
constexpr double motion_min = 0.05;

/// Energy that zones may add, over the energy of the cloth at the start and that of its free fall
/// in the step.
constexpr double stretch_max = 0.1;
/// The same for some steps after one whose shortest parts added more: bisecting helps little there.
/// Most energy at play may be that of cloth that a body carries along, so that the whole of it
/// would let elastic energy grow tenfold in a step.
constexpr double stretch_in_jams = 0.3;

/// Whether a step can gain energy only from gravity, bodies and pins.
template <class T>
bool only_gravity_acts(const Store<T>& store) {
  const Scene& scene = store.scene();
  return store.accelerations().empty() && scene.handles.empty() &&
         !any_seam_open(scene, store.model()) && scene.wind.density == 0 &&
         std::none_of(scene.cloths.begin(), scene.cloths.end(),
                      [](const Cloth& c) { return c.pressure != 0; });
}

/// Whether bodies or pins ever move.
bool anything_moves(const Scene& scene) {
  return std::any_of(scene.obstacles.begin(), scene.obstacles.end(), obstacle_moves) ||
         std::any_of(scene.pins.begin(), scene.pins.end(), pin_moves);
}

}  // namespace

template <class T>
bool ZoneEnergy<T>::gained(double dt, std::size_t impacts_met,
                           const std::vector<unsigned char>& fixed) const {
  const Model& model = store_.model();
  const Scene& scene = store_.scene();
  if (!only_gravity_acts(store_)) return false;
  const double size = std::sqrt(model.whole.area);
  const bool long_step = length(scene.gravity) * dt * dt > fall_min * size;
  const auto impacts = static_cast<double>(impacts_met);
  if (!long_step && impacts < impacts_min * model.whole.vertices) return false;
  Queue& master = store_.devices()[0].compute();
  const auto x0 = cast_all<double>(download(master, store_.rank(0).positions));
  const auto x1 = cast_all<double>(download(master, motion_[0].positions_t1));
  double farthest_sq = 0;
  for (std::size_t v = 0; v < x0.size(); ++v) {
    const double moved_sq = length_sq(x1[v] - x0[v]);
    const bool prescribed =
        v >= static_cast<std::size_t>(model.cloth_vertex_count) || fixed[v] != 0;
    if (prescribed && moved_sq > 0) return false;
    farthest_sq = std::max(farthest_sq, moved_sq);
  }
  const double least = motion_min * model.mean_edge;
  if (farthest_sq <= least * least) return false;
  const auto plate = store_.plate(fixed);
  const auto measure = [&](const std::vector<Vec3<double>>& x, const Buffer<Vec3<T>>& v) {
    return measure_energy(scene, model, x, cast_all<double>(download(master, v)), {}, *plate);
  };
  const Energy before = measure(x0, store_.rank(0).velocities);
  const Energy after = measure(x1, motion_[0].velocities_t1);
  const double fallen = after.gravitational - before.gravitational;
  const double gain = after.kinetic - before.kinetic + after.elastic - before.elastic + fallen;
  return gain > (long_step ? gain_max : short_gain_max) * (before.kinetic + std::abs(fallen));
}

template <class T>
bool ZoneEnergy<T>::stretched(double dt, bool must_stand) {
  const Backoff& backoff = store_.backoff;
  if (backoff.truncated > 0 || zones_.any_compliant() || !only_gravity_acts(store_) ||
      !anything_moves(store_.scene()))
    return false;
  using Spans = std::vector<Span<const Vec3<T>>>;
  Spans held, held_v, free, free_v;
  for (int r = 0; r < store_.devices().size(); ++r) {
    const RankMotion<T>& m = motion_[static_cast<std::size_t>(r)];
    held.push_back(m.positions_t1.span());
    held_v.push_back(m.velocities_t1.span());
    free.push_back(zones_.free_positions(r));
    free_v.push_back(zones_.free_velocities(r));
  }
  const double of_free = system_.step_energy(free, free_v).at_start;
  const double stretch = system_.step_energy(held, free_v).at_start - of_free;
  if (stretch <= 0) return false;
  const double both = system_.step_energy(held, held_v).at_start - of_free;
  const double gain = std::min(stretch, both);
  if (gain <= 0) return false;
  const double fall = length(store_.scene().gravity) * dt;
  const double at_play =
      system_.step_energy().at_start + 0.5 * store_.model().whole.mass * fall * fall;
  const bool too_far = gain > stretch_max * at_play;
  stretched_at_last_ = stretched_at_last_ || (too_far && must_stand);
  if (must_stand) return false;
  return backoff.stretched > 0 ? gain > stretch_in_jams * at_play : too_far;
}

template <class T>
bool ZoneEnergy<T>::broke_limits() const {
  const Backoff& backoff = store_.backoff;
  if (backoff.truncated > 0 || backoff.stretched > 0 || !has_limits(store_.model().laws->rows))
    return false;
  std::vector<Span<const Vec3<T>>> free, free_v;
  for (int r = 0; r < store_.devices().size(); ++r) {
    free.push_back(zones_.free_positions(r));
    free_v.push_back(zones_.free_velocities(r));
  }
  return !std::isfinite(system_.step_energy(free, free_v).limited);
}

template class ZoneEnergy<float>;
template class ZoneEnergy<double>;

}  // namespace weft
