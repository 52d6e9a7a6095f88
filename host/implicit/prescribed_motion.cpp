#include "host/implicit/prescribed_motion.hpp"

#include <algorithm>
#include <cstddef>
#include <cstdio>
#include <limits>
#include <string>

#include "host/implicit/collision_response/prescribed.hpp"
#include "host/implicit/parallel/exchange.hpp"
#include "host/implicit/step_failure.hpp"
#include "weft/elements/scalar.hpp"
#include "weft/kernels/integrate/prescribe.hpp"

namespace weft {
namespace {

/// A number as messages show it.
std::string number_text(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.4g", value);
  return text;
}

/// A prescribed vertex has reached its target if it misses it by no more than this share of the
/// target's distance from the origin.
template <class T>
constexpr double rounding_share = 2 * static_cast<double>(epsilon<T>);

}  // namespace

template <class T>
PrescribedMotion<T>::PrescribedMotion(Store<T>& store, std::vector<RankGeometry<T>>& geometry,
                                      std::vector<RankMotion<T>>& motion, LinearSystem<T>& system)
    : store_(store), geometry_(geometry), motion_(motion), system_(system) {
  for (int r = 0; r < store.devices().size(); ++r) rank_targets_.emplace_back(store.devices()[r]);
}

template <class T>
void PrescribedMotion<T>::place(double time) {
  const Model& model = store_.model();
  const Scene& scene = store_.scene();
  DeviceSet& devices = store_.devices();
  const std::vector<unsigned char> fixed = fixed_vertices(scene, model, time);
  const bool fixed_changed = fixed != fixed_;
  if (fixed_changed) {
    fixed_ = fixed;
    system_.hold(fixed_);
  }
  const VertexRun placed = place_obstacles(scene, model, time, placed_);
  targets_.clear();
  for (const auto& p : model.pinned)
    if (fixed_[static_cast<std::size_t>(p.vertex)] != 0)
      targets_.push_back({p.vertex, vec_cast<T>(pinned_position(scene, p, time, placed_))});
  const auto first = static_cast<std::size_t>(placed.first);
  const auto last = static_cast<std::size_t>(placed.last);
  placed_rounded_.resize(placed_.size());
  for (std::size_t i = first; i < last; ++i) placed_rounded_[i] = vec_cast<T>(placed_[i]);
  const auto cloth = static_cast<std::size_t>(model.cloth_vertex_count);
  for (int r = 0; r < devices.size(); ++r) {
    const auto n = static_cast<std::size_t>(r);
    Queue& queue = devices[r].compute();
    if (fixed_changed) queue.copy(geometry_[n].fixed.data(), fixed_.data(), fixed_.size());
    queue.copy(motion_[n].positions_t1.data() + cloth, placed_rounded_.data(),
               placed_rounded_.size() * sizeof(Vec3<T>));
    rank_targets_[n].resize(targets_.size());
    queue.copy(rank_targets_[n].data(), targets_.data(), targets_.size() * sizeof(MovedVertex<T>));
    launch(queue, IntegratePrescribe<T>{rank_targets_[n].span(), motion_[n].positions_t1.span()});
  }
}

template <class T>
double PrescribedMotion<T>::farthest() const {
  Queue& master = store_.devices()[0].compute();
  const std::vector<Vec3<T>> from = download(master, store_.rank(0).positions);
  const std::vector<Vec3<T>> to = download(master, motion_.front().positions_t1);
  double farthest = 0;
  for (std::size_t v = 0; v < from.size(); ++v)
    if (fixed_[v] != 0) farthest = std::max(farthest, static_cast<double>(length(to[v] - from[v])));
  return farthest;
}

template <class T>
typename PrescribedMotion<T>::Misses PrescribedMotion<T>::misses() const {
  const Model& model = store_.model();
  const Scene& scene = store_.scene();
  Queue& master = store_.devices()[0].compute();
  const std::vector<Vec3<T>> x0 = download(master, store_.rank(0).positions);
  const std::vector<Vec3<T>> x1 = download(master, motion_[0].positions_t1);
  Misses all;
  const auto look = [&](Index vertex, const Vec3<double>& target_t0, const Vec3<T>& target_t1) {
    const auto v = static_cast<std::size_t>(vertex);
    const auto distance = static_cast<double>(length(x1[v] - target_t1));
    if (!(distance > rounding_share<T> * static_cast<double>(length(target_t1)))) return;
    ++all.count;
    all.distance = std::max(all.distance, distance);
    all.farther = std::max(all.farther, distance - length(vec_cast<double>(x0[v]) - target_t0));
    const double allowed = compliance_distance(scene.contact);
    const double over = allowed > 0 ? distance / allowed : std::numeric_limits<double>::infinity();
    if (over > 1) all.over.push_back(vertex);
    if (over <= all.over_limit) return;
    all.over_limit = over;
    all.worst = vertex;
    all.worst_distance = distance;
  };
  std::vector<Vec3<double>> placed_t0;
  place_obstacles(scene, model, store_.time, placed_t0);
  for (std::size_t i = 0; i < placed_t0.size(); ++i)
    look(model.cloth_vertex_count + static_cast<Index>(i), placed_t0[i], placed_rounded_[i]);
  auto target = targets_.begin();
  for (const Model::PinnedVertex& p : model.pinned) {
    if (fixed_[static_cast<std::size_t>(p.vertex)] == 0) continue;
    look(p.vertex, pinned_position(scene, p, store_.time, placed_t0), target->position);
    ++target;
  }
  return all;
}

template <class T>
bool PrescribedMotion<T>::fail_by(const Misses& c, double dt, StepReport& report) const {
  Vec3<T> place;
  Queue& master = store_.devices()[0].compute();
  master.copy(&place, motion_[0].positions_t1.data() + c.worst, sizeof place);
  master.sync();
  std::string where;
  for (int i = 0; i < 3; ++i)
    where += (i > 0 ? ", " : "") + number_text(static_cast<double>(place[i]));
  return fail(report, Failure::pinched,
              "cloth keeps " + prescribed_names(store_.scene(), store_.model(), c.over) +
                  " from the prescribed place: " + number_text(c.worst_distance) + " m short at (" +
                  where + ") at " + number_text(store_.time + dt) +
                  " s; contact.compliance_distance allows " +
                  number_text(compliance_distance(store_.scene().contact)),
              vec_cast<double>(place));
}

template class PrescribedMotion<float>;
template class PrescribedMotion<double>;

}  // namespace weft
