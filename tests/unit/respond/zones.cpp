#include "weft/kernels/respond/zones.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>

#include "tests/support/zone_case.hpp"
#include "weft/elements/ccd.hpp"

namespace weft {
namespace {

using test::chain;
using test::exclude_the_first;
using test::gap;
using test::kinetic;
using test::momentum;
using test::momentum_size;
using test::random_impact;
using test::same_bits;
using test::solve_zones;
using test::start_satisfies;
using test::tangle;
using test::tangles;
using test::vice;
using test::worst_share;
using test::ZoneCase;
using test::ZoneRandom;
using test::ZoneResult;

/// Rounding of positions of size 1 and of weights that sum to zero; far below what was promised.
constexpr double exact = 1e-12;
/// A constraint counts as met from here on, and the rounding of positions on top.
constexpr double short_of = 1 - zone_met_share + 1e-6;

/// The sum of m x u about the origin, for x where the impact is.
Vec3<double> angular_momentum(const ZoneCase& zones, const std::vector<Vec3<double>>& end,
                              double toi) {
  Vec3<double> sum{};
  for (std::size_t i = 0; i < end.size(); ++i) {
    const Vec3<double> at = zones.start[i] + toi * (zones.end[i] - zones.start[i]);
    sum += zones.mass[i] * cross(at, end[i] - zones.start[i]);
  }
  return sum;
}

TEST(Zones, ASingleImpactKeepsMomentaAndLosesEnergy) {
  ZoneRandom random(1);
  int judged = 0;
  for (int n = 0; n < 400; ++n) {
    const ZoneCase zones = random_impact(random, 1 + n % 2, n % 4 < 2 ? 3 : 1e4);
    const ZoneResult result = solve_zones(zones);
    ASSERT_TRUE(result.solved);
    EXPECT_LE(worst_share(zones, result.end), short_of);
    const double size = momentum_size(zones, zones.end) + momentum_size(zones, result.end);
    EXPECT_LE(length(momentum(zones, result.end) - momentum(zones, zones.end)), exact * size);
    const double toi = zones.collisions[0].toi;
    EXPECT_LE(
        length(angular_momentum(zones, result.end, toi) - angular_momentum(zones, zones.end, toi)),
        exact * size);
    if (!start_satisfies(zones)) continue;
    ++judged;
    EXPECT_LE(kinetic(zones, result.end), kinetic(zones, zones.end) * (1 + exact));
  }
  EXPECT_GT(judged, 100);
}

/// Where the primitives end does not matter: after one round the planes of the start part them.
TEST(Zones, PlanesPartAPairForGoodAndLoseEnergy) {
  ZoneRandom random(9);
  for (int n = 0; n < 400; ++n) {
    const int kind = 1 + n % 2;
    const ZoneCase zones = random_impact(random, kind, n % 4 < 2 ? 3 : 1e4);
    const ZoneResult result = solve_zones(zones, ZoneMotion::planes);
    ASSERT_TRUE(result.solved);
    const Vec3<double>* x0 = zones.start.data();
    const double distance =
        std::sqrt((kind == 1 ? vertex_triangle(x0) : edge_edge(x0)).distance_sq);
    const double separation = std::min(1e-4, 0.5 * distance);
    const Impact again = kind == 1 ? ccd_vertex_triangle(x0, result.end.data(), separation)
                                   : ccd_edge_edge(x0, result.end.data(), separation);
    EXPECT_FALSE(again.hit) << n;
    const double size = momentum_size(zones, zones.end) + momentum_size(zones, result.end);
    EXPECT_LE(length(momentum(zones, result.end) - momentum(zones, zones.end)), exact * size);
    EXPECT_LE(kinetic(zones, result.end), kinetic(zones, zones.end) * (1 + exact));
  }
}

/// What touches at the start has no plane between it: its vertices are parted along the impact.
TEST(Zones, PlanesOfWhatTouchesAtTheStartAreThoseOfTheImpact) {
  ZoneRandom random(13);
  constexpr double offset = 2e-4;
  for (int n = 0; n < 50; ++n) {
    SCOPED_TRACE(n);
    const int kind = 1 + n % 2;
    ZoneCase zones;
    // On whole numbers, so that the distance is none: a vertex on a face, or two edges that cross.
    const std::vector<Vec3<double>> at =
        kind == 1 ? std::vector<Vec3<double>>{{1, 1, 0}, {0, 0, 0}, {4, 0, 0}, {0, 4, 0}}
                  : std::vector<Vec3<double>>{{-1, 0, 0}, {1, 0, 0}, {0, -1, 0}, {0, 1, 0}};
    for (const Vec3<double>& x : at) zones.add(x, x + random.vector(0.5), random.uniform(1, 1e2));
    ASSERT_EQ(0, (kind == 1 ? vertex_triangle(at.data()) : edge_edge(at.data())).distance_sq);
    Vec3<double> normal = Vec3<double>{0, 0, 1} + random.vector(0.1);
    normal *= 1 / length(normal);
    zones.collisions.push_back({{0, 1, 2, 3}, {1, -0.5, -0.25, -0.25}, normal, offset, 0.5, kind});
    const ZoneResult result = solve_zones(zones, ZoneMotion::planes);
    EXPECT_TRUE(result.solved);
    for (int i = 0; i < kind; ++i)
      for (int j = kind; j < 4; ++j) {
        const Vec3<double> apart =
            result.end[static_cast<std::size_t>(i)] - result.end[static_cast<std::size_t>(j)];
        EXPECT_GE(dot(normal, apart), (1 - short_of) * offset);
      }
    const double size = momentum_size(zones, zones.end) + momentum_size(zones, result.end);
    EXPECT_LE(length(momentum(zones, result.end) - momentum(zones, zones.end)), exact * size);
  }
}

TEST(Zones, LargeZonesKeepLinearMomentumAndLoseEnergy) {
  ZoneRandom random(2);
  double angular = 0;
  for (int n = 0; n < 60; ++n) {
    const ZoneCase zones = tangle(random, 60, 20 + static_cast<std::size_t>(n), n % 2 ? 1 : 1e4);
    ASSERT_TRUE(start_satisfies(zones));
    const ZoneResult result = solve_zones(zones);
    ASSERT_TRUE(result.solved) << n;
    EXPECT_LE(worst_share(zones, result.end), short_of) << n;
    const double size = momentum_size(zones, zones.end) + momentum_size(zones, result.end);
    EXPECT_LE(length(momentum(zones, result.end) - momentum(zones, zones.end)), exact * size);
    EXPECT_LE(kinetic(zones, result.end), kinetic(zones, zones.end) * (1 + exact));
    angular = std::max(angular, length(angular_momentum(zones, result.end, 0) -
                                       angular_momentum(zones, zones.end, 0)) /
                                    size);
  }
  RecordProperty("angular_momentum_change", std::to_string(angular));
}

/// What impacts cannot meet, the planes of the start do.
TEST(Zones, ImpactsThatExcludeEachOtherGiveWayToPlanes) {
  ZoneRandom random(3);
  for (int n = 0; n < 50; ++n) {
    ZoneCase zones = random_impact(random, 1 + n % 2, 1e2);
    exclude_the_first(zones);
    const ZoneResult result = solve_zones(zones);
    EXPECT_TRUE(result.solved);
    EXPECT_EQ(1, result.outcomes[0].planes);
    EXPECT_LE(result.passes, 2 * (zone_passes_max + 2));
    EXPECT_LE(kinetic(zones, result.end), kinetic(zones, zones.end) * (1 + exact));
    // Where nothing can move there is nothing to solve.
    for (const Index v : zones.collisions[0].v) zones.fixed[static_cast<std::size_t>(v)] = 1;
    const ZoneResult stuck = solve_zones(zones);
    EXPECT_FALSE(stuck.solved);
    EXPECT_TRUE(stuck.moved.empty());
  }
}

/// So they do where something prescribed carries the zone along, and that there is no other way is
/// found out early.
TEST(Zones, ImpactsThatExcludeEachOtherGiveWayToPlanesAboutWhatMovesAsOne) {
  ZoneRandom random(4);
  for (int n = 0; n < 50; ++n) {
    SCOPED_TRACE(n);
    ZoneCase zones = random_impact(random, 1 + n % 2, 1e2);
    // The second primitive is held, and carries all with it.
    const Vec3<double> shift{0.3, -2, 1};
    const int first = zones.collisions[0].first;
    for (int j = 0; j < 4; ++j) {
      const auto v = static_cast<std::size_t>(zones.collisions[0].v[j]);
      if (j >= first) {
        zones.fixed[v] = 1;
        zones.end[v] = zones.start[v];
      }
      zones.end[v] += shift;
    }
    exclude_the_first(zones);
    const ZoneResult result = solve_zones(zones);
    EXPECT_TRUE(result.solved);
    EXPECT_EQ(1, result.outcomes[0].planes);
    EXPECT_EQ(0, result.outcomes[0].pinched);
    EXPECT_LE(result.passes, 400);
    // Held the other way for a part, nothing says that there is a way at all.
    zones.end[static_cast<std::size_t>(zones.collisions[0].v[3])] += Vec3<double>{0, 0, 1e-3};
    EXPECT_EQ(0, solve_zones(zones).outcomes[0].planes);
  }
}

TEST(Zones, AFixedTriangleHoldsAVertexAtItsOffset) {
  ZoneCase zones;
  zones.add({0.2, 0.2, 0.5}, {0.3, 0.2, -0.5}, 2);
  zones.add({0, 0, 0}, {0, 0, 0}, 1, true);
  zones.add({1, 0, 0}, {1, 0, 0}, 1, true);
  zones.add({0, 1, 0}, {0, 1, 0}, 1, true);
  zones.collisions.push_back({{0, 1, 2, 3}, {1, -0.55, -0.25, -0.2}, {0, 0, 1}, 0.01, 0.5});
  const ZoneResult result = solve_zones(zones);
  EXPECT_TRUE(result.solved);
  ASSERT_EQ(1u, result.moved.size()) << "what is fixed moves";
  EXPECT_EQ(0.3, result.end[0][0]);
  EXPECT_EQ(0.2, result.end[0][1]);
  EXPECT_NEAR(0.01, result.end[0][2], 1e-15);
}

TEST(Zones, WhatIsPrescribedPinches) {
  const ZoneResult roomy = solve_zones(vice(0.85));
  EXPECT_TRUE(roomy.solved);
  EXPECT_EQ(1, roomy.outcomes[0].pinched);
  const ZoneResult tight = solve_zones(vice(0.95));
  EXPECT_FALSE(tight.solved);
  EXPECT_EQ(1, tight.outcomes[0].pinched);
  EXPECT_LE(tight.passes, 2 * (pinched_passes_max + 2));
  ZoneCase compliant = vice(0.95);
  std::copy(compliant.fixed.begin(), compliant.fixed.end(), compliant.compliant.begin());
  const ZoneResult complied = solve_zones(compliant);
  EXPECT_TRUE(complied.solved);
  EXPECT_EQ(0, complied.outcomes[0].pinched);
  EXPECT_EQ(7u, complied.moved.size());
  // Bodies that do not move never pinch cloth, however narrow the gap.
  ZoneCase still = vice(0.95);
  still.start = still.end;
  EXPECT_EQ(0, solve_zones(still).outcomes[0].pinched);
}

TEST(Zones, RigidZonesKeepMomentumOrFollowWhatIsPrescribed) {
  ZoneRandom random(4);
  for (int n = 0; n < 20; ++n) {
    ZoneCase zones = tangle(random, 8, 6, 1e2);
    for (std::size_t i = 0; i < zones.end.size(); ++i)
      zones.end[i] = zones.start[i] + 1e-3 * (zones.end[i] - zones.start[i]);
    const ZoneResult result = solve_zones(zones, ZoneMotion::rigid);
    ASSERT_TRUE(result.solved);
    const double size = momentum_size(zones, zones.end) + momentum_size(zones, result.end);
    // A zone that is all of the vertices: some may be in none.
    EXPECT_LE(length(momentum(zones, result.end) - momentum(zones, zones.end)), exact * size);
    for (const auto& a : result.moved)
      for (const auto& b : result.moved) {
        if (result.outcomes.size() > 1) continue;
        const auto i = static_cast<std::size_t>(a.vertex), j = static_cast<std::size_t>(b.vertex);
        EXPECT_NEAR(length(zones.start[i] - zones.start[j]), length(a.position - b.position),
                    1e-12);
      }
  }
  ZoneCase carried = vice(0.5);
  for (std::size_t i = 1; i < carried.end.size(); ++i)
    carried.end[i] = carried.start[i] + Vec3<double>{0.25, 0, 1};
  const ZoneResult result = solve_zones(carried, ZoneMotion::rigid);
  ASSERT_TRUE(result.solved);
  EXPECT_EQ((Vec3<double>{0.25, 0, 1}), result.end[0]);
  const ZoneResult stuck = solve_zones(vice(0.5), ZoneMotion::rigid);
  EXPECT_FALSE(stuck.solved);
  EXPECT_TRUE(stuck.moved.empty()) << "a zone that cannot move as a body stays as it is";
}

TEST(Zones, TheOrderOfCollisionsAndTheNumberOfRanksDoNotMatter) {
  ZoneRandom random(5);
  for (int n = 0; n < 8; ++n) {
    ZoneCase zones = tangles(random, 9);
    const ZoneResult first = solve_zones(zones);
    EXPECT_GT(first.outcomes.size(), 8u);
    for (int k = 0; k < 4; ++k) {
      for (std::size_t i = zones.collisions.size(); i > 1; --i)
        std::swap(zones.collisions[i - 1], zones.collisions[random.below(i)]);
      EXPECT_TRUE(same_bits(first, solve_zones(zones)));
    }
    for (const int ranks : {2, 3, 5, 8, 30})
      EXPECT_TRUE(same_bits(first, solve_zones(zones, ZoneMotion::impacts, ranks))) << ranks;
  }
}

TEST(Zones, DisjointZonesComeOutAsEachAloneAndNothingElseMoves) {
  ZoneRandom random(6);
  const ZoneCase zones = tangles(random, 2);
  const ZoneResult both = solve_zones(zones);
  std::vector<unsigned char> moved(zones.start.size(), 0);
  for (int part = 0; part < 2; ++part) {
    ZoneCase alone = zones;
    alone.collisions.clear();
    const Index middle = 13;
    for (const Collision& c : zones.collisions)
      if ((c.v[0] < middle) == (part == 0)) alone.collisions.push_back(c);
    ASSERT_FALSE(alone.collisions.empty());
    for (const auto& m : solve_zones(alone).moved) {
      const auto i = static_cast<std::size_t>(m.vertex);
      moved[i] = 1;
      EXPECT_EQ(0, std::memcmp(&m.position, &both.end[i], sizeof m.position)) << i;
    }
  }
  std::size_t outside = 0;
  for (std::size_t i = 0; i < moved.size(); ++i) {
    if (moved[i] != 0) continue;
    ++outside;
    EXPECT_EQ(0, std::memcmp(&zones.end[i], &both.end[i], sizeof zones.end[i])) << i;
  }
  EXPECT_GT(outside, 0u);
}

TEST(Zones, LongChainsConvergeWithinTheirBound) {
  for (const std::size_t count : {std::size_t{3}, std::size_t{20}, std::size_t{200}})
    for (const double mass_ratio : {1.0, 1e4})
      for (const bool redundant : {false, true}) {
        const ZoneCase zones = chain(count, mass_ratio, redundant);
        // A round that hardly gets further leaves it to the next one to go on from there.
        const ZoneResult result =
            solve_zones(zones, ZoneMotion::impacts, 1, zone_rounds_before_planes + 1);
        const std::string name = std::to_string(count) + " layers, masses 1 to " +
                                 std::to_string(mass_ratio) + (redundant ? ", redundant" : "");
        EXPECT_TRUE(result.solved) << name << ", " << result.passes << " passes";
        EXPECT_LE(worst_share(zones, result.end), short_of) << name;
        EXPECT_LE(result.passes_of_round, zone_passes_max) << name;
        EXPECT_LE(kinetic(zones, result.end), kinetic(zones, zones.end)) << name;
        RecordProperty("passes_" + std::to_string(count) + (redundant ? "_redundant" : "") +
                           (mass_ratio > 1 ? "_masses" : ""),
                       result.passes);
      }
}

TEST(ZoneList, EqualCollisionsAreThereOnceAndOldOnesAreNotNews) {
  ZoneRandom random(8);
  ZoneCase zones = random_impact(random, 1, 1);
  zones.collisions.push_back(zones.collisions[0]);
  ZoneList list;
  const auto light = [](Index) { return false; };
  const Span<const Collision> all(zones.collisions.data(), zones.collisions.size());
  // Found again as it was: no news, but its zone has not parted it and is listed.
  list.join(all, 1, false, light, 2);
  EXPECT_FALSE(list.any_new());
  EXPECT_EQ(1, list.zone_count());
  // Not found again.
  list.join(all, 2, false, light, 2);
  EXPECT_FALSE(list.any_new());
  EXPECT_EQ(0, list.zone_count());
  list.join(all, 1, true, light, 2);
  EXPECT_EQ(1, list.zone_count());
  EXPECT_EQ(1, list.largest());
  zones.collisions[1].offset *= 0.5;
  list.join(all, 1, false, light, 2);
  EXPECT_TRUE(list.any_new());
  EXPECT_EQ(1, list.zone_count());
  EXPECT_EQ(2, list.largest());
}

}  // namespace
}  // namespace weft
