#include "weft/kernels/collide/continuous.hpp"

#include <algorithm>
#include <cmath>

#include "host/collide/near_pairs.hpp"
#include "host/exec/host_device.hpp"

namespace weft {
namespace {

template <class T>
class ContinuousFinder {
 public:
  explicit ContinuousFinder(const CollideContinuous<T>& args) : a_(args) {}

  void find() {
    CollideCounts& counts = a_.counts[0];
    counts.face_collisions = 0;
    check_vertices(counts);
    if (counts.out_of_bounds == 0) {
      find<1>(std::min(static_cast<std::size_t>(counts.face_pairs), a_.face_pairs.size()));
      counts.face_collisions = static_cast<Index>(count_);
      find<2>(std::min(static_cast<std::size_t>(counts.edge_pairs), a_.edge_pairs.size()));
    }
    counts.collisions = static_cast<Index>(count_);
    counts.missed = missed_;
    counts.ccd_tests = tests_;
  }

 private:
  bool done() const { return a_.stop_at_missed && missed_ > 0; }

  void check_vertices(CollideCounts& counts) {
    counts.out_of_bounds = 0;
    counts.not_finite = 0;
    for (Index v = a_.vertex_begin; v < a_.vertex_end; ++v) {
      counts.not_finite += rule_.not_finite(v);
      counts.out_of_bounds += rule_.out_of_bounds(v) ? 1 : 0;
    }
    for (std::size_t v = 0; v < a_.deviation.size(); ++v) {
      const float d = rule_.deviation(v);
      a_.deviation[v] = d;
      if (d > largest_deviation_ || std::isnan(d)) largest_deviation_ = d;
    }
  }

  template <int First>
  void find(std::size_t pairs) {
    PairLanes<T, First> lanes;
    const float deviation = largest_deviation_ + largest_deviation_;
    const auto is_far = [&](std::size_t i) {
      return rule_.is_apart(rule_.template separation_bound<First>(i), deviation);
    };
    const auto look_at = [&](std::size_t i) {
      Index v[4];
      rule_.template corners<First>(i, v);
      if (!rule_.template has_to_be_looked_at<First>(v, rule_.template separation_bound<First>(i)))
        return;
      lanes.add(v, i, a_.positions_t0, a_.positions_t1);
      if (lanes.full()) look(lanes);
    };
    visit_near_pairs((First == 1 ? a_.face_pairs : a_.edge_pairs).data(), pairs, is_far, look_at,
                     [this] { return done(); });
    look(lanes);
  }

  /// Tests what boxes and planes at the start do not keep apart either, and empties the lanes.
  template <int First>
  void look(PairLanes<T, First>& lanes) {
    bool may_collide[PairLanes<T, First>::width];
    rule_.may_collide(lanes, may_collide);
    for (int k = 0; k < lanes.count(); ++k) {
      if (!may_collide[k]) continue;
      ++tests_;
      Collision collision;
      if (!rule_.template collides<First>(lanes.corners(k), collision)) continue;
      if (count_ < a_.collisions.size()) a_.collisions[count_] = collision;
      ++count_;
      if (rule_.template separation_bound<First>(lanes.number(k)) != separation_bound_of_contact)
        ++missed_;
    }
    lanes.clear();
  }

  const CollideContinuous<T> a_;
  const ContinuousRule<T> rule_{a_};
  float largest_deviation_ = 0;  ///< [m] not a number if any is not
  std::size_t count_ = 0;
  Index missed_ = 0;
  Offset tests_ = 0;
};

}  // namespace

template <class T>
void run(OnHost, Queue& queue, const CollideContinuous<T>& args) {
  submit_host(queue, [args] { ContinuousFinder<T>(args).find(); });
}

template void run(OnHost, Queue&, const CollideContinuous<float>&);
template void run(OnHost, Queue&, const CollideContinuous<double>&);

}  // namespace weft
