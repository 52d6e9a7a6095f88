#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

#include "host/render/close_up.hpp"
#include "weft/error.hpp"
#include "weft/shapes.hpp"

namespace weft::io {
namespace {

/// A sheet of side 1 about the origin with cells of side 0.025.
NamedMesh sheet() {
  NamedMesh mesh{"sheet", make_grid({1, 1}, {40, 40}, Diagonals::same)};
  mesh.mesh.material.clear();
  return mesh;
}

NamedMesh box(const Vec3<double>& centre, const Vec3<double>& size) {
  NamedMesh mesh{"box", make_box(size, {2, 2, 2})};
  for (auto& x : mesh.mesh.positions) x += centre;
  return mesh;
}

TEST(CloseUp, LooksAtThePlaceFromNearby) {
  const Vec3<double> place{0.2, -0.1, 0};
  const CloseUp view = close_up({sheet()}, {}, place);
  // Edges are 0.025 and 0.025 sqrt(2) long.
  EXPECT_NEAR(view.radius, 5 * 0.025 * (2 + std::sqrt(2.0)) / 3, 1e-9);
  EXPECT_FALSE(view.options.automatic_camera);
  const Vec3<double> centre = project_to_picture(view.options, place);
  EXPECT_NEAR(centre[0], view.options.width / 2.0, 1e-6);
  EXPECT_NEAR(centre[1], view.options.height / 2.0, 1e-6);
  // The radius fills half of the picture's height, up to perspective.
  const Vec3<double> aside =
      project_to_picture(view.options, place + Vec3<double>{0, 0, 1} * view.radius);
  EXPECT_LT(centre[1] - aside[1], view.options.height * 0.75);
  // It sees the sheet from a side, not its edge.
  EXPECT_GT(std::abs(view.options.eye[2]), 0.5 * length(view.options.eye - place));
  // Far triangles are gone; near ones are there.
  EXPECT_LT(view.cloths[0].mesh.triangles.size(), sheet().mesh.triangles.size() / 2);
  EXPECT_GT(view.cloths[0].mesh.triangles.size(), 50u);
}

TEST(CloseUp, LooksPastWhatHidesTheCloth) {
  const Vec3<double> place{0, 0, 0};
  const NamedMesh above = box({0, 0, 0.06}, {0.8, 0.8, 0.1});
  const NamedMesh below = box({0, 0, -0.06}, {0.8, 0.8, 0.1});
  EXPECT_LT(close_up({sheet()}, {above}, place).options.eye[2], 0);
  EXPECT_GT(close_up({sheet()}, {below}, place).options.eye[2], 0);
  EXPECT_FALSE(close_up({sheet()}, {above}, place).obstacles[0].mesh.triangles.empty());
  // Between two, one of them is drawn as wires, and so does not hide the place.
  PictureOptions small;
  small.width = 64;
  small.height = 48;
  small.samples = 16;
  const CloseUp both = close_up({sheet()}, {above, below}, place, small);
  const bool from_above = both.options.eye[2] > 0;
  EXPECT_TRUE(both.obstacles[from_above ? 0 : 1].mesh.triangles.empty());
  EXPECT_FALSE(both.obstacles[from_above ? 1 : 0].mesh.triangles.empty());
  EXPECT_GT(both.options.wires.size(), 12u);
  // In front of the cross in the middle there is cloth, if anything, and no grey.
  const Image image = render_picture(both.cloths, both.obstacles, both.options);
  const std::size_t beside = 3 * (std::size_t{20} * 64 + 37);
  EXPECT_GT(image.rgb[beside], image.rgb[beside + 2] + 30) << "the first cloth is red";
}

TEST(CloseUp, ReachesTheNearestCloth) {
  const CloseUp view = close_up({sheet()}, {box({0, 0, 3}, {0.2, 0.2, 0.2})}, {0, 0, 3});
  EXPECT_GT(view.radius, 3);
  EXPECT_FALSE(view.cloths[0].mesh.triangles.empty());
}

TEST(CloseUp, NeedsCloth) {
  NamedMesh broken = sheet();
  for (auto& x : broken.mesh.positions) x[0] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(close_up({broken}, {box({0, 0, 0}, {1, 1, 1})}, {0, 0, 0}), SceneError);
  EXPECT_THROW(close_up({}, {}, {0, 0, 0}), SceneError);
}

}  // namespace
}  // namespace weft::io
