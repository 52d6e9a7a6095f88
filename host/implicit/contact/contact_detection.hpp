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

/// What a search has found out about a run, for one that takes its place when the topology changes:
/// how much to expect. It decides how often pairs are searched and listed, never a result.
struct DetectionHints {
  double margin_factor = 1;  ///< factor of the margins of moving cloth
  std::size_t face_pairs = 0, edge_pairs = 0, contacts = 0;  ///< most of a rank
};

/// Broad phase and proximities over all ranks. Holds the pairs of the latest search, which stay
/// complete as long as every vertex keeps to its swept AABB. Pairs of cloth with cloth are left out
/// where a certificate proves that they make neither contacts nor collisions; wherever it does not
/// hold any more, they are listed over the boxes of the latest search, as if it had done so. So the
/// outcome is the same bits with and without. On the host only: devices do not ask for it.
template <class T>
class ContactDetection {
 public:
  /// @param hints of the search whose place this one takes, if there is one
  ContactDetection(Store<T>& store, std::vector<RankGeometry<T>>& geometry,
                   std::vector<RankMotion<T>>& motion, const DetectionHints& hints = {});

  DetectionHints hints() const;

  /// Finds the contacts along the motion from the state's positions to positions_t1, and gives
  /// every rank all of them in one order. Pairs are searched anew only if some vertex leaves the
  /// swept AABB of the search before; what is found does not depend on that. Waits for the ranks.
  /// @param dt   [s] length of the step
  /// @param anew search in any case
  void search(double dt, bool anew, StepReport& report);

  /// Searches pairs anew, along the motion to where positions_t1 are now, which some vertex has
  /// left its swept AABB for: only those of the vertices that have, where these are few. Which of
  /// them count as contacts is still up to the positions of the latest update_contacts(): whether
  /// boxes had to be made anew must not change what a step comes to.
  void search_on_the_way(double dt, StepReport& report);

  /// Decides anew which pairs of the latest search are contacts, from where positions_t1 are now.
  /// @param dt [s] length of the step
  void update_contacts(double dt, StepReport& report);

  /// All contacts of the latest search, as rank r has them; those of faces come first.
  Span<Contact<T>> contacts(int r) const;
  std::int64_t face_contacts() const noexcept { return face_contact_count_; }

  /// Continuous detection over the pairs of the latest search, on every rank's share.
  /// @param later_round    only pairs with a vertex marked in moved_now
  /// @param stop_at_missed that there is a collision of no contact is all that the caller asks
  void launch_continuous(bool later_round, bool stop_at_missed, StepReport& report);

  /// Waits for launch_continuous and joins what the ranks found.
  /// @param collisions appended to, in an order that does not depend on the number of ranks
  /// @return sums over the ranks; the collisions are not complete if out_of_bounds > 0, or missed >
  /// 0
  ///         with `stop_at_missed`
  CollideCounts collect(std::vector<Collision>& collisions, bool later_round, bool stop_at_missed);

  /// How evenly the ranks were busy since the last call.
  BalanceReport take_balance() { return balance_.take_report(); }

  /// Whether the pairs of cloth with cloth are among those of the latest search, or there are none.
  bool lists_self() const noexcept { return self_listed_; }
  /// [s] wall time spent on certificates so far
  double certificate_seconds() const noexcept { return separation_.seconds(); }

 private:
  struct Rank {
    Buffer<Pair> face_pairs, edge_pairs;
    Buffer<float> face_separation_bound, edge_separation_bound;
    Buffer<Vec3<T>> predicted;  ///< positions_t1 of the latest proximities
    Buffer<float> deviation;
    Buffer<Contact<T>> own_contacts, contacts;
    Buffer<Collision> collisions;
    Buffer<CollideCounts> counts;
    Buffer<std::uint32_t> scratch;  ///< of the narrow phase in CUDA; else empty
  };

  /// What CollideCandidateUpdate takes, made when it first does.
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

  /// What a rank adds to its lists.
  struct Added {
    std::vector<Pair> face_pairs, edge_pairs;
    std::vector<float> separation_bound;
  };

  Rank make_rank(int r, const DetectionHints& hints);
  std::pair<Index, Index> vertices_of(int r) const;  ///< that rank r looks at
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
  double margin_factor_ = 1;             ///< factor of the margins of moving cloth
  double margin_factor_on_the_way_ = 1;  ///< the same in whole searches after the solve
  double update_margin_factor_ = 1;      ///< and for vertices that have left their boxes
  bool short_of_margin_ = false;         ///< in the latest step
  int without_more_ = 0;                 ///< searches that get no more room
  std::int64_t pairs_before_ = 0;        ///< of the latest search for a step
  bool searched_ = false;
  bool unordered_ = false;  ///< pairs have been added at the end of the lists
  SelfSeparation<T> separation_;
  bool self_listed_ = true;
  SearchBalance balance_;
};

}  // namespace weft
