#include "host/implicit/collision_response/zone_list.hpp"

#include <algorithm>
#include <compare>
#include <numeric>
#include <tuple>

namespace weft {
namespace {

/// All that tells collisions apart. The vertices come first, so that neighbours stay together.
auto key(const Collision& c) {
  return std::tuple(c.v[0], c.v[1], c.v[2], c.v[3], c.first, c.w[0], c.w[1], c.w[2], c.w[3], c.n[0],
                    c.n[1], c.n[2], c.offset, c.toi);
}

/// Two numbers of vertices as one that sorts as they do.
std::uint64_t two(Index first, Index second) {
  return std::uint64_t{static_cast<std::uint32_t>(first)} << 32 |
         static_cast<std::uint32_t>(second);
}

}  // namespace

void ZoneList::join(Span<const Collision> collisions, std::size_t first_new, bool all,
                    const std::function<bool(Index)>& heavy, int ranks) {
  sort_entries(collisions, first_new);
  find_zones(all, heavy);
  share_out(ranks);
}

void ZoneList::sort_entries(Span<const Collision> collisions, std::size_t first_new) {
  // Vertices alone tell most of them apart: few words to move about, and to compare.
  order_.clear();
  for (std::size_t k = 0; k < collisions.size(); ++k) {
    const Index* v = collisions[k].v;
    order_.push_back({two(v[0], v[1]), two(v[2], v[3]), k});
  }
  multipliers_.resize(collisions.size());
  std::sort(order_.begin(), order_.end(), [&](const Numbered& a, const Numbered& b) {
    if (a.first != b.first) return a.first < b.first;
    if (a.second != b.second) return a.second < b.second;
    const auto order = key(collisions[a.place]) <=> key(collisions[b.place]);
    return order != 0 ? order < 0 : (a.place >= first_new) < (b.place >= first_new);
  });
  entries_.clear();
  for (std::size_t i = 0; i < order_.size(); ++i) {
    const bool fresh = order_[i].place >= first_new;
    entries_.push_back({collisions[order_[i].place], i, fresh, fresh});
  }
  // Of equal ones the old one stays if there is one. That it has been found again still counts: its
  // zone has not parted it, and only pairs of zones that are solved are tested again.
  std::size_t kept = 0;
  for (const Entry& e : entries_) {
    if (kept > 0 && key(entries_[kept - 1].collision) == key(e.collision))
      entries_[kept - 1].found |= e.found;
    else
      entries_[kept++] = e;
  }
  entries_.resize(kept);
  any_new_ = std::any_of(entries_.begin(), entries_.end(), [](const Entry& e) { return e.fresh; });
}

Index ZoneList::find(Index i) {
  while (parent_[static_cast<std::size_t>(i)] != i) {
    Index& p = parent_[static_cast<std::size_t>(i)];
    p = parent_[static_cast<std::size_t>(p)];
    i = p;
  }
  return i;
}

/// Joins collisions that share a vertex which can move. A zone is named by its first collision.
void ZoneList::find_zones(bool all, const std::function<bool(Index)>& heavy) {
  parent_.resize(entries_.size());
  std::iota(parent_.begin(), parent_.end(), 0);
  for (std::size_t k = 0; k < entries_.size(); ++k)
    for (const Index v : entries_[k].collision.v) {
      if (heavy(v)) continue;
      const auto vertex = static_cast<std::size_t>(v);
      if (vertex >= first_of_vertex_.size()) first_of_vertex_.resize(vertex + 1, -1);
      Index& first = first_of_vertex_[vertex];
      if (first < 0) {
        first = static_cast<Index>(k);
        continue;
      }
      const Index p = find(first);
      const Index q = find(static_cast<Index>(k));
      parent_[static_cast<std::size_t>(std::max(p, q))] = std::min(p, q);
    }
  for (const Entry& entry : entries_)
    for (const Index v : entry.collision.v)
      if (!heavy(v)) first_of_vertex_[static_cast<std::size_t>(v)] = -1;
  list_members();
  zones_.clear();
  for (std::size_t i = 0, next = 0; i < members_.size(); i = next) {
    bool found = all;
    for (next = i; next < members_.size() && members_[next].first == members_[i].first; ++next)
      found = found || entries_[static_cast<std::size_t>(members_[next].second)].found;
    if (found) zones_.push_back({static_cast<Index>(i), static_cast<Index>(next)});
  }
}

/// Zone by zone, in the order of their first collisions.
void ZoneList::list_members() {
  place_.assign(entries_.size() + 1, 0);
  for (std::size_t k = 0; k < entries_.size(); ++k)
    ++place_[static_cast<std::size_t>(find(static_cast<Index>(k))) + 1];
  std::partial_sum(place_.begin(), place_.end(), place_.begin());
  members_.resize(entries_.size());
  for (std::size_t k = 0; k < entries_.size(); ++k) {
    const Index zone = find(static_cast<Index>(k));
    members_[static_cast<std::size_t>(place_[static_cast<std::size_t>(zone)]++)] = {
        zone, static_cast<Index>(k)};
  }
}

/// The largest zones first, each to the rank that has least to do: which rank that is changes no
/// result.
void ZoneList::share_out(int ranks) {
  std::vector<std::size_t> order(zones_.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [this](std::size_t a, std::size_t b) {
    return zones_[a].end - zones_[a].begin > zones_[b].end - zones_[b].begin;
  });
  shares_.assign(static_cast<std::size_t>(ranks), {});
  for (const std::size_t z : order) {
    ZoneShare& share = *std::min_element(shares_.begin(), shares_.end(),
                                         [](const ZoneShare& a, const ZoneShare& b) {
                                           return a.collisions.size() < b.collisions.size();
                                         });
    for (Index m = zones_[z].begin; m < zones_[z].end; ++m) {
      const Index number = members_[static_cast<std::size_t>(m)].second;
      const Entry& entry = entries_[static_cast<std::size_t>(number)];
      share.collisions.push_back(entry.collision);
      share.multipliers.push_back(multipliers_[order_[entry.first].place]);
      share.entry.push_back(number);
    }
    share.zone_begin.push_back(static_cast<Index>(share.collisions.size()));
  }
}

/// All equal collisions get them: which of these is the first next time does not matter then.
void ZoneList::set_multipliers(std::size_t entry, const ZoneMultipliers& multipliers) {
  const std::size_t end = entry + 1 < entries_.size() ? entries_[entry + 1].first : order_.size();
  for (std::size_t i = entries_[entry].first; i < end; ++i)
    multipliers_[order_[i].place] = multipliers;
}

void ZoneList::keep(std::size_t rank, const std::vector<ZoneMultipliers>& multipliers) {
  const std::vector<Index>& numbers = shares_[rank].entry;
  for (std::size_t k = 0; k < numbers.size(); ++k)
    set_multipliers(static_cast<std::size_t>(numbers[k]), multipliers[k]);
}

void ZoneList::take_back_round() {
  for (const ZoneShare& share : shares_)
    for (const Index number : share.entry) {
      const auto entry = static_cast<std::size_t>(number);
      ZoneMultipliers m = multipliers_[order_[entries_[entry].first].place];
      if (m.unsolved_rounds == 0) continue;
      --m.unsolved_rounds;
      set_multipliers(entry, m);
    }
}

void ZoneList::forget_where(const std::function<bool(Index)>& of_vertex) {
  for (std::size_t i = 0, next = 0; i < members_.size(); i = next) {
    bool holds = false;
    for (next = i; next < members_.size() && members_[next].first == members_[i].first; ++next)
      for (const Index v : entries_[static_cast<std::size_t>(members_[next].second)].collision.v)
        holds = holds || of_vertex(v);
    if (!holds) continue;
    for (std::size_t m = i; m < next; ++m)
      set_multipliers(static_cast<std::size_t>(members_[m].second), {});
  }
}

Index ZoneList::largest() const {
  Index largest = 0;
  for (const Zone& zone : zones_) largest = std::max(largest, zone.end - zone.begin);
  return largest;
}

}  // namespace weft
