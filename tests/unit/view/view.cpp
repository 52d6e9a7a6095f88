// What a camera makes of sizing: each equation of Koh, Narain and O'Brien 2015 in a case that can
// be worked out by hand.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <vector>

#include "host/geometry/tensor.hpp"
#include "host/view/compensation.hpp"
#include "host/view/occlusion.hpp"
#include "host/view/view_factor.hpp"
#include "host/view/view_sizing.hpp"
#include "weft/shapes.hpp"

namespace weft::test {
namespace {

void expect_near(const Mat2<double>& a, const Mat2<double>& b, double tolerance) {
  for (int k = 0; k < 4; ++k) EXPECT_NEAR(a.e[k], b.e[k], tolerance) << "entry " << k;
}

Mat2<double> diagonal(double a, double b) {
  return {{a, 0, 0, b}};
}

/// Looks along +y from (0, -5, 0), as wide as high, 45 degrees to each side.
CameraKey key_towards(const Vec3<double>& look_at, double time = 0, bool jump = false) {
  CameraKey key;
  key.time = time;
  key.position = {0, -5, 0};
  key.look_at = look_at;
  key.field_of_view = std::numbers::pi / 2;
  key.jump = jump;
  return key;
}

ViewCamera ahead() {
  return {key_towards({0, 0, 0}), 100, 100};
}

// ---- frustum

TEST(ViewFrustum, DistanceOfPoints) {
  const Frustum f{1, 1};
  EXPECT_EQ(frustum_distance(f, Vec3<double>{0, 0, 5}), 0);
  EXPECT_EQ(frustum_distance(f, Vec3<double>{5, -5, 5}), 0) << "on an edge";
  EXPECT_NEAR(frustum_distance(f, Vec3<double>{3, 0, 1}), std::sqrt(2.0), 1e-15) << "a side";
  EXPECT_NEAR(frustum_distance(f, Vec3<double>{0, -3, 1}), std::sqrt(2.0), 1e-15);
  EXPECT_NEAR(frustum_distance(f, Vec3<double>{3, 3, 1}), std::sqrt(8.0 / 3), 1e-14) << "an edge";
  EXPECT_NEAR(frustum_distance(f, Vec3<double>{0, 0, -2}), 2, 1e-15) << "the eye";
  EXPECT_NEAR(frustum_distance({2, 1}, Vec3<double>{6, 0, 0.5}), 5 / std::sqrt(5.0), 1e-14);
}

TEST(ViewFrustum, DistanceOfTriangles) {
  const Frustum f{1, 1};
  const Vec3<double> across[3] = {{-10, 0.1, 1}, {10, 0.1, 1}, {0, 20, 1}};
  EXPECT_EQ(frustum_distance(f, across), 0) << "no corner in view, but the middle";
  const Vec3<double> beside[3] = {{4, -5, 1}, {4, 5, 1}, {9, 0, 1}};
  EXPECT_NEAR(frustum_distance(f, beside), 3 / std::sqrt(2.0), 1e-14) << "an edge and a side";
  // An edge that passes the frustum's edge through (1, 1, 1) at 0.6.
  const Vec3<double> out = (1 / std::sqrt(6.0)) * Vec3<double>{1, 1, -2};
  const Vec3<double> along = (1 / std::sqrt(2.0)) * Vec3<double>{1, -1, 0};
  const Vec3<double> p = Vec3<double>{2, 2, 2} + 0.6 * out;
  const Vec3<double> corner[3] = {p - 5 * along, p + 5 * along, p + 3 * out};
  EXPECT_NEAR(frustum_distance(f, corner), 0.6, 1e-14);
  const Vec3<double> behind[3] = {{-9, -9, -1.5}, {9, -9, -1.5}, {0, 20, -1.5}};
  EXPECT_NEAR(frustum_distance(f, behind), 1.5, 1e-14) << "a face and the eye";
}

TEST(ViewFrustum, CameraSeesItsPicture) {
  const ViewCamera camera = ahead();
  const Vec3<double> seen = camera.seen({1, -1, 2});
  EXPECT_LT(length(seen - Vec3<double>{1, 2, 4}), 1e-15);
  const Vec2<double> pixel = camera.pixel(seen);
  EXPECT_NEAR(pixel[0], 50 + 50 * 0.25, 1e-13);
  EXPECT_NEAR(pixel[1], 50 - 50 * 0.5, 1e-13);
  EXPECT_NEAR(camera.near(), 0.05, 1e-15);
}

// ---- equation (3)

TEST(ViewFactor, FallsOverTheMargin) {
  const ViewSettings s;
  EXPECT_EQ(smoothed_factor(1, 0, s), 1);
  EXPECT_EQ(smoothed_factor(0.2, 0, s), 0.2);
  EXPECT_NEAR(smoothed_factor(1, 0.1, s), 1 - 0.25 * 0.99, 1e-15);
  EXPECT_NEAR(smoothed_factor(0.2, 0.1, s), 0.2 - 0.25 * 0.19, 1e-15);
  EXPECT_EQ(smoothed_factor(1, 0.4, s), 0.01);
  EXPECT_EQ(smoothed_factor(0.2, 7, s), 0.01);
  ViewSettings sharp;
  sharp.margin = 0;
  EXPECT_EQ(smoothed_factor(1, 0, sharp), 1);
  EXPECT_EQ(smoothed_factor(1, 1e-9, sharp), 0.01);
}

/// Squares in the x-z plane, front towards -y, at these x.
struct Strip {
  ViewPlaces places;
  std::vector<Tri> triangles;

  void add(double x, double y, double size, bool front = true) {
    const auto v = static_cast<Index>(places.cloth.size());
    for (const auto& [dx, dz] : {std::pair{0.0, 0.0}, {1.0, 0.0}, {1.0, 1.0}, {0.0, 1.0}})
      places.cloth.push_back({x + dx * size, y, (dz - 0.5) * size});
    triangles.push_back(front ? Tri{{v, v + 1, v + 2}} : Tri{{v, v + 2, v + 1}});
    triangles.push_back(front ? Tri{{v, v + 2, v + 3}} : Tri{{v, v + 3, v + 2}});
  }
  ViewSurface surface() const { return make_view_surface(triangles, {}); }
};

TEST(ViewFactor, FrontsBacksAndTheDistanceFromTheFrustum) {
  Strip strip;
  strip.add(0, 0, 1);
  strip.add(0, 0, 1, false);
  // The frustum's right side is x = y + 5; at y = 0 it is 0.2 from x = 5 + 0.2 sqrt(2).
  strip.add(5 + 0.2 * std::sqrt(2.0), 0, 1);
  strip.add(100, 0, 1);
  ViewSettings s;
  const auto factors = view_factors(ahead(), strip.surface(), strip.places, s);
  EXPECT_EQ(factors[0], 1);
  EXPECT_EQ(factors[2], 0.2);
  EXPECT_NEAR(factors[5], 1 - 0.5 * 0.99, 1e-12) << "the triangle with the whole left side";
  EXPECT_EQ(factors[6], 0.01);
  s.two_sided = true;
  EXPECT_EQ(view_factors(ahead(), strip.surface(), strip.places, s)[2], 1);
  const auto out = out_of_frustum(ahead(), strip.surface(), strip.places);
  EXPECT_EQ(out, (std::vector<unsigned char>{0, 0, 0, 0, 1, 1, 1, 1}));
}

// ---- equation (4)

TEST(ViewAnticipation, WeightFallsToZero) {
  EXPECT_EQ(anticipation_weight(0, 0.2), 1);
  EXPECT_NEAR(anticipation_weight(0.08, 0.2), 0.6, 1e-15);
  EXPECT_EQ(anticipation_weight(0.2, 0.2), 0);
  EXPECT_EQ(anticipation_weight(0, 0), 1);
  EXPECT_EQ(anticipation_weight(0.01, 0), 0);
}

TEST(ViewAnticipation, RisesTowardsACut) {
  Strip strip;
  strip.add(-0.5, 0, 1);
  Camera camera;
  camera.keys = {key_towards({0, -9, 0}), key_towards({0, 0, 0}, 1, true)};  // away, then towards
  const ViewSettings s;
  const auto factor_at = [&](double time) {
    return look(
               view_instants(camera, s, 25, time), strip.surface(),
               [&](double) { return strip.places; }, s)
        .factor(0);
  };
  EXPECT_NEAR(factor_at(0.5), 0.01, 1e-15);
  EXPECT_NEAR(factor_at(0.8), 0.01, 1e-15);
  EXPECT_NEAR(factor_at(0.85), 1 - 0.15 / 0.2, 1e-12) << "between frames";
  EXPECT_NEAR(factor_at(0.92), 0.6, 1e-12);
  EXPECT_NEAR(factor_at(0.96), 0.8, 1e-12);
  EXPECT_EQ(factor_at(1), 1);
  ViewSettings blind = s;
  blind.anticipation = 0;
  EXPECT_EQ(view_instants(camera, blind, 25, 0.96).size(), 1u);
}

TEST(ViewAnticipation, ACameraAtRestIsOneInstant) {
  Camera camera;
  camera.keys = {key_towards({0, 0, 0})};
  EXPECT_EQ(view_instants(camera, {}, 25, 3).size(), 1u);
  camera.keys = {key_towards({0, 0, 0}), key_towards({1, 0, 0}, 2)};
  EXPECT_EQ(view_instants(camera, {}, 25, 1).size(), 5u) << "each frame of the window but its end";
}

// ---- equations (5) to (8)

/// S^-T M S^-1, eigenvalues cut, S^T ... S, as printed.
Mat2<double> by_inversion(const Mat2<double>& m, const Mat2<double>& s, double pixel_min) {
  const double det = s(0, 0) * s(1, 1) - s(0, 1) * s(1, 0);
  const Mat2<double> inverse{{s(1, 1) / det, -s(0, 1) / det, -s(1, 0) / det, s(0, 0) / det}};
  Eigen2 e = eigen(transpose(inverse) * m * inverse);
  for (double& value : e.value) value = std::min(value, 1 / (pixel_min * pixel_min));
  return transpose(s) * compose(e) * s;
}

TEST(ViewPixels, CutsWhatIsFinerThanItsPixels) {
  // Edges of 0.01 m are 2 pixels, those of 0.1 m 5: the first become 4 pixels, 0.02 m.
  expect_near(pixel_bounded(diagonal(1e4, 100), diagonal(200, 50), 4), diagonal(2500, 100), 1e-9);
  expect_near(pixel_bounded(diagonal(1e4, 100), diagonal(200, 50), 0), diagonal(1e4, 100), 0);
}

TEST(ViewPixels, IsThePrintedFormula) {
  const Mat2<double> m{{900, 200, 200, 400}};
  for (const Mat2<double>& s : {Mat2<double>{{30, 80, -60, 20}}, Mat2<double>{{200, 10, 0, 5}},
                                Mat2<double>{{-90, 40, 70, 300}}})
    expect_near(pixel_bounded(m, s, 4), by_inversion(m, s, 4), 1e-9);
}

TEST(ViewPixels, AViewAlongTheClothNeedsNoInverse) {
  expect_near(pixel_bounded(diagonal(1e4, 1e4), diagonal(100, 0), 4), diagonal(625, 0), 1e-9);
  expect_near(pixel_bounded(diagonal(1e4, 1e4), diagonal(0, 0), 4), diagonal(0, 0), 1e-9);
}

TEST(ViewPixels, JacobianOfASlantedTriangle) {
  const ViewCamera camera = ahead();
  // Upright, 5 m away: 10 pixels a metre; pictures count from the top.
  const Vec2<double> u[3] = {{0, 0}, {0.01, 0}, {0, 0.01}};
  const auto pixels_of = [&](const Vec3<double>& up, Vec2<double> pixels[3]) {
    for (int j = 0; j < 3; ++j)
      pixels[j] = camera.pixel(camera.seen(u[j][0] * Vec3<double>{1, 0, 0} + u[j][1] * up));
  };
  Vec2<double> pixels[3];
  pixels_of({0, 0, 1}, pixels);
  expect_near(screen_jacobian(pixels, u), diagonal(10, -10), 1e-10);
  // Leaning back by 60 degrees: half as high, and a little less for being farther away.
  pixels_of({0, std::sqrt(0.75), 0.5}, pixels);
  expect_near(screen_jacobian(pixels, u),
              diagonal(10, -50 * 0.005 / (5 + 0.01 * std::sqrt(0.75)) / 0.01), 1e-10);
}

ViewField field_of(const Strip& strip, const ViewSettings& s) {
  Camera camera;
  camera.width = camera.height = 100;
  camera.keys = {key_towards({0, 0, 0})};
  return look(
      view_instants(camera, s, 25, 0), strip.surface(), [&](double) { return strip.places; }, s);
}

TEST(ViewSizing, ScalesBoundsAndClamps) {
  Remeshing sizes;
  sizes.size_min = 0.01;
  sizes.size_max = 2;
  sizes.aspect_min = 0;
  const Vec2<double> u[3] = {{0, 0}, {1, 0}, {1, 1}};
  Strip strip;
  strip.add(0, 0, 1, false);
  ViewSettings s;
  s.pixel_min = 0;
  const Tri tri = strip.triangles[0];
  const Vec2<double> back[3] = {u[0], u[2], u[1]};
  // Equation (2) with a factor of 0.2.
  expect_near(view_tensor(field_of(strip, s), 0, tri, back, diagonal(100, 400), sizes),
              diagonal(4, 16), 1e-12);
  // 10 pixels a metre: no edge shorter than 0.4 m.
  s.pixel_min = 4;
  expect_near(view_tensor(field_of(strip, s), 0, tri, back, diagonal(100, 400), sizes),
              diagonal(4, 1 / 0.16), 1e-12);
  s.pixel_min = 40;
  expect_near(view_tensor(field_of(strip, s), 0, tri, back, diagonal(100, 400), sizes),
              diagonal(0.25, 0.25), 1e-12);
}

TEST(ViewSizing, WhatCrossesTheNearPlaneHasNoPixels) {
  Remeshing sizes;
  sizes.size_min = 0.01;
  sizes.size_max = 100;
  sizes.aspect_min = 0;
  Strip strip;
  strip.add(-0.5, 0, 1);
  strip.places.cloth[0] = {-0.5, -5.5, -0.5};  // behind the eye
  ViewSettings s;
  s.pixel_min = 50;
  const Vec2<double> u[3] = {{0, 0}, {1, 0}, {1, 1}};
  const Mat2<double> tensor = diagonal(100, 400);
  s.two_sided = true;
  expect_near(view_tensor(field_of(strip, s), 0, strip.triangles[0], u, tensor, sizes), tensor,
              1e-10);
}

// ---- section 3.3

TEST(ViewTransfer, TheDarkSideOfASilhouetteGetsTheMean) {
  const Mesh strip = make_grid({3, 1}, {3, 1}, Diagonals::same);
  const ViewSurface surface = make_view_surface(strip.triangles, {});
  // Neighbours in a row, however they are numbered.
  std::vector<Index> row{0};
  for (const Tri& t : strip.triangles) {
    int open = 0;
    for (const Index n : surface.across[static_cast<std::size_t>(&t - strip.triangles.data())])
      open += n < 0;
    if (open == 2) row[0] = static_cast<Index>(&t - strip.triangles.data());
  }
  while (row.size() < 6)
    for (const Index n : surface.across[static_cast<std::size_t>(row.back())])
      if (n >= 0 && std::find(row.begin(), row.end(), n) == row.end()) {
        row.push_back(n);
        break;
      }
  const auto transferred = [&](const std::vector<double>& by_row) {
    std::vector<double> factors(6), result;
    for (std::size_t k = 0; k < 6; ++k) factors[static_cast<std::size_t>(row[k])] = by_row[k];
    factors = transferred_factors(factors, surface, 0.1);
    for (const Index t : row) result.push_back(factors[static_cast<std::size_t>(t)]);
    return result;
  };
  EXPECT_EQ(transferred({1, 1, 0.2, 0.15, 0.01, 0.01}),
            (std::vector<double>{1, 1, 0.6, 0.15, 0.08, 0.01}));
  EXPECT_EQ(transferred({1, 0.2, 0.5, 0.5, 0.45, 0.5}),
            (std::vector<double>{1, 0.6, 0.5, 0.5, 0.45, 0.5}))
      << "the higher neighbour counts";
}

// ---- equations (11) and (12)

TEST(ViewCompensation, SharesByArea) {
  ViewSettings s;
  s.compensation_power = 2;
  const auto shares = [&](const std::vector<double>& areas, const std::vector<unsigned char>& out,
                          AreaRange range = {1, 3}) {
    return compression_shares(areas, std::vector(areas.size(), range), out, s);
  };
  EXPECT_EQ(shares({1, 2, 3, 5, 0.1}, {1, 1, 1, 0, 0}), (std::vector<double>{1, 0.25, 0, 1, 1}));
  EXPECT_EQ(shares({0.5, 2, 4}, {1, 1, 1}), (std::vector<double>{1, 0.25, 0}))
      << "beyond the range";
  EXPECT_TRUE(shares({2, 2, 2}, {1, 1, 1}, {2, 2}).empty()) << "sizes that leave no choice";
  EXPECT_TRUE(shares({2, 3}, {0, 0}).empty()) << "all in view";
  s.compensation_power = 10;
  EXPECT_NEAR(shares({1, 2, 3}, {1, 1, 1})[1], std::pow(0.5, 10), 1e-18);
  s.compensation = BucklingCompensation::full;
  EXPECT_EQ(shares({2, 2, 5}, {1, 1, 0}), (std::vector<double>{0, 0, 1}));
  s.compensation = BucklingCompensation::none;
  EXPECT_TRUE(shares({1, 2, 3}, {1, 1, 1}).empty());
}

// ---- occlusion

TEST(ViewOcclusion, HidesWhatIsBehindAsAWhole) {
  Strip strip;
  strip.add(-1, -2, 2);   // 0, 1: in front
  strip.add(-0.5, 0, 1);  // 2, 3: behind it
  strip.add(0.5, 0, 3);   // 4, 5: partly
  strip.add(-4, 0, 1);    // 6, 7: beside
  const ViewSurface surface = strip.surface();
  const std::vector<unsigned char> expected{0, 0, 1, 1, 0, 0, 0, 0};
  EXPECT_EQ(hidden_triangles(ahead(), surface, strip.places), expected);
  // Obstacles hide as cloth does.
  ViewPlaces places = strip.places;
  places.obstacles = {{-4.2, -1, -1}, {-2, -1, -1}, {-2, -1, 1}, {-4.2, -1, 1}};
  const ViewSurface more = make_view_surface(surface.triangles, {{{0, 1, 2}}, {{0, 2, 3}}});
  EXPECT_EQ(hidden_triangles(ahead(), more, places),
            (std::vector<unsigned char>{0, 0, 1, 1, 0, 0, 1, 1}));
}

TEST(ViewOcclusion, FallsOffAlongTheCloth) {
  // A sheet whose left half is behind a wall.
  const Mesh sheet = make_grid({4, 0.1}, {80, 2}, Diagonals::alternating);
  ViewPlaces places;
  for (const Vec3<double>& x : sheet.positions) places.cloth.push_back({x[0], 0, x[1]});
  places.obstacles = {{-4, -1, -2}, {0, -1, -2}, {0, -1, 2}, {-4, -1, 2}};
  const ViewSurface surface = make_view_surface(sheet.triangles, {{{0, 1, 2}}, {{0, 2, 3}}});
  ViewSettings s;
  const Camera wide{{key_towards({0, 0, 0})}, 500, 500};
  const ViewCamera camera(wide.keys[0], 500, 500);
  for (const double f : view_factors(camera, surface, places, s)) EXPECT_EQ(f, 1);
  s.occlusion = true;
  const auto factors = view_factors(camera, surface, places, s);
  for (std::size_t t = 0; t < factors.size(); ++t) {
    double x = 0;
    for (const Index v : sheet.triangles[t].v)
      x += sheet.positions[static_cast<std::size_t>(v)][0] / 3;
    if (x > 0.05) {
      EXPECT_EQ(factors[t], 1) << "at " << x;
    } else if (x < -0.5) {
      EXPECT_EQ(factors[t], 0.01) << "at " << x;
    } else if (x < -0.1) {
      // Ways along triangles are up to 1.5 times as long, and it is the wall's picture that counts.
      EXPECT_LE(factors[t], 1 - (-x - 0.1) / 0.4 * 0.99 + 1e-9) << "at " << x;
      EXPECT_GE(factors[t], std::max(0.01, 1 - 1.5 * (-x + 0.02) / 0.4 * 0.99 - 1e-9)) << x;
    }
  }
}

}  // namespace
}  // namespace weft::test
