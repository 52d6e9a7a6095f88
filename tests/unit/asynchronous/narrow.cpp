// The narrow phase and the broad one beneath it, on cases made by hand and at random.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>
#include <set>

#include "host/asynchronous/clock.hpp"
#include "host/asynchronous/dop.hpp"
#include "host/asynchronous/hierarchy.hpp"
#include "host/asynchronous/layers.hpp"
#include "host/asynchronous/narrow.hpp"
#include "host/asynchronous/order.hpp"

namespace weft::test {
namespace {

using Trajectories = std::vector<std::vector<Breakpoint>>;

bool close(const Trajectories& trajectories, bool edges, double distance, bool slabs,
           NarrowCounts& counts) {
  const PrimitivePair pair{PrimitivePair::key_of(edges, 0, 1), {0, 1, 2, 3}};
  const Trajectory corners[4] = {trajectories[0], trajectories[1], trajectories[2],
                                 trajectories[3]};
  return comes_within(pair, corners, distance, slabs, 1e-15, counts);
}

/// A vertex over a triangle at z = 0, down to `depth` halfway through a window of a millisecond.
Trajectories dip(double depth) {
  Trajectories trajectories(4);
  trajectories[0] = {{0, {0.2, 0.2, 0.01}}, {5e-4, {0.2, 0.2, depth}}, {1e-3, {0.2, 0.2, 0.01}}};
  const Vec3<double> corners[3] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  for (std::size_t c = 0; c < 3; ++c) trajectories[c + 1] = {{0, corners[c]}, {1e-3, corners[c]}};
  return trajectories;
}

TEST(NarrowPhase, FindsADipAndNothingElse) {
  for (const bool slabs : {true, false}) {
    NarrowCounts counts;
    EXPECT_TRUE(close(dip(0.0019), false, 0.002, slabs, counts)) << slabs;
    EXPECT_FALSE(close(dip(0.0021), false, 0.002, slabs, counts)) << slabs;
    EXPECT_TRUE(close(dip(-0.01), false, 0.002, slabs, counts)) << "went through, " << slabs;
    EXPECT_EQ(counts.calls, 3);
    EXPECT_EQ(counts.failsafe > 0, !slabs);
  }
}

/// Ways of random breakpoints: slabs and continuous detection may differ only within a thousandth.
TEST(NarrowPhase, SlabsAgreeWithContinuousDetection) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> unit(0, 1);
  int hits = 0, misses = 0;
  NarrowCounts slab_counts, ccd_counts;
  for (int n = 0; n < 4000; ++n) {
    Trajectories trajectories(4);
    const double speed = std::pow(10.0, -3 * unit(random));
    for (auto& way : trajectories) {
      Vec3<double> x{unit(random), unit(random), unit(random)};
      const auto breakpoints = 2 + random() % 20;
      std::vector<double> times{0, 1e-3};
      for (std::size_t k = 2; k < breakpoints; ++k) times.push_back(1e-3 * unit(random));
      std::sort(times.begin(), times.end());
      for (const double t : times) {
        if (!way.empty() && !(t > way.back().t)) continue;
        way.push_back({t, x});
        for (int c = 0; c < 3; ++c) x[c] += speed * (unit(random) - 0.5);
      }
    }
    const bool edges = n % 2 == 0;
    const double distance = 0.3 * unit(random);
    const bool by_slabs = close(trajectories, edges, distance, true, slab_counts);
    const bool by_ccd = close(trajectories, edges, distance, false, ccd_counts);
    if (by_slabs != by_ccd) {
      EXPECT_TRUE(close(trajectories, edges, distance * (1 + 2e-3), false, ccd_counts)) << n;
      EXPECT_FALSE(close(trajectories, edges, distance * (1 - 2e-3), false, ccd_counts)) << n;
    }
    (by_slabs ? hits : misses) += 1;
  }
  EXPECT_GT(hits, 500);
  EXPECT_GT(misses, 500);
  EXPECT_LT(slab_counts.failsafe, slab_counts.calls / 50);
}

/// Near the distance for long: bounded work, and still the right answer.
TEST(NarrowPhase, EndsAtTheBrink) {
  Trajectories trajectories = dip(0.0020001);
  trajectories[0].clear();
  for (int k = 0; k <= 1000; ++k)
    trajectories[0].push_back({1e-6 * k, {0.2 + 1e-4 * k, 0.2, k % 2 == 0 ? 0.00201 : 0.0021}});
  for (std::size_t c = 1; c < 4; ++c) trajectories[c].back().t = 1e-3;
  NarrowCounts counts;
  EXPECT_FALSE(close(trajectories, false, 0.002, true, counts));
  EXPECT_LE(counts.slabs, slabs_max);
  EXPECT_LE(counts.ccd, 3000);
}

/// Two points are farther than a distance below theirs along an axis of the polytope, and never
/// farther than theirs, however large the coordinates are.
TEST(Dop, ShowsGapsThatThereAreOnly) {
  std::mt19937 random(11);
  std::uniform_real_distribution<double> unit(0, 1);
  const auto of = [](const Vec3<double>& x) {
    Extent extent;
    extent.include(x);
    return Dop(extent);
  };
  for (int n = 0; n < 20000; ++n) {
    Vec3<double> x, step;
    for (int k = 0; k < 3; ++k) {
      x[k] = 100 * (unit(random) - 0.5);
      step[k] = static_cast<double>(random() % 3) - 1;
    }
    if (length(step) == 0) continue;
    const double distance = 0.1 * unit(random);
    const Vec3<double> y = x + step * (distance / length(step));
    EXPECT_FALSE(of(x).farther(of(y), dop_distance(distance))) << n;
    EXPECT_TRUE(of(x).farther(of(y), dop_distance(distance - 1e-4))) << n;
    EXPECT_LE(of(x).gap(of(y)), distance) << n;
    EXPECT_GE(of(x).gap(of(y)), distance - 1e-4) << n;
    // A ball reaches as far as its radius says, and no farther.
    Extent ball;
    ball.include(x);
    ball.widen(distance);
    EXPECT_FALSE(Dop(ball).farther(of(y), dop_distance(0))) << n;
    EXPECT_LE(Dop(ball).gap(of(y)), 0) << n;
    EXPECT_GE(Dop(ball).gap(of(y)), -1e-4) << n;
  }
}

TEST(Hierarchy, FindsAllPairsOfDops) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> unit(0, 1);
  std::vector<Tri> triangles;
  std::vector<Vec3<double>> x;
  for (Index t = 0; t < 150; ++t) {
    triangles.push_back({{3 * t, 3 * t + 1, 3 * t + 2}});
    const Vec3<double> centre{unit(random), unit(random), unit(random)};
    for (int c = 0; c < 3; ++c)
      x.push_back(centre +
                  Vec3<double>{0.2 * unit(random), 0.2 * unit(random), 0.2 * unit(random)});
  }
  std::vector<Dop> swept(x.size());
  for (std::size_t i = 0; i < x.size(); ++i) {
    Extent extent;
    extent.include(x[i]);
    extent.include(x[i] + Vec3<double>{0.05 * unit(random), 0, 0});
    swept[i] = Dop(extent);
  }
  Workers workers(2);
  const std::size_t cloth = 100;
  for (const bool self : {true, false}) {
    Hierarchy tree(triangles, cloth);
    tree.build(x);
    tree.fit(swept, workers);
    std::vector<std::vector<std::pair<std::size_t, std::size_t>>> found;
    tree.visit(
        dop_distance(0.02), self, workers, [&](std::size_t tasks) { found.resize(tasks); },
        [&](std::size_t task, std::size_t s, std::size_t t) {
          found[task].emplace_back(std::min(s, t), std::max(s, t));
        });
    std::set<std::pair<std::size_t, std::size_t>> all, expected;
    std::size_t count = 0;
    for (const auto& part : found) {
      count += part.size();
      all.insert(part.begin(), part.end());
    }
    for (std::size_t s = 0; s < triangles.size(); ++s)
      for (std::size_t t = s + 1; t < triangles.size(); ++t)
        if (s < cloth && (self || t >= cloth) &&
            !tree.of_triangle(s).farther(tree.of_triangle(t), dop_distance(0.02)))
          expected.emplace(s, t);
    EXPECT_EQ(count, all.size()) << "some pair came twice";
    EXPECT_EQ(all, expected);
    EXPECT_GT(all.size(), 20u);
  }
}

TEST(Layers, DepthIsThatOfTheDistance) {
  const LayerRule rule{0.01, 100, 1e-4};
  EXPECT_EQ(rule.layers_within(0.0100001, 100), 0);
  EXPECT_EQ(rule.layers_within(0.0099999, 100), 1);
  for (int l = 2; l < 60; ++l) {
    EXPECT_EQ(rule.layers_within(rule.thickness_of(l) * (1 + 1e-12), 100), l - 1);
    EXPECT_EQ(rule.layers_within(rule.thickness_of(l) * (1 - 1e-12), 100), l);
  }
  EXPECT_EQ(rule.layers_within(1e-6, 100), 100);
  EXPECT_EQ(rule.layers_within(0, 100), 100);
  EXPECT_DOUBLE_EQ(rule.thickness_of(16), 0.005);
  EXPECT_DOUBLE_EQ(rule.stiffness_of(2), 800);
  EXPECT_DOUBLE_EQ(rule.step_of(4), 1e-4 / 8);
}

TEST(Ticks, AreMultiplesOfTheStep) {
  const Ticks ticks{1e-3 / 3};
  for (std::int64_t k = 1; k < 100000; k += 37) {
    EXPECT_EQ(ticks.first_from(ticks.time(k)), k);
    EXPECT_EQ(ticks.first_from(std::nextafter(ticks.time(k), 1e9)), k + 1);
  }
  EXPECT_EQ(ticks.first_from(0), 0);
}

TEST(Order, BringsNeighboursTogether) {
  // A strip of 100 x 3 vertices, numbered along its length: neighbours across are 100 apart.
  std::vector<Edge> edges;
  for (Index i = 0; i < 100; ++i)
    for (Index j = 0; j < 3; ++j) {
      if (i + 1 < 100) edges.push_back({{j * 100 + i, j * 100 + i + 1}});
      if (j + 1 < 3) edges.push_back({{j * 100 + i, (j + 1) * 100 + i}});
    }
  const std::vector<Index> order = reverse_cuthill_mckee(300, edges);
  std::vector<Index> sorted = order, place(300);
  std::sort(sorted.begin(), sorted.end());
  for (Index v = 0; v < 300; ++v) {
    EXPECT_EQ(sorted[static_cast<std::size_t>(v)], v);
    place[static_cast<std::size_t>(order[static_cast<std::size_t>(v)])] = v;
  }
  for (const Edge& e : edges)
    EXPECT_LE(
        std::abs(place[static_cast<std::size_t>(e.v[0])] - place[static_cast<std::size_t>(e.v[1])]),
        4);
}

}  // namespace
}  // namespace weft::test
