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
  std::vector<ZoneMultipliers> multipliers;  ///< [collisions] from the last round; 0 if new
  std::vector<Index> entry;                  ///< [collisions] number in the list
  std::vector<Index> zone_begin{0};          ///< [zones + 1] into collisions

  std::size_t zone_count() const { return zone_begin.size() - 1; }
};

/// Joins collisions into impact zones and distributes these among the ranks (P-Cloth section 4.3:
/// one GPU collects the zones and distributes them). The result depends on the set of collisions,
/// not on their order.
class ZoneList {
 public:
  /// @param collisions all of the step so far
  /// @param first_new  number of the first collision that is new in this round
  /// @param all        list all zones, not only those with a new collision
  /// @param heavy      whether a vertex has infinite mass: such vertices do not connect zones
  /// @param ranks      number of ranks
  void join(Span<const Collision> collisions, std::size_t first_new, bool all,
            const std::function<bool(Index)>& heavy, int ranks);

  /// Stores the multipliers of a rank's zones for the next join().
  /// @param multipliers [collisions of the rank's share]
  void keep(std::size_t rank, const std::vector<ZoneMultipliers>& multipliers);

  /// Forgets all multipliers, before a different quadratic programme.
  void forget() { multipliers_.clear(); }

  /// Forgets the multipliers of all zones of the latest join() that hold a vertex for which
  /// `of_vertex` is true. This includes zones that were not listed: a later round may list them.
  void forget_where(const std::function<bool(Index)>& of_vertex);

  /// Call this before the listed zones are solved again in the same round. It takes back the
  /// unsolved round that keep() has just counted for them.
  void take_back_round();

  /// The listed zones by rank. Bitwise equal collisions appear once.
  const std::vector<ZoneShare>& shares() const { return shares_; }

  /// Whether at least one new collision differs from all old ones.
  bool any_new() const { return any_new_; }

  Index zone_count() const { return static_cast<Index>(zones_.size()); }
  /// Number of collisions of the largest zone.
  Index largest() const;

 private:
  struct Entry {
    Collision collision;
    std::size_t first;  ///< first collision equal to it, in order_
    bool fresh;         ///< not in an earlier round
    bool found;         ///< found in this round
  };
  struct Zone {
    Index begin, end;  ///< into members_
  };
  /// Vertices of a collision, and its place in the list.
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
  std::vector<Index> parent_;                     ///< [entries] union-find; root: first of the zone
  std::vector<std::pair<Index, Index>> members_;  ///< (first entry of the zone, entry), sorted
  std::vector<Zone> zones_;
  std::vector<ZoneShare> shares_;
  bool any_new_ = false;
};

}  // namespace weft
