#include "host/render/picture.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "weft/error.hpp"

namespace {

using weft::Index;
using weft::Mesh;
using weft::SceneError;
using weft::Vec3;
using weft::io::frame_camera;
using weft::io::Image;
using weft::io::NamedMesh;
using weft::io::PictureOptions;
using weft::io::project_to_picture;
using weft::io::render_picture;
using weft::io::upright;

using Meshes = std::vector<NamedMesh>;

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

/// Grid of n x n cells over the unit square, moved by `place`(s, t).
template <class F>
Mesh sheet(Index n, F&& place) {
  Mesh mesh;
  for (Index j = 0; j <= n; ++j)
    for (Index i = 0; i <= n; ++i) mesh.positions.push_back(place(i * 1.0 / n, j * 1.0 / n));
  for (Index j = 0; j < n; ++j)
    for (Index i = 0; i < n; ++i) {
      const Index a = j * (n + 1) + i, b = a + n + 1;
      mesh.triangles.push_back({{a, a + 1, b + 1}});
      mesh.triangles.push_back({{a, b + 1, b}});
    }
  return mesh;
}

Mesh wavy_sheet() {
  return sheet(24, [](double s, double t) {
    return Vec3<double>{s, t, 0.3 + 0.08 * std::sin(20 * s)};
  });
}

/// Level square, its front up.
Mesh level_square(double half, double z) {
  return sheet(1, [&](double s, double t) {
    return Vec3<double>{half * (2 * s - 1), half * (2 * t - 1), z};
  });
}

PictureOptions small_picture() {
  PictureOptions options;
  options.width = 120;
  options.height = 90;
  options.samples = 4;
  return options;
}

/// Camera that looks straight down from height `z`, +x to the right, +y to the top.
PictureOptions from_above(double z) {
  PictureOptions options = small_picture();
  options.automatic_camera = false;
  options.eye = {0, 0, z};
  options.look_at = {0, 0, 0};
  options.up = {0, 1, 0};
  return options;
}

double channel(const Image& image, int x, int y, int k) {
  return image.rgb[3 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(image.width) +
                        static_cast<std::size_t>(x)) +
                   static_cast<std::size_t>(k)];
}

double brightness(const Image& image, int x, int y) {
  return (channel(image, x, y, 0) + channel(image, x, y, 1) + channel(image, x, y, 2)) / 3;
}

template <class F>
std::string message_of(F&& f) {
  try {
    f();
  } catch (const SceneError& error) {
    return error.what();
  }
  return "nothing was thrown";
}

TEST(Picture, SameBytesForAnyNumberOfThreads) {
  const Meshes cloths{{"sheet", wavy_sheet()}}, obstacles{{"block", level_square(0.3, 0.1)}};
  PictureOptions options = small_picture();
  options.threads = 1;
  const Image one = render_picture(cloths, obstacles, options);
  ASSERT_EQ(one.rgb.size(), std::size_t{3 * 120 * 90});
  for (const int threads : {1, 2, 5, 0}) {
    options.threads = threads;
    EXPECT_EQ(render_picture(cloths, obstacles, options).rgb, one.rgb) << threads << " threads";
  }
}

TEST(Picture, AutomaticCameraShowsEveryVertexAndIsNotTooFar) {
  // Deep, wide and tall shapes: each lets another side of the picture decide.
  const std::vector<Vec3<double>> sizes{{1, 1, 1}, {9, 0.2, 0.1}, {0.1, 7, 0.2}, {0.1, 0.2, 4}};
  for (const Vec3<double>& size : sizes)
    for (const double azimuth : {-60.0, 0.0, 140.0})
      for (const double elevation : {-10.0, 22.0, 80.0})
        for (const int width : {60, 200}) {
          const Mesh mesh = sheet(12, [&](double s, double t) {
            return Vec3<double>{100 + size[0] * s, size[1] * t, size[2] * std::sin(9 * s + 4 * t)};
          });
          PictureOptions options = small_picture();
          options.width = width;
          options.azimuth_degrees = azimuth;
          options.elevation_degrees = elevation;
          const PictureOptions framed = frame_camera({{"sheet", mesh}}, {}, options);
          ASSERT_FALSE(framed.automatic_camera);
          double x0 = 1e9, x1 = -1e9, y0 = 1e9, y1 = -1e9;
          for (const Vec3<double>& p : mesh.positions) {
            const Vec3<double> pixel = project_to_picture(framed, p);
            ASSERT_GT(pixel[2], 0);
            x0 = std::min(x0, pixel[0]), x1 = std::max(x1, pixel[0]);
            y0 = std::min(y0, pixel[1]), y1 = std::max(y1, pixel[1]);
          }
          const double w = options.width, h = options.height;
          EXPECT_GT(x0, 0.06 * w);
          EXPECT_LT(x1, 0.94 * w);
          EXPECT_GT(y0, 0.06 * h);
          EXPECT_LT(y1, 0.94 * h);
          EXPECT_GT(std::max((x1 - x0) / w, (y1 - y0) / h), 0.8) << "the subject is too small";
          EXPECT_NEAR(x0 + x1, w, 1e-3 * w) << "not in the middle";
          EXPECT_NEAR(y0 + y1, h, 1e-3 * h) << "not in the middle";
        }
}

TEST(Picture, CameraLooksSlightlyDownFromTheSideThatIsAsked) {
  PictureOptions options = small_picture();
  options.azimuth_degrees = 90;
  options.elevation_degrees = 30;
  const PictureOptions framed = frame_camera({{"sheet", wavy_sheet()}}, {}, options);
  const Vec3<double> back = framed.eye - framed.look_at;
  EXPECT_NEAR(back[0], 0, 1e-9);
  EXPECT_GT(back[1], 0);
  EXPECT_NEAR(back[2] / length(back), 0.5, 1e-9);
}

TEST(Picture, UpIsWhereGravityDoesNotPull) {
  const Mesh mesh = wavy_sheet();
  Mesh turned = mesh;  // as a program with y up has it
  for (Vec3<double>& x : turned.positions) x = {x[0], x[2], -x[1]};
  const PictureOptions with_z =
      frame_camera({{"sheet", mesh}}, {}, upright(small_picture(), {0.1, 0, -9.81}));
  const PictureOptions with_y =
      frame_camera({{"sheet", turned}}, {}, upright(small_picture(), {0, -9.81, 0}));
  EXPECT_EQ(with_z.up, (Vec3<double>{0, 0, 1}));
  EXPECT_EQ(with_y.up, (Vec3<double>{0, 1, 0}));
  for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
    const Vec3<double> a = project_to_picture(with_z, mesh.positions[v]);
    const Vec3<double> b = project_to_picture(with_y, turned.positions[v]);
    EXPECT_LT(length(a - b), 1e-6) << v;
  }
  EXPECT_EQ(upright({}, {0, 0, 0}).up, (Vec3<double>{0, 0, 1}));
  EXPECT_EQ(upright({}, {0, 0, 3}).up, (Vec3<double>{0, 0, -1}));
}

TEST(Picture, WideFloorsAreNotFramedButLargeBodiesAre) {
  const Meshes cloths{{"sheet", level_square(1, 1)}};
  const PictureOptions options = small_picture();
  const Vec3<double> alone = frame_camera(cloths, {}, options).eye;
  const auto eye = [&](const std::string& name, double half) {
    return frame_camera(cloths, {{name, level_square(half, 0)}}, options).eye;
  };
  EXPECT_EQ(eye("the_floor", 2), alone);
  EXPECT_EQ(eye("Ground plane", 2), alone);
  EXPECT_EQ(eye("wall", 3), alone);
  EXPECT_FALSE(eye("airplane", 2) == alone) << "a word that only ends like a floor";
  EXPECT_FALSE(eye("floor", 1) == alone) << "as small as the cloth";
}

TEST(Picture, ProjectionHasItsClosedForm) {
  PictureOptions options = from_above(2);
  options.vertical_field_of_view_degrees = 90;
  // At depth 2 the half height, 45 pixels, spans 2 m.
  const Vec3<double> pixel = project_to_picture(options, {1, 0.5, 0});
  EXPECT_NEAR(pixel[0], 60 + 22.5, 1e-9);
  EXPECT_NEAR(pixel[1], 45 - 11.25, 1e-9);
  EXPECT_NEAR(pixel[2], 2, 1e-12);
}

TEST(Picture, RaysAgreeWithTheProjection) {
  const Vec3<double> center{0.4, -0.3, 0};
  Mesh patch = level_square(0.08, 0);
  for (Vec3<double>& p : patch.positions) p += center;
  PictureOptions options = from_above(3);
  options.ground = false;
  const Image with = render_picture({{"patch", patch}}, {}, options);
  for (Vec3<double>& p : patch.positions) p += Vec3<double>{50, 0, 0};
  const Image without = render_picture({{"patch", patch}}, {}, options);
  double count = 0, x_sum = 0, y_sum = 0;
  for (int y = 0; y < with.height; ++y)
    for (int x = 0; x < with.width; ++x)
      if (std::abs(brightness(with, x, y) - brightness(without, x, y)) > 8) {
        ++count;
        x_sum += x + 0.5;
        y_sum += y + 0.5;
      }
  const Vec3<double> expected = project_to_picture(options, center);
  const double side = 0.16 * 45 / (3 * std::tan(17.5 * 3.14159265358979 / 180));  // pixels
  ASSERT_GT(count, 0);
  EXPECT_NEAR(x_sum / count, expected[0], 0.6);
  EXPECT_NEAR(y_sum / count, expected[1], 0.6);
  EXPECT_NEAR(std::sqrt(count), side, 2);
}

TEST(Picture, FoldsShowAsLightAndShade) {
  const Meshes cloths{{"sheet", wavy_sheet()}};
  PictureOptions options = frame_camera(cloths, {}, small_picture());
  const Image image = render_picture(cloths, {}, options);
  double darkest = 255, brightest = 0;
  for (const Vec3<double>& p : cloths[0].mesh.positions) {
    if (p[0] < 0.1 || p[0] > 0.9 || p[1] < 0.1 || p[1] > 0.9) continue;
    const Vec3<double> pixel = project_to_picture(options, p);
    const double b = brightness(image, static_cast<int>(pixel[0]), static_cast<int>(pixel[1]));
    darkest = std::min(darkest, b);
    brightest = std::max(brightest, b);
  }
  EXPECT_GT(brightest - darkest, 50);
}

TEST(Picture, EachClothHasItsOwnHueAndItsBackIsPaler) {
  Meshes cloths;
  for (int i = 0; i < 3; ++i) {
    cloths.push_back({"square", level_square(0.2, 0)});
    for (Vec3<double>& p : cloths.back().mesh.positions) p[0] += 0.6 * (i - 1);
  }
  PictureOptions options = from_above(2.5);
  const auto redness = [](const Image& image, const Vec3<double>& p) {
    const int x = static_cast<int>(p[0]), y = static_cast<int>(p[1]);
    return channel(image, x, y, 0) / channel(image, x, y, 2);
  };
  const auto at = [&](int i) { return project_to_picture(options, {0.6 * (i - 1), 0, 0}); };
  const Image front = render_picture(cloths, {}, options);
  EXPECT_GT(redness(front, at(0)), 1.3);
  EXPECT_LT(redness(front, at(1)), 0.8);
  EXPECT_GT(redness(front, at(2)), 1.3);
  for (NamedMesh& m : cloths)
    for (weft::Tri& t : m.mesh.triangles) std::swap(t.v[0], t.v[1]);
  const Image back = render_picture(cloths, {}, options);
  for (int i = 0; i < 3; ++i) {
    const Vec3<double> p = at(i);
    EXPECT_GT(brightness(back, static_cast<int>(p[0]), static_cast<int>(p[1])),
              brightness(front, static_cast<int>(p[0]), static_cast<int>(p[1])) + 15);
  }
}

TEST(Picture, ObstaclesAreGrey) {
  const PictureOptions options = from_above(3);
  const Image image = render_picture({}, {{"block", level_square(0.5, 0)}}, options);
  EXPECT_NEAR(channel(image, 60, 45, 0), channel(image, 60, 45, 2), 25);
}

TEST(Picture, GroundAndFloorsCatchShadows) {
  const Meshes cloths{{"square", level_square(0.5, 0)}}, floor{{"floor", level_square(20, -0.8)}};
  PictureOptions options = from_above(3);
  options.ground_height = -0.8;
  const Image ground_image = render_picture(cloths, {}, options);
  const Image floor_image = render_picture(cloths, floor, options);
  options.ground = false;
  const Image backdrop = render_picture(cloths, {}, options);
  double ground_shadow = 0, floor_shadow = 0, difference = 0;
  for (int y = 0; y < backdrop.height; ++y)
    for (int x = 0; x < backdrop.width; ++x) {
      const double b = brightness(backdrop, x, y);
      const double ground = brightness(ground_image, x, y), level = brightness(floor_image, x, y);
      ground_shadow = std::max(ground_shadow, b - ground);
      floor_shadow = std::max(floor_shadow, b - level);
      difference += std::abs(ground - level) / (backdrop.width * backdrop.height);
    }
  EXPECT_GT(ground_shadow, 30);
  EXPECT_GT(floor_shadow, 30);
  // Where no shadow falls, neither shows: the floor's colour and border least of all.
  EXPECT_NEAR(brightness(floor_image, 2, 86), brightness(backdrop, 2, 86), 1);
  EXPECT_NEAR(brightness(ground_image, 2, 86), brightness(backdrop, 2, 86), 1);
  EXPECT_LT(difference, 0.5) << "floor and ground are at the same height";
}

TEST(Picture, BrokenTrianglesAreLeftOut) {
  Mesh whole = wavy_sheet();
  const Image expected = render_picture({{"sheet", whole}}, {}, small_picture());
  Mesh broken = whole;
  const Index first = static_cast<Index>(broken.positions.size());
  broken.positions.push_back({nan, 0, 0});
  broken.positions.push_back({0, std::numeric_limits<double>::infinity(), 0});
  broken.positions.push_back({0, 0, -1e200});
  for (Index k = 0; k < 3; ++k) broken.triangles.push_back({{0, 1, first + k}});
  EXPECT_EQ(render_picture({{"sheet", broken}}, {}, small_picture()).rgb, expected.rgb);
}

TEST(Picture, EmptyFramesAreRefused) {
  EXPECT_THROW(render_picture({}, {}, small_picture()), SceneError);
  EXPECT_THROW(render_picture({{"none", Mesh{}}}, {}, small_picture()), SceneError);
  EXPECT_THROW(frame_camera({}, {}, small_picture()), SceneError);
  Mesh broken = level_square(1, 0);
  for (Vec3<double>& p : broken.positions) p[2] = nan;
  EXPECT_THROW(render_picture({{"broken", broken}}, {}, small_picture()), SceneError);
}

TEST(Picture, TrianglesWithMissingVerticesAreRefusedByName) {
  for (const Index bad : {-1, 4}) {
    Mesh mesh = level_square(1, 0);
    mesh.triangles[1].v[2] = bad;
    const std::string message = message_of([&] {
      render_picture({}, {{"table", mesh}}, small_picture());
    });
    EXPECT_NE(message.find("table"), std::string::npos) << message;
    EXPECT_NE(message.find(std::to_string(bad)), std::string::npos) << message;
  }
}

TEST(Picture, OptionsOutOfRangeAreRefusedByName) {
  const auto expect_refused = [](const std::string& field, auto&& change) {
    PictureOptions options = small_picture();
    change(options);
    const std::string message = message_of([&] {
      render_picture({{"sheet", wavy_sheet()}}, {}, options);
    });
    EXPECT_NE(message.find("picture." + field), std::string::npos) << message;
  };
  expect_refused("width", [](PictureOptions& o) { o.width = 0; });
  expect_refused("height", [](PictureOptions& o) { o.height = 20000; });
  expect_refused("samples", [](PictureOptions& o) { o.samples = 0; });
  expect_refused("threads", [](PictureOptions& o) { o.threads = -1; });
  expect_refused("vertical_field_of_view_degrees",
                 [](PictureOptions& o) { o.vertical_field_of_view_degrees = nan; });
  expect_refused("elevation_degrees", [](PictureOptions& o) { o.elevation_degrees = 90; });
  expect_refused("ground_height", [](PictureOptions& o) { o.ground_height = nan; });
  expect_refused("eye", [](PictureOptions& o) { o.automatic_camera = false; });
  expect_refused("eye", [](PictureOptions& o) {
    o.automatic_camera = false;
    o.eye = {0, 0, 1};  // looks along up
  });
  expect_refused("eye", [](PictureOptions& o) {
    o.automatic_camera = false;
    o.eye = {nan, 0, 1};
  });
  expect_refused("eye", [](PictureOptions& o) {
    o.automatic_camera = false;
    o.eye = {1e40, 0, 0};
  });
  EXPECT_THROW(project_to_picture(small_picture(), {0, 0, 0}), SceneError);
}

/// Exploded, collapsed and far away frames are what a picture is looked at for.
TEST(Picture, ExtremeFramesStillGiveAPicture) {
  const PictureOptions options = small_picture();
  const std::size_t size = 3 * 120 * 90;
  EXPECT_EQ(render_picture({{"tiny", level_square(1e-12, 0)}}, {}, options).rgb.size(), size);
  EXPECT_EQ(render_picture({{"huge", level_square(1e60, 0)}}, {}, options).rgb.size(), size);
  EXPECT_EQ(render_picture({{"point", level_square(0, 5)}}, {}, options).rgb.size(), size);
  Mesh exploded = wavy_sheet();
  exploded.positions[7] = {1e30, -1e30, 3};
  EXPECT_EQ(render_picture({{"exploded", exploded}}, {}, options).rgb.size(), size);
  const Meshes far{{"wall", level_square(1e40, -1)}};
  EXPECT_EQ(render_picture({{"sheet", wavy_sheet()}}, far, options).rgb.size(), size);
  Mesh away = level_square(1, 0);
  for (Vec3<double>& p : away.positions) p += Vec3<double>{1e9, -1e9, 1e9};
  EXPECT_EQ(render_picture({{"away", away}}, {}, options).rgb.size(), size);
}

}  // namespace
