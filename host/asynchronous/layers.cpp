#include "host/asynchronous/layers.hpp"

#include "weft/core/at.hpp"

#include <algorithm>
#include <limits>
#include <utility>

namespace weft {
namespace {

/// Layers are kept until the pair is so much farther than they are thick: contacts hover about
/// that distance, and each layer that is dropped too early costs a window that is rolled back.
constexpr double kept_share = 1.1;
/// Slabs that spare a pair the look at its closest points are so much thicker than the layer: much
/// more than what both are rounded by.
constexpr double layer_slab_margin = 1e-6;
/// Pairs of a layer that are worth a thread.
constexpr std::size_t least_pairs_per_thread = 128;

/// Whether a slab across a unit vector shows that the corners are farther apart than a distance,
/// with rounding to spare.
bool slab_between(const Vec3<double> (&x)[4], int first_count, const Vec3<double>& across,
                  double distance) {
  double first = std::numeric_limits<double>::infinity(), second = -first;
  for (int c = 0; c < 4; ++c) {
    const double along = dot(across, x[c]);
    if (c < first_count)
      first = std::min(first, along);
    else
      second = std::max(second, along);
  }
  return first - second > distance * (1 + layer_slab_margin);
}

/// What one layer does to one pair.
bool impulse_of(LayeredPair& layered, double thickness, double strength, const LayerForces& forces,
                const VertexMotion& motion, double time, LayerImpulse& out) {
  const PrimitivePair& pair = layered.pair;
  Vec3<double> x[4];
  for (int c = 0; c < 4; ++c) x[c] = motion.position(at(pair.v[c]), time);
  if (slab_between(x, pair.first_count(), layered.across, thickness)) return false;
  const Proximity<double> p = pair.closest(x);
  const double d = std::sqrt(p.distance_sq);
  if (!(d > 0)) return false;
  out.n = p.difference * (1 / d);
  layered.across = out.n;
  if (!(p.distance_sq < thickness * thickness)) return false;
  double separating = 0;
  for (int c = 0; c < 4; ++c) {
    out.w[c] = p.w[c];
    separating += p.w[c] * dot(out.n, motion.v[at(pair.v[c])]);
  }
  out.normal = strength * (thickness - d);
  if (separating > 0) out.normal *= forces.restitution * forces.restitution;
  out.friction = {};
  return out.normal > 0;
}

}  // namespace

int LayerRule::layers_within(double d, int most) const {
  if (!(d < thickness)) return 0;
  const double ratio = d > 0 ? thickness / d : std::numeric_limits<double>::infinity();
  const double estimate = ratio * ratio * ratio * ratio;
  int l = estimate < most ? static_cast<int>(estimate) : most;
  while (l < most && d < thickness_of(l + 1)) ++l;
  while (l > 0 && !(d < thickness_of(l))) --l;
  return l;
}

std::size_t ActiveLayers::layer_pairs() const {
  std::size_t sum = 0;
  for (const auto& list : lists_) sum += list.size();
  return sum;
}

std::size_t ActiveLayers::bytes() const {
  const auto of = [](const auto& list, auto size) { return list.capacity() * size; };
  std::size_t sum = of(pairs_, sizeof(pairs_[0])) + of(lists_, sizeof(lists_[0])) +
                    of(found_, sizeof(found_[0])) + of(impulses_, sizeof(impulses_[0])) +
                    of(sharing_, sizeof(sharing_[0])) + of(slots_, sizeof(slots_[0]));
  for (const auto& list : lists_) sum += of(list, sizeof(list[0]));
  for (const auto& found : found_) sum += of(found, sizeof(found[0]));
  return sum;
}

void ActiveLayers::list_layers() {
  std::size_t slots = 2;
  slot_shift_ = 63;
  for (; slots < 4 * pairs_.size(); slots *= 2) --slot_shift_;
  slots_.assign(slots, none);
  int deepest = 0;
  for (const LayeredPair& p : pairs_) deepest = std::max(deepest, p.depth);
  lists_.resize(static_cast<std::size_t>(deepest));
  for (auto& list : lists_) list.clear();
  for (std::size_t i = 0; i < pairs_.size(); ++i) {
    std::size_t slot = slot_of(pairs_[i].pair.key);
    while (slots_[slot] != none) slot = (slot + 1) & (slots - 1);
    slots_[slot] = static_cast<std::uint32_t>(i);
    for (int l = 0; l < pairs_[i].depth; ++l)
      lists_[static_cast<std::size_t>(l)].push_back(static_cast<std::uint32_t>(i));
  }
}

void ActiveLayers::set(std::vector<LayeredPair> pairs) {
  pairs_ = std::move(pairs);
  std::erase_if(pairs_, [](const LayeredPair& p) { return p.depth <= 0; });
  const auto by_key = [](const LayeredPair& a, const LayeredPair& b) {
    return a.pair.key < b.pair.key;
  };
  if (!std::is_sorted(pairs_.begin(), pairs_.end(), by_key))
    std::sort(pairs_.begin(), pairs_.end(), by_key);
  list_layers();
}

void ActiveLayers::deepen(const std::vector<PrimitivePair>& found) {
  std::vector<LayeredPair> next = pairs_;
  for (const PrimitivePair& pair : found) {
    const std::uint32_t known = number_of(pair.key);
    if (known == none)
      next.push_back({pair, 1});
    else
      ++next[known].depth;
  }
  set(std::move(next));
}

std::vector<LayeredPair> ActiveLayers::kept(const LayerRule& rule, const VertexMotion& motion,
                                            double time, Workers& workers) const {
  std::vector<LayeredPair> next = pairs_;
  workers.share(next.size(), least_pairs_per_thread, [&](std::size_t a, std::size_t b) {
    for (std::size_t i = a; i < b; ++i) {
      const PrimitivePair& pair = next[i].pair;
      Vec3<double> x[4];
      for (int c = 0; c < 4; ++c) x[c] = motion.position(at(pair.v[c]), time);
      const bool idle =
          slab_between(x, pair.first_count(), next[i].across, kept_share * rule.thickness);
      const double d = idle ? 0 : std::sqrt(pair.closest(x).distance_sq);
      next[i].depth = idle ? 0 : rule.layers_within(d / kept_share, next[i].depth);
    }
  });
  return next;
}

/// Coulomb's friction as it can be had without a state of its own: each tick brakes the sliding of
/// a pair, up to mu times its normal impulse.
void ActiveLayers::add_friction(const LayerForces& forces, const std::vector<std::uint32_t>& list,
                                const VertexMotion& motion) {
  sharing_.resize(motion.x.size(), 0);
  for (const LayerImpulse& j : impulses_)
    for (const Index v : pairs_[list[j.pair]].pair.v) ++sharing_[at(v)];
  for (LayerImpulse& j : impulses_) {
    const Index* v = pairs_[list[j.pair]].pair.v;
    double mu = forces.friction[at(v[0])];
    double compliance = 0;
    int most = 1;
    Vec3<double> slip{};
    for (int c = 0; c < 4; ++c) {
      if (v[c] >= forces.cloth_count) mu = forces.friction[at(v[c])];
      compliance += j.w[c] * j.w[c] * motion.inv_mass[at(v[c])];
      most = std::max(most, sharing_[at(v[c])]);
      slip += motion.v[at(v[c])] * j.w[c];
    }
    slip -= j.n * dot(j.n, slip);
    const double speed = length(slip);
    if (!(speed > 0) || !(compliance > 0)) continue;
    const double impulse = std::min(mu * j.normal, speed / (compliance * most));
    j.friction = slip * (-impulse / speed);
  }
  for (const LayerImpulse& j : impulses_)
    for (const Index v : pairs_[list[j.pair]].pair.v) sharing_[at(v)] = 0;
}

LayerTick ActiveLayers::act(int l, double h, double time, const LayerForces& forces,
                            VertexMotion& motion, Histories& histories, Workers& workers) {
  const std::vector<std::uint32_t>& list = lists_[static_cast<std::size_t>(l - 1)];
  const double thickness = forces.rule.thickness_of(l);
  const double strength = h * forces.rule.stiffness_of(l);
  const auto collect = [&](std::size_t first, std::size_t last, std::vector<LayerImpulse>& to) {
    to.clear();
    LayerImpulse j;
    for (std::size_t i = first; i < last; ++i)
      if (impulse_of(pairs_[list[i]], thickness, strength, forces, motion, time, j)) {
        j.pair = static_cast<std::uint32_t>(i);
        to.push_back(j);
      }
  };
  const int threads = workers.parts_of(list.size(), least_pairs_per_thread);
  if (threads == 1) {
    collect(0, list.size(), impulses_);
  } else {
    const auto parts = static_cast<std::size_t>(threads);
    found_.resize(parts);
    workers.run(threads, [&](int n) {
      const auto part = static_cast<std::size_t>(n);
      collect(list.size() * part / parts, list.size() * (part + 1) / parts, found_[part]);
    });
    impulses_.clear();
    for (const auto& part : found_) impulses_.insert(impulses_.end(), part.begin(), part.end());
  }
  if (!forces.friction.empty()) add_friction(forces, list, motion);
  for (const LayerImpulse& j : impulses_) {
    const Index* v = pairs_[list[j.pair]].pair.v;
    for (int c = 0; c < 4; ++c) {
      const std::size_t i = at(v[c]);
      if (j.w[c] == 0) continue;
      if (motion.inv_mass[i] == 0) {
        motion.push_carrier(i, time, (j.n * j.normal + j.friction) * j.w[c]);
        continue;
      }
      if (motion.t[i] < time) {
        motion.advance(i, time);
        histories.add(i, time, motion.x[i]);
      }
      motion.v[i] += (j.n * j.normal + j.friction) * (j.w[c] * motion.inv_mass[i]);
    }
  }
  return {static_cast<std::int64_t>(list.size()), static_cast<std::int64_t>(impulses_.size())};
}

}  // namespace weft
