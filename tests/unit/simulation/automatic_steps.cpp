// Steps of automatic length: their error estimate, their bits, and what they cost.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <string>
#include <vector>

#include "host/base/scratch_folder.hpp"
#include "host/scene/frame_steps.hpp"
#include "host/state/checkpoint.hpp"
#include "tests/support/small_scenes.hpp"
#include "weft/error.hpp"
#include "weft/shapes.hpp"
#include "weft/simulation.hpp"

namespace weft {
namespace {

Scene automatic(Scene s, double tolerance = 0.02) {
  s.time.automatic = true;
  s.time.tolerance = tolerance;
  return s;
}

/// A fast sheet that hits a ball: some steps are rejected there.
Scene sheet_at_ball(Precision precision, Integrator integrator) {
  Scene s = automatic(test::sheet_on_sphere(precision, 8));
  s.integrator = integrator;
  s.contact.thickness = 1e-3;
  for (auto& p : s.cloths[0].mesh.positions) p[2] += 0.04;
  s.cloths[0].velocity = {0.3, 0.06, -4};
  return s;
}

/// A napkin folded onto itself: some steps are bisected.
Scene napkin() {
  return automatic(test::folded_napkin(Precision::single_precision), 0.5);
}

/// The states of a run, by their hashes, and what its steps were.
struct Ran {
  std::vector<std::uint64_t> hashes;
  std::vector<double> lengths;
  int rejected = 0;
  int bisected = 0;
};

Ran advance(Simulation& simulation, int steps) {
  Ran ran;
  for (int k = 0; k < steps; ++k) {
    const double planned = simulation.step_length();
    const StepReport r = simulation.step();
    EXPECT_EQ(Failure::none, r.failure) << r.failure_detail;
    EXPECT_TRUE(r.step_error.has_value());
    if (r.rejected == 0) {
      EXPECT_EQ(planned, r.step);
    } else {
      EXPECT_GT(planned, r.step);
    }
    ran.hashes.push_back(simulation.state_hash());
    ran.lengths.push_back(r.step);
    ran.rejected += r.rejected;
    ran.bisected += r.fallback_level == FallbackLevel::whole ? 0 : 1;
  }
  return ran;
}

Scene falling_sheet(Integrator integrator) {
  Scene s;
  s.precision = Precision::double_precision;
  s.integrator = integrator;
  s.materials.push_back(test::cotton());
  s.cloths.push_back(test::sheet(6, 0));
  s.solver.tolerance = 1e-13;
  return automatic(s);
}
/// [m] of that sheet
const double mean_edge = (2 * 6 * 7 + 36 * std::sqrt(2)) / (2 * 6 * 7 + 36) * 0.4 / 6;

TEST(AutomaticSteps, FreeFallHasTheErrorOfImplicitEuler) {
  Simulation simulation(falling_sheet(Integrator::implicit_euler), host_devices(1));
  double longest = 0;
  for (int k = 0; k < 20; ++k) {
    const StepReport r = simulation.step();
    EXPECT_NEAR(9.81 * r.step * r.step / 2 / (0.02 * mean_edge), *r.step_error, 1e-6);
    longest = std::max(longest, r.step);
  }
  // As long as the error allows, but for what frames round off.
  const double allowed = std::sqrt(2 * 0.02 * mean_edge / 9.81);
  EXPECT_LT(longest, 1.05 * allowed);
  EXPECT_GT(longest, allowed / 2);
}

/// BDF2 falls without an error once it has a past.
TEST(AutomaticSteps, FreeFallHasNoErrorOfBdf2) {
  Simulation simulation(falling_sheet(Integrator::bdf2), host_devices(1));
  EXPECT_NEAR(9.81 * 0.005 * 0.005 / 2 / (0.02 * mean_edge), *simulation.step().step_error, 1e-6);
  double error = 0;
  for (int k = 0; k < 30; ++k) error = *simulation.step().step_error;
  EXPECT_LT(error, 1e-3);
  EXPECT_NEAR(0.04, simulation.step_length(), 1e-12) << "a frame";
}

TEST(AutomaticSteps, FramesAreHitExactly) {
  for (const double rate : {25.0, 24.0, 30000.0 / 1001}) {
    Scene s = sheet_at_ball(Precision::single_precision, Integrator::implicit_euler);
    s.time.frame_rate = rate;
    Simulation simulation(s, host_devices(1));
    EXPECT_TRUE(simulation.at_frame_end());
    int frames = 0;
    for (int k = 0; frames < 4 && k < 400; ++k) {
      ASSERT_EQ(Failure::none, simulation.step().failure);
      if (!simulation.at_frame_end()) {
        EXPECT_EQ(frames, simulation.frame_number());
        EXPECT_LT(simulation.time(), (frames + 1) / rate);
        continue;
      }
      ++frames;
      EXPECT_EQ(frames, simulation.frame_number());
      EXPECT_EQ(frames / rate, simulation.time());
      EXPECT_EQ(frames, simulation.frame().number);
    }
    EXPECT_EQ(4, frames);
  }
}

TEST(AutomaticSteps, SameBitsForAnyNumberOfRanks) {
  int rejected = 0, bisected = 0;
  std::vector<Scene> scenes{napkin()};
  for (const auto precision : {Precision::single_precision, Precision::double_precision})
    for (const auto integrator : {Integrator::implicit_euler, Integrator::bdf2})
      scenes.push_back(sheet_at_ball(precision, integrator));
  for (const Scene& s : scenes) {
    Simulation one(s, host_devices(1)), two(s, host_devices(2));
    const Ran alone = advance(one, 16);
    const Ran shared = advance(two, 16);
    EXPECT_EQ(alone.hashes, shared.hashes);
    EXPECT_EQ(alone.lengths, shared.lengths);
    rejected += alone.rejected;
    bisected += alone.bisected;
    EXPECT_LT(*std::min_element(alone.lengths.begin(), alone.lengths.end()),
              *std::max_element(alone.lengths.begin(), alone.lengths.end()) / 2);
  }
  EXPECT_GT(rejected, 0);
  EXPECT_GT(bisected, 0);
}

class AutomaticCheckpoint : public testing::Test {
 protected:
  /// Stops within frames and at their ends, before and after steps that were rejected.
  void expect_resumes(const Scene& s, int steps, int every) {
    Simulation whole(s, host_devices(1));
    const Ran all = advance(whole, steps);
    for (int stop = 1; stop < steps; stop += every) {
      Simulation before(s, host_devices(1));
      advance(before, stop);
      before.save(file_);
      Simulation resumed(s, host_devices(2));
      resumed.resume(file_);
      EXPECT_EQ(before.at_frame_end(), resumed.at_frame_end());
      EXPECT_EQ(before.step_length(), resumed.step_length());
      const Ran rest = advance(resumed, steps - stop);
      EXPECT_EQ(all.hashes.back(), rest.hashes.back()) << "stopped after " << stop;
      EXPECT_EQ(all.lengths.back(), rest.lengths.back());
      EXPECT_EQ(whole.time(), resumed.time());
      EXPECT_EQ(whole.frame_number(), resumed.frame_number());
      EXPECT_EQ(whole.step_number(), resumed.step_number());
    }
  }

  const ScratchFolder folder_;
  const std::filesystem::path file_ = folder_ / "checkpoint.weft";
};

TEST_F(AutomaticCheckpoint, ResumesBitForBit) {
  for (const auto integrator : {Integrator::implicit_euler, Integrator::bdf2})
    expect_resumes(sheet_at_ball(Precision::single_precision, integrator), 16, 5);
}

TEST_F(AutomaticCheckpoint, ResumesBitForBitAroundARelease) {
  const Scene s = automatic(test::curled_sheet(Precision::single_precision, Bending::plate), 0.01);
  expect_resumes(s, 16, 5);
}

/// What a run with fixed steps leaves is a start like any other, and the other way round.
TEST_F(AutomaticCheckpoint, OfFixedStepsGoesOn) {
  Scene fixed = test::sheet_on_sphere(Precision::single_precision, 6);
  fixed.time.frame_rate = 24;
  fixed.time.step = 1 / 96.0;
  for (const int steps : {28, 29}) {
    Simulation before(fixed, host_devices(1));
    for (int k = 0; k < steps; ++k) before.step();
    before.save(file_);
    Simulation after(automatic(fixed), host_devices(1));
    EXPECT_THROW(after.resume(file_), SceneError);
    EXPECT_FALSE(after.resume(file_, SceneChanges::allow).empty());
    EXPECT_EQ(7, after.frame_number());
    EXPECT_EQ(steps == 28, after.at_frame_end());
    EXPECT_NEAR(1 / 192.0, after.step_length(), 1e-12);
    do {
      ASSERT_EQ(Failure::none, after.step().failure);
    } while (!after.at_frame_end());
    EXPECT_EQ(8, after.frame_number());
    EXPECT_EQ(8 / 24.0, after.time());
    after.save(file_);
    Simulation back(fixed, host_devices(1));
    back.resume(file_, SceneChanges::allow);
    EXPECT_EQ(32, back.step_number());
    EXPECT_EQ(8, back.frame_number());
  }
}

TEST_F(AutomaticCheckpoint, ValuesThatCannotBeAreRefused) {
  const Scene s = automatic(test::sheet_on_sphere(Precision::single_precision, 4));
  DeviceSet devices = host_devices(1);
  Store<float> store(s, devices);
  const StateSnapshot<float> start = store.snapshot();
  const auto load = [&](double time, double next_step) {
    StateSnapshot<float> state = start;
    state.time = time;
    state.next_step = next_step;
    write_checkpoint(file_, s, store.model(), state, {});
    state = start;
    read_checkpoint(file_, s, store.model(), state);
    return state.next_step;
  };
  EXPECT_EQ(0.01, load(0.1, 0.01));
  EXPECT_EQ(0, load(0.1, 0));
  const auto expect_refused = [&](double time, double next_step, const std::string& name) {
    try {
      load(time, next_step);
      FAIL() << time << " " << next_step;
    } catch (const SceneError& error) {
      EXPECT_NE(std::string::npos, std::string(error.what()).find(name)) << error.what();
    }
  };
  for (const double bad : {std::nan(""), std::numeric_limits<double>::infinity(), -0.01})
    expect_refused(0.1, bad, "next_step");
  expect_refused(1e12, 0.01, "core");
}

/// Root mean square of what lies between two states. [m]
double distance(const Frame& a, const Frame& b) {
  double sum = 0;
  std::size_t count = 0;
  for (std::size_t c = 0; c < a.cloth_positions.size(); ++c)
    for (std::size_t v = 0; v < a.cloth_positions[c].size(); ++v, ++count)
      sum += length_sq(a.cloth_positions[c][v] - b.cloth_positions[c][v]);
  return std::sqrt(sum / static_cast<double>(count));
}

struct Outcome {
  std::vector<Frame> frames;
  std::int64_t steps = 0;
};

Outcome run(const Scene& s, int frames) {
  Outcome outcome;
  Simulation simulation(s, host_devices(1));
  while (simulation.frame_number() < frames) {
    EXPECT_EQ(Failure::none, simulation.step().failure);
    if (simulation.at_frame_end()) outcome.frames.push_back(simulation.frame());
  }
  outcome.steps = simulation.step_number();
  return outcome;
}

Scene with_step(Scene s, double step) {
  s.time.automatic = false;
  s.time.step = step;
  return s;
}

/// Mean over the frames. [m]
double error(const Outcome& a, const Outcome& reference) {
  double sum = 0;
  for (std::size_t n = 0; n < a.frames.size(); ++n)
    sum += distance(a.frames[n], reference.frames[n]);
  return sum / static_cast<double>(a.frames.size());
}

TEST(AutomaticSteps, ASmallerToleranceGivesASmallerError) {
  for (const auto integrator : {Integrator::implicit_euler, Integrator::bdf2}) {
    Scene s = test::hanging_sheet(Precision::double_precision, integrator);
    s.solver.tolerance = 1e-6;
    const Outcome reference = run(with_step(s, 0.04 / 256), 8);
    double before = std::numeric_limits<double>::infinity();
    std::int64_t steps = 0;
    for (const double tolerance : {0.1, 0.02, 0.004, 0.0008}) {
      const Outcome found = run(automatic(s, tolerance), 8);
      const double now = error(found, reference);
      EXPECT_LT(now, 0.75 * before) << tolerance;
      EXPECT_GT(found.steps, steps) << tolerance;
      before = now;
      steps = found.steps;
    }
  }
}

/// A sheet that is pinned along an edge swings down onto a wall, and comes to rest there.
TEST(AutomaticSteps, FewerStepsThanFixedOnesOfTheSameErrorWithContact) {
  Scene s;
  s.precision = Precision::double_precision;
  s.solver.tolerance = 1e-5;
  s.materials.push_back(test::cotton());
  s.materials[0].damping_stiffness = 5e-3;
  s.cloths.push_back(test::sheet(8, 0));
  Pin pin;
  for (Index v = 0; v < 9; ++v) pin.vertices.push_back(9 * v);
  s.pins = {pin};
  const Vec3<double> hinge = s.cloths[0].mesh.positions[0];
  Obstacle wall;
  wall.name = "wall";
  wall.mesh = make_box({0.1, 0.8, 0.8}, {2, 8, 8});
  wall.transform.translate = {hinge[0] - 0.06, hinge[1] + 0.2, -0.5};
  s.obstacles.push_back(wall);
  const Outcome reference = run(with_step(s, 0.04 / 64), 30);
  const Outcome fixed = run(with_step(s, 0.01), 30);
  const Outcome found = run(automatic(s, 0.01), 30);
  EXPECT_LT(error(found, reference), error(fixed, reference));
  EXPECT_LT(4 * found.steps, 3 * fixed.steps);
}

/// Meshes change at the end of a frame, and the length of steps goes on.
TEST_F(AutomaticCheckpoint, OfChangingMeshesResumesBitForBit) {
  for (const char* method : {"adaptive", "view"}) {
    Scene s = sheet_at_ball(Precision::single_precision, Integrator::bdf2);
    s.method = method;
    s.camera.keys = {{0, {0.1, -2, 0.8}, {0, 0, 0}}};
    expect_resumes(s, 12, 5);
  }
}

}  // namespace
}  // namespace weft
