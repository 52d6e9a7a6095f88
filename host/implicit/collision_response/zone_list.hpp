#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <utility>
#include <vector>

#include "weft/core/ids.hpp"
#include "weft/core/span.hpp"
#include "weft/kernels/respond/zones.hpp"
#include "weft/state/contact.hpp"

namespace weft {

/// The impact zones that one rank solves.
struct ZoneShare {
  std::vector<Collision> collisions;         ///< zone by zone
  std::vector<ZoneMultipliers> multipliers;  ///< [collisions] as kept, 0 for new ones
  std::vector<Index> entry;                  ///< [collisions] their numbers in the list
  std::vector<Index> zone_begin{0};          ///< [zones + 1] into collisions

  std::size_t zone_count() const { return zone_begin.size() - 1; }
};

/// Joins collisions into impact zones and shares these out to the ranks (P-Cloth section 4.3: one
/// GPU collects the zones and distributes them). The outcome depends on which collisions there are,
/// not on their order.
class ZoneList {
 public:
  /// @param collisions all of the step so far
  /// @param first_new  those from here on have not been in a list before
  /// @param all        list all zones, not only those with a new collision
  /// @param heavy      whether a vertex has infinite mass: such vertices join nothing
  /// @param ranks      to share out to
  void join(Span<const Collision> collisions, std::size_t first_new, bool all,
            const std::function<bool(Index)>& heavy, int ranks);

  /// Takes what a rank's zones have come to, for the next join().
  /// @param multipliers [collisions of the rank's share]
  void keep(std::size_t rank, const std::vector<ZoneMultipliers>& multipliers);

  /// Forgets all multipliers: what comes is another programme.
  void forget() { multipliers_.clear(); }

  /// Forgets those of the zones of the latest join() that hold such a vertex: zones that were not
  /// listed too, as a later round may list them.
  void forget_where(const std::function<bool(Index)>& of_vertex);

  /// The listed zones are solved once more in the same round: what was kept of them last is no
  /// unsolved round of its own.
  void take_back_round();

  /// The listed zones by rank. Collisions that are equal to the bit are there once.
  const std::vector<ZoneShare>& shares() const { return shares_; }

  /// Whether some new collision differs from all old ones.
  bool any_new() const { return any_new_; }

  Index zone_count() const { return static_cast<Index>(zones_.size()); }
  /// Collisions of the largest of them.
  Index largest() const;

 private:
  struct Entry {
    Collision collision;
    std::size_t first;  ///< of those equal to it, in order_
    bool fresh;         ///< not known from an earlier round
    bool found;         ///< in this round
  };
  struct Zone {
    Index begin, end;  ///< into members_
  };
  /// Vertices of a collision, and where it stands.
  struct Numbered {
    std::uint64_t first, second;
    std::size_t place;
  };
  void set_multipliers(std::size_t entry, const ZoneMultipliers& multipliers);
  void sort_entries(Span<const Collision> collisions, std::size_t first_new);
  void find_zones(bool all, const std::function<bool(Index)>& heavy);
  void list_members();
  void share_out(int ranks);
  Index find(Index i);

  std::vector<ZoneMultipliers> multipliers_;      ///< [collisions] as far as known
  std::vector<Numbered> order_;                   ///< the collisions, sorted
  std::vector<Index> first_of_vertex_;            ///< [vertices] collision, -1 between calls
  std::vector<Index> place_;                      ///< [entries + 1] working memory
  std::vector<Entry> entries_;                    ///< in canonical order
  std::vector<Index> parent_;                     ///< [entries] towards the first of the zone
  std::vector<std::pair<Index, Index>> members_;  ///< (first entry of the zone, entry), sorted
  std::vector<Zone> zones_;
  std::vector<ZoneShare> shares_;
  bool any_new_ = false;
};

}  // namespace weft
