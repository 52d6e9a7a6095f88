#include "host/simulation/rest_count.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <memory>
#include <vector>

#include "host/model/deformation.hpp"

namespace weft::test {
namespace {

/// A thousand vertices, frame by frame of 0.04 s.
class Cloth {
 public:
  Cloth() : x_(1000, Vec3<double>{1, 2, 3}), v_(1000) {
    count_.begin_frame(Span<const Vec3<double>>(x_.data(), x_.size()), 0);
  }
  explicit Cloth(double last_change) : Cloth() { count_.reset(last_change); }

  /// The first so many are displaced by `way` in the frame, and have that velocity or one that is
  /// given.
  void frame(std::size_t moving, double way, double speed = 0) {
    for (std::size_t k = 0; k < x_.size(); ++k) {
      const Vec3<double> along = k < moving ? Vec3<double>{0, 0.6, -0.8} : Vec3<double>{};
      x_[k] += way * along;
      v_[k] = (speed > 0 ? speed : way / duration) * along;
    }
    end_ += duration;
    count_.add_frame(Span<const Vec3<double>>(x_.data(), x_.size()),
                     Span<const Vec3<double>>(v_.data(), v_.size()), end_, frames);
  }
  const RestState& state() const { return count_.state(); }
  RestCount& count() { return count_; }

  static constexpr int frames = 5;
  static constexpr double duration = 0.04;  ///< [s]

 private:
  std::vector<Vec3<double>> x_, v_;
  RestCount count_;
  double end_ = 0;
};

TEST(RestCount, NeedsQuietFramesInARow) {
  Cloth cloth;
  cloth.frame(15, 1);
  EXPECT_DOUBLE_EQ(cloth.state().moving_share, 0.015);
  EXPECT_DOUBLE_EQ(cloth.state().displaced_share, 0.015);
  cloth.frame(1000, 0.0099 * Cloth::duration);
  EXPECT_EQ(cloth.state().quiet_frames, 2);
  EXPECT_FALSE(cloth.state().rested);
  cloth.frame(16, 1);
  EXPECT_EQ(cloth.state().quiet_frames, 0);
  for (int k = 1; k < Cloth::frames; ++k) cloth.frame(0, 0);
  EXPECT_FALSE(cloth.state().rested);
  cloth.frame(0, 0);
  EXPECT_TRUE(cloth.state().rested);
}

/// What drifts is 2 mm away in the end if it is faster than 0.01 m/s, however it trembles.
TEST(RestCount, TremblingClothRests) {
  for (const double drift : {0.0, 0.0099, 0.0101}) {
    Cloth cloth;
    for (int k = 0; k < Cloth::frames; ++k) cloth.frame(50, drift * Cloth::duration, 1);
    EXPECT_EQ(cloth.state().rested, drift < 0.01) << drift;
  }
  Cloth cloth;
  for (int k = 0; k < Cloth::frames; ++k) cloth.frame(50, k % 2 == 0 ? 0.0019 : -0.0019);
  EXPECT_TRUE(cloth.state().rested);
}

/// About its turning points a swing is nowhere far from where it was, but most of it is fast.
TEST(RestCount, ASwingDoesNotRest) {
  Cloth cloth;
  double angle = 0;
  for (int k = 0; k < 200; ++k) {
    const double next = 2 * 3.14159265358979 * Cloth::duration * (k + 1) / 1.6;
    cloth.frame(1000, 0.01 * (std::cos(next) - std::cos(angle)), 0.04 * std::fabs(std::sin(next)));
    angle = next;
    EXPECT_FALSE(cloth.state().rested) << k;
  }
}

TEST(RestCount, NotBeforeTheLastChange) {
  Cloth cloth(0.1);
  for (int k = 0; k < 2; ++k) cloth.frame(0, 0);
  EXPECT_EQ(cloth.state().quiet_frames, 0);
  for (int k = 0; k < Cloth::frames; ++k) cloth.frame(0, 0);
  EXPECT_TRUE(cloth.state().rested);
}

TEST(RestCount, GoesOnWithWhatACheckpointHolds) {
  Cloth through;
  for (int k = 0; k < 3; ++k) through.frame(1000, 0.0005, 0.001);
  Cloth resumed = through;
  resumed.count() = RestCount();
  const std::vector<Vec3<double>> x(1000,
                                    Vec3<double>{1, 2 + 3 * 0.6 * 0.0005, 3 - 3 * 0.8 * 0.0005});
  resumed.count().begin_frame(Span<const Vec3<double>>(x.data(), x.size()), 3 * Cloth::duration);
  resumed.count().restore(through.count().quiet_frames(), Cloth::frames);
  for (Cloth* cloth : {&through, &resumed}) {
    cloth->frame(1000, 0.0001, 0.001);
    EXPECT_EQ(cloth->state().quiet_frames, 4);
    cloth->frame(1000, 0.0005, 0.001);  // 2.1 mm in all
    EXPECT_EQ(cloth->state().quiet_frames, 0);
  }
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
