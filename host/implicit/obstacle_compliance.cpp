// How far prescribed vertices miss their targets because cloth is in between.
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdio>
#include <limits>
#include <string>
#include <vector>

#include "host/implicit/collision_response/prescribed.hpp"
#include "host/implicit/parallel/exchange.hpp"
#include "host/implicit/step.hpp"
#include "weft/elements/scalar.hpp"

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

/// [m] by which prescribed vertex v may miss its target.
template <class T>
double ImplicitStep<T>::compliance_limit(Index v) const {
  return declared_compliance(store_.scene(), store_.model(), v)
      .value_or(compliance_distance(store_.scene().contact));
}

template <class T>
typename ImplicitStep<T>::ObstacleCompliance ImplicitStep<T>::measure_compliance() {
  const Model& model = store_.model();
  const Scene& scene = store_.scene();
  Queue& master = store_.devices()[0].compute();
  const std::vector<Vec3<T>> x0 = download(master, store_.rank(0).positions);
  const std::vector<Vec3<T>> x1 = download(master, motion_[0].positions_t1);
  ObstacleCompliance all;
  const auto look = [&](Index vertex, const Vec3<double>& target_t0, const Vec3<T>& target_t1) {
    const auto v = static_cast<std::size_t>(vertex);
    const auto distance = static_cast<double>(length(x1[v] - target_t1));
    if (!(distance > rounding_share<T> * static_cast<double>(length(target_t1)))) return;
    ++all.count;
    all.distance = std::max(all.distance, distance);
    all.farther = std::max(all.farther, distance - length(vec_cast<double>(x0[v]) - target_t0));
    const double limit = compliance_limit(vertex);
    const double over = limit > 0 ? distance / limit : std::numeric_limits<double>::infinity();
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

/// Fails the step because prescribed vertices would miss their targets by more than they may.
template <class T>
bool ImplicitStep<T>::fail_compliance(const ObstacleCompliance& c, double dt, StepReport& report) {
  Vec3<T> place;
  Queue& master = store_.devices()[0].compute();
  master.copy(&place, motion_[0].positions_t1.data() + c.worst, sizeof place);
  master.sync();
  const bool own = declared_compliance(store_.scene(), store_.model(), c.worst) !=
                   store_.scene().contact.compliance_distance;
  const std::string allowing = own ? "its compliance" : "contact.compliance_distance";
  std::string where;
  for (int i = 0; i < 3; ++i)
    where += (i > 0 ? ", " : "") + number_text(static_cast<double>(place[i]));
  return fail(report, Failure::pinched,
              "cloth keeps " + prescribed_names(store_.scene(), store_.model(), c.over) +
                  " from the prescribed place: " + number_text(c.worst_distance) + " m short at (" +
                  where + ") at " + number_text(store_.time + dt) + " s; " + allowing + " allows " +
                  number_text(compliance_limit(c.worst)),
              vec_cast<double>(place));
}

template double ImplicitStep<float>::compliance_limit(Index) const;
template double ImplicitStep<double>::compliance_limit(Index) const;
template ImplicitStep<float>::ObstacleCompliance ImplicitStep<float>::measure_compliance();
template ImplicitStep<double>::ObstacleCompliance ImplicitStep<double>::measure_compliance();
template bool ImplicitStep<float>::fail_compliance(const ObstacleCompliance&, double, StepReport&);
template bool ImplicitStep<double>::fail_compliance(const ObstacleCompliance&, double, StepReport&);

}  // namespace weft
