// Single triangles: inverted, degenerate, non-finite, strain; and the report of a verdict.
#include "host/lab/check/quality.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "host/lab/check/report_json.hpp"
#include "host/lab/check/validator.hpp"
#include "tests/unit/lab/check/soup.hpp"
#include "weft/error.hpp"

namespace weft::lab::test {
namespace {

const double nan_value = std::numeric_limits<double>::quiet_NaN();
const double infinity = std::numeric_limits<double>::infinity();

Mesh flat_sheet() {
  return sheet(4, [](double u, double v) { return Vec3<double>{u, v, 0}; });
}

TEST(ValidatorQuality, FlatSheetIsCleanAndUnstrained) {
  const FrameVerdict verdict = validate(flat_sheet(), nullptr);
  EXPECT_TRUE(verdict.clean());
  EXPECT_EQ(verdict.triangle_count, 32);
  EXPECT_EQ(verdict.strain.triangle_count, 32);
  EXPECT_EQ(verdict.strain.largest.max, 0);
  EXPECT_EQ(verdict.strain.smallest.min, 0);
}

TEST(ValidatorQuality, EmptyMeshIsClean) {
  const Mesh empty;
  EXPECT_TRUE(validate(empty, &empty).clean());
}

TEST(ValidatorQuality, StrainOfAKnownStretch) {
  // 25 % along u, -12.5 % along v, rotated and moved: the principal stretches themselves.
  const double c = std::cos(0.4), s = std::sin(0.4);
  const Mesh mesh = sheet(8, [&](double u, double v) {
    const double x = 1.25 * u, y = 0.875 * v;
    return Vec3<double>{3, c * x - s * y, s * x + c * y};
  });
  const StrainVerdict strain = validate(mesh, nullptr).strain;
  EXPECT_EQ(strain.triangle_count, 128);
  for (const double p : {strain.largest.min, strain.largest.p1, strain.largest.p50,
                         strain.largest.p99, strain.largest.max})
    EXPECT_NEAR(p, 0.25, 1e-13);
  for (const double p : {strain.smallest.min, strain.smallest.p1, strain.smallest.p50,
                         strain.smallest.p99, strain.smallest.max})
    EXPECT_NEAR(p, -0.125, 1e-13);
}

TEST(ValidatorQuality, StrainOfAShear) {
  // F = [1 k; 0 1]: stretches are sqrt(1 + k^2/4) +- k/2.
  const double k = 0.5;
  const Mesh mesh = sheet(2, [&](double u, double v) { return Vec3<double>{u + k * v, v, 0}; });
  const StrainVerdict strain = validate(mesh, nullptr).strain;
  EXPECT_NEAR(strain.largest.p50, std::sqrt(1 + k * k / 4) + k / 2 - 1, 1e-15);
  EXPECT_NEAR(strain.smallest.p50, std::sqrt(1 + k * k / 4) - k / 2 - 1, 1e-15);
}

TEST(ValidatorQuality, PercentilesByNearestRank) {
  // 200 separate triangles, number i stretched by 1 + i/100 along u.
  Mesh mesh;
  for (int i = 200; i >= 1; --i) {
    Mesh one = mesh_of({{0, 0, double(i)}, {1 + 0.01 * i, 0, double(i)}, {0, 1, double(i)}},
                       {{{0, 1, 2}}});
    one.material = {{0, 0}, {1, 0}, {0, 1}};
    append(mesh, one);
  }
  const StrainVerdict strain = validate(mesh, nullptr).strain;
  EXPECT_NEAR(strain.largest.min, 0.01, 1e-14);
  EXPECT_NEAR(strain.largest.p1, 0.02, 1e-14);
  EXPECT_NEAR(strain.largest.p50, 1.00, 1e-14);
  EXPECT_NEAR(strain.largest.p99, 1.98, 1e-14);
  EXPECT_NEAR(strain.largest.max, 2.00, 1e-14);
  EXPECT_NEAR(strain.smallest.min, 0, 1e-14);
  EXPECT_NEAR(strain.smallest.max, 0, 1e-14);
}

TEST(ValidatorQuality, CrushedTriangleHasStrainMinusOne) {
  const Mesh mesh = sheet(1, [](double u, double v) { return Vec3<double>{u + v, u + v, 0}; });
  EXPECT_EQ(validate(mesh, nullptr).strain.smallest.min, -1);
}

TEST(ValidatorQuality, WithoutMaterialThereIsNoStrain) {
  Mesh mesh = flat_sheet();
  mesh.material.clear();
  const FrameVerdict verdict = validate(mesh, nullptr);
  EXPECT_TRUE(verdict.clean());
  EXPECT_EQ(verdict.strain.triangle_count, 0);
  EXPECT_TRUE(to_json(verdict)["strain"].is_null());
}

TEST(ValidatorQuality, InvertedInMaterialSpace) {
  Mesh mesh = flat_sheet();
  // Vertex 6 of the material moves across its neighbours, in the plane of the material only.
  mesh.material[6] = {0.6, 0.55};
  std::vector<Index> expected;
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const auto m = [&](int k) {
      return mesh.material[static_cast<std::size_t>(mesh.triangles[i].v[k])];
    };
    const Vec2<double> a = m(1) - m(0), b = m(2) - m(0);
    if (a[0] * b[1] - a[1] * b[0] <= 0) expected.push_back(static_cast<Index>(i));
  }
  ASSERT_FALSE(expected.empty());
  const FrameVerdict verdict = validate(mesh, nullptr);
  EXPECT_EQ(verdict.inverted.list, expected);
  EXPECT_EQ(verdict.inverted.count, static_cast<std::int64_t>(expected.size()));
  EXPECT_FALSE(verdict.clean());
  // The mirror image of the whole has the same minority.
  for (auto& m : mesh.material) m[0] = -m[0];
  EXPECT_EQ(validate(mesh, nullptr).inverted.list, expected);
}

TEST(ValidatorQuality, ZeroMaterialAreaIsInvertedAndLeftOutOfTheStrain) {
  Mesh mesh = flat_sheet();
  mesh.material[0] = {0.5, 0.5};  // on the line of vertices 6 and 12, still in the first triangles
  mesh.material[1] = {0.75, 0.75};
  const FrameVerdict verdict = validate(mesh, nullptr);
  ASSERT_FALSE(verdict.inverted.list.empty());
  EXPECT_EQ(verdict.inverted.list.front(), 0);
  EXPECT_LT(verdict.strain.triangle_count, 32);
}

TEST(ValidatorQuality, FoldInTheWorldIsNoInversion) {
  const Mesh mesh = sheet(2, [](double u, double v) {
    return Vec3<double>{u <= 0.5 ? u : 1 - u + 0.01, v, u <= 0.5 ? 0 : 0.1 * u};
  });
  EXPECT_EQ(validate(mesh, nullptr).inverted.count, 0);
}

TEST(ValidatorQuality, DegenerateTriangles) {
  const double third = 1.0 / 3;
  const Points corners{{0, 0, 0}, {third, third, third}, {1, 1, 1}};
  EXPECT_EQ(
      validate(mesh_of({{0, 0, 0}, {1, 1, 1}, {3, 3, 3}}, {{{0, 1, 2}}}), nullptr).degenerate.list,
      std::vector<Index>{0});
  EXPECT_EQ(validate(mesh_of(corners, {{{0, 1, 2}}}), nullptr).degenerate.count, 1);
  EXPECT_EQ(
      validate(mesh_of({{1, 2, 3}, {1, 2, 3}, {1, 2, 3}}, {{{0, 1, 2}}}), nullptr).degenerate.count,
      1);
  EXPECT_EQ(validate(mesh_of({{1, 2, 3}, {4, 5, 6}}, {{{0, 1, 1}}}), nullptr).degenerate.count, 1);
}

TEST(ValidatorQuality, AspectDecidesOnSlivers) {
  const auto sliver = [](double scale, double aspect) {
    return validate(
        mesh_of({{0, 0, 0}, {0, 0, scale}, {0, scale * aspect, scale / 2}}, {{{0, 1, 2}}}),
        nullptr);
  };
  for (const double scale : {1e-300, 1e-6, 1.0, 1e6, 1e300}) {
    EXPECT_EQ(sliver(scale, 0.99e-10).degenerate.count, 1) << scale;
    EXPECT_EQ(sliver(scale, 1.01e-10).degenerate.count, 0) << scale;
    EXPECT_EQ(sliver(scale, 1).degenerate.count, 0) << scale;
  }
}

TEST(ValidatorQuality, NonFiniteVertexIsAFindingAndItsTrianglesAreLeftOut) {
  for (const double bad : {nan_value, infinity, -infinity}) {
    Mesh mesh = flat_sheet();
    mesh.positions[12][1] = bad;
    // The rest is still checked: a second sheet crosses the first.
    append(mesh, sheet(1, [](double u, double v) { return Vec3<double>{u, 0.1, v - 0.5}; }));
    const FrameVerdict verdict = validate(mesh, nullptr);
    EXPECT_EQ(verdict.nonfinite.list, std::vector<Index>{12});
    EXPECT_EQ(verdict.nonfinite.count, 1);
    EXPECT_FALSE(verdict.clean());
    EXPECT_GT(verdict.cloth_cloth_count, 0);
    EXPECT_EQ(verdict.strain.triangle_count, 32 + 2 - 6);
  }
}

TEST(ValidatorQuality, NonFiniteMaterialAndObstacle) {
  Mesh mesh = flat_sheet();
  mesh.material[3][0] = nan_value;
  EXPECT_EQ(validate(mesh, nullptr).nonfinite.list, std::vector<Index>{3});
  Mesh obstacle = sheet(1, [](double u, double v) { return Vec3<double>{u, v, -1}; });
  obstacle.positions[2][2] = infinity;
  const FrameVerdict verdict = validate(flat_sheet(), &obstacle);
  EXPECT_EQ(verdict.nonfinite_obstacle.list, std::vector<Index>{2});
  EXPECT_EQ(verdict.nonfinite.count, 0);
  EXPECT_FALSE(verdict.clean());
}

TEST(ValidatorQuality, BrokenMeshesAreRefused) {
  Mesh mesh = flat_sheet();
  mesh.triangles[3].v[1] = 25;
  EXPECT_THROW(validate(mesh, nullptr), SceneError);
  EXPECT_THROW(validate(flat_sheet(), &mesh), SceneError);
  mesh.triangles[3].v[1] = -1;
  EXPECT_THROW(validate(mesh, nullptr), SceneError);
  mesh = flat_sheet();
  mesh.material.pop_back();
  EXPECT_THROW(validate(mesh, nullptr), SceneError);
}

TEST(ValidatorReport, HoldsWhatTheVerdictHolds) {
  Mesh mesh = flat_sheet();
  append(mesh, sheet(1, [](double u, double v) { return Vec3<double>{u, 0.1, v - 0.5}; }));
  mesh.positions[24][0] = nan_value;
  const FrameVerdict verdict = validate(mesh, &mesh);
  const auto json = nlohmann::json::parse(to_json(verdict).dump());
  EXPECT_FALSE(json["clean"]);
  EXPECT_EQ(json["triangle_count"], 34);
  EXPECT_EQ(json["obstacle_triangle_count"], 34);
  EXPECT_EQ(json["cloth_cloth"]["count"], verdict.cloth_cloth_count);
  EXPECT_EQ(json["cloth_cloth"]["pairs"].size() + json["cloth_obstacle"]["pairs"].size(),
            verdict.pairs.size());
  EXPECT_EQ(json["cloth_cloth"]["pairs"][0], (std::vector{verdict.pairs[0].a, verdict.pairs[0].b}));
  EXPECT_EQ(json["nonfinite_vertices"]["list"], std::vector{24});
  EXPECT_EQ(json["nonfinite_obstacle_vertices"]["count"], 1);
  EXPECT_EQ(json["strain"]["largest"]["max"], verdict.strain.largest.max);
  EXPECT_EQ(json["inverted"]["count"], 0);
  EXPECT_EQ(json["degenerate"]["count"], 0);
}

}  // namespace
}  // namespace weft::lab::test
