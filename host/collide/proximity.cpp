#include "weft/kernels/collide/proximity.hpp"

#include <algorithm>

#include "host/exec/host_device.hpp"

namespace weft {
namespace {

template <class T>
class ProximityFinder {
 public:
  explicit ProximityFinder(const CollideProximity<T>& args) : a_(args) {}

  void find() {
    CollideCounts& counts = a_.counts[0];
    const bool all = has_all_pairs(a_);
    if (all) find<1>(static_cast<std::size_t>(counts.face_pairs));
    counts.face_contacts = static_cast<Index>(count_);
    if (all) find<2>(static_cast<std::size_t>(counts.edge_pairs));
    counts.contacts = static_cast<Index>(count_);
  }

 private:
  template <int First>
  void find(std::size_t pairs) {
    const ProximityRule<T> rule(a_);
    PairLanes<T, First> lanes;
    for (std::size_t i = 0; i < pairs; ++i) {
      rule.add(lanes, i);
      if (lanes.full()) look(rule, lanes);
    }
    look(rule, lanes);
  }

  /// Writes each pair's slack, appends contacts, and empties the lanes.
  template <int First>
  void look(const ProximityRule<T>& rule, PairLanes<T, First>& lanes) {
    constexpr int width = PairLanes<T, First>::width;
    T closing[width];
    T reach[width];
    bool apart[width];
    rule.look(lanes, closing, reach, apart);
    for (int k = 0; k < lanes.count(); ++k) {
      PairRole role = PairRole::apart;
      const T distance =
          apart[k] ? reach[k]
                   : measure<First>(rule, lanes.number(k), lanes.corners(k), closing[k], role);
      rule.template slack<First>(lanes.number(k)) =
          role == PairRole::apart ? rule.slack_of(distance, closing[k], lanes.size(k))
                                  : slack_of_contact;
    }
    lanes.clear();
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
    ++count_;
    return p.distance;
  }

  const CollideProximity<T>& a_;
  std::size_t count_ = 0;
};

}  // namespace

template <class T>
void run(OnHost, Queue& queue, const CollideProximity<T>& args) {
  submit_host(queue, [args] { ProximityFinder<T>(args).find(); });
}

template void run(OnHost, Queue&, const CollideProximity<float>&);
template void run(OnHost, Queue&, const CollideProximity<double>&);

}  // namespace weft
