#include "host/io/animation/bvh_file.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <random>

#include "host/base/file_bytes.hpp"
#include "host/geometry/mesh_check.hpp"
#include "host/io/animation/capture_body.hpp"
#include "weft/error.hpp"

namespace weft::io {
namespace {

constexpr double pi = std::numbers::pi;

/// A root with an arm of two bones along x; in the second frame the root is 10 higher, the arm is
/// turned by 90 degrees about z, then by 90 about its own x; the forearm by 90 about z.
const std::string arm = R"(HIERARCHY
ROOT Hips
{
  OFFSET 0 0 0
  CHANNELS 6 Xposition Yposition Zposition Zrotation Xrotation Yrotation
  JOINT Left Arm {
    OFFSET 0 5 0
    CHANNELS 3 Zrotation Xrotation Yrotation
    JOINT forearm
    {
      OFFSET 2 0 0
      CHANNELS 1 Zrotation
      End Site
      { OFFSET 2 0 0 }
    }
  }
}
MOTION
Frames: 2
Frame Time: .5
0 0 0 0 0 0   0 0 0   0
0 10 0 0 0 0  90 90 0  90
)";

void expect_near(const Vec3<double>& a, const Vec3<double>& b, double tolerance = 1e-13) {
  for (int k = 0; k < 3; ++k) EXPECT_NEAR(a[k], b[k], tolerance) << "component " << k;
}

/// Message of the refusal, or nothing.
std::string refusal(const std::string& bytes) {
  try {
    parse_bvh(bytes, "take.bvh");
  } catch (const SceneError& error) {
    return error.what();
  }
  return "";
}

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return text.replace(at, from.size(), to);
}

CaptureBody whole(const Capture& capture) {
  CaptureBody body;
  body.y_up = false;
  body.last_frame = capture.frame_count - 1;
  return body;
}

TEST(Bvh, ReadsSkeletonAndFrames) {
  const Capture capture = parse_bvh(arm, "take.bvh");
  ASSERT_EQ(capture.joints.size(), 4u);
  EXPECT_EQ(capture.joints[1].name, "Left Arm");
  EXPECT_EQ(capture.joints[1].parent, 0);
  EXPECT_EQ(capture.joints[1].first_channel, 6u);
  EXPECT_TRUE(capture.joints[3].end_site);
  EXPECT_EQ(capture.joints[3].parent, 2);
  EXPECT_EQ(capture.channel_count, 10u);
  EXPECT_EQ(capture.frame_count, 2u);
  EXPECT_EQ(capture.frame_time, 0.5);
  EXPECT_EQ(capture.value(1, 1), 10);
  EXPECT_FALSE(capture.joints[0].channels[2].rotation);
  EXPECT_EQ(capture.joints[0].channels[2].axis, 2);
  EXPECT_TRUE(capture.joints[0].channels[3].rotation);
}

TEST(Bvh, TakesWhatOtherProgramsWrite) {
  EXPECT_EQ(refusal(replaced(arm, "HIERARCHY", "\xef\xbb\xbfhierarchy")), "");
  EXPECT_EQ(refusal(replaced(arm, "Frames: 2", "FRAMES :2")), "");
  EXPECT_EQ(refusal(replaced(arm, "MOTION", "ROOT other { OFFSET 0 0 0 CHANNELS 0 }\nMOTION")), "");
  std::string crlf;
  for (const char c : arm) crlf += c == '\n' ? std::string("\r\n") : std::string(1, c);
  EXPECT_EQ(refusal(crlf), "");
  EXPECT_EQ(parse_bvh(crlf, "").joints[1].name, "Left Arm");
}

TEST(Bvh, RefusesWithLineAndValue) {
  EXPECT_NE(refusal("").find("end of file"), std::string::npos);
  EXPECT_NE(
      refusal(replaced(arm, "OFFSET 0 5 0", "OFFSET 0 five 0")).find("line 7: OFFSET: \"five"),
      std::string::npos);
  EXPECT_NE(refusal(replaced(arm, "1 Zrotation", "1 Zrotatoin")).find("Zrotatoin"),
            std::string::npos);
  EXPECT_NE(refusal(replaced(arm, "1 Zrotation", "2 Zrotation Zrotation")).find("once a joint"),
            std::string::npos);
  EXPECT_NE(refusal(replaced(arm, "Frames: 2", "Frames: 3")).find("line 20: Frames"),
            std::string::npos)
      << refusal(replaced(arm, "Frames: 2", "Frames: 3"));
  EXPECT_EQ(parse_bvh(replaced(arm, "Frames: 2", "Frames: 1"), "").frame_count, 1u);
  EXPECT_NE(refusal(replaced(arm, "Frames: 2", "Frames: 900000000000")).find("900000000000"),
            std::string::npos);
  EXPECT_NE(refusal(replaced(arm, "90 90 0", "90 nan 0")).find("frame 1"), std::string::npos);
  EXPECT_NE(refusal(replaced(arm, ".5", "0")).find("Frame Time"), std::string::npos);
  EXPECT_NE(refusal(replaced(arm, "End Site", "End Site { JOINT x")).find("OFFSET or }"),
            std::string::npos);
}

TEST(Bvh, SurvivesDamage) {
  std::mt19937 random(11);
  for (int trial = 0; trial < 3000; ++trial) {
    std::string damaged = arm;
    for (int hits = 1 + static_cast<int>(random() % 4); hits > 0; --hits) {
      const std::size_t at = random() % damaged.size();
      if (random() % 3 == 0)
        damaged.erase(at, 1 + random() % 40);
      else
        damaged[at] = static_cast<char>(random() % 256);
      if (damaged.empty()) damaged = "H";
    }
    const std::string message = refusal(damaged);
    EXPECT_EQ(message.find('\n'), std::string::npos) << message;
  }
  std::string deep = "HIERARCHY ROOT a {";
  for (int i = 0; i < 200000; ++i) deep += " JOINT b {";
  EXPECT_NE(refusal(deep).find("joints"), std::string::npos);
}

TEST(CaptureBody, JointsAreWhereTheChannelsSay) {
  const Capture capture = parse_bvh(arm, "take.bvh");
  const SkinnedSurface body = make_capture_body(capture, whole(capture), "take.bvh");
  EXPECT_EQ(body.skin.duration, 0.5);
  const auto at = [&](double time) { return node_frames(body.skin.nodes, time); };
  const Vec3<double> origin{0, 0, 0};
  expect_near(at(0)[3](origin), {4, 5, 0});
  expect_near(at(0.5)[0](origin), {0, 10, 0});
  expect_near(at(0.5)[1](origin), {0, 15, 0});
  // Zrotation stands first, so it is the last to turn a point: Rz Rx (2, 0, 0) = (0, 2, 0); the
  // other order would leave the elbow at (0, 15, 2).
  expect_near(at(0.5)[2](origin), {0, 17, 0});
  // The forearm bends to its own y first, which Rz Rx takes to z.
  expect_near(at(0.5)[3](origin), {0, 17, 2});
  // Between frames: positions half way, the forearm at 45 degrees.
  expect_near(at(0.25)[0](origin), {0, 5, 0});
  const Affine forearm = at(0.25)[2];
  const Affine upper = at(0.25)[1];
  const Vec3<double> bend = upper.linear * Vec3<double>{std::sqrt(2), std::sqrt(2), 0};
  expect_near(forearm(Vec3<double>{2, 0, 0}), forearm(origin) + bend);
}

TEST(CaptureBody, RotationsGoOnTheShortestArc) {
  // Rz(90) Rx(90) is a turn by 120 degrees about (1, 1, 1); half way it is one by 60.
  const Capture capture = parse_bvh(arm, "take.bvh");
  const SkinnedSurface body = make_capture_body(capture, whole(capture), "take.bvh");
  const Affine half = node_frames(body.skin.nodes, 0.25)[1];
  const Vec3<double> axis = Vec3<double>{1, 1, 1} * (1 / std::sqrt(3));
  const Mat3<double> expected = matrix_of(rotation_about(axis, pi / 3));
  for (int i = 0; i < 9; ++i) EXPECT_NEAR(half.linear.e[i], expected.e[i], 1e-14);
}

TEST(CaptureBody, CapsulesAreClosedAndOnTheirBones) {
  const Capture capture = parse_bvh(arm, "take.bvh");
  CaptureBody style = whole(capture);
  style.radius = 0.25;
  style.radii["forearm"] = 0.125;
  style.edge = 0.05;
  const SkinnedSurface body = make_capture_body(capture, style, "take.bvh");
  const Skin& skin = body.skin;
  const SkinnedDeformation deformation(skin, {});
  Mesh mesh{std::vector<Vec3<double>>(skin.rest.size()), {}, body.triangles, {}, {}, {}};
  for (const double time : {0.0, 0.2, 0.5}) {
    deformation.positions(time, mesh.positions);
    EXPECT_NO_THROW(check_mesh(mesh, {"", "body", ""}, false));
    const auto frames = node_frames(skin.nodes, time);
    std::map<Index, double> nearest;
    for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
      const Index node = skin.influences[v].bone;
      // Bones: hips to arm, arm to forearm, forearm to its tip, on whose skin the end site lies.
      const Vec3<double> end = node == 0   ? Vec3<double>{0, 5, 0}
                               : node == 1 ? Vec3<double>{2, 0, 0}
                                           : Vec3<double>{2 - 0.125, 0, 0};
      const Affine& frame = frames[static_cast<std::size_t>(node)];
      const Vec3<double> a = frame(Vec3<double>{0, 0, 0});
      const Vec3<double> along = frame(end) - a;
      const double s = std::clamp(dot(mesh.positions[v] - a, along) / length_sq(along), 0.0, 1.0);
      const double radius = node == 2 ? 0.125 : 0.25;
      EXPECT_NEAR(length(mesh.positions[v] - (a + along * s)), radius, 1e-13);
      nearest[node] = 1;
    }
    EXPECT_EQ(nearest.size(), 3u);
  }
  // Outwards: the volumes of three capsules, less what chords lose.
  double volume = 0;
  for (const Tri& t : body.triangles) {
    const auto at = [&](int k) { return mesh.positions[static_cast<std::size_t>(t.v[k])]; };
    volume += dot(at(0), cross(at(1), at(2))) / 6;
  }
  const auto capsule = [](double r, double l) { return pi * r * r * (l + 4 * r / 3); };
  const double exact = capsule(0.25, 5) + capsule(0.25, 2) + capsule(0.125, 1.875);
  EXPECT_LT(volume, exact);
  EXPECT_GT(volume, 0.97 * exact);
}

TEST(CaptureBody, HeightAndUnits) {
  const Capture capture = parse_bvh(arm, "take.bvh");
  EXPECT_EQ(capture_height(capture, true), 5);
  EXPECT_EQ(capture_height(capture, false), 0);
  CaptureBody style = whole(capture);
  style.y_up = true;
  style.scale = 0.1;
  style.radius = 0.02;
  const SkinnedSurface body = make_capture_body(capture, style, "take.bvh");
  std::vector<Vec3<double>> out(body.skin.rest.size());
  SkinnedDeformation(body.skin, {}).positions(0, out);
  double low = 1e9;
  double high = -1e9;
  for (const Vec3<double>& x : out) {
    low = std::min(low, x[2]);
    high = std::max(high, x[2]);
  }
  EXPECT_NEAR(low, -0.02, 1e-14);  // radii are metres, whatever the unit of the file
  EXPECT_NEAR(high, 0.5 + 0.02, 1e-14);
}

TEST(CaptureBody, PlaysTheFramesAskedFor) {
  const Capture capture = parse_bvh(arm, "take.bvh");
  CaptureBody style = whole(capture);
  style.first_frame = 1;
  const SkinnedSurface body = make_capture_body(capture, style, "take.bvh");
  EXPECT_EQ(body.skin.duration, 0);
  expect_near(node_frames(body.skin.nodes, 0)[0](Vec3<double>{0, 0, 0}), {0, 10, 0});
}

TEST(CaptureBody, StaysBelowItsLimitsAndRefusesHair) {
  const Capture capture = parse_bvh(arm, "take.bvh");
  CaptureBody style = whole(capture);
  style.edge = 1e-9;
  EXPECT_LE(make_capture_body(capture, style, "").triangles.size(), max_body_triangles);
  style.radius = 1e-9;
  EXPECT_THROW(make_capture_body(capture, style, ""), SceneError);
  const Capture point = parse_bvh(
      "HIERARCHY ROOT a { OFFSET 0 0 0 CHANNELS 1 Xrotation } MOTION Frames: 1 Frame Time: 1 0",
      "");
  EXPECT_THROW(make_capture_body(point, whole(point), ""), SceneError);
}

TEST(DefaultRadius, KnowsTheBody) {
  EXPECT_NEAR(default_radius("LeftUpLeg", 0.4, 1.75), 0.079, 0.001);
  EXPECT_GT(default_radius("Spine1", 0.1, 1.75), default_radius("LeftForeArm", 0.1, 1.75));
  EXPECT_GT(default_radius("RightArm", 0.3, 1.75), default_radius("RightForeArm", 0.3, 1.75));
  EXPECT_LT(default_radius("LeftHandIndex1", 0.03, 1.75), 0.015);
  EXPECT_DOUBLE_EQ(default_radius("bone_17", 0.2, 2), 0.04);
}

/// Real takes, from Debian's assimp-testmodels.
class RealCapture : public testing::TestWithParam<const char*> {};

TEST_P(RealCapture, MakesAManifoldBodyThatMoves) {
  const std::filesystem::path path =
      std::filesystem::path("/usr/share/assimp/models/BVH") / GetParam();
  if (!std::filesystem::exists(path))
    GTEST_SKIP() << "NOT TESTED: " << path << " is missing; install assimp-testmodels";
  const Capture capture = read_bvh(path);
  CaptureBody style = whole(capture);
  style.y_up = true;
  style.scale = 1.7 / capture_height(capture, true);
  const SkinnedSurface body = make_capture_body(capture, style, path.string());
  EXPECT_LE(body.triangles.size(), max_body_triangles);
  Mesh mesh{std::vector<Vec3<double>>(body.skin.rest.size()), {}, body.triangles, {}, {}, {}};
  const SkinnedDeformation deformation(body.skin, {});
  std::vector<Vec3<double>> start;
  for (const double share : {0.0, 0.37, 1.0}) {
    deformation.positions(share * body.skin.duration, mesh.positions);
    check_mesh(mesh, {path.string(), "body", ""}, false);
    double low = 1e9;
    double high = -1e9;
    for (const Vec3<double>& x : mesh.positions) {
      low = std::min(low, x[2]);
      high = std::max(high, x[2]);
    }
    EXPECT_GT(high - low, 1.0) << "a body that stands";
    EXPECT_LT(high - low, 2.6);
    if (start.empty()) start = mesh.positions;
  }
  double farthest = 0;
  for (std::size_t v = 0; v < start.size(); ++v)
    farthest = std::max(farthest, length(mesh.positions[v] - start[v]));
  EXPECT_GT(farthest, 0.05);
  EXPECT_LT(farthest, 30);
}

INSTANTIATE_TEST_SUITE_P(Debian, RealCapture,
                         testing::Values("01_01.bvh", "01_03.bvh", "Boxing_Toes.bvh"),
                         [](const auto& param) {
                           std::string name = param.param;
                           return name.substr(0, name.find('.'));
                         });

}  // namespace
}  // namespace weft::io
