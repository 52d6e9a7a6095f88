// What windows promise: no pair comes closer than its layers allow, and neither window, narrow
// phase nor threads change a bit.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "host/scene/procedural.hpp"
#include "tests/unit/asynchronous/scenes.hpp"
#include "weft/elements/ccd.hpp"

namespace weft::test {
namespace {

std::size_t at(Index i) {
  return static_cast<std::size_t>(i);
}

/// Two sheets that fall on each other and on a box that rises.
Scene heap(int cells) {
  Scene s = asynchronous_scene();
  s.asynchronous.restitution = 0.3;
  s.contact.friction = 0.2;
  s.cloths.push_back(sheet(cells, 0.0));
  s.cloths.push_back(sheet(cells - 1, 0.006));
  s.cloths[1].velocity = {0.1, 0.05, -1.0};
  Obstacle o;
  o.name = "box";
  o.mesh = make_box({0.2, 0.2, 0.1}, {2, 2, 1});
  o.friction = 0.4;
  o.motion = {{0, {{0, 0, -0.056}, {0, 0, 1}, 0, 1}}, {0.2, {{0, 0, 0.04}, {0, 0, 1}, 0.5, 1}}};
  s.obstacles.push_back(o);
  return s;
}

/// A sheet that falls on its edge and folds up on the floor.
Scene folds() {
  Scene s = asynchronous_scene();
  s.asynchronous.restitution = 0;
  s.contact.friction = 0.5;
  s.cloths.push_back(sheet(7, 0.0));
  for (auto& x : s.cloths[0].mesh.positions)
    x = {0.2 * x[0] + 0.02 * x[1], x[1], 0.22 + 0.97 * x[0]};
  s.cloths[0].velocity = {0, 0, -3};
  Obstacle floor;
  floor.name = "floor";
  floor.mesh = make_grid({2, 2}, {2, 2}, Diagonals::same);
  floor.mesh.material.clear();
  s.obstacles.push_back(floor);
  return s;
}

/// What the engine's broad and narrow phases have no part in: every pair, every piece of its ways.
struct Brute {
  const WindowRun* run = nullptr;
  std::vector<Index> place;
  std::vector<std::vector<Knot>> ways;
  std::int64_t windows = 0, tested = 0, violations = 0;

  static void look(void* context, const Histories& ways, const ActiveLayers& layers,
                   const VertexMotion& motion, const LayerRule& rule) {
    static_cast<Brute*>(context)->window(ways, layers, motion, rule);
  }

  void window(const Histories& histories, const ActiveLayers& layers, const VertexMotion& motion,
              const LayerRule& rule) {
    ++windows;
    ways.clear();
    for (std::size_t i = 0; i < histories.size(); ++i) ways.push_back(histories.way(i));
    const Model& model = run->model;
    for (std::size_t f = 0; f < model.triangles.size(); ++f)
      for (Index v = 0; v < model.vertex_count; ++v) {
        const Index* t = model.triangles[f].v;
        const Index corners[4] = {place[at(v)], place[at(t[0])], place[at(t[1])], place[at(t[2])]};
        pair(false, PrimitivePair::key_of(false, place[at(v)], static_cast<Index>(f)), corners,
             layers, motion, rule);
      }
    for (std::size_t e = 0; e < model.edges.size(); ++e)
      for (std::size_t g = e + 1; g < model.edges.size(); ++g) {
        const Index* p = model.edges[e].v;
        const Index* q = model.edges[g].v;
        const Index corners[4] = {place[at(p[0])], place[at(p[1])], place[at(q[0])],
                                  place[at(q[1])]};
        pair(true, PrimitivePair::key_of(true, static_cast<Index>(e), static_cast<Index>(g)),
             corners, layers, motion, rule);
      }
  }

  void pair(bool edges, std::uint64_t key, const Index (&v)[4], const ActiveLayers& layers,
            const VertexMotion& motion, const LayerRule& rule) {
    const int first = edges ? 2 : 1;
    bool movable = false;
    for (const Index i : v) movable = movable || motion.inv_mass[at(i)] > 0;
    for (int a = 0; a < first; ++a)
      for (int b = first; b < 4; ++b)
        if (v[a] == v[b]) return;
    if (!movable) return;
    // Continuous detection may see contact a thousandth above the distance.
    const double distance = rule.thickness_of(layers.depth(key) + 1) * (1 - 2e-3);
    if (apart(v, first, distance)) return;
    ++tested;
    std::vector<double> times;
    for (const Index i : v)
      for (const Knot& k : ways[at(i)]) times.push_back(k.t);
    std::sort(times.begin(), times.end());
    times.erase(std::unique(times.begin(), times.end()), times.end());
    for (std::size_t k = 0; k + 1 < times.size(); ++k) {
      Vec3<double> x0[4], x1[4];
      for (int c = 0; c < 4; ++c) {
        x0[c] = position_at(ways[at(v[c])], times[k]);
        x1[c] = position_at(ways[at(v[c])], times[k + 1]);
      }
      const auto impact =
          edges ? ccd_edge_edge(x0, x1, distance) : ccd_vertex_triangle(x0, x1, distance);
      if (!impact.hit) continue;
      ++violations;
      return;
    }
  }

  bool apart(const Index (&v)[4], int first, double distance) const {
    for (int axis = 0; axis < 3; ++axis) {
      double lo[2] = {1e300, 1e300}, hi[2] = {-1e300, -1e300};
      for (int c = 0; c < 4; ++c)
        for (const Knot& k : ways[at(v[c])]) {
          const int side = c < first ? 0 : 1;
          lo[side] = std::min(lo[side], k.x[axis]);
          hi[side] = std::max(hi[side], k.x[axis]);
        }
      if (std::max(lo[0] - hi[1], lo[1] - hi[0]) > distance) return true;
    }
    return false;
  }
};

class Safety : public testing::TestWithParam<int> {};

TEST_P(Safety, NoPairComesWithinItsNextLayer) {
  WindowRun run(GetParam() == 0 ? heap(5) : folds());
  Brute brute;
  brute.run = &run;
  brute.place = run.windows.places();
  run.windows.observe(Brute::look, &brute);
  for (int k = 1; k <= 10; ++k) ASSERT_TRUE(run.advance(0.02 * k)) << run.total.failure_detail;
  EXPECT_GT(run.total.asynchronous.rollbacks, 0) << "nothing ever met";
  EXPECT_GT(brute.tested, 1000);
  EXPECT_GE(brute.windows, 60);
  EXPECT_EQ(brute.violations, 0);
}

INSTANTIATE_TEST_SUITE_P(Scenes, Safety, testing::Values(0, 1));

/// Where all vertices are after a while, to the bit.
std::vector<Vec3<double>> outcome(const Scene& scene, int threads, int steps = 8) {
  WindowRun run(scene, threads);
  for (int k = 1; k <= steps; ++k) EXPECT_TRUE(run.advance(0.01 * k)) << run.total.failure_detail;
  EXPECT_GT(run.total.asynchronous.acting_pairs, 0);
  return run.positions;
}

TEST(Equivalence, WindowsChangeNoBit) {
  Scene s = heap(8);
  s.asynchronous.window = 0.003;
  const auto expected = outcome(s, 1);
  for (const double window : {0.0004, 0.01}) {
    s.asynchronous.window = window;
    EXPECT_EQ(outcome(s, 1), expected) << window;
  }
}

TEST(Equivalence, NarrowPhaseChangesNoBit) {
  Scene s = heap(8);
  const auto expected = outcome(s, 1);
  s.asynchronous.narrow = NarrowPhase::ccd;
  EXPECT_EQ(outcome(s, 1), expected);
}

TEST(Equivalence, TuningChangesNoBit) {
  Scene s = heap(8);
  const auto expected = outcome(s, 1);
  s.asynchronous.tune_window = true;
  EXPECT_EQ(outcome(s, 1), expected);
}

TEST(Equivalence, ThreadsChangeNoBit) {
  const Scene s = heap(32);
  const auto expected = outcome(s, 1, 1);
  for (const int threads : {2, 3}) EXPECT_EQ(outcome(s, threads, 1), expected) << threads;
}

TEST(Caps, EndAsNamed) {
  Scene s = heap(6);
  s.asynchronous.layers = 1;
  WindowRun few(s);
  bool good = true;
  for (int k = 1; good && k <= 20; ++k) good = few.advance(0.01 * k);
  EXPECT_FALSE(good);
  EXPECT_EQ(few.total.failure, Failure::layers) << few.total.failure_detail;

  s = heap(6);
  s.asynchronous.rollbacks = 0;
  WindowRun once(s);
  good = true;
  for (int k = 1; good && k <= 20; ++k) good = once.advance(0.01 * k);
  EXPECT_FALSE(good);
  EXPECT_EQ(once.total.failure, Failure::rollbacks);

  s = heap(6);
  s.asynchronous.smallest_step = 0.9 * WindowRun(s).windows.rule().step_of(2);
  WindowRun coarse(s);
  good = true;
  for (int k = 1; good && k <= 20; ++k) good = coarse.advance(0.01 * k);
  EXPECT_FALSE(good);
  EXPECT_EQ(coarse.total.failure, Failure::small_step);
}

}  // namespace
}  // namespace weft::test
