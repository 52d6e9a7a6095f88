#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "host/render/picture.hpp"
#include "host/scene/camera.hpp"
#include "weft/error.hpp"

namespace weft::io {
namespace {

constexpr double degree = std::numbers::pi / 180;

NamedMesh blob(const Vec3<double>& center, double size) {
  Mesh mesh;
  for (int i = 0; i < 60; ++i) {
    const double a = 0.7 * i, z = i / 30.0 - 1, r = std::sqrt(1 - z * z);
    mesh.positions.push_back(center +
                             Vec3<double>{r * std::cos(a), r * std::sin(a), z} * (0.5 * size));
  }
  for (Index i = 0; i + 2 < 60; ++i) mesh.triangles.push_back({{i, i + 1, i + 2}});
  return {"blob", mesh};
}

TEST(PictureSubject, OneCameraSeesTheWholeMotion) {
  std::vector<NamedMesh> frames;
  for (int k = 0; k < 10; ++k) frames.push_back(blob({0.4 * k, 0.1 * k * k, 3.0 - 0.3 * k}, 1));
  PictureOptions options;
  options.subject.emplace();
  for (const NamedMesh& frame : frames) add_to_subject(*options.subject, {frame}, {});
  const PictureOptions first = frame_camera({frames.front()}, {}, options);
  const PictureOptions last = frame_camera({frames.back()}, {}, options);
  EXPECT_EQ(first.eye, last.eye);
  EXPECT_EQ(first.look_at, last.look_at);
  double x0 = 1e9, x1 = -1e9, y0 = 1e9, y1 = -1e9;
  for (const NamedMesh& frame : frames)
    for (const Vec3<double>& p : frame.mesh.positions) {
      const Vec3<double> pixel = project_to_picture(first, p);
      x0 = std::min(x0, pixel[0]), x1 = std::max(x1, pixel[0]);
      y0 = std::min(y0, pixel[1]), y1 = std::max(y1, pixel[1]);
    }
  EXPECT_GT(std::min(x0, y0), 0.03 * 960);
  EXPECT_LT(x1, 0.97 * 1280);
  EXPECT_LT(y1, 0.97 * 960);
  EXPECT_GT(std::max((x1 - x0) / 1280, (y1 - y0) / 960), 0.8) << "and is not too far away";
}

TEST(PictureSubject, KeepsTheLowestPointAndTheLargestCloth) {
  PictureSubject subject;
  add_to_subject(subject, {blob({0, 0, 1}, 1)}, {});
  const double lowest = subject.lowest;
  const double size = subject.cloth_size;
  add_to_subject(subject, {blob({0, 0, 5}, 0.5)}, {});
  EXPECT_EQ(subject.lowest, lowest);
  EXPECT_EQ(subject.cloth_size, size);
  add_to_subject(subject, {blob({0, 0, -2}, 2)}, {});
  EXPECT_LT(subject.lowest, -2.9);
  EXPECT_NEAR(subject.cloth_size, 2 * size, 1e-9);
}

Camera two_takes() {
  Camera camera;
  camera.keys = {{0, {4, 0, 1}, {0, 0, 0}, {0, 0, 1}, 40 * degree, false},
                 {2, {0, 4, 1}, {0, 0, 1}, {0, 0, 1}, 60 * degree, false},
                 {3, {-4, 0, 2}, {0, 0, 0}, {0, 0, 1}, 30 * degree, true},
                 {5, {-4, 2, 2}, {0, 0, 0}, {0, 0, 1}, 30 * degree, false}};
  return camera;
}

TEST(SceneCamera, PassesThroughItsKeysAndEasesBetweenThem) {
  const Camera camera = two_takes();
  for (const CameraKey& key : camera.keys) {
    EXPECT_EQ(camera_at(camera, key.time).position, key.position) << key.time;
    EXPECT_EQ(camera_at(camera, key.time).look_at, key.look_at) << key.time;
    EXPECT_EQ(camera_at(camera, key.time).field_of_view, key.field_of_view) << key.time;
  }
  // Two keys of a take: rest at both ends, the mean in the middle.
  const CameraKey middle = camera_at(camera, 1);
  EXPECT_NEAR(length(middle.position - Vec3<double>{2, 2, 1}), 0, 1e-12);
  EXPECT_NEAR(middle.look_at[2], 0.5, 1e-12);
  EXPECT_NEAR(middle.field_of_view, 50 * degree, 1e-12);
  EXPECT_NEAR(length(camera_at(camera, 1e-4).position - camera.keys[0].position), 0, 1e-6);
}

TEST(SceneCamera, RestsOutsideItsKeys) {
  const Camera camera = two_takes();
  EXPECT_EQ(camera_at(camera, -7).position, camera.keys.front().position);
  EXPECT_EQ(camera_at(camera, 70).position, camera.keys.back().position);
}

TEST(SceneCamera, JumpsAtACut) {
  const Camera camera = two_takes();
  EXPECT_EQ(camera_at(camera, 2.5).position, camera.keys[1].position);
  EXPECT_EQ(camera_at(camera, 3 - 1e-6).position, camera.keys[1].position);
  EXPECT_EQ(camera_at(camera, 3).position, camera.keys[2].position);
  // 3 s as a sum of frames of 1/30 s, just below.
  double sum = 0;
  for (int k = 0; k < 90; ++k) sum += 1.0 / 30;
  EXPECT_EQ(camera_at(camera, sum).position, camera.keys[2].position) << sum - 3;
}

TEST(SceneCamera, SlopesAreCatmullRomWithinATake) {
  Camera camera;
  // Even motion: at the middle key the speed is that of the chord.
  camera.keys = {{0, {0, 0, 5}, {9, 0, 0}}, {1, {1, 0, 5}, {9, 0, 0}}, {2, {2, 0, 5}, {9, 0, 0}}};
  const double d = 1e-5;
  const double slope =
      (camera_at(camera, 1 + d).position[0] - camera_at(camera, 1 - d).position[0]) / (2 * d);
  // The two sides' second derivatives are 2 and -2, which adds d.
  EXPECT_NEAR(slope, 1 + d, 1e-9);
  camera.keys[2].jump = true;
  EXPECT_NEAR((1 - camera_at(camera, 1 - d).position[0]) / d, 0, 1e-3) << "the end of a take";
}

TEST(SceneCamera, SetsTheViewOfAPicture) {
  Camera camera;
  camera.width = 400, camera.height = 200;
  EXPECT_TRUE(with_camera({}, camera, 0).automatic_camera);
  camera.keys = {{0, {0, -2, 0}, {0, 0, 0}, {0, 0, 1}, 90 * degree, false}};
  const PictureOptions options = with_camera({}, camera, 12);
  EXPECT_FALSE(options.automatic_camera);
  // At depth 2 the half height, 100 pixels, spans 2 m: 50 pixels a metre.
  const Vec3<double> pixel = project_to_picture(options, {0.5, 0, 1});
  EXPECT_NEAR(pixel[0], 200 + 25, 1e-9);
  EXPECT_NEAR(pixel[1], 100 - 50, 1e-9);
  EXPECT_NEAR(pixel[2], 2, 1e-12);
  const PictureOptions plain = with_camera({}, Camera{}, 0);
  EXPECT_EQ(plain.width, PictureOptions{}.width);
}

}  // namespace
}  // namespace weft::io
