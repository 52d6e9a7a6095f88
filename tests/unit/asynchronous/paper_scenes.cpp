// The scenes of the paper, with few triangles, through all of their contacts: safety by an
// independent validator over every window, and equivalence.
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "host/io/scene/scene_file.hpp"
#include "tests/unit/asynchronous/brute_safety.hpp"

namespace weft::test {
namespace {

struct PaperScene {
  const char* name;
  std::vector<std::string> overrides;
  int frames;     ///< in which most of its contacts happen
  int rollbacks;  ///< that happen at least
};

/// The compactor's small sheet fills as much of what is left of it; the twister's rod is not waited
/// for.
const std::vector<PaperScene>& paper_scenes() {
  static const std::vector<PaperScene> all{
      {"reef_knot", {"triangles=300"}, 75, 20},
      {"bowline", {"triangles=300"}, 75, 10},
      {"trash_compactor", {"cloths.0.grid.cells=[13,8]"}, 40, 100},
      {"two_cloths", {"triangles=200"}, 25, 40},
      {"twister",
       {"cloths.0.grid.cells=[18,6]", "obstacles.0.driven.start_time=0",
        "obstacles.0.driven.torque=0.1",
        R"(pins.1.motion=[{"time":0},{"time":3,"translate":[0.2,0,0]}])",
        R"(pins.2.motion=[{"time":0},{"time":3,"translate":[-0.2,0,0]}])"},
       60,
       2}};
  return all;
}

Scene scene_of(const PaperScene& paper) {
  return io::read_scene(std::string(WEFT_SOURCE_DIR "/scenes/") + paper.name + ".json",
                        paper.overrides);
}

class PaperScenes : public testing::TestWithParam<std::size_t> {
 protected:
  const PaperScene& paper() const { return paper_scenes()[GetParam()]; }
};

void expect_safe(const PaperScene& paper, int every) {
  WindowRun run(scene_of(paper));
  BruteSafety brute;
  brute.watch(run, every);
  const double step = run.scene.time.step;
  const double end = paper.frames / run.scene.time.frame_rate;
  for (int k = 1; step * k < end + step / 2; ++k)
    ASSERT_TRUE(run.advance(step * k)) << run.total.failure_detail;
  EXPECT_EQ(brute.windows, run.total.asynchronous.windows);
  EXPECT_GE(run.total.asynchronous.rollbacks, paper.rollbacks);
  EXPECT_GT(run.total.asynchronous.acting_pairs, 10000);
  EXPECT_GT(brute.tested, 1000);
  EXPECT_EQ(brute.violations, 0);
}

TEST_P(PaperScenes, NoPairComesWithinItsNextLayerInSomeWindows) {
  expect_safe(paper(), 16);
}

/// Every window.
TEST_P(PaperScenes, SlowNoPairComesWithinItsNextLayer) {
  expect_safe(paper(), 1);
}

std::vector<Vec3<double>> outcome(const Scene& scene, int threads) {
  WindowRun run(scene, threads);
  for (int k = 1; k <= 12; ++k)
    EXPECT_TRUE(run.advance(scene.time.step * k)) << run.total.failure_detail;
  EXPECT_GT(run.total.asynchronous.acting_pairs, 0);
  return run.positions;
}

TEST_P(PaperScenes, WindowsAndNarrowPhaseAndThreadsChangeNoBit) {
  Scene s = scene_of(paper());
  const auto expected = outcome(s, 1);
  for (const int threads : {2, 5, 8}) EXPECT_EQ(outcome(s, threads), expected) << threads;
  s.asynchronous.optimistic = false;
  EXPECT_EQ(outcome(s, 2), expected) << "no optimistic starts";
  for (const double window : {0.0007, 0.01}) {
    s.asynchronous.window = window;
    EXPECT_EQ(outcome(s, 1), expected) << window;
  }
  s.asynchronous.narrow = NarrowPhase::ccd;
  EXPECT_EQ(outcome(s, 1), expected);
}

INSTANTIATE_TEST_SUITE_P(All, PaperScenes, testing::Range(std::size_t{0}, paper_scenes().size()),
                         [](const auto& scene) {
                           return std::string(paper_scenes()[scene.param].name);
                         });

}  // namespace
}  // namespace weft::test
