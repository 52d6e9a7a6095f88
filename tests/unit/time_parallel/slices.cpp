// Runs of slices: the same bits whoever works them off, whatever stops them, and what is at seams.
#include "host/time_parallel/slices.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstddef>
#include <filesystem>
#include <map>
#include <memory>
#include <mutex>
#include <string>

#include "host/scene/intersection_check.hpp"
#include "host/time_parallel/coarse_states.hpp"
#include "host/time_parallel/gpu_pool.hpp"
#include "tests/unit/time_parallel/memory_sink.hpp"
#include "tests/unit/time_parallel/scenes.hpp"
#include "tests/unit/time_parallel/slices_fixture.hpp"
#include "weft/error.hpp"

namespace weft::test {
namespace {

namespace fs = std::filesystem;

class SlicesTest : public SlicesFixture {
 protected:
  static void expect_clean(const Scene& scene, const Frame& frame) {
    Scene now = scene;
    for (std::size_t c = 0; c < now.cloths.size(); ++c)
      now.cloths[c].mesh.positions = frame.cloth_positions[c];
    EXPECT_NO_THROW(refuse_intersecting_start(now)) << "frame " << frame.number;
  }
};

TEST_F(SlicesTest, SameBitsForAnyNumberOfWorkers) {
  const TimeParallelScene scene(hanging_sheet(20, Precision::single_precision), 4);
  EXPECT_EQ(scene.steps(), 64);
  std::string first;
  std::vector<std::int64_t> starts;
  for (const int workers : {1, 2, 5}) {
    MemorySink sink;
    const std::string name = std::to_string(workers);
    const SlicesOutcome outcome = run_slices(scene, options(name, workers), sink);
    ASSERT_TRUE(outcome.done);
    ASSERT_EQ(outcome.slices.size(), 4u);
    ASSERT_EQ(outcome.seams.size(), 3u);
    EXPECT_EQ(sink.steps_taken, 64);
    ASSERT_EQ(sink.frames.size(), 9u);
    for (const auto& [number, frame] : sink.frames) expect_clean(scene.fine(), frame);
    if (workers == 1) {
      first = states(name, 4);
      starts = outcome.starts;
    } else {
      EXPECT_EQ(outcome.starts, starts) << "Algorithm 1 on counted work, " << workers;
      EXPECT_TRUE(states(name, 4) == first) << workers;
    }
  }
  // The partition as it was reported, given back.
  SliceOptions given = options("given", 3);
  given.starts = starts;
  MemorySink sink;
  EXPECT_TRUE(run_slices(scene, given, sink).done);
  EXPECT_TRUE(states("given", 4) == first);
}

// The first slice waits for the coarse run, which must not wait for the first slice.
TEST_F(SlicesTest, ACoarseStepMayCostMoreThanFineOnes) {
  Scene costly = hanging_sheet(20, Precision::single_precision);
  costly.time_parallel.coarse_step = costly.time.step;
  costly.time_parallel.coarsening = 1.5;
  costly.solver.tolerance = 1e-6;
  costly.solver.newton_iterations = 4;
  const TimeParallelScene scene(costly, 3);
  MemorySink sink;
  SliceOptions patient = options("costly", 2);
  const auto end = std::chrono::steady_clock::now() + std::chrono::minutes(2);
  patient.stop = [end] { return std::chrono::steady_clock::now() > end; };
  const SlicesOutcome outcome = run_slices(scene, patient, sink);
  EXPECT_TRUE(outcome.done);
  EXPECT_EQ(outcome.starts.size(), 3u);
}

TEST_F(SlicesTest, OneSliceIsTheSerialRun) {
  const Scene sheet = hanging_sheet(20);
  const TimeParallelScene scene(sheet, 1);
  MemorySink sink;
  ASSERT_TRUE(run_slices(scene, options("one", 1), sink).done);
  Simulation serial(scene.fine(), host_devices(1));
  while (serial.frame_number() < sheet.time.frames) ASSERT_EQ(serial.step().failure, Failure::none);
  serial.save(directory_ / "serial.weft");
  EXPECT_TRUE(bytes(directory_ / "serial.weft") == bytes(SliceFiles(directory_ / "one", 0).end()));
}

TEST_F(SlicesTest, OnlyWhatIsNotDoneIsSimulatedAgain) {
  const TimeParallelScene scene(hanging_sheet(20, Precision::single_precision), 3);
  MemorySink whole;
  ASSERT_TRUE(run_slices(scene, options("whole", 2), whole).done);
  MemorySink cut;
  SliceOptions o = options("cut", 2);
  o.stop = [&] { return cut.steps_taken > 30; };
  EXPECT_FALSE(run_slices(scene, o, cut).done);
  EXPECT_LT(cut.steps_taken, 64);
  MemorySink rest;
  const SlicesOutcome outcome = run_slices(scene, options("cut", 2), rest);
  EXPECT_TRUE(outcome.done);
  EXPECT_EQ(cut.steps_taken + rest.steps_taken, 64) << "nothing twice";
  EXPECT_TRUE(states("cut", 3) == states("whole", 3));
  MemorySink none;
  EXPECT_TRUE(run_slices(scene, options("cut", 2), none).done);
  EXPECT_EQ(none.steps_taken, 0);
}

// Coarse states are not waited for until the disk has them.
TEST_F(SlicesTest, WhatAPowerCutDamagesOfTheCoarseRunIsMadeAgain) {
  const TimeParallelScene scene(hanging_sheet(20, Precision::single_precision), 3);
  MemorySink sink;
  const SlicesOutcome whole = run_slices(scene, options("run", 2), sink);
  ASSERT_TRUE(whole.done);
  const std::string first = states("run", 3);
  const fs::path coarse = SliceFiles::coarse(directory_ / "run");
  const std::string third = bytes(CoarseStates::file(coarse, 3));
  fs::resize_file(CoarseStates::file(coarse, 0), 0);
  fs::resize_file(CoarseStates::file(coarse, 3), third.size() / 2);
  fs::resize_file(CoarseStates::file(coarse, 5), third.size() - 1);
  fs::remove_all(SliceFiles(directory_ / "run", 1).directory());
  const SlicesOutcome again = run_slices(scene, options("run", 2), sink);
  ASSERT_TRUE(again.done);
  EXPECT_EQ(again.starts, whole.starts);
  EXPECT_EQ(again.coarse.work, whole.coarse.work);
  EXPECT_TRUE(bytes(CoarseStates::file(coarse, 3)) == third);
  EXPECT_TRUE(states("run", 3) == first);
}

TEST_F(SlicesTest, SlowRecoveryConverges) {
  Scene sheet = hanging_sheet(30);
  sheet.obstacles.clear();
  sheet.materials[0].damping_stiffness = 5e-4;
  sheet.time_parallel.recovery_tolerance = 0;
  SliceOptions o = options("few", 2);
  o.starts = {0, 40};
  sheet.time_parallel.recovery_iterations = 3;
  MemorySink sink;
  const SlicesOutcome few = run_slices(TimeParallelScene(sheet, 2), o, sink);
  ASSERT_TRUE(few.done);
  EXPECT_EQ(few.slices[1].start.iterations, 3) << few.slices[1].start.note;
  o.run = directory_ / "many";
  sheet.time_parallel.recovery_iterations = 60;
  const SlicesOutcome many = run_slices(TimeParallelScene(sheet, 2), o, sink);
  ASSERT_TRUE(many.done);
  EXPECT_EQ(many.slices[1].start.iterations, 60) << many.slices[1].start.note;
  EXPECT_LT(many.slices[1].start.change, 0.2 * few.slices[1].start.change);
  EXPECT_LT(many.slices[1].start.tracking_error, 1e-9);
  // With the scene's own tolerance it ends as soon as the change is below.
  o.run = directory_ / "usual";
  sheet.time_parallel.recovery_tolerance = 1e-3;
  const SlicesOutcome usual = run_slices(TimeParallelScene(sheet, 2), o, sink);
  ASSERT_TRUE(usual.done);
  EXPECT_LT(usual.slices[1].start.iterations, 60);
  EXPECT_LE(usual.slices[1].start.change, 1e-3);
}

TEST(GpuPool, NoTwoSlicesShareACardWhileOneIsFree) {
  GpuPool pool({3, 0, 5});
  auto first = std::make_unique<GpuPool::Lease>(pool);
  auto second = std::make_unique<GpuPool::Lease>(pool);
  const GpuPool::Lease third(pool);
  EXPECT_EQ(first->gpu(), 3);
  EXPECT_EQ(second->gpu(), 0);
  EXPECT_EQ(third.gpu(), 5);
  second.reset();
  const GpuPool::Lease fourth(pool);
  EXPECT_EQ(fourth.gpu(), 0) << "the one that was given back";
  first.reset();
  const GpuPool::Lease fifth(pool), sixth(pool);
  EXPECT_EQ(fifth.gpu(), 3);
  EXPECT_EQ(sixth.gpu(), 3) << "the first of those that have one slice";
}

TEST_F(SlicesTest, MoreSlicesThanStepsAreRefused) {
  try {
    const TimeParallelScene scene(hanging_sheet(20), 65);
    FAIL() << "65 slices of 64 steps";
  } catch (const SceneError& error) {
    EXPECT_NE(std::string(error.what()).find("64 steps"), std::string::npos) << error.what();
  }
}

TEST_F(SlicesTest, PartitionsAreChecked) {
  const TimeParallelScene scene(hanging_sheet(20), 3);
  for (const std::vector<std::int64_t>& starts :
       {std::vector<std::int64_t>{0, 10}, {1, 10, 20}, {0, 20, 20}, {0, 10, 64}})
    EXPECT_THROW(scene.check_starts(starts), SceneError);
  EXPECT_NO_THROW(scene.check_starts({0, 1, 63}));
}

TEST_F(SlicesTest, ErrorsOfASliceEndTheRun) {
  const TimeParallelScene scene(hanging_sheet(20), 3);
  MemorySink sink;
  SliceOptions o = options("error", 2);
  o.devices = [](int slice) -> DeviceSet {
    if (slice == 1) throw DeviceError("GPU lost");
    return host_devices(1);
  };
  EXPECT_THROW(run_slices(scene, o, sink), DeviceError);
}

}  // namespace
}  // namespace weft::test
