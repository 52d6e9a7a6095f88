// The controller of steps of automatic length, without a simulation.
#include "host/simulation/step_control.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include "host/scene/frame_steps.hpp"

namespace weft {
namespace {

TimeSettings at_rate(double frame_rate) {
  TimeSettings time;
  time.frame_rate = frame_rate;
  time.automatic = true;
  return time;
}

/// Takes a step whatever its error is.
double advance(const StepControl& control, double& length, double now, double error) {
  const StepControl::Step step = control.next(length, now);
  length = control.after(step, error, true);
  return step.end;
}

TEST(StepControl, BeginsWithAnEighthOfAFrame) {
  const StepControl::Step step = StepControl(at_rate(25), Integrator::implicit_euler).next(0, 0);
  EXPECT_DOUBLE_EQ(0.005, step.length);
  EXPECT_EQ(step.length, step.end);
  EXPECT_FALSE(step.ends_frame);
}

/// A quarter of the length has a sixteenth, or a sixty-fourth, of the error.
TEST(StepControl, KnowsTheOrderOfTheError) {
  const TimeSettings time = at_rate(25);
  const StepControl euler(time, Integrator::implicit_euler), bdf2(time, Integrator::bdf2);
  const StepControl::Step step = euler.next(0, 0);
  const double by_euler = euler.after(step, 0.81, true);
  EXPECT_DOUBLE_EQ(step.length, by_euler);
  EXPECT_DOUBLE_EQ(step.length, bdf2.after(step, 0.729, true));
}

TEST(StepControl, GrowsAndShrinksWithinBounds) {
  const StepControl control(at_rate(25), Integrator::implicit_euler);
  const StepControl::Step step = control.next(0, 0);
  EXPECT_EQ(2 * step.length, control.after(step, 0, true));
  EXPECT_EQ(2 * step.length, control.after(step, 1e-12, true));
  EXPECT_EQ(step.length, control.after(step, 1e-12, false));
  EXPECT_EQ(step.length / 4, control.after(step, 1e12, true));
  EXPECT_EQ(step.length / 4, control.again(step, 1e12));
  EXPECT_LE(control.again(step, 2), step.length / 2);
}

/// Whatever the errors are, frames are hit to the bit, no step is a small rest of a frame, and the
/// lengths that follow each other differ by bounded factors.
TEST(StepControl, DividesFramesWithoutRemainder) {
  std::mt19937 random(7);
  for (const double rate : {25.0, 24.0, 29.97, 1.0, 1000.0 / 7}) {
    const TimeSettings time = at_rate(rate);
    const StepControl control(time, Integrator::bdf2);
    double length = 0, now = 0, before = 0;
    int frames = 0;
    for (int n = 0; n < 3000; ++n) {
      const StepControl::Step step = control.next(length, now);
      ASSERT_GT(step.length, 0);
      ASSERT_LE(step.length, (1 + 1e-12) / rate);
      if (n > 0) {
        ASSERT_LE(step.length, (1 + 1e-9) * StepControl::growth_max * before);
        ASSERT_GE(step.length, (1 - 1e-9) * before / (2 * StepControl::shrinkage_max));
      }
      frames += step.ends_frame ? 1 : 0;
      ASSERT_EQ(frames, control.frames(step.end));
      ASSERT_EQ(step.ends_frame, control.at_frame_end(step.end));
      if (step.ends_frame) {
        ASSERT_EQ(frames / rate, step.end);
      }
      const double error = std::pow(10.0, static_cast<double>(random() % 60) / 10 - 3);
      length = control.after(step, error, true);
      now = step.end;
      before = step.length;
    }
    EXPECT_GT(frames, 0);
  }
}

/// With an error that no step meets, the length falls to its floor, where steps are taken all the
/// same.
TEST(StepControl, EndsWhateverTheErrorIs) {
  for (const double error : {1e300, std::numeric_limits<double>::infinity()}) {
    const TimeSettings time = at_rate(25);
    const StepControl control(time, Integrator::implicit_euler);
    double length = 0, now = 0;
    int steps = 0, attempts_max = 0, rejections_in_frame = 0;
    while (control.frames(now) < 2) {
      int attempts = 1;
      StepControl::Step step = control.next(length, now);
      for (; control.rejects(step, error, attempts - 1); ++attempts) {
        step = control.next(control.again(step, error), now);
        ASSERT_LE(attempts, StepControl::rejections_max);
      }
      if (control.frames(now) == 1) rejections_in_frame += attempts - 1;
      attempts_max = std::max(attempts_max, attempts);
      length = control.after(step, error, attempts == 1);
      now = step.end;
      ASSERT_LE(++steps, 2 * automatic_frame_steps_max);
    }
    EXPECT_EQ(StepControl::rejections_max + 1, attempts_max);
    EXPECT_EQ(0, rejections_in_frame) << "the shortest step is taken as it is";
    EXPECT_EQ(frame_time(time, 2), now);
  }
}

TEST(StepControl, TakesAsFewStepsAsFramesIfThereIsNoError) {
  const StepControl control(at_rate(25), Integrator::implicit_euler);
  double length = 0, now = 0;
  while (control.frames(now) < 2) now = advance(control, length, now, 0);
  const StepControl::Step step = control.next(length, now);
  EXPECT_TRUE(step.ends_frame);
  EXPECT_DOUBLE_EQ(0.04, step.length);
}

}  // namespace
}  // namespace weft
