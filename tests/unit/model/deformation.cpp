#include "host/model/deformation.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace weft {
namespace {

using Points = std::vector<Vec3<double>>;

Points at(const Deformation& deformation, double time, std::size_t count) {
  Points out(count);
  deformation.positions(time, out);
  return out;
}

SampledDeformation sampled(const std::vector<double>& times, const std::vector<Points>& frames,
                           Interpolation interpolation, Playback playback = {}) {
  SampledDeformation result(interpolation, playback);
  for (std::size_t f = 0; f < frames.size(); ++f)
    result.add_frame(times[f], Span<const Vec3<double>>(frames[f].data(), frames[f].size()));
  return result;
}

TEST(ClipTime, HoldsAtBothEnds) {
  const Playback playback{1, 2, false};
  EXPECT_EQ(clip_time(playback, 3, -10), 0);
  EXPECT_EQ(clip_time(playback, 3, 1), 0);
  EXPECT_EQ(clip_time(playback, 3, 2), 2);
  EXPECT_EQ(clip_time(playback, 3, 2.5), 3);
  EXPECT_EQ(clip_time(playback, 3, 99), 3);
}

TEST(ClipTime, LoopsBothWays) {
  const Playback playback{0, 1, true};
  EXPECT_EQ(clip_time(playback, 4, 5), 1);
  EXPECT_EQ(clip_time(playback, 4, -1), 3);
  EXPECT_EQ(clip_time(playback, 4, 4), 0);
  EXPECT_EQ(clip_time(playback, 0, 4), 0);
}

TEST(Sampled, HitsFloatFramesExactly) {
  std::mt19937 random(5);
  std::uniform_real_distribution<float> uniform(-3, 3);
  std::vector<Points> frames(4, Points(7));
  for (Points& frame : frames)
    for (auto& x : frame)
      for (int k = 0; k < 3; ++k) x[k] = static_cast<double>(uniform(random));
  const std::vector<double> times{0, 0.1, 0.35, 1};
  for (const Interpolation interpolation : {Interpolation::linear, Interpolation::cubic}) {
    const auto deformation = sampled(times, frames, interpolation);
    for (std::size_t f = 0; f < frames.size(); ++f) {
      const Points out = at(deformation, times[f], 7);
      for (std::size_t v = 0; v < out.size(); ++v) EXPECT_TRUE(out[v] == frames[f][v]) << f;
    }
  }
}

TEST(Sampled, HitsFloatFramesThatWereMovedFarAwayExactly) {
  const Vec3<double> offset{0x1p20, -0x1p18, 0};
  const Points near{{0.1f, 0.7f, -0.3f}, {0.25f, -0.4f, 0.9f}, {0.8f, 0.5f, 0.6f}};
  Points far = near;
  for (auto& x : far) x += offset;
  const auto deformation = sampled({0}, {far}, Interpolation::linear);
  const Points out = at(deformation, 0, 3);
  for (std::size_t v = 0; v < out.size(); ++v) EXPECT_EQ(out[v] - offset, near[v]);
}

TEST(Sampled, KeepsDoublesWithinTheDocumentedError) {
  // Far from the origin, where plain floats would be off by 30 micrometres.
  const Points frame{{1000.1, 2000.2, -1000.3}, {1001.7, 2001.9, -999.4}, {1000.9, 2000.6, -1000}};
  const auto deformation = sampled({0}, {frame}, Interpolation::cubic);
  const Points out = at(deformation, 0, 3);
  const double bound = std::ldexp(1.7 / 2, -24) + 1e-12;
  for (std::size_t v = 0; v < 3; ++v)
    for (int k = 0; k < 3; ++k) EXPECT_NEAR(out[v][k], frame[v][k], bound);
}

TEST(Sampled, LinearIsLinear) {
  const auto deformation =
      sampled({0, 2}, {{{0, 0, 0}}, {{4, -2, 8}}}, Interpolation::linear, {10, 1, false});
  EXPECT_TRUE(at(deformation, 10.5, 1)[0] == (Vec3<double>{1, -0.5, 2}));
  EXPECT_TRUE(at(deformation, 0, 1)[0] == (Vec3<double>{0, 0, 0}));
  EXPECT_TRUE(at(deformation, 50, 1)[0] == (Vec3<double>{4, -2, 8}));
}

TEST(Sampled, CubicReproducesAParabolaBetweenInnerFrames) {
  // Catmull-Rom slopes at equal distances are those of the parabola; it is monotone here.
  std::vector<Points> frames;
  for (int f = 0; f < 4; ++f) frames.push_back({{1.0 * f * f, 0, 0}});
  const auto deformation = sampled({0, 1, 2, 3}, frames, Interpolation::cubic);
  for (const double t : {1.1, 1.5, 1.9}) EXPECT_NEAR(at(deformation, t, 1)[0][0], t * t, 1e-14);
}

TEST(Sampled, CubicNeverLeavesTheInterval) {
  // Plain Catmull-Rom dips to -0.07 between the second and the third frame.
  const std::vector<Points> frames{{{1, 0, 3}}, {{0, 0, 3}}, {{0, 5, 3}}, {{1, 0, 3}}, {{9, 1, 3}}};
  const auto deformation = sampled({0, 1, 2, 3, 4}, frames, Interpolation::cubic);
  for (int i = 0; i <= 400; ++i) {
    const double t = i / 100.0;
    const auto before = static_cast<std::size_t>(std::min(std::floor(t), 3.0));
    const Vec3<double> x = at(deformation, t, 1)[0];
    for (int k = 0; k < 3; ++k) {
      EXPECT_GE(x[k], std::min(frames[before][0][k], frames[before + 1][0][k]) - 1e-14) << t;
      EXPECT_LE(x[k], std::max(frames[before][0][k], frames[before + 1][0][k]) + 1e-14) << t;
    }
    EXPECT_EQ(x[2], 3);
  }
}

TEST(Sampled, CubicHasContinuousVelocity) {
  const std::vector<Points> frames{{{0, 0, 0}}, {{1, 2, 0}}, {{3, 1, 5}}, {{4, 0, 6}}};
  const auto deformation = sampled({0, 1, 1.5, 3}, frames, Interpolation::cubic);
  const double h = 1e-5;
  for (const double t : {1.0, 1.5}) {
    const Vec3<double> here = at(deformation, t, 1)[0];
    const Vec3<double> before = (here - at(deformation, t - h, 1)[0]) * (1 / h);
    const Vec3<double> after = (at(deformation, t + h, 1)[0] - here) * (1 / h);
    // Each is off by half a second derivative, which is below 200, times h.
    for (int k = 0; k < 3; ++k) EXPECT_NEAR(before[k], after[k], 200 * h);
  }
}

}  // namespace
}  // namespace weft
