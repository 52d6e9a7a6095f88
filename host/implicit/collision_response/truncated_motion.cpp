#include "host/implicit/collision_response/truncated_motion.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "weft/core/at.hpp"

namespace weft {
namespace {

/// Share of the way to its collision that a vertex goes: some gap is left to begin the next step.
constexpr double share_before_collision = 0.9;
/// Rounds of clusters that shorten the same vertices.
constexpr int rounds_per_stage = 3;
/// Rounds of planes: that only free vertices keep; that all keep; that also shorten what collides.
constexpr int plane_rounds_free = 3;
constexpr int plane_rounds = 10;
constexpr int plane_rounds_shortened = 20;
/// Sweeps over the carriers of a cluster to get out of the way of all of them.
constexpr int ride_sweeps = 10;
/// Free weight of a collision below which the cluster cannot open it.
constexpr double weight_least = 0.05;

}  // namespace

template <class T>
void TruncatedMotion<T>::begin(std::vector<Vec3<T>> from, std::vector<Vec3<T>> to,
                               const std::vector<unsigned char>& held, TruncationKind kind,
                               double thickness) {
  from_ = std::move(from);
  to_ = std::move(to);
  end_ = to_;
  held_ = held;
  kind_ = kind;
  own_share_.assign(to_.size(), T(1));
  share_.assign(to_.size(), T(1));
  ride_.assign(to_.size(), Vec3<double>{});
  cluster_.resize(to_.size());
  for (std::size_t v = 0; v < to_.size(); ++v) cluster_[v] = static_cast<Index>(v);
  carriers_.clear();
  if (kind == TruncationKind::planes) planes_.begin(from_, to_, held_, thickness);
  round_ = 0;
}

template <class T>
const std::vector<MovedVertex<T>>& TruncatedMotion<T>::shorten(Span<const Collision> collisions) {
  ++round_;
  if (round_ >= rounds_max) {
    std::fill(share_.begin(), share_.end(), T(0));
  } else if (kind_ == TruncationKind::planes) {
    keep_planes(collisions);
  } else {
    join(collisions);
    find_rides();
    limit(collisions);
  }
  find_moved();
  return moved_;
}

template <class T>
Index TruncatedMotion<T>::cluster_of(Index v) {
  while (cluster_[at(v)] != v) v = cluster_[at(v)] = cluster_[at(cluster_[at(v)])];
  return v;
}

/// Joins the free vertices of each collision, and notes what runs into them.
template <class T>
void TruncatedMotion<T>::join(Span<const Collision> collisions) {
  for (const Collision& c : collisions) {
    Carrier carrier{-1, {}, c.n, 0, 0};
    bool any_held = false;
    for (int j = 0; j < 4; ++j) {
      const Index v = c.v[j];
      if (held_[at(v)] != 0) {
        any_held = true;
        const auto u = vec_cast<double>(to_[at(v)] - from_[at(v)]);
        carrier.approach += c.w[j] * dot(c.n, u);
        if (length_sq(u) > length_sq(carrier.displacement)) carrier.displacement = u;
        continue;
      }
      carrier.weight += c.w[j];
      const Index own = cluster_of(v);
      if (carrier.cluster < 0) carrier.cluster = own;
      const Index first = std::min(own, carrier.cluster);
      cluster_[at(std::max(own, carrier.cluster))] = first;
      carrier.cluster = first;
    }
    if (kind_ == TruncationKind::rides && any_held && carrier.cluster >= 0 &&
        std::abs(carrier.weight) >= weight_least)
      carriers_.push_back(carrier);
  }
}

/// What each cluster rides along with.
template <class T>
void TruncatedMotion<T>::find_rides() {
  for (Carrier& c : carriers_) {
    ride_[at(c.cluster)] = {};
    c.cluster = cluster_of(c.cluster);
    ride_[at(c.cluster)] = {};
  }
  for (const Carrier& c : carriers_)
    if (length_sq(c.displacement) > length_sq(ride_[at(c.cluster)]))
      ride_[at(c.cluster)] = c.displacement;
  for (int sweep = 0; sweep < ride_sweeps; ++sweep)
    for (const Carrier& c : carriers_) {
      const double closing = -(c.weight * dot(c.n, ride_[at(c.cluster)]) + c.approach);
      if (closing > 0) ride_[at(c.cluster)] += (closing / c.weight) * c.n;
    }
}

/// Shortens what collides, as the round says.
template <class T>
void TruncatedMotion<T>::limit(Span<const Collision> collisions) {
  const bool held_too = kind_ == TruncationKind::shares || round_ > rounds_per_stage;
  const bool clusters_ride = round_ > 2 * rounds_per_stage;
  const bool all_stay = round_ > 3 * rounds_per_stage;
  const std::vector<T> own_before = own_share_;
  const std::vector<T> before = share_;
  std::vector<unsigned char> rides(to_.size(), 0);
  for (const Collision& c : collisions) {
    const auto ahead = static_cast<T>(share_before_collision * c.toi);
    for (const Index v : c.v) {
      if (held_[at(v)] == 0) {
        own_share_[at(v)] = std::min(own_share_[at(v)], ahead * own_before[at(v)]);
        rides[at(cluster_of(v))] = 1;
      } else if (all_stay) {
        share_[at(v)] = T(0);
      } else if (held_too) {
        share_[at(v)] = std::min(share_[at(v)], ahead * before[at(v)]);
      }
    }
  }
  if (!clusters_ride) return;
  for (std::size_t v = 0; v < to_.size(); ++v) {
    if (held_[v] != 0 || rides[at(cluster_of(static_cast<Index>(v)))] == 0) continue;
    own_share_[v] = T(0);
    if (all_stay) share_[v] = T(0);
  }
}

template <class T>
void TruncatedMotion<T>::keep_planes(Span<const Collision> collisions) {
  if (round_ <= plane_rounds) {
    planes_.add(collisions);
    planes_.keep(round_ > plane_rounds_free);
    return;
  }
  const std::vector<T> before = share_;
  for (const Collision& c : collisions) {
    const auto ahead = static_cast<T>(share_before_collision * c.toi);
    for (const Index v : c.v)
      share_[at(v)] =
          round_ > plane_rounds_shortened ? T(0) : std::min(share_[at(v)], ahead * before[at(v)]);
  }
}

template <class T>
void TruncatedMotion<T>::find_moved() {
  moved_.clear();
  for (std::size_t v = 0; v < to_.size(); ++v) {
    const Vec3<T> end = end_of(v);
    if (end == end_[v]) continue;
    end_[v] = end;
    moved_.push_back({static_cast<Index>(v), end});
  }
}

template <class T>
Vec3<T> TruncatedMotion<T>::end_of(std::size_t v) {
  if (!(share_[v] > T(0))) return from_[v];
  if (kind_ == TruncationKind::planes) {
    const auto end = vec_cast<T>(planes_.ends()[v]);
    return share_[v] == T(1) ? end : from_[v] + share_[v] * (end - from_[v]);
  }
  if (share_[v] == T(1) && own_share_[v] == T(1)) return to_[v];
  const Vec3<T> way = to_[v] - from_[v];
  const Vec3<T> ride =
      held_[v] != 0 ? way : vec_cast<T>(ride_[at(cluster_of(static_cast<Index>(v)))]);
  return from_[v] + share_[v] * (ride + own_share_[v] * (way - ride));
}

template class TruncatedMotion<float>;
template class TruncatedMotion<double>;

}  // namespace weft
