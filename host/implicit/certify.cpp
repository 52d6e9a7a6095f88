#include <algorithm>
#include <string>

#include "host/implicit/exchange.hpp"
#include "host/implicit/step.hpp"
#include "weft/kernels/respond/apply.hpp"

namespace weft {
namespace {

constexpr int solves_again_max = 2;

}  // namespace

/// Continuous detection and impact zones by turns until detection is silent (P-Cloth section 4).
/// Only then is the step free of intersections: pairs that the broad phase left out cannot meet as
/// long as every vertex keeps to its motion box, and where one does not the search starts anew.
template <class T>
bool ImplicitStep<T>::certify(const Attempt& a, StepReport& report) {
  DeviceSet& devices = store_.devices();
  const int rounds_max = store_.scene().contact.zone_rounds;
  for (int r = 0; r < devices.size(); ++r) {
    RankMotion<T>& m = motion_[static_cast<std::size_t>(r)];
    devices[r].compute().fill(m.touched.data(), 0, m.touched.size());
  }
  devices[0].compute().fill(yielding_.data(), 0, yielding_.size());
  collisions_.clear();
  yielded_ = false;
  bool later_round = false;
  bool free_saved = false;
  int solves_again = 0;
  for (int round = 0;; ++round) {
    const std::size_t first_new = collisions_.size();
    search_.launch_continuous(later_round);
    const CollideCounts counts = search_.collect(collisions_, later_round);
    if (counts.not_finite > 0)
      return fail(report, Failure::not_finite,
                  std::to_string(counts.not_finite) + " coordinates are not finite");
    if (counts.escaped > 0) {
      // Some vertex left its motion box: the pairs are not all. Search along the actual motion.
      if (round >= rounds_max)
        return fail(report, Failure::intersection, "vertices keep leaving their motion boxes");
      collisions_.resize(first_new);
      ++report.rebuilds;
      search_.search_on_the_way(a.dt, report);
      later_round = false;
      continue;
    }
    report.ccd_tests += counts.ccd_tests;
    report.impacts += counts.collisions;
    if (counts.collisions == 0) {
      if (yielded_) report_yielding(report);
      return true;
    }
    if (counts.missed > 0 && !free_saved && solves_again < solves_again_max) {
      // Contacts that the prediction missed belong into the system, where all forces meet. Where
      // the system knew of all collisions, it would only come to the same end again.
      collisions_.resize(first_new);
      ++solves_again;
      if (!solve_again(a, report)) return false;
      continue;
    }
    if (round >= rounds_max)
      return fail(report, Failure::intersection,
                  std::to_string(counts.collisions) + " impacts are left after " +
                      std::to_string(round) + " rounds");
    if (!free_saved) save_free_positions();
    free_saved = true;
    // The last resort comes after the zones have had half of the rounds to themselves.
    const bool rigid = a.last_resort && round >= rounds_max / 2;
    if (!respond(a, rigid ? 0 : first_new, rigid, report))
      return fail(report, Failure::intersection,
                  "an impact zone is squeezed by what is prescribed");
    ++report.zone_rounds;
    later_round = true;
  }
}

/// Every round solves its zones from where the step would have ended without them.
template <class T>
void ImplicitStep<T>::save_free_positions() {
  positions_free_.resize(motion_[0].positions_t1.size());
  store_.devices()[0].compute().copy(positions_free_.data(), motion_[0].positions_t1.data(),
                                     positions_free_.size() * sizeof(Vec3<T>));
}

/// Solves the impact zones on rank 0 and takes their outcome to all ranks (P-Cloth section 4.3).
template <class T>
bool ImplicitStep<T>::respond(const Attempt& a, std::size_t first_new, bool rigid,
                              StepReport& report) {
  DeviceSet& devices = store_.devices();
  Queue& master = devices[0].compute();
  master_collisions_.resize(collisions_.size());
  master_moved_.resize(4 * collisions_.size());
  master.copy(master_collisions_.data(), collisions_.data(),
              collisions_.size() * sizeof(Collision));
  launch(master, RespondZones<T>{master_collisions_.span(), static_cast<Index>(first_new),
                                 store_.rank(0).positions.span(), positions_free_.span(),
                                 geometry_[0].mass.span(), geometry_[0].fixed.span(),
                                 store_.model().cloth_vertex_count, rigid, yielding_.span(),
                                 master_moved_.span(), zone_counts_.span()});
  ZoneCounts counts;
  master.copy(&counts, zone_counts_.data(), sizeof counts);
  master.sync();
  moved_.resize(static_cast<std::size_t>(counts.moved));
  master.copy(moved_.data(), master_moved_.data(), moved_.size() * sizeof(MovedVertex<T>));
  master.sync();
  if (counts.yielding > 0) yielded_ = true;
  report.zones = std::max(report.zones, static_cast<int>(counts.zones));
  if (rigid) report.rigid_zones += counts.zones;
  for (int r = 0; r < devices.size(); ++r) {
    const auto n = static_cast<std::size_t>(r);
    Queue& queue = devices[r].compute();
    RankMotion<T>& m = motion_[n];
    rank_moved_[n].resize(moved_.size());
    queue.copy(rank_moved_[n].data(), moved_.data(), moved_.size() * sizeof(MovedVertex<T>));
    queue.fill(m.moved_now.data(), 0, m.moved_now.size());
    launch(queue, RespondApply<T>{rank_moved_[n].span(), m.base_positions.span(),
                                  static_cast<T>(a.h), m.positions_t1.span(),
                                  m.velocities_t1.span(), m.moved_now.span(), m.touched.span()});
  }
  return counts.moved > 0;
}

/// How many vertices are not where they should be because cloth is in between, and how far.
template <class T>
void ImplicitStep<T>::report_yielding(StepReport& report) {
  Queue& master = store_.devices()[0].compute();
  const std::vector<unsigned char> yielding = download(master, yielding_);
  const std::vector<Vec3<T>> positions = download(master, motion_[0].positions_t1);
  std::vector<Vec3<T>> wanted(positions.begin(),
                              positions.begin() + store_.model().cloth_vertex_count);
  wanted.insert(wanted.end(), placed_rounded_.begin(), placed_rounded_.end());
  for (const MovedVertex<T>& target : targets_)
    wanted[static_cast<std::size_t>(target.vertex)] = target.position;
  int count = 0;
  for (std::size_t v = 0; v < yielding.size(); ++v) {
    if (yielding[v] == 0) continue;
    ++count;
    report.yielding_distance =
        std::max(report.yielding_distance, static_cast<double>(length(positions[v] - wanted[v])));
  }
  report.yielding = std::max(report.yielding, count);
}

template bool ImplicitStep<float>::certify(const Attempt&, StepReport&);
template bool ImplicitStep<double>::certify(const Attempt&, StepReport&);

}  // namespace weft
