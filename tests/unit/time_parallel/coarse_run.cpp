// The coarse run: where a step fails it goes on with thicker contacts, from states that stay.
#include "host/time_parallel/coarse_run.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "host/base/scratch_folder.hpp"
#include "host/time_parallel/coarse_states.hpp"
#include "host/time_parallel/slice_start.hpp"
#include "host/time_parallel/slices.hpp"
#include "tests/unit/time_parallel/memory_sink.hpp"
#include "tests/unit/time_parallel/scenes.hpp"

namespace weft::test {
namespace {

namespace fs = std::filesystem;

/// A sheet that falls on a ball, with long steps, thin contacts and few rounds for impacts.
Scene thin_contact(int rounds, double thickness) {
  Scene scene = hanging_sheet(30);
  scene.pins.clear();
  scene.obstacles[0].transform.translate = {0.02, -0.05, -0.15};
  scene.time_parallel.coarsening = 5;
  scene.time_parallel.coarse_step = 0.02;
  scene.time_parallel.coarse_newton_iterations = 3;  // by which whole steps fail before slow ones
  scene.time_parallel.coarse_newton_tolerance = 1e-6;
  scene.contact.substep_bisections = 0;
  scene.contact.zone_rounds = rounds;
  scene.contact.thickness = thickness;
  return scene;
}

constexpr std::int64_t steps = 16;

class CoarseRunTest : public ::testing::Test {
 protected:
  static bool never() { return false; }
  static void ignore(double) {}
  /// Takes steps until the run has come to `last`, or one fails.
  CoarseRun::Step run_to(CoarseRun& run, std::int64_t last) {
    CoarseRun::Step step;
    while (run.simulation().step_number() < last) {
      step = run.step(never, ignore);
      if (!step.done) break;
    }
    return step;
  }
  std::string state(const std::string& name, std::int64_t step) const {
    std::ifstream in(CoarseStates::file(folder_.path() / name, step), std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
  }
  fs::path directory(const std::string& name) const {
    fs::create_directories(folder_.path() / name);
    return folder_.path() / name;
  }

  const ScratchFolder folder_;
  const CoarseScene level_ = make_coarse_scene(thin_contact(2, 5e-4));
};

TEST_F(CoarseRunTest, EasesAreAsThickAsTheRatioOfTheEdges) {
  const std::vector<CoarseRelaxation> eases = coarse_relaxations(level_.scene);
  ASSERT_EQ(eases.size(), 4u);
  const double thickness[] = {1e-3, 2e-3, 2.5e-3, 2.5e-3};
  for (int k = 0; k < 4; ++k) {
    EXPECT_DOUBLE_EQ(eases[static_cast<std::size_t>(k)].thickness, thickness[k]);
    EXPECT_EQ(eases[static_cast<std::size_t>(k)].substep_bisections, k + 1);
  }
}

TEST_F(CoarseRunTest, EasesBeginFromTheThicknessThatIsSet) {
  Scene sheet = thin_contact(2, 5e-4);
  sheet.time_parallel.coarse_thickness = 5;
  const CoarseScene thick = make_coarse_scene(sheet);
  EXPECT_DOUBLE_EQ(contact_thickness(thick.scene.contact), 2.5e-3);
  const std::vector<CoarseRelaxation> eases = coarse_relaxations(thick.scene);
  ASSERT_EQ(eases.size(), 1u) << "there is no more to gain but a halving";
  EXPECT_DOUBLE_EQ(eases[0].thickness, 2.5e-3);
  EXPECT_EQ(eases[0].substep_bisections, 1);
}

TEST_F(CoarseRunTest, ZonesThatMoveAsRigidBodiesAreEased) {
  Scene sheet = thin_contact(6, 1e-4);
  sheet.contact.substep_bisections = 1;
  const CoarseScene level = make_coarse_scene(sheet);
  Simulation plain(level.scene, host_devices(1));
  StepReport report;
  while (report.fallback_level != FallbackLevel::rigid && plain.step_number() < steps) {
    report = plain.step();
    ASSERT_EQ(report.failure, Failure::none);
  }
  ASSERT_EQ(report.fallback_level, FallbackLevel::rigid);
  CoarseRun run(level, directory("rigid"));
  ASSERT_TRUE(run_to(run, plain.step_number()).done);
  ASSERT_FALSE(run.relaxed().empty());
  EXPECT_EQ(run.relaxed().front(), plain.step_number());
}

TEST_F(CoarseRunTest, GoesOnWhereAStepIsJammed) {
  const CoarseScene level = make_coarse_scene(thin_contact(2, 1e-3));
  CoarseRun run(level, directory("whole"));
  Simulation plain(level.scene, host_devices(1));
  std::int64_t good = 0;
  while (plain.step().fallback_level < FallbackLevel::rigid) {
    ++good;
    plain.save(CoarseStates::file(directory("plain"), good));
    ASSERT_LT(good, steps) << "no step is jammed";
  }
  const std::int64_t rows = cloth_rows(level.scene);
  while (run.simulation().step_number() < steps) {
    double counted = 0;
    const CoarseRun::Step step = run.step(never, [&](double work) { counted = work; });
    ASSERT_TRUE(step.done) << step.failure_detail;
    double taken = 0;
    for (const StepReport& report : step.taken) taken += counted_work(report, rows);
    EXPECT_DOUBLE_EQ(counted, taken);
    if (run.simulation().step_number() != good + 1) continue;
    ASSERT_GE(step.taken.size(), 3u) << "what failed, and what was repeated before it";
    EXPECT_GE(step.taken.front().fallback_level, FallbackLevel::rigid);
    EXPECT_GT(counted, counted_work(step.taken.back(), rows));
  }
  ASSERT_FALSE(run.relaxed().empty());
  EXPECT_EQ(run.relaxed().front(), good + 1);
  for (std::int64_t step = 1; step <= good; ++step)
    EXPECT_TRUE(state("whole", step) == state("plain", step)) << step << ": slices may have it";
}

TEST_F(CoarseRunTest, SameBitsWhereverItIsCutOff) {
  constexpr std::int64_t last = 40;  // by which two steps are jammed
  CoarseRun whole(level_, directory("whole"));
  ASSERT_TRUE(run_to(whole, last).done);
  const std::vector<std::int64_t> relaxed = whole.relaxed();
  ASSERT_GE(relaxed.size(), 2u);
  for (const std::int64_t cut : {relaxed[0] - 1, relaxed[0], relaxed[1] - 1, relaxed[1]}) {
    const std::string name = std::to_string(cut);
    {
      CoarseRun first(level_, directory(name));
      run_to(first, cut);
    }
    // As if it had been cut off once it had noted a step, before the state was there.
    std::error_code error;
    fs::copy_file(folder_.path() / "whole/eased.bin", folder_.path() / name / "eased.bin",
                  fs::copy_options::overwrite_existing, error);
    ASSERT_FALSE(error) << error.message();
    EXPECT_LT(coarse_relaxed(folder_.path() / name, relaxed[1] - 1).size(), relaxed.size());
    CoarseRun rest(level_, directory(name));
    rest.resume(cut);
    ASSERT_TRUE(run_to(rest, last).done);
    EXPECT_EQ(rest.relaxed(), relaxed) << cut;
    EXPECT_TRUE(state(name, last) == state("whole", last)) << cut;
  }
}

TEST_F(CoarseRunTest, MayBeStoppedBetweenRepeatedSteps) {
  CoarseRun run(level_, directory("stopped"));
  CoarseRun::Step step;
  bool asked = false;
  do {
    ASSERT_LT(run.simulation().step_number(), 2 * steps) << "nothing jams";
    step = run.step([&] { return asked = true; }, ignore);
  } while (step.done);
  EXPECT_TRUE(asked);
  EXPECT_EQ(step.failure, Failure::none);
  EXPECT_TRUE(state("stopped", run.relaxed().front()).empty());
}

TEST_F(CoarseRunTest, WhatNoEaseHelpsIsNamed) {
  Scene sheet = thin_contact(1, 1e-4);
  sheet.solver.max_iterations = 1;
  const CoarseScene level = make_coarse_scene(sheet);
  CoarseRun run(level, directory("failing"));
  const CoarseRun::Step step = run_to(run, 2 * steps);
  EXPECT_FALSE(step.done);
  EXPECT_EQ(step.failure, Failure::not_converged);
  EXPECT_NE(step.failure_detail.find("linear solve"), std::string::npos) << step.failure_detail;
  EXPECT_EQ(run.relaxed().size(), coarse_relaxations(level.scene).size()) << "all were tried";
}

/// A stiff sheet falls on a small ball off its middle.
Scene tilted_sheet(double height) {
  Scene scene = hanging_sheet(1, Precision::single_precision);
  scene.pins.clear();
  scene.materials[0].density = 0.128;
  scene.materials[0].orthotropic = OrthotropicStretch{4110, 4180, 0.0118, 60.3};
  scene.time = {1.0 / 60, 30, 21};
  scene.time_parallel.coarse_step = 0.02;
  Cloth& sheet = scene.cloths[0];
  sheet.mesh = make_grid({1.318, 1.212}, {16, 15}, Diagonals::same);
  for (Vec3<double>& x : sheet.mesh.positions)
    x = {0.9899 * x[0], x[1], height + 0.1416 * x[0]};  // tilted by 8 degrees
  sheet.velocity = {0, 0, -2.618};
  scene.obstacles[0].mesh = make_icosphere(0.126, 1);
  scene.obstacles[0].transform.translate = {-0.257, -0.251, 0};
  scene.contact.thickness = 0.0037;
  scene.contact.friction = 0.93;
  return scene;
}

/// From some heights, steps of two iterations of Newton's method on twelve cells gain a tenth of
/// the energy.
TEST_F(CoarseRunTest, AStepThatGainsEnergyIsRepeatedLinearly) {
  int repeated = 0;
  double highest = 0;
  for (int k = 0; k < 40; ++k) {
    const CoarseScene level = make_coarse_scene(tilted_sheet(0.42 + 0.002 * k));
    CoarseRun run(level, directory("gaining_" + std::to_string(k)));
    const double start = run.simulation().energy().total();
    while (run.simulation().step_number() < steps) {
      repeated += run.step(never, ignore).taken.size() > 1 ? 1 : 0;
      highest = std::max(highest, run.simulation().energy().total() / start);
    }
    EXPECT_TRUE(run.relaxed().empty()) << k;
  }
  EXPECT_GT(repeated, 0);
  EXPECT_LT(highest, 1.2);
}

TEST_F(CoarseRunTest, SlicesHearOfIt) {
  Scene sheet = thin_contact(1, 2e-3);  // short steps get along with that
  sheet.time.frames = 10;
  const TimeParallelScene scene(sheet, 2);
  std::string first;
  for (const int workers : {1, 3}) {
    SliceOptions options;
    options.run = folder_.path() / std::to_string(workers);
    options.workers = workers;
    options.starts = {0, 76};
    options.devices = [](int) { return host_devices(1); };
    MemorySink sink;
    const SlicesOutcome outcome = run_slices(scene, options, sink);
    ASSERT_TRUE(outcome.done);
    EXPECT_EQ(outcome.coarse.steps, 19);
    EXPECT_FALSE(outcome.coarse.relaxed.empty());
    EXPECT_EQ(run_slices(scene, options, sink).coarse.relaxed, outcome.coarse.relaxed) << "again";
    std::ifstream in(SliceFiles(options.run, 1).end(), std::ios::binary);
    const std::string end{std::istreambuf_iterator<char>(in), {}};
    if (workers == 1) first = end;
    EXPECT_TRUE(end == first);
  }
}

}  // namespace
}  // namespace weft::test
