#include "host/implicit/contact/contact_detection.hpp"

#include <algorithm>

#include "host/exec/host_device.hpp"
#include "host/implicit/parallel/exchange.hpp"
#include "weft/kernels/collide/out_of_bounds.hpp"
#include "weft/kernels/collide/proximity.hpp"

namespace weft {
namespace {

/// How far a vertex may leave its predicted motion before the pairs are searched again: this,
/// in mean edges, and what its change of velocity in the last step would make of it now. Room costs
/// pairs, a new search costs more. Moving cloth leaves any box with the next step, so that it gets
/// what the solve is likely to ask for; cloth at rest gets enough to keep its pairs for some steps.
constexpr double margin_edges = 0.05;
constexpr double margin_edges_at_rest = 0.08;
constexpr double margin_of_change = 2;
constexpr double margin_of_change_max = 4;  ///< in margins: an impact is no sign of another one
/// Boxes also cover this many more motions like that of the step.
constexpr double motions_ahead = 2;
/// Largest displacement along an axis, in mean edges, from which on a search splits the motion.
constexpr double split_edges = 0.5;
/// A step that had to search again had too little room: the next one gets twice as much, up to
/// this, unless that lists so many more pairs that searching twice would have been less work; then
/// none gets more for some searches. Room falls slowly where steps do without. All this decides how
/// often pairs are searched, never a result.
constexpr double margin_factor_max = 16;
constexpr double margin_factor_decay = 0.97;
constexpr double pairs_more_max = 1.5;
constexpr int searches_without_more = 16;
/// Places of a list of which so many are in use.
std::size_t with_spare(std::size_t count) {
  return count + count / 4;
}

/// Numbers of scratch for so many pairs.
std::size_t scratch_size(const Device& device, std::size_t face_pairs, std::size_t edge_pairs) {
  if (device.backend() != Backend::cuda) return 0;
  return std::max(proximity_scratch_size(face_pairs, edge_pairs),
                  continuous_scratch_size(face_pairs, edge_pairs));
}

PrimitiveCounts primitive_counts(const Model& m) {
  return {m.cloth_vertex_count,   m.vertex_count,
          m.cloth_triangle_count, static_cast<Index>(m.triangles.size()),
          m.cloth_edge_count,     static_cast<Index>(m.edges.size())};
}

}  // namespace

template <class T>
ContactDetection<T>::ContactDetection(Store<T>& store, std::vector<RankGeometry<T>>& geometry,
                                      std::vector<RankMotion<T>>& motion,
                                      const DetectionHints& hints)
    : store_(store),
      geometry_(geometry),
      motion_(motion),
      broad_phase_(store.devices(), primitive_counts(store.model()), store.scene().contact.self),
      added_(geometry.size()),
      counts_(geometry.size()),
      nominal_step_(store.scene().time.step),
      margin_factor_(hints.margin_factor),
      separation_(store, motion),
      balance_(store.devices().size(), store.devices().backend()) {
  const MemoryName name("pairs");
  for (int r = 0; r < store.devices().size(); ++r) {
    ranks_.push_back(make_rank(r, hints));
    candidate_updates_.emplace_back(store.devices()[r]);
  }
}

template <class T>
DetectionHints ContactDetection<T>::hints() const {
  DetectionHints hints;
  hints.margin_factor = margin_factor_;
  const auto keep_most = [](std::size_t& most, Index count) {
    most = std::max(most, static_cast<std::size_t>(count));
  };
  for (const CollideCounts& c : counts_) {
    keep_most(hints.face_pairs, c.face_pairs);
    keep_most(hints.edge_pairs, c.edge_pairs);
    keep_most(hints.contacts, c.contacts);
  }
  return hints;
}

template <class T>
typename ContactDetection<T>::Rank ContactDetection<T>::make_rank(int r,
                                                                  const DetectionHints& hints) {
  Device& device = store_.devices()[r];
  const Model& m = store_.model();
  const std::size_t pairs =
      4 * m.edges.size() / static_cast<std::size_t>(store_.devices().size()) + 1024;
  const std::size_t faces = std::max(pairs, with_spare(hints.face_pairs));
  const std::size_t edges = std::max(pairs, with_spare(hints.edge_pairs));
  const MemoryName name("pairs");
  Rank rank{Buffer<Pair>(device, faces),
            Buffer<Pair>(device, edges),
            Buffer<float>(device, faces),
            Buffer<float>(device, edges),
            Buffer<Vec3<T>>(device, m.positions.size()),
            Buffer<float>(device, m.positions.size()),
            {},
            {},
            {},
            Buffer<CollideCounts>(device, 1),
            Buffer<std::uint32_t>(device, scratch_size(device, faces, edges))};
  const MemoryName of_contacts("contacts");
  const std::size_t contacts = std::max<std::size_t>(1024, with_spare(hints.contacts));
  rank.own_contacts = Buffer<Contact<T>>(device, contacts);
  if (r == 0 || !share_memory(store_.devices()))
    rank.contacts = Buffer<Contact<T>>(device, contacts);
  rank.collisions = Buffer<Collision>(device, 1024);
  if (device.backend() == Backend::host) {
    const MemoryName of_pairs("pairs");
    rank.face_distance = Buffer<float>(device, faces);
    rank.edge_distance = Buffer<float>(device, edges);
    rank.closed = Buffer<float>(device, 1);
    rank.measured = Buffer<Vec3<T>>(device, m.positions.size());
    rank.motions = Buffer<PrimitiveMotion<T>>(
        device, m.positions.size() + m.edges.size() + m.triangles.size());
  }
  return rank;
}

template <class T>
CollideBoxes<T> ContactDetection<T>::boxes_of(int r, double dt, double margin_factor) const {
  const auto n = static_cast<std::size_t>(r);
  CollideBoxes<T> boxes{};
  boxes.positions_t0 = store_.rank(r).positions.span();
  boxes.positions_t1 = motion_[n].positions_t1.span();
  boxes.velocities = store_.rank(r).velocities.span();
  boxes.previous_velocities = store_.rank(r).previous_velocities.span();
  boxes.edges = geometry_[n].edges.span();
  boxes.triangles = geometry_[n].triangles.span();
  const double edge = store_.model().mean_edge;
  boxes.margin = static_cast<T>(margin_factor * margin_edges * edge);
  boxes.margin_at_rest =
      static_cast<T>(std::max(margin_edges_at_rest, margin_factor * margin_edges) * edge);
  boxes.motions_ahead = static_cast<T>(motions_ahead);
  boxes.change_time = static_cast<T>(margin_of_change * dt);
  boxes.change_max = static_cast<T>(margin_of_change_max * margin_factor * margin_edges * edge);
  boxes.reach = static_cast<T>(contact_thickness(store_.scene().contact) / 2);
  boxes.split_motion = static_cast<T>(split_edges * store_.model().mean_edge);
  return boxes;
}

template <class T>
CollidePairs<T> ContactDetection<T>::search_of(int r) const {
  const auto n = static_cast<std::size_t>(r);
  CollidePairs<T> pairs{};
  pairs.edges = geometry_[n].edges.span();
  pairs.triangles = geometry_[n].triangles.span();
  pairs.face_pairs = ranks_[n].face_pairs.span();
  pairs.edge_pairs = ranks_[n].edge_pairs.span();
  pairs.counts = ranks_[n].counts.span();
  return pairs;
}

template <class T>
void ContactDetection<T>::launch_pairs(int r) {
  broad_phase_.launch_pairs(r, search_of(r));
  ranks_[static_cast<std::size_t>(r)].distances_hold = false;
}

template <class T>
CollideProximity<T> ContactDetection<T>::proximity_of(int r) const {
  const auto n = static_cast<std::size_t>(r);
  const ContactSettings& contact = store_.scene().contact;
  const Rank& rank = ranks_[n];
  const RankGeometry<T>& g = geometry_[n];
  const Span<const ContactMemory<T>> memory = store_.rank(r).contacts.span();
  const auto faces = static_cast<std::size_t>(store_.face_contacts);
  return {rank.face_pairs.span(),
          rank.edge_pairs.span(),
          g.surface(),
          g.triangles.span(),
          store_.rank(r).positions.span(),
          rank.predicted.span(),
          g.mass.span(),
          g.fixed.span(),
          g.material_points.span(),
          g.cloth_of_vertex.span(),
          g.tied.span(),
          g.friction_of_vertex.span(),
          store_.model().cloth_vertex_count,
          static_cast<T>(contact_thickness(contact)),
          static_cast<T>(stiffness_factor_ * contact.stiffness),
          static_cast<T>(nominal_step_),
          memory.subspan(0, faces),
          memory.subspan(faces, memory.size() - faces),
          rank.face_separation_bound.span(),
          rank.edge_separation_bound.span(),
          rank.own_contacts.span(),
          rank.counts.span(),
          rank.scratch.span(),
          hold_normal_forces_,
          g.start_thickness.span(),
          static_cast<T>(fall_),
          store_.rank(r).touched.span(),
          static_cast<T>(seams_pull_ ? closed_share_while_sewn : closed_share_of_loads),
          !seams_pull_,
          static_cast<T>(length(store_.scene().gravity)),
          g.cut.span(),
          {rank.face_distance.span(), rank.edge_distance.span(), rank.measured.span(),
           rank.closed.span(), rank.motions.span(), rank.distances_hold, rank.turn}};
}

template <class T>
void ContactDetection<T>::launch_proximity(int r) {
  launch(store_.devices()[r].compute(), proximity_of(r));
  Rank& rank = ranks_[static_cast<std::size_t>(r)];
  rank.distances_hold = rank.face_distance.size() > 0;
  ++rank.turn;
}

template <class T>
void ContactDetection<T>::read_counts() {
  DeviceSet& devices = store_.devices();
  for (int r = 0; r < devices.size(); ++r) {
    const auto n = static_cast<std::size_t>(r);
    devices[r].compute().copy(&counts_[n], ranks_[n].counts.data(), sizeof(CollideCounts));
  }
  sync_ranks(devices);
}

template <class T>
bool ContactDetection<T>::grow_where_full() {
  bool full = false;
  for (std::size_t n = 0; n < ranks_.size(); ++n) {
    Rank& rank = ranks_[n];
    const auto grow = [&](auto& buffer, Index count) {
      if (static_cast<std::size_t>(count) <= buffer.size()) return;
      buffer.grow(with_spare(static_cast<std::size_t>(count)));
      full = true;
    };
    grow(rank.face_pairs, counts_[n].face_pairs);
    grow(rank.edge_pairs, counts_[n].edge_pairs);
    grow(rank.own_contacts, counts_[n].contacts);
    rank.face_separation_bound.resize(rank.face_pairs.size());
    rank.edge_separation_bound.resize(rank.edge_pairs.size());
    if (rank.measured.size() > 0) {
      rank.face_distance.resize(rank.face_pairs.size());
      rank.edge_distance.resize(rank.edge_pairs.size());
    }
    rank.scratch.resize(
        scratch_size(rank.scratch.device(), rank.face_pairs.size(), rank.edge_pairs.size()));
  }
  return full;
}

template <class T>
std::pair<Index, Index> ContactDetection<T>::vertices_of(int r) const {
  const Offset count = store_.model().vertex_count;
  const int ranks = store_.devices().size();
  return {static_cast<Index>(count * r / ranks), static_cast<Index>(count * (r + 1) / ranks)};
}

/// Whether the pairs of the search before are still all that can meet; if so, finds the contacts
/// among them.
template <class T>
bool ContactDetection<T>::candidates_valid() {
  if (!searched_ || unordered_) return false;
  if (!self_listed_ && !separation_.holds()) list_self_pairs();
  for (int r = 0; r < store_.devices().size(); ++r) {
    Rank& rank = ranks_[static_cast<std::size_t>(r)];
    // Every rank tests all vertices, so that no rank measures pairs that a search will replace.
    launch(store_.devices()[r].compute(),
           CollideOutOfBounds<T>{store_.rank(r).positions.span(),
                                 motion_[static_cast<std::size_t>(r)].positions_t1.span(),
                                 broad_phase_.swept_aabb(r), 0, store_.model().vertex_count,
                                 rank.counts.span(), broad_phase_.split(r)});
    launch_proximity(r);  // does nothing if a vertex is out of bounds
  }
  read_counts();
  const bool hold = std::all_of(counts_.begin(), counts_.end(),
                                [](const CollideCounts& c) { return c.out_of_bounds == 0; });
  if (hold) balance_.add_pass(counts_);
  if (hold && grow_where_full()) find_contacts();
  return hold;
}

/// Finds all pairs, and the contacts among them.
/// @param margin_factor of the margins of moving cloth
/// @param predict whether cloth may end elsewhere than positions_t1
/// @param self    pairs of cloth with cloth too
template <class T>
void ContactDetection<T>::search_pairs(double dt, double margin_factor, bool predict, bool self,
                                       StepReport& report) {
  broad_phase_.set_self(self && store_.scene().contact.self);
  share_out_queries();
  std::vector<CollideBoxes<T>> boxes;
  for (int r = 0; r < store_.devices().size(); ++r) {
    boxes.push_back(boxes_of(r, dt, margin_factor));
    if (predict) boxes.back().inertial_time = static_cast<T>(dt);
  }
  broad_phase_.launch_boxes(boxes);
  list_pairs(self);
  searched_ = true;
  unordered_ = false;
  ++report.searches;
}

/// Distributes queries by the work of the latest shares, before all lists are rebuilt.
template <class T>
void ContactDetection<T>::share_out_queries() {
  if (!searched_ || ranks_.size() == 1) return;
  const std::vector<double> work = balance_.take_work();
  if (store_.scene().solver.rebalance == Rebalance::never) return;
  std::vector<double> of_faces, of_edges;
  for (std::size_t n = 0; n < ranks_.size(); ++n) {
    const double faces = counts_[n].face_pairs + 1.0, edges = counts_[n].edge_pairs + 1.0;
    of_faces.push_back(work[n] * faces / (faces + edges));
    of_edges.push_back(work[n] * edges / (faces + edges));
  }
  broad_phase_.share_out(of_faces, of_edges);
}

/// Pairs over the boxes that there are, and the contacts among them.
template <class T>
void ContactDetection<T>::list_pairs(bool self) {
  self_listed_ = self;
  do {
    for (int r = 0; r < store_.devices().size(); ++r) {
      launch_pairs(r);
      launch_proximity(r);  // does nothing where the lists are too short for all pairs
    }
    read_counts();
    balance_.add_search(counts_);
  } while (grow_where_full());
  balance_.add_pass(counts_);
}

/// The pairs of the latest search with those of cloth with cloth, which it left out.
template <class T>
void ContactDetection<T>::list_self_pairs() {
  broad_phase_.set_self(true);
  share_out_queries();
  for (int r = 0; r < store_.devices().size(); ++r) broad_phase_.launch_work(r);
  list_pairs(true);
}

template <class T>
void ContactDetection<T>::search(double dt, bool always, StepReport& report) {
  margin_factor_on_the_way_ = 1;
  update_margin_factor_ = 1;
  set_prediction();
  separation_.begin();
  fall_ = length(store_.scene().gravity) * dt * dt;
  if (always || !candidates_valid()) search_for_step(dt, report);
  report_pairs(report);
  exchange_contacts();
  report_contacts(report);
}

/// Finds the pairs of a step that has yet to be solved, and its contacts.
template <class T>
void ContactDetection<T>::search_for_step(double dt, StepReport& report) {
  const bool more = short_of_margin_ && without_more_ == 0;
  short_of_margin_ = false;
  without_more_ = std::max(0, without_more_ - 1);
  const double before = margin_factor_;
  margin_factor_ = more ? std::min(margin_factor_max, 2 * margin_factor_)
                        : std::max(1.0, margin_factor_decay * margin_factor_);
  search_pairs(dt, margin_factor_, true, !separation_.holds(), report);
  const std::int64_t pairs = pair_count();
  if (more && static_cast<double>(pairs) > pairs_more_max * static_cast<double>(pairs_before_)) {
    margin_factor_ = before;
    without_more_ = searches_without_more;
  }
  pairs_before_ = pairs;
}

template <class T>
void ContactDetection<T>::extend_pairs(double dt, StepReport& report) {
  // Zones may go on to push: who was short of room has twice as much the next time. Strays do not
  // widen a later whole search, whose boxes are those of all vertices.
  if (update_candidates(dt)) {
    update_margin_factor_ = std::min(margin_factor_max, 2 * update_margin_factor_);
  } else {
    short_of_margin_ = true;
    search_pairs(dt, margin_factor_on_the_way_, false, self_listed_, report);
    margin_factor_on_the_way_ *= 2;
  }
  report_pairs(report);
}

template <class T>
std::int64_t ContactDetection<T>::pair_count() const {
  std::int64_t count = 0;
  for (const CollideCounts& c : counts_)
    count += std::int64_t{c.face_pairs} + std::int64_t{c.edge_pairs};
  return count;
}

template <class T>
void ContactDetection<T>::report_pairs(StepReport& report) const {
  std::int64_t face_pairs = 0;
  std::int64_t edge_pairs = 0;
  for (const CollideCounts& c : counts_) {
    face_pairs += c.face_pairs;
    edge_pairs += c.edge_pairs;
  }
  report.face_pairs = std::max(report.face_pairs, face_pairs);
  report.edge_pairs = std::max(report.edge_pairs, edge_pairs);
}

/// Contacts and separation bounds along the motion to `predicted`.
template <class T>
void ContactDetection<T>::find_contacts() {
  do {
    for (int r = 0; r < store_.devices().size(); ++r) launch_proximity(r);
    read_counts();
  } while (grow_where_full());
  balance_.add_pass(counts_);
}

/// From here on contacts are those along the motion to where positions_t1 are now.
template <class T>
void ContactDetection<T>::set_prediction() {
  for (int r = 0; r < store_.devices().size(); ++r) {
    const auto n = static_cast<std::size_t>(r);
    store_.devices()[r].compute().copy(ranks_[n].predicted.data(), motion_[n].positions_t1.data(),
                                       ranks_[n].predicted.size() * sizeof(Vec3<T>));
  }
}

template <class T>
void ContactDetection<T>::update_contacts(double dt, StepReport& report) {
  set_prediction();
  separation_.begin();
  fall_ = 0;
  if (unordered_) {
    search_pairs(dt, margin_factor_on_the_way_, false, self_listed_, report);
  } else {
    if (!self_listed_ && !separation_.holds()) {
      list_self_pairs();
      report_pairs(report);
    }
    find_contacts();
  }
  exchange_contacts();
  report_contacts(report);
}

template <class T>
void ContactDetection<T>::report_contacts(StepReport& report) const {
  report.proximities = std::max(report.proximities, static_cast<std::int64_t>(contact_count_));
}

/// Faces of all ranks first, then edges of all ranks: an order that knows nothing of the ranks.
template <class T>
void ContactDetection<T>::exchange_contacts() {
  DeviceSet& devices = store_.devices();
  std::vector<GatherPiece> faces;
  std::vector<GatherPiece> edges;
  contact_count_ = 0;
  const auto append = [this](std::vector<GatherPiece>& pieces, Index count) {
    pieces.push_back({contact_count_, static_cast<std::size_t>(count)});
    contact_count_ += pieces.back().count;
  };
  for (const CollideCounts& c : counts_) append(faces, c.face_contacts);
  for (const CollideCounts& c : counts_) append(edges, c.contacts - c.face_contacts);
  face_contact_count_ = 0;
  for (const CollideCounts& c : counts_) face_contact_count_ += c.face_contacts;
  if (devices.size() == 1) {
    std::swap(ranks_[0].own_contacts, ranks_[0].contacts);
    return;
  }
  if (share_memory(devices)) {
    ranks_[0].contacts.grow(contact_count_);
    join_ranks(devices);
    for (int r = 0; r < devices.size(); ++r) {
      const auto n = static_cast<std::size_t>(r);
      const Contact<T>* own = ranks_[n].own_contacts.data();
      for (const GatherPiece& piece : {faces[n], edges[n]}) {
        devices[r].compute().copy(ranks_[0].contacts.data() + piece.begin, own,
                                  piece.count * sizeof(Contact<T>));
        own += piece.count;
      }
    }
    join_ranks(devices);
    return;
  }
  for (Rank& rank : ranks_) rank.contacts.grow(contact_count_);
  const auto target = [&](int r) { return ranks_[static_cast<std::size_t>(r)].contacts.data(); };
  const auto own = [&](int r) { return ranks_[static_cast<std::size_t>(r)].own_contacts.data(); };
  all_gather(devices, faces, sizeof(Contact<T>), own, target, false);
  all_gather(
      devices, edges, sizeof(Contact<T>),
      [&](int r) { return own(r) + counts_[static_cast<std::size_t>(r)].face_contacts; }, target,
      false);
}

template <class T>
double ContactDetection<T>::slide() const {
  float slide = 0;
  for (const CollideCounts& c : counts_) slide = std::max(slide, c.slide);
  return slide;
}

template <class T>
Span<Contact<T>> ContactDetection<T>::contacts(int r) const {
  const std::size_t n = share_memory(store_.devices()) ? 0 : static_cast<std::size_t>(r);
  return ranks_[n].contacts.span().subspan(0, contact_count_);
}

template <class T>
Span<Contact<T>> ContactDetection<T>::contacts_to_change(int r) const {
  if (!share_memory(store_.devices())) return contacts(r);
  const auto n = static_cast<std::size_t>(r);
  const auto begin = contact_count_ * n / ranks_.size();
  const auto end = contact_count_ * (n + 1) / ranks_.size();
  return contacts(r).subspan(begin, end - begin);
}

template class ContactDetection<float>;
template class ContactDetection<double>;

}  // namespace weft
