#include "host/implicit/collision_response/impact_zones.hpp"

#include <algorithm>

#include "host/implicit/collision_response/prescribed.hpp"
#include "host/implicit/parallel/exchange.hpp"

namespace weft {
namespace {

/// How often zones are joined and solved again in a round because a prescribed vertex has given
/// way.
constexpr int compliance_passes_max = 16;

}  // namespace

template <class T>
ImpactZones<T>::ImpactZones(Store<T>& store, std::vector<RankGeometry<T>>& geometry,
                            std::vector<RankMotion<T>>& motion)
    : store_(store),
      geometry_(geometry),
      motion_(motion),
      rank_moved_(geometry.size()),
      outcomes_(geometry.size()),
      rank_multipliers_(geometry.size()),
      compliant_(static_cast<std::size_t>(store.model().vertex_count), 0),
      any_may_comply_(store.scene().contact.compliance_distance.value_or(0) > 0) {
  const MemoryName name("zones");
  for (int r = 0; r < store.devices().size(); ++r) {
    Device& device = store.devices()[r];
    ranks_.push_back({Buffer<Collision>(device), Buffer<Index>(device),
                      Buffer<ZoneMultipliers>(device), Buffer<MovedVertex<T>>(device),
                      Buffer<ZoneOutcome>(device), Buffer<Vec3<T>>(device), Buffer<Vec3<T>>(device),
                      Buffer<unsigned char>(device), Buffer<std::byte>(device)});
  }
}

template <class T>
void ImpactZones<T>::begin() {
  std::fill(compliant_.begin(), compliant_.end(), static_cast<unsigned char>(0));
  any_compliant_ = false;
  any_goes_on_ = false;
  last_motion_ = ZoneMotion::impacts;
  list_.forget();
}

template <class T>
void ImpactZones<T>::save_free_end() {
  for (int r = 0; r < store_.devices().size(); ++r) {
    Rank& rank = ranks_[static_cast<std::size_t>(r)];
    const RankMotion<T>& m = motion_[static_cast<std::size_t>(r)];
    Queue& queue = store_.devices()[r].compute();
    rank.positions_free.resize(m.positions_t1.size());
    rank.velocities_free.resize(m.velocities_t1.size());
    rank.compliant.resize(compliant_.size());
    queue.copy(rank.positions_free.data(), m.positions_t1.data(),
               m.positions_t1.size() * sizeof(Vec3<T>));
    queue.copy(rank.velocities_free.data(), m.velocities_t1.data(),
               m.velocities_t1.size() * sizeof(Vec3<T>));
    queue.copy(rank.compliant.data(), compliant_.data(), compliant_.size());
  }
}

template <class T>
ZoneCounts ImpactZones<T>::solve(const std::vector<Collision>& collisions, std::size_t first_new,
                                 ZoneMotion motion, const std::vector<unsigned char>& fixed,
                                 std::int64_t visits_max,
                                 const std::function<void(int zones)>& joined) {
  const auto heavy = [&](Index v) {
    const auto i = static_cast<std::size_t>(v);
    return fixed[i] != 0 && compliant_[i] == 0;
  };
  ZoneCounts counts;
  moved_.clear();
  for (int pass = 0;; ++pass) {
    list_.join(Span<const Collision>(collisions.data(), collisions.size()), first_new,
               motion != ZoneMotion::impacts, heavy, store_.devices().size());
    if (pass == 0 && motion == last_motion_ && !list_.any_new() && !any_goes_on_) {
      counts.stalled = true;
      return counts;
    }
    if (joined) joined(list_.zone_count());
    launch_zones(motion, std::max<std::int64_t>(0, visits_max - counts.visits));
    read_zones(motion);
    count_passes(counts);
    if (store_.devices().stop_requested()) break;
    if (pass >= compliance_passes_max || counts.visits > visits_max) break;
    if (!any_may_comply_ || !comply_where_pinched(fixed)) break;
  }
  last_motion_ = motion;
  sum_up(fixed, counts);
  return counts;
}

template <class T>
void ImpactZones<T>::count_passes(ZoneCounts& counts) const {
  for (std::size_t r = 0; r < outcomes_.size(); ++r) {
    const std::vector<Index>& begin = list_.shares()[r].zone_begin;
    for (std::size_t z = 0; z < outcomes_[r].size(); ++z) {
      const std::int64_t passes = outcomes_[r][z].passes;
      counts.passes += passes;
      counts.visits += passes * (begin[z + 1] - begin[z]);
    }
  }
}

template <class T>
void ImpactZones<T>::launch_zones(ZoneMotion motion, std::int64_t visits_max) {
  for (int r = 0; r < store_.devices().size(); ++r) {
    const auto n = static_cast<std::size_t>(r);
    const ZoneShare& share = list_.shares()[n];
    Rank& rank = ranks_[n];
    Queue& queue = store_.devices()[r].compute();
    rank.collisions.grow(share.collisions.size());
    rank.zone_begin.grow(share.zone_begin.size());
    rank.multipliers.grow(share.collisions.size());
    rank.moved.grow(4 * share.collisions.size());
    rank.outcomes.grow(share.zone_count());
    queue.copy(rank.collisions.data(), share.collisions.data(),
               share.collisions.size() * sizeof(Collision));
    queue.copy(rank.zone_begin.data(), share.zone_begin.data(),
               share.zone_begin.size() * sizeof(Index));
    if (motion != ZoneMotion::rigid)
      queue.copy(rank.multipliers.data(), share.multipliers.data(),
                 share.multipliers.size() * sizeof(ZoneMultipliers));
    if (share.zone_count() == 0) continue;
    if (queue.backend() == Backend::cuda)
      rank.scratch.grow(zone_scratch_bytes(share.collisions.size(), share.zone_count()));
    launch(queue,
           RespondZones<T>{rank.collisions.span().subspan(0, share.collisions.size()),
                           rank.zone_begin.span().subspan(0, share.zone_begin.size()),
                           store_.rank(r).positions.span(), rank.positions_free.span(),
                           geometry_[n].mass.span(), geometry_[n].fixed.span(),
                           store_.model().cloth_vertex_count, motion, rank.compliant.span(),
                           rank.multipliers.span().subspan(0, share.collisions.size()),
                           rank.moved.span().subspan(0, 4 * share.collisions.size()),
                           rank.outcomes.span().subspan(0, share.zone_count()), rank.scratch.span(),
                           store_.devices().stop_flag(), visits_max, any_may_comply_});
  }
}

template <class T>
void ImpactZones<T>::read_zones(ZoneMotion motion) {
  for (int r = 0; r < store_.devices().size(); ++r) {
    const auto n = static_cast<std::size_t>(r);
    const ZoneShare& share = list_.shares()[n];
    Queue& queue = store_.devices()[r].compute();
    rank_moved_[n].resize(4 * share.collisions.size());
    outcomes_[n].resize(share.zone_count());
    queue.copy(rank_moved_[n].data(), ranks_[n].moved.data(),
               rank_moved_[n].size() * sizeof(MovedVertex<T>));
    queue.copy(outcomes_[n].data(), ranks_[n].outcomes.data(),
               outcomes_[n].size() * sizeof(ZoneOutcome));
    if (motion == ZoneMotion::rigid) continue;
    rank_multipliers_[n].resize(share.collisions.size());
    queue.copy(rank_multipliers_[n].data(), ranks_[n].multipliers.data(),
               rank_multipliers_[n].size() * sizeof(ZoneMultipliers));
  }
  sync_ranks(store_.devices());
  if (motion == ZoneMotion::rigid) return;
  for (std::size_t n = 0; n < ranks_.size(); ++n) list_.keep(n, rank_multipliers_[n]);
}

/// @return whether a vertex has yielded: zones that share it are one zone now
template <class T>
bool ImpactZones<T>::comply_where_pinched(const std::vector<unsigned char>& fixed) {
  const std::vector<unsigned char> before = compliant_;
  bool complied = false;
  for (std::size_t n = 0; n < ranks_.size(); ++n) {
    const ZoneShare& share = list_.shares()[n];
    for (std::size_t z = 0; z < outcomes_[n].size(); ++z) {
      if (!lost(outcomes_[n][z])) continue;
      for (Index k = share.zone_begin[z]; k < share.zone_begin[z + 1]; ++k)
        for (const Index v : share.collisions[static_cast<std::size_t>(k)].v) {
          const auto i = static_cast<std::size_t>(v);
          if (fixed[i] == 0 || compliant_[i] != 0) continue;
          compliant_[i] = 1;
          complied = true;
        }
    }
  }
  if (!complied) return false;
  any_compliant_ = true;
  list_.take_back_round();
  // Where a vertex has yielded, masses are others now.
  list_.forget_where([&](Index v) {
    const auto i = static_cast<std::size_t>(v);
    return compliant_[i] != before[i];
  });
  for (int r = 0; r < store_.devices().size(); ++r)
    store_.devices()[r].compute().copy(ranks_[static_cast<std::size_t>(r)].compliant.data(),
                                       compliant_.data(), compliant_.size());
  return true;
}

/// Whether the zone is large and unsolved, and for so few rounds that its impacts are asked again.
template <class T>
bool ImpactZones<T>::goes_on(std::size_t rank, std::size_t zone) const {
  const std::vector<Index>& begin = list_.shares()[rank].zone_begin;
  return last_motion_ == ZoneMotion::impacts && outcomes_[rank][zone].solved == 0 &&
         begin[zone + 1] - begin[zone] > zone_planes_at_once &&
         rank_multipliers_[rank][static_cast<std::size_t>(begin[zone])].unsolved_rounds <=
             zone_rounds_before_planes;
}

/// What the zones came to, and where they moved what.
template <class T>
void ImpactZones<T>::sum_up(const std::vector<unsigned char>& fixed, ZoneCounts& counts) {
  counts.zones = list_.zone_count();
  counts.largest = list_.largest();
  pinched_.clear();
  any_goes_on_ = false;
  for (std::size_t n = 0; n < ranks_.size(); ++n) {
    const ZoneShare& share = list_.shares()[n];
    for (std::size_t z = 0; z < outcomes_[n].size(); ++z) {
      const ZoneOutcome& o = outcomes_[n][z];
      const auto begin = rank_moved_[n].begin() +
                         std::ptrdiff_t{4} * static_cast<std::ptrdiff_t>(share.zone_begin[z]);
      moved_.insert(moved_.end(), begin, begin + static_cast<std::ptrdiff_t>(o.moved));
      if (o.solved == 0) ++counts.unsolved;
      const bool on = goes_on(n, z);
      any_goes_on_ = any_goes_on_ || on;
      if (o.solved == 0 && o.free != 0 && !on) ++counts.unsolved_free;
      counts.planes += o.planes;
      if (!lost(o)) continue;
      ++counts.pinched;
      for (Index k = share.zone_begin[z]; k < share.zone_begin[z + 1]; ++k)
        for (const Index v : share.collisions[static_cast<std::size_t>(k)].v) {
          if (fixed[static_cast<std::size_t>(v)] != 0) pinched_.push_back(v);
        }
    }
  }
}

template <class T>
std::string ImpactZones<T>::pinched_parts() const {
  return prescribed_names(store_.scene(), store_.model(), pinched_);
}

template class ImpactZones<float>;
template class ImpactZones<double>;

}  // namespace weft
