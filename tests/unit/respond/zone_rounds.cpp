// What a round of impact zones leaves to those that follow it.
#include <gtest/gtest.h>

#include <algorithm>
#include <compare>

#include "tests/support/zone_case.hpp"
#include "weft/kernels/respond/zones.hpp"

namespace weft {
namespace {

using test::chain;
using test::exclude_the_first;
using test::gap;
using test::join;
using test::kinetic;
using test::solve_listed;
using test::solve_zones;
using test::tangles;
using test::vice;
using test::worst_share;
using test::ZoneCase;
using test::ZoneRandom;
using test::ZoneResult;

/// A constraint counts as met from here on, and the rounding of positions on top.
constexpr double short_of = 1 - zone_met_share + 1e-6;

/// What gives way to slow progress goes on, and takes planes only if that does not help.
TEST(ZoneRounds, LargeZonesGoOnForSomeRoundsBeforeTheyTakePlanes) {
  const ZoneCase zones = chain(180, 1, false);
  ASSERT_GT(zones.collisions.size(), static_cast<std::size_t>(zone_planes_at_once));
  const ZoneResult once = solve_zones(zones);
  EXPECT_FALSE(once.solved);
  EXPECT_EQ(0, once.outcomes[0].planes);
  const ZoneResult all = solve_zones(zones, ZoneMotion::impacts, 1, zone_rounds_before_planes + 1);
  EXPECT_TRUE(all.solved) << all.rounds << " rounds, " << all.passes << " passes";
  EXPECT_LE(all.rounds, zone_rounds_before_planes);
  EXPECT_EQ(0, all.outcomes[0].planes);
  EXPECT_LE(worst_share(zones, all.end), short_of);
  EXPECT_LE(kinetic(zones, all.end), kinetic(zones, zones.end));
}

/// Where nothing but planes helps, they come once the impacts have had their rounds, and at once
/// where it is seen that the impacts exclude each other.
TEST(ZoneRounds, LargeZonesTakePlanesInTheEnd) {
  const ZoneCase zones = chain(400, 1e4, false);
  const ZoneResult before = solve_zones(zones, ZoneMotion::impacts, 1, zone_rounds_before_planes);
  EXPECT_FALSE(before.solved);
  EXPECT_EQ(0, before.outcomes[0].planes);
  const ZoneResult then = solve_zones(zones, ZoneMotion::impacts, 1, zone_rounds_before_planes + 1);
  EXPECT_TRUE(then.solved);
  EXPECT_EQ(1, then.outcomes[0].planes);
  ZoneCase excluded = chain(180, 1, false);
  exclude_the_first(excluded);
  EXPECT_EQ(1, solve_zones(excluded).outcomes[0].planes);
}

/// Impacts that are found only once the others are parted are all that a round has to look after.
TEST(ZoneRounds, ARoundBeginsWhereTheOneBeforeHasEnded) {
  const ZoneCase zones = chain(40, 1, false);
  const std::size_t count = zones.collisions.size();
  const std::size_t old = count - 3;
  ZoneList cold_list;
  join(cold_list, zones, count, 0);
  const ZoneResult cold = solve_listed(zones, cold_list);
  EXPECT_TRUE(cold.solved);
  std::vector<Vec3<double>> first_end;
  for (const int ranks : {1, 3}) {
    ZoneList list;
    join(list, zones, old, 0, false, ranks);
    EXPECT_TRUE(solve_listed(zones, list).solved);
    join(list, zones, count, old, false, ranks);
    const ZoneResult warm = solve_listed(zones, list);
    EXPECT_TRUE(warm.solved);
    EXPECT_GT(warm.passes, 0);
    EXPECT_LT(warm.passes, cold.passes / 2) << "of " << cold.passes;
    EXPECT_LE(worst_share(zones, warm.end), short_of);
    EXPECT_LE(kinetic(zones, warm.end), kinetic(zones, zones.end));
    if (ranks == 1) first_end = warm.end;
    EXPECT_EQ(first_end, warm.end) << "the ranks that share the zones out change bits";
    // Forgotten, they are as if there had been no round.
    list.forget();
    join(list, zones, count, 0, false, ranks);
    EXPECT_EQ(cold.end, solve_listed(zones, list).end);
  }
}

/// Zones that a round joins keep what each of them had, whoever solved it and in whatever order
/// their collisions come.
TEST(ZoneRounds, JoinedZonesKeepTheirMultipliersOnAnyNumberOfRanks) {
  ZoneRandom random(12);
  ZoneCase zones = tangles(random, 9);
  const std::size_t old = zones.collisions.size();
  // Of every second group one collision reaches into the next: they join by pairs.
  for (Index g = 0; g < 8; g += 2) {
    Collision c = zones.collisions[static_cast<std::size_t>(g)];
    for (const Collision& other : zones.collisions)
      if (other.v[0] / 13 == g) c = other;
    c.v[3] = 13 * (g + 1) + 2;
    if (gap(c, zones.start) < 0) c.n = -c.n;
    c.offset = std::max(1e-3, 0.9 * gap(c, zones.start));
    zones.collisions.push_back(c);
  }
  std::vector<Vec3<double>> first_end;
  for (const int ranks : {1, 2, 5}) {
    for (std::size_t i = old; i > 1; --i)
      std::swap(zones.collisions[i - 1], zones.collisions[random.below(i)]);
    ZoneList list;
    std::vector<Vec3<double>> end = zones.end;
    std::size_t warm = 0;
    for (const bool second : {false, true}) {
      join(list, zones, second ? zones.collisions.size() : old, second ? old : 0, false, ranks);
      for (const ZoneShare& share : list.shares())
        for (const ZoneMultipliers& m : share.multipliers) warm += m.impact > 0 ? 1 : 0;
      for (const auto& m : solve_listed(zones, list).moved)
        end[static_cast<std::size_t>(m.vertex)] = m.position;
    }
    EXPECT_EQ(4, list.zone_count()) << "pairs of groups";
    EXPECT_GT(warm, 0u);
    if (ranks == 1) first_end = end;
    EXPECT_EQ(first_end, end) << ranks;
  }
}

/// A chain of impacts and two vices, each a zone.
struct Pinched {
  ZoneCase zones;
  Index tight, roomy;  ///< first vertices of the vices: the free ones, which their jaws follow

  Pinched() : zones(chain(40, 1, false)) {
    tight = zones.add(vice(0.95));
    roomy = zones.add(vice(0.85));
    zones.end[static_cast<std::size_t>(roomy)][2] += 0.3;
  }
  bool in_jaws_of_tight(Index v) const { return v > tight && v < roomy; }
};

struct Start {
  Index vertex;  ///< first of a collision
  double multiplier;
  auto operator<=>(const Start&) const = default;
};

/// Joins the zones for another round: those of new collisions, which there are none of, or all.
/// @return where that begins, by vertex
std::vector<Start> join_again(ZoneList& list, const ZoneCase& zones, bool all, int ranks) {
  join(list, zones, zones.collisions.size(), zones.collisions.size(), all, ranks);
  std::vector<Start> starts;
  for (const ZoneShare& share : list.shares())
    for (std::size_t k = 0; k < share.collisions.size(); ++k)
      starts.push_back({share.collisions[k].v[0], share.multipliers[k].impact});
  std::sort(starts.begin(), starts.end());
  return starts;
}

/// Expects that all begins as it was kept, but what collides with vertex `forgotten` from nothing.
void expect_forgotten(const std::vector<Start>& kept, const std::vector<Start>& begins,
                      Index forgotten) {
  ASSERT_EQ(kept.size(), begins.size());
  double largest = 0;
  for (std::size_t k = 0; k < kept.size(); ++k) {
    const bool here = kept[k].vertex == forgotten;
    if (here) largest = std::max(largest, kept[k].multiplier);
    EXPECT_EQ((Start{kept[k].vertex, here ? 0 : kept[k].multiplier}), begins[k]);
  }
  EXPECT_GT(largest, 0);
}

/// A zone whose masses change starts over; what has nothing to do with it goes on from where it is,
/// and all come to an end that meets every constraint, on any number of ranks.
TEST(ZoneRounds, WhereSomethingYieldsOtherZonesKeepTheirMultipliers) {
  std::vector<Vec3<double>> first_end;
  for (const int ranks : {1, 2, 3, 5}) {
    SCOPED_TRACE(ranks);
    Pinched s;
    ZoneList list;
    join(list, s.zones, s.zones.collisions.size(), 0, false, ranks);
    const ZoneResult cold = solve_listed(s.zones, list);
    EXPECT_FALSE(cold.solved);
    ASSERT_EQ(3u, cold.outcomes.size());
    const std::vector<Start> kept = join_again(list, s.zones, true, ranks);
    list.forget_where([&](Index v) { return s.in_jaws_of_tight(v); });
    expect_forgotten(kept, join_again(list, s.zones, true, ranks), s.tight);
    for (Index v = s.tight + 1; v < s.roomy; ++v)
      s.zones.compliant[static_cast<std::size_t>(v)] = 1;
    join_again(list, s.zones, true, ranks);
    const ZoneResult warm = solve_listed(s.zones, list);
    EXPECT_TRUE(warm.solved);
    EXPECT_LE(worst_share(s.zones, warm.end), short_of);
    // A sweep finds that all is met, and another look says so of all at once.
    EXPECT_EQ(2, std::count_if(warm.outcomes.begin(), warm.outcomes.end(),
                               [](const ZoneOutcome& o) { return o.passes == 2; }));
    if (ranks == 1) first_end = warm.end;
    EXPECT_EQ(first_end, warm.end);
  }
}

/// A zone that is solved again as another one has yielded has gone on for one round, not two.
TEST(ZoneRounds, PassesOfOneRoundCountOnce) {
  const ZoneCase zones = chain(400, 1e4, false);
  ZoneList list;
  for (int pass = 0; pass <= zone_rounds_before_planes; ++pass) {
    join(list, zones, zones.collisions.size(), 0);
    EXPECT_EQ(0, solve_listed(zones, list).outcomes[0].planes) << pass;
    list.take_back_round();
  }
}

/// A zone in which nothing is new may be met again, and has yielded then as others have.
TEST(ZoneRounds, ZonesThatAreNotListedForgetToo) {
  const Pinched s;
  ZoneList list;
  join(list, s.zones, s.zones.collisions.size(), 0);
  solve_listed(s.zones, list);
  const std::vector<Start> kept = join_again(list, s.zones, true, 1);
  EXPECT_TRUE(join_again(list, s.zones, false, 1).empty()) << "a zone is listed";
  list.forget_where([&](Index v) { return s.in_jaws_of_tight(v); });
  expect_forgotten(kept, join_again(list, s.zones, true, 1), s.tight);
}

/// Bodies have no multipliers: these stay, and need not be there.
TEST(ZoneRounds, RigidMotionLeavesMultipliers) {
  const ZoneCase zones = chain(40, 1, false);
  ZoneList list;
  join(list, zones, zones.collisions.size(), 0);
  std::vector<ZoneMultipliers> before = list.shares()[0].multipliers;
  for (std::size_t k = 0; k < before.size(); ++k) {
    before[k].impact = 0.25 * static_cast<double>(k);
    before[k].unsolved_rounds = 2;
  }
  list.keep(0, before);
  join_again(list, zones, true, 1);
  EXPECT_TRUE(solve_listed(zones, list, ZoneMotion::rigid).solved);
  join_again(list, zones, true, 1);
  const std::vector<ZoneMultipliers>& after = list.shares()[0].multipliers;
  ASSERT_EQ(before.size(), after.size());
  for (std::size_t k = 0; k < before.size(); ++k) {
    EXPECT_EQ(before[k].impact, after[k].impact);
    EXPECT_EQ(2, after[k].unsolved_rounds);
  }
}

}  // namespace
}  // namespace weft
