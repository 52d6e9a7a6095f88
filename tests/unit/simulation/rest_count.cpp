#include "host/simulation/rest_count.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <memory>
#include <vector>

#include "host/model/deformation.hpp"

namespace weft::test {
namespace {

/// So many of a thousand vertices at a speed, the others at rest.
std::vector<Vec3<double>> velocities(std::size_t moving, double speed) {
  std::vector<Vec3<double>> v(1000, Vec3<double>{0, 0, 0});
  for (std::size_t k = 0; k < moving; ++k) v[k] = {0, 0.6 * speed, -0.8 * speed};
  return v;
}

void add(RestCount& count, std::size_t moving, double speed, double end) {
  const auto v = velocities(moving, speed);
  count.add_frame(Span<const Vec3<double>>(v.data(), v.size()), end, 3);
}

TEST(RestCount, NeedsQuietFramesInARow) {
  RestCount count;
  add(count, 15, 1, 1);
  EXPECT_DOUBLE_EQ(count.state().moving_share, 0.015);
  add(count, 1000, 0.0099, 2);
  EXPECT_EQ(count.state().quiet_frames, 2);
  EXPECT_FALSE(count.state().rested);
  add(count, 16, 0.0101, 3);
  EXPECT_EQ(count.state().quiet_frames, 0);
  for (int k = 0; k < 2; ++k) add(count, 0, 0, 4 + k);
  EXPECT_FALSE(count.state().rested);
  add(count, 0, 0, 6);
  EXPECT_TRUE(count.state().rested);
}

/// What only trembles has a velocity, but is where it was a frame ago; what drifts is not.
TEST(RestCount, TremblingClothRests) {
  for (const double drift : {0.0, 0.0099, 0.0101}) {
    RestCount count;
    const auto v = velocities(1000, 1);
    std::vector<Vec3<double>> x(1000, Vec3<double>{1, 2, 3});
    const auto frame = [&](double end) {
      count.add_frame(Span<const Vec3<double>>(v.data(), v.size()), end, 3,
                      Span<const Vec3<double>>(x.data(), x.size()));
    };
    frame(0.1);
    EXPECT_DOUBLE_EQ(count.state().moving_share, 1);  // nothing is known of the frame before
    for (int k = 2; k <= 4; ++k) {
      for (Vec3<double>& p : x) p[0] += 0.1 * drift;
      frame(0.1 * k);
    }
    EXPECT_EQ(count.state().rested, drift < 0.01) << drift;
  }
}

TEST(RestCount, NotBeforeTheLastChange) {
  RestCount count;
  count.reset(2);
  for (int k = 1; k <= 4; ++k) add(count, 0, 0, 0.5 * k);
  EXPECT_EQ(count.state().quiet_frames, 0);
  for (int k = 5; k <= 7; ++k) add(count, 0, 0, 0.5 * k);
  EXPECT_TRUE(count.state().rested);
}

TEST(RestCount, FramesOfAFifthOfASecond) {
  TimeSettings time;
  time.frame_rate = 25;
  EXPECT_EQ(quiet_frames_of_rest(time), 5);
  time.frame_rate = 60;
  EXPECT_EQ(quiet_frames_of_rest(time), 12);
  time.frame_rate = 5;
  EXPECT_EQ(quiet_frames_of_rest(time), 2);
}

TEST(LastChange, OfAllThatTheScenePlans) {
  Scene scene;
  EXPECT_EQ(last_change(scene), 0);
  Obstacle obstacle;
  obstacle.motion = {{0, {}}, {1.5, {}}};
  scene.obstacles.push_back(obstacle);
  EXPECT_EQ(last_change(scene), 1.5);
  scene.pins.emplace_back();  // never released
  EXPECT_EQ(last_change(scene), 1.5);
  scene.pins.back().release_time = 2;
  EXPECT_EQ(last_change(scene), 2);
  scene.handles.emplace_back();
  scene.handles.back().end_time = 2.5;
  scene.handles.back().fade_time = 0.25;
  EXPECT_EQ(last_change(scene), 2.75);
  scene.seams.emplace_back();
  scene.seams.back().start_time = 2.6;
  scene.seams.back().ramp_time = 0.4;
  EXPECT_EQ(last_change(scene), 3);
  const std::vector<Vec3<double>> places(3, Vec3<double>{0, 0, 0});
  const auto clip = [&](bool loop) {
    auto shape = std::make_shared<SampledDeformation>(Interpolation::linear, Playback{1, 2, loop});
    for (const double time : {0.0, 5.0}) shape->add_frame(time, {places.data(), places.size()});
    return shape;
  };
  scene.obstacles[0].deformation = clip(false);
  EXPECT_EQ(last_change(scene), 3.5);
  scene.obstacles[0].deformation = clip(true);
  EXPECT_EQ(last_change(scene), std::numeric_limits<double>::infinity());
}

}  // namespace
}  // namespace weft::test
