#include "host/model/skinning.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <thread>

namespace weft {
namespace {

constexpr double pi = std::numbers::pi;
const Vec3<double> x_axis{1, 0, 0};
const Vec3<double> z_axis{0, 0, 1};

void expect_near(const Vec3<double>& a, const Vec3<double>& b, double tolerance = 1e-14) {
  for (int k = 0; k < 3; ++k) EXPECT_NEAR(a[k], b[k], tolerance) << "component " << k;
}

SkeletonNode joint(Index parent, const Vec3<double>& offset, Track<Quaternion> turns) {
  SkeletonNode node;
  node.parent = parent;
  node.animated = true;
  node.translate = {{0, offset}};
  node.rotate = std::move(turns);
  node.scale = {{0, Vec3<double>{1, 1, 1}}};
  return node;
}

/// Upper arm and forearm of length 1 along x; in a second the shoulder turns by 90 degrees about
/// z, the elbow by 60. Vertices: the elbow, the hand, and one that both bones pull at.
Skin two_bone_arm() {
  Skin skin;
  skin.nodes.push_back(joint(-1, {0, 0, 0}, {{0, {}}, {1, rotation_about(z_axis, pi / 2)}}));
  skin.nodes.push_back(joint(0, {1, 0, 0}, {{0, {}}, {1, rotation_about(z_axis, pi / 3)}}));
  skin.bones = {{0, {}}, {1, {Mat3<double>::identity(), {-1, 0, 0}}}};
  skin.rest = {{1, 0, 0}, {2, 0, 0}, {1, 0.25, 0}};
  skin.influences = {{0, 1}, {1, 1}, {0, 0.25}, {1, 0.75}};
  skin.first_influence = {0, 1, 2, 4};
  skin.duration = 1;
  return skin;
}

TEST(Slerp, GoesHalfWayOnTheShortArc) {
  const Quaternion half = slerp({}, rotation_about(z_axis, pi / 2), 0.5);
  const Quaternion expected = rotation_about(z_axis, pi / 4);
  EXPECT_NEAR(half.w, expected.w, 1e-15);
  expect_near(half.v, expected.v, 1e-15);
  // The same rotation with the other sign must not take the long way.
  const Quaternion turn = rotation_about(z_axis, pi / 2);
  expect_near(slerp({}, {-turn.w, -turn.v}, 0.5).v, expected.v, 1e-15);
}

TEST(Slerp, HasConstantSpeedAndHitsItsEnds) {
  const Quaternion a = rotation_about(x_axis, 0.3);
  const Quaternion b = rotation_about(x_axis, 2.3);
  for (const double s : {0.0, 0.1, 0.5, 0.9, 1.0}) {
    const Quaternion q = slerp(a, b, s);
    EXPECT_NEAR(2 * std::atan2(q.v[0], q.w), 0.3 + 2 * s, 1e-14);
  }
  // Nearly equal rotations: the naive formula divides two rounding errors.
  const Quaternion c = rotation_about(x_axis, 0.3 + 1e-9);
  const Quaternion middle = slerp(a, c, 0.5);
  EXPECT_NEAR(2 * std::atan2(middle.v[0], middle.w), 0.3 + 0.5e-9, 1e-15);
  EXPECT_EQ(slerp(a, a, 0.7).w, a.w);
}

TEST(Quaternion, TurnsLikeItsMatrix) {
  expect_near(matrix_of(rotation_about(z_axis, pi / 2)) * x_axis, {0, 1, 0});
  const Quaternion both = rotation_about(z_axis, pi / 2) * rotation_about(x_axis, pi / 2);
  expect_near(matrix_of(both) * Vec3<double>{0, 1, 0}, {0, 0, 1});  // x first: y to z, which stays
}

TEST(Skinned, ArmByHand) {
  const SkinnedDeformation arm(two_bone_arm(), {});
  std::vector<Vec3<double>> out(3);
  arm.positions(0, out);
  expect_near(out[0], {1, 0, 0});
  expect_near(out[1], {2, 0, 0});
  expect_near(out[2], {1, 0.25, 0});

  // Shoulder at 45 degrees, elbow at 30 more.
  arm.positions(0.5, out);
  const Vec3<double> elbow{std::cos(pi / 4), std::sin(pi / 4), 0};
  const auto along = [](double angle) { return Vec3<double>{std::cos(angle), std::sin(angle), 0}; };
  expect_near(out[0], elbow);
  expect_near(out[1], elbow + along(pi / 4 + pi / 6));
  const Vec3<double> by_upper = elbow + along(pi / 4 + pi / 2) * 0.25;
  const Vec3<double> by_fore = elbow + along(pi / 4 + pi / 6 + pi / 2) * 0.25;
  expect_near(out[2], by_upper * 0.25 + by_fore * 0.75);

  arm.positions(7, out);  // held
  expect_near(out[1], Vec3<double>{0, 1, 0} + along(pi / 2 + pi / 3));
}

TEST(Skinned, FollowsPlaybackUnitsAndAxes) {
  Skin skin = two_bone_arm();
  skin.to_world = axes_to_world(true, 0.01);  // centimetres, y up
  const SkinnedDeformation arm(skin, {2, 0.5, false});
  std::vector<Vec3<double>> out(3);
  arm.positions(4, out);  // a second of the clip
  expect_near(out[0], {0, 0, 0.01}, 1e-16);
}

TEST(Skinned, ScalesBeforeItTurns) {
  Skin skin;
  skin.nodes.push_back(joint(-1, {5, 0, 0}, {{0, rotation_about(z_axis, pi / 2)}}));
  skin.nodes[0].scale = {{0, Vec3<double>{2, 1, 1}}, {1, Vec3<double>{4, 1, 1}}};
  skin.bones = {{0, {}}};
  skin.rest = {{1, 1, 0}};
  skin.influences = {{0, 1}};
  skin.first_influence = {0, 1};
  skin.duration = 1;
  std::vector<Vec3<double>> out(1);
  SkinnedDeformation(skin, {}).positions(0.5, out);
  expect_near(out[0], {5 - 1, 3, 0});
}

TEST(Skinned, GivesTheSameFromSeveralThreads) {
  const SkinnedDeformation arm(two_bone_arm(), {});
  std::vector<std::vector<Vec3<double>>> out(4, std::vector<Vec3<double>>(3));
  std::vector<std::thread> threads;
  for (auto& mine : out)
    threads.emplace_back([&] {
      for (int i = 0; i <= 100; ++i) arm.positions(i / 100.0 * 0.7, mine);
    });
  for (auto& thread : threads) thread.join();
  for (const auto& other : out)
    for (std::size_t v = 0; v < 3; ++v) EXPECT_TRUE(other[v] == out[0][v]);
}

}  // namespace
}  // namespace weft
