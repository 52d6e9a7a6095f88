#include "weft/kernels/collide/proximity.hpp"

#include <algorithm>

#include "host/collide/close_pairs.hpp"
#include "host/collide/known_pairs.hpp"
#include "host/collide/near_pairs.hpp"
#include "host/exec/host_device.hpp"

namespace weft {
namespace {

template <class T>
class ProximityFinder {
 public:
  explicit ProximityFinder(const CollideProximity<T>& args) : a_(args) {}

  void find() {
    CollideCounts& counts = a_.counts[0];
    if (!has_all_pairs(a_)) {
      counts.face_contacts = counts.contacts = 0;
      counts.slide = 0;
      return;
    }
    KnownPairs<T> known(a_);
    find<1>(static_cast<std::size_t>(counts.face_pairs), known);
    counts.face_contacts = static_cast<Index>(count_);
    find<2>(static_cast<std::size_t>(counts.edge_pairs), known);
    known.finish();
    counts.contacts = static_cast<Index>(count_);
    counts.slide = slide_;
  }

 private:
  template <int First>
  void find(std::size_t pairs, KnownPairs<T>& known) {
    const ProximityRule<T> rule(a_);
    PairLanes<T, First> lanes;
    ClosePairs<T, First> close;
    const auto is_far = [&](std::size_t i) {
      return known.template is_far<First>(i, rule.template separation_bound<First>(i));
    };
    const auto look_at = [&](std::size_t i) {
      if (known.template passes_over<First>(rule.template pair<First>(i), i,
                                            rule.template separation_bound<First>(i)))
        return;
      rule.add(lanes, i);
      if (lanes.full()) look(rule, lanes, close, known);
    };
    visit_near_pairs(rule.template all_pairs<First>(), pairs, is_far, look_at,
                     [] { return false; });
    look(rule, lanes, close, known);
    look(rule, close, known);
  }

  /// Writes the separation bounds of pairs that boxes or planes keep apart, passes on the others,
  /// and empties the lanes.
  template <int First>
  void look(const ProximityRule<T>& rule, PairLanes<T, First>& lanes, ClosePairs<T, First>& close,
            KnownPairs<T>& known) {
    constexpr int width = PairLanes<T, First>::width;
    T closing[width], reach[width], gap[width];
    float separation_bound[width];
    rule.look(lanes, closing, reach, gap);
    for (int k = 0; k < width; ++k)
      separation_bound[k] = rule.separation_bound_of(gap[k], closing[k], lanes.size(k));
    for (int k = 0; k < lanes.count(); ++k) {
      if (gap[k] > reach[k]) {
        rule.template separation_bound<First>(lanes.number(k)) = separation_bound[k];
        known.template keep<First>(lanes.number(k), gap[k]);
        continue;
      }
      const Index* v = lanes.corners(k);
      close.add({lanes.number(k), {v[0], v[1], v[2], v[3]}, closing[k], reach[k], lanes.size(k)},
                a_.positions_t0);
      if (close.full()) look(rule, close, known);
    }
    lanes.clear();
  }

  /// Writes each pair's separation bound, appends contacts, and empties the lanes.
  template <int First>
  void look(const ProximityRule<T>& rule, ClosePairs<T, First>& close, KnownPairs<T>& known) {
    T bound[ClosePairs<T, First>::width];
    close.distance_bounds(bound);
    for (int k = 0; k < close.count(); ++k) {
      const auto& pair = close.item(k);
      PairRole role = PairRole::apart;
      const T distance = bound[k] > pair.reach
                             ? bound[k]
                             : measure<First>(rule, pair.number, pair.v, pair.closing, role);
      rule.template separation_bound<First>(pair.number) =
          role == PairRole::apart ? rule.separation_bound_of(distance, pair.closing, pair.size)
                                  : separation_bound_of_contact;
      known.template keep<First>(pair.number, distance);
    }
    close.clear();
  }

  /// @return [m] the pair's distance; appends a contact where there is one
  template <int First>
  T measure(const ProximityRule<T>& rule, std::size_t number, const Index v[4], T closing,
            PairRole& role) {
    const PairApproach<T> p = rule.template approach<First>(v);
    if (!rule.template is_near<First>(v, p.distance, closing)) return p.distance;
    Contact<T> contact;
    role = rule.template role<First>(rule.template pair<First>(number), v, p, contact);
    if (role != PairRole::contact) return p.distance;
    if (count_ < a_.contacts.size()) a_.contacts[count_] = contact;
    slide_ = std::max(slide_, rule.template slide<First>(contact));
    ++count_;
    return p.distance;
  }

  const CollideProximity<T>& a_;
  std::size_t count_ = 0;
  float slide_ = 0;
};

}  // namespace

template <class T>
void run(OnHost, Queue& queue, const CollideProximity<T>& args) {
  submit_host(queue, [args] { ProximityFinder<T>(args).find(); });
}

template void run(OnHost, Queue&, const CollideProximity<float>&);
template void run(OnHost, Queue&, const CollideProximity<double>&);

}  // namespace weft
