#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "host/implicit/contact/broad_phase.hpp"
#include "host/implicit/contact/self_separation.hpp"
#include "host/implicit/parallel/search_balance.hpp"
#include "host/state/rank_geometry.hpp"
#include "weft/kernels/collide/candidate_update.hpp"
#include "weft/kernels/collide/continuous.hpp"
#include "weft/kernels/collide/pairs.hpp"
#include "weft/kernels/collide/proximity.hpp"
#include "weft/report.hpp"
#include "weft/state/contact.hpp"

namespace weft {

/// What a search has learned about a run: margins and list sizes. A search for the next topology
/// starts from them. They change how often pairs are searched, never a result.
struct DetectionHints {
  double margin_factor = 1;  ///< factor of the margins of moving cloth
  std::size_t face_pairs = 0, edge_pairs = 0, contacts = 0;  ///< largest counts of a rank
};

/// Broad phase and contacts over all ranks. Holds the pairs of the latest search, which stay
/// complete as long as every vertex stays inside its swept AABB. Pairs of cloth with cloth are left
/// out while a self certificate proves that they cause neither contacts nor collisions. Once the
/// proof fails, they are listed from the boxes of the latest search. The bits are therefore the
/// same with and without a certificate. Certificates are used on the host only.
template <class T>
class ContactDetection {
 public:
  /// @param hints of the previous topology's search, if there is one
  ContactDetection(Store<T>& store, std::vector<RankGeometry<T>>& geometry,
                   std::vector<RankMotion<T>>& motion, const DetectionHints& hints = {});

  DetectionHints hints() const;

  /// Finds the contacts along the motion from the state's positions to positions_t1, and gives
  /// every rank all of them in the same order. Searches pairs only if a vertex leaves its swept
  /// AABB of the previous search; the result does not depend on that. Waits for the ranks.
  /// @param dt   [s] length of the step
  /// @param always search pairs even if the candidates are valid
  void search(double dt, bool always, StepReport& report);

  /// Searches pairs along the motion to the present positions_t1, after a vertex has left its swept
  /// AABB. If few vertices have left, searches only their pairs. The positions of the latest
  /// update_contacts() still decide which pairs are contacts, because the result of a step must not
  /// depend on whether boxes were rebuilt.
  void extend_pairs(double dt, StepReport& report);

  /// Decides again which pairs of the latest search are contacts, by the present positions_t1.
  /// @param dt [s] length of the step
  void update_contacts(double dt, StepReport& report);

  /// All contacts of the latest search, in memory that rank r reads; those of face pairs come
  /// first.
  Span<Contact<T>> contacts(int r) const;
  /// Those that rank r changes: all, unless ranks share the list.
  Span<Contact<T>> contacts_to_change(int r) const;
  /// Largest number of edges by which one that bears much slides, see ProximityRule::slide().
  double slide() const;
  std::int64_t face_contacts() const noexcept { return face_contact_count_; }

  /// Continuous detection over the pairs of the latest search, on every rank's share.
  /// @param later_round    only pairs with a vertex marked in moved_now
  /// @param stop_at_missed stop at the first collision whose pair is not a contact
  void launch_continuous(bool later_round, bool stop_at_missed, StepReport& report);

  /// Waits for launch_continuous and joins what the ranks found.
  /// @param collisions appended to, in an order that does not depend on the number of ranks
  /// @return sums over the ranks. The collisions are incomplete if out_of_bounds > 0, or if
  ///         missed > 0 with `stop_at_missed`
  CollideCounts collect(std::vector<Collision>& collisions, bool later_round, bool stop_at_missed);

  /// @param step [s] that sets the stiffness of contacts
  void set_nominal_step(double step) { nominal_step_ = step; }

  /// Contacts found from now on start from their last normal forces, see CollideProximity.
  /// @param stiffness_factor of their stiffness; 0: they start from nothing, as usual
  void hold_normal_forces(double stiffness_factor) {
    hold_normal_forces_ = stiffness_factor > 0;
    stiffness_factor_ = hold_normal_forces_ ? stiffness_factor : 1;
  }

  /// Whether layers yield to loads as open seams need it, see CollideProximity::closed_share.
  void let_seams_close(bool seams_pull) { seams_pull_ = seams_pull; }

  /// How evenly work was shared among the ranks since the last call.
  BalanceReport take_balance() { return balance_.take_report(); }

  /// Whether the latest search lists the pairs of cloth with cloth, if there are any.
  bool lists_self() const noexcept { return self_listed_; }
  /// [s] wall time spent on certificates so far
  double certificate_seconds() const noexcept { return separation_.seconds(); }

 private:
  struct Rank {
    Buffer<Pair> face_pairs, edge_pairs;
    Buffer<float> face_separation_bound, edge_separation_bound;
    Buffer<Vec3<T>> predicted;  ///< positions_t1 at the latest search for contacts
    Buffer<float> deviation;
    Buffer<Contact<T>> own_contacts;
    Buffer<Contact<T>> contacts;  ///< ranks on the host share those of rank 0
    Buffer<Collision> collisions;
    Buffer<CollideCounts> counts;
    Buffer<std::uint32_t> scratch;  ///< of the narrow phase in CUDA; else empty
    /// See KnownDistances; in CUDA empty.
    Buffer<float> face_distance = {}, edge_distance = {}, closed = {};
    Buffer<Vec3<T>> measured = {};
    Buffer<PrimitiveMotion<T>> motions = {};
    bool distances_hold = false;
    std::size_t turn = 0;  ///< calls of CollideProximity so far
  };

  /// Buffers of CollideCandidateUpdate, allocated on first use.
  struct CandidateUpdateBuffers {
    Buffer<Index> out_of_bounds_index;
    Buffer<OutOfBoundsVertex<T>> out_of_bounds;
    Buffer<DirtyPrimitive> dirty;
    Buffer<Pair> face_pairs, edge_pairs;
    Buffer<CandidateUpdateCounts> counts;

    explicit CandidateUpdateBuffers(Device& device)
        : out_of_bounds_index(device),
          out_of_bounds(device),
          dirty(device),
          face_pairs(device),
          edge_pairs(device),
          counts(device, 1) {}
  };

  /// Pairs that a candidate update appends to a rank's lists.
  struct Added {
    std::vector<Pair> face_pairs, edge_pairs;
    std::vector<float> separation_bound;
  };

  Rank make_rank(int r, const DetectionHints& hints);
  std::pair<Index, Index> vertices_of(int r) const;  ///< that rank r tests for out of bounds
  CollideBoxes<T> boxes_of(int r, double dt, double margin_factor) const;
  CollidePairs<T> search_of(int r) const;
  CollideProximity<T> proximity_of(int r) const;
  void launch_pairs(int r);
  void launch_proximity(int r);
  bool grow_where_full();
  bool candidates_valid();
  void search_pairs(double dt, double margin_factor, bool predict, bool self, StepReport& report);
  void list_pairs(bool self);
  void share_out_queries();
  bool update_candidates(double dt);
  bool find_out_of_bounds(double dt);
  bool share_candidate_update(const std::vector<Pair>& faces, const std::vector<Pair>& edges);
  void launch_added(int r);
  void list_self_pairs();
  void search_for_step(double dt, StepReport& report);
  std::int64_t pair_count() const;
  void set_prediction();
  void find_contacts();
  void report_contacts(StepReport& report) const;
  void report_pairs(StepReport& report) const;
  void read_counts();
  void detect(bool later_round, bool stop_at_missed);
  void exchange_contacts();

  Store<T>& store_;
  std::vector<RankGeometry<T>>& geometry_;
  std::vector<RankMotion<T>>& motion_;
  BroadPhase<T> broad_phase_;
  std::vector<Rank> ranks_;
  std::vector<CandidateUpdateBuffers> candidate_updates_;  ///< [ranks]
  std::vector<Added> added_;                               ///< [ranks]
  std::vector<CollideCounts> counts_;                      ///< [ranks] as last read
  std::size_t contact_count_ = 0;
  std::int64_t face_contact_count_ = 0;
  double nominal_step_;                  ///< [s] that sets the stiffness of contacts
  double margin_factor_ = 1;             ///< factor of the margins of moving cloth
  double margin_factor_on_the_way_ = 1;  ///< the same for full searches after the solve
  double update_margin_factor_ = 1;      ///< the same for candidate updates
  bool short_of_margin_ = false;         ///< in the latest step
  int without_more_ = 0;                 ///< searches left before margins may grow again
  std::int64_t pairs_before_ = 0;        ///< of the latest search for a step
  bool searched_ = false;
  bool hold_normal_forces_ = false;
  bool seams_pull_ = false;
  double stiffness_factor_ = 1;
  double fall_ = 0;         ///< [m] what gravity adds to the prediction
  bool unordered_ = false;  ///< a candidate update has appended pairs to the lists
  SelfSeparation<T> separation_;
  bool self_listed_ = true;
  SearchBalance balance_;
};

}  // namespace weft
