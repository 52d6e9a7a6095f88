#include "host/implicit/contact/contact_detection.hpp"
#include "host/implicit/parallel/exchange.hpp"

namespace weft {
namespace {

/// Continuous detection calls it a collision below this share of the thickness, and the response
/// restores a larger one, so that a pair that has been parted stays parted.
constexpr double separation_share = 0.1;
constexpr double offset_share = 0.2;

}  // namespace

template <class T>
void ContactDetection<T>::launch_continuous(bool later_round, bool stop_at_missed,
                                            StepReport& report) {
  if (!self_listed_ && !separation_.holds_to_end()) {
    list_self_pairs();
    report_pairs(report);
  }
  detect(later_round, stop_at_missed);
}

/// Submits continuous detection to every rank.
template <class T>
void ContactDetection<T>::detect(bool later_round, bool stop_at_missed) {
  const double thickness = contact_thickness(store_.scene().contact);
  for (int r = 0; r < store_.devices().size(); ++r) {
    const auto n = static_cast<std::size_t>(r);
    Rank& rank = ranks_[n];
    Span<const unsigned char> moved;
    if (later_round) moved = motion_[n].moved_now.span();
    const auto [first_vertex, last_vertex] = vertices_of(r);
    launch(store_.devices()[r].compute(), CollideContinuous<T>{rank.face_pairs.span(),
                                                               rank.edge_pairs.span(),
                                                               rank.face_separation_bound.span(),
                                                               rank.edge_separation_bound.span(),
                                                               geometry_[n].edges.span(),
                                                               geometry_[n].triangles.span(),
                                                               store_.rank(r).positions.span(),
                                                               motion_[n].positions_t1.span(),
                                                               rank.predicted.span(),
                                                               rank.deviation.span(),
                                                               broad_phase_.swept_aabb(r),
                                                               moved,
                                                               first_vertex,
                                                               last_vertex,
                                                               separation_share * thickness,
                                                               offset_share * thickness,
                                                               rank.collisions.span(),
                                                               rank.counts.span(),
                                                               stop_at_missed,
                                                               rank.scratch.span()});
  }
}

template <class T>
CollideCounts ContactDetection<T>::collect(std::vector<Collision>& collisions, bool later_round,
                                           bool stop_at_missed) {
  while (true) {
    read_counts();
    bool full = false;
    for (std::size_t n = 0; n < ranks_.size(); ++n)
      if (static_cast<std::size_t>(counts_[n].collisions) > ranks_[n].collisions.size()) {
        ranks_[n].collisions.grow(static_cast<std::size_t>(counts_[n].collisions));
        full = true;
      }
    if (!full) break;
    detect(later_round, stop_at_missed);
  }
  CollideCounts sum{};
  for (const CollideCounts& c : counts_) {
    sum.collisions += c.collisions;
    sum.face_collisions += c.face_collisions;
    sum.missed += c.missed;
    sum.out_of_bounds += c.out_of_bounds;
    sum.not_finite += c.not_finite;
    sum.ccd_tests += c.ccd_tests;
  }
  balance_.add_detection(counts_);
  if (sum.collisions == 0) return sum;
  // Faces of all ranks first, as with contacts.
  std::size_t face = collisions.size();
  std::size_t edge = face + static_cast<std::size_t>(sum.face_collisions);
  collisions.resize(face + static_cast<std::size_t>(sum.collisions));
  for (std::size_t n = 0; n < ranks_.size(); ++n) {
    const auto faces = static_cast<std::size_t>(counts_[n].face_collisions);
    const auto edges = static_cast<std::size_t>(counts_[n].collisions) - faces;
    Queue& queue = store_.devices()[static_cast<int>(n)].compute();
    queue.copy(collisions.data() + face, ranks_[n].collisions.data(), faces * sizeof(Collision));
    queue.copy(collisions.data() + edge, ranks_[n].collisions.data() + faces,
               edges * sizeof(Collision));
    face += faces;
    edge += edges;
  }
  sync_ranks(store_.devices());
  for (auto c = collisions.end() - (sum.collisions - sum.face_collisions); c != collisions.end();
       ++c)
    c->first = 2;
  return sum;
}

template void ContactDetection<float>::launch_continuous(bool, bool, StepReport&);
template void ContactDetection<double>::launch_continuous(bool, bool, StepReport&);
template CollideCounts ContactDetection<float>::collect(std::vector<Collision>&, bool, bool);
template CollideCounts ContactDetection<double>::collect(std::vector<Collision>&, bool, bool);

}  // namespace weft
