#pragma once

#include <cstdint>
#include <set>
#include <string>
#include <vector>

#include "host/implicit/collision_response/zone_list.hpp"
#include "host/state/rank_geometry.hpp"
#include "weft/kernels/respond/zones.hpp"

namespace weft {

/// What became of the zones of one round.
struct ZoneCounts {
  int zones = 0;
  int largest = 0;          ///< collisions of the largest zone
  int unsolved = 0;         ///< zones whose constraints could not all be met
  int planes = 0;           ///< zones that kept the planes of the start, see ZoneMotion
  int unsolved_free = 0;    ///< of the unsolved, zones in which nothing is prescribed and that do
                            ///< not go on first, see zone_rounds_before_planes
  int pinched = 0;          ///< of these, zones that what is prescribed pinches
  std::int64_t passes = 0;  ///< over the collisions of all zones
  std::int64_t visits = 0;  ///< of collisions in those passes
  bool stalled = false;     ///< nothing new was found since the last round: no zone was solved
};

/// The impact zones of a step over all ranks: joined by the host, solved by the ranks side by side.
/// The same bits for any number of ranks, as no zone knows of another.
template <class T>
class ImpactZones {
 public:
  ImpactZones(Store<T>& store, std::vector<RankGeometry<T>>& geometry,
              std::vector<RankMotion<T>>& motion);

  /// Starts the rounds of an attempt: nothing yields.
  void begin();

  /// Takes positions_t1 as where the step would end without any response. Every round solves its
  /// zones from there.
  void save_free_positions();

  /// Solves the zones that hold a collision from `first_new` on, or all zones if they
  /// are to move in another way than the impacts say. Where
  /// what is prescribed pinches one that has no solution - an arm that is pressed into the ribs,
  /// with cloth in between - and `may_comply`, that gets a mass, and the zones that it touches
  /// become one. Waits for the ranks.
  /// @param fixed [vertices] 1 where the position is prescribed
  ZoneCounts solve(const std::vector<Collision>& collisions, std::size_t first_new,
                   ZoneMotion motion, bool may_comply, const std::vector<unsigned char>& fixed);

  /// What the latest round came to; each vertex once.
  const std::vector<MovedVertex<T>>& moved() const { return moved_; }

  /// [vertices] 1 for prescribed ones that have yielded in this attempt
  const std::vector<unsigned char>& compliant() const { return compliant_; }
  bool any_compliant() const { return any_compliant_; }

  /// Cloths and obstacles of the zones that counted as pinched in the latest round, in one line.
  std::string pinched_parts() const;

 private:
  struct Rank {
    Buffer<Collision> collisions;
    Buffer<Index> zone_begin;
    Buffer<ZoneMultipliers> multipliers;
    Buffer<MovedVertex<T>> moved;
    Buffer<ZoneOutcome> outcomes;
    Buffer<Vec3<T>> positions_free;
    Buffer<unsigned char> compliant;
    Buffer<std::byte> scratch;  ///< on a GPU alone
  };
  void launch_zones(ZoneMotion motion);
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
  std::set<std::string> pinched_;
  bool any_compliant_ = false;
  bool any_goes_on_ = false;  ///< of the latest round
  ZoneMotion last_motion_ = ZoneMotion::impacts;
};

}  // namespace weft
