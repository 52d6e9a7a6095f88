#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "host/implicit/collision_response/zone_list.hpp"
#include "host/state/rank_geometry.hpp"
#include "weft/kernels/respond/zones.hpp"

namespace weft {

/// Counts over the zones of one round.
struct ZoneCounts {
  int zones = 0;
  int largest = 0;   ///< collisions of the largest zone
  int unsolved = 0;  ///< zones whose constraints could not all be met
  int planes = 0;    ///< zones that used separating planes, see ZoneMotion
  /// Of the unsolved: zones without prescribed vertices, except large ones that get more rounds
  /// first, see zone_rounds_before_planes.
  int unsolved_free = 0;
  int pinched = 0;          ///< of the unsolved: zones pinched by prescribed vertices
  std::int64_t passes = 0;  ///< over the collisions of all zones
  std::int64_t visits = 0;  ///< of collisions in those passes
  bool stalled = false;     ///< no new collision since the last round, so no zone was solved
};

/// The impact zones of a step over all ranks. The host joins them, and the ranks solve them in
/// parallel. The bits do not depend on the number of ranks, because zones are independent.
template <class T>
class ImpactZones {
 public:
  ImpactZones(Store<T>& store, std::vector<RankGeometry<T>>& geometry,
              std::vector<RankMotion<T>>& motion);

  /// Starts the rounds of an attempt. No prescribed vertex gives way at first.
  void begin();

  /// Saves positions_t1 and velocities_t1 as the end of the step without collision response. Every
  /// round solves its zones from there.
  void save_free_end();
  /// Those, in the memory of rank r.
  Span<const Vec3<T>> free_positions(int r) const {
    return ranks_[static_cast<std::size_t>(r)].positions_free.span();
  }
  Span<const Vec3<T>> free_velocities(int r) const {
    return ranks_[static_cast<std::size_t>(r)].velocities_free.span();
  }

  /// Solves the zones that hold a collision from `first_new` on, or all zones unless `motion` is
  /// `impacts`. If prescribed vertices pinch a zone without a solution, such as an arm pressed into
  /// the ribs with cloth in between, those that the scene declares compliant get a finite mass,
  /// and the zones that they touch are joined. Waits for the ranks.
  /// @param fixed      [vertices] 1 if the position is prescribed
  /// @param visits_max of collisions, see RespondZones
  /// @param joined     called with the number of zones whenever they have been joined, before they
  ///                   are solved
  ZoneCounts solve(const std::vector<Collision>& collisions, std::size_t first_new,
                   ZoneMotion motion, const std::vector<unsigned char>& fixed,
                   std::int64_t visits_max, const std::function<void(int zones)>& joined = {});

  /// Vertices that the latest round moved, each once.
  const std::vector<MovedVertex<T>>& moved() const { return moved_; }

  /// [vertices] 1 for prescribed vertices that have given way in this attempt
  const std::vector<unsigned char>& compliant() const { return compliant_; }
  bool any_compliant() const { return any_compliant_; }
  /// Whether the scene declares any prescribed vertex compliant.
  bool any_may_comply() const { return any_may_comply_; }

  /// One line with the cloths and obstacles of the pinched zones of the latest round.
  std::string pinched_parts() const;

  /// Prescribed vertices of these zones, some several times. Their order depends on the ranks.
  const std::vector<Index>& pinched() const { return pinched_; }

 private:
  struct Rank {
    Buffer<Collision> collisions;
    Buffer<Index> zone_begin;
    Buffer<ZoneMultipliers> multipliers;
    Buffer<MovedVertex<T>> moved;
    Buffer<ZoneOutcome> outcomes;
    Buffer<Vec3<T>> positions_free, velocities_free;
    Buffer<unsigned char> compliant;
    Buffer<std::byte> scratch;  ///< used only on a GPU
  };
  void launch_zones(ZoneMotion motion, std::int64_t visits_max);
  void read_zones(ZoneMotion motion);
  void count_passes(ZoneCounts& counts) const;
  bool comply_where_pinched(const std::vector<unsigned char>& fixed);
  void sum_up(const std::vector<unsigned char>& fixed, ZoneCounts& counts);
  bool lost(const ZoneOutcome& o) const { return o.solved == 0 && o.pinched != 0; }
  bool goes_on(std::size_t rank, std::size_t zone) const;

  Store<T>& store_;
  std::vector<RankGeometry<T>>& geometry_;
  std::vector<RankMotion<T>>& motion_;
  ZoneList list_;
  std::vector<Rank> ranks_;
  std::vector<std::vector<MovedVertex<T>>> rank_moved_;  ///< as the kernel writes it
  std::vector<std::vector<ZoneOutcome>> outcomes_;
  std::vector<std::vector<ZoneMultipliers>> rank_multipliers_;
  std::vector<MovedVertex<T>> moved_;
  std::vector<unsigned char> compliant_;
  bool any_may_comply_;         ///< the scene declares compliance
  std::vector<Index> pinched_;  ///< prescribed vertices of the pinched zones of the latest round
  bool any_compliant_ = false;
  bool any_goes_on_ = false;  ///< of the latest round
  ZoneMotion last_motion_ = ZoneMotion::impacts;
};

}  // namespace weft
