#include "host/render/picture_values.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "host/render/picture.hpp"
#include "host/render/picture_colour.hpp"
#include "weft/error.hpp"

namespace weft::io {
namespace {

/// Unit square of two triangles in the plane z, material coordinates as placed.
NamedMesh square(double z) {
  Mesh mesh;
  mesh.positions = {{0, 0, z}, {1, 0, z}, {1, 1, z}, {0, 1, z}};
  for (const auto& p : mesh.positions) mesh.material.push_back({p[0], p[1]});
  mesh.triangles = {{{0, 1, 2}}, {{0, 2, 3}}};
  return {"square", mesh};
}

/// Of the first cloth; a copy, so that a loop may run over it.
std::vector<float> first_of(const CornerValues& values) {
  return values.at(0);
}

TEST(PictureValues, StrainIsTheLargestPrincipalStretch) {
  NamedMesh named = square(0);
  // Stretched to 1.2 along the diagonal, to 0.9 across it, then turned out of the plane.
  const double h = std::sqrt(0.5), turn = 0.7;
  for (Vec3<double>& p : named.mesh.positions) {
    const double along = 1.2 * h * (p[0] + p[1]), across = 0.9 * h * (p[1] - p[0]);
    p = {along * std::cos(turn), across, along * std::sin(turn)};
  }
  for (const float value : first_of(strain_values({named}))) EXPECT_NEAR(value, 0.2, 1e-6);
  for (Vec3<double>& p : named.mesh.positions) p = p * 0.5;
  for (const float value : first_of(strain_values({named}))) EXPECT_NEAR(value, -0.4, 1e-6);
}

TEST(PictureValues, StrainFollowsMaterialTrianglesOfTheirOwn) {
  NamedMesh named = square(0);
  // The second triangle is twice as large in the material, at another place.
  named.mesh.material.insert(named.mesh.material.end(), {{5, 5}, {7, 7}, {5, 7}});
  named.mesh.material_triangles = {{{0, 1, 2}}, {{4, 5, 6}}};
  const auto values = strain_values({named})[0];
  ASSERT_EQ(values.size(), 6u);
  EXPECT_NEAR(values[0], 0, 1e-6);
  EXPECT_NEAR(values[5], -0.5, 1e-6);
}

TEST(PictureValues, NoMaterialNoStrain) {
  NamedMesh named = square(0);
  named.mesh.material.clear();
  for (const float value : first_of(strain_values({named}))) EXPECT_TRUE(std::isnan(value));
}

TEST(PictureValues, HeightIsThatOfTheCorner) {
  NamedMesh named = square(0.5);
  named.mesh.positions[2][2] = 2;
  const auto values = height_values({named})[0];
  EXPECT_EQ(values, (std::vector<float>{0.5f, 0.5f, 2, 0.5f, 2, 0.5f}));
}

TEST(PictureValues, ContactIsTheGapInThicknesses) {
  // Vertices above the inside of a face, the other side, and an obstacle far away.
  const auto gap = [](double z, const std::vector<NamedMesh>& obstacles) {
    return contact_values({square(0), square(z)}, obstacles, 0.01, 2)[0];
  };
  for (const float value : gap(0.013, {})) EXPECT_NEAR(value, 1.3, 1e-6);
  for (const float value : gap(-0.004, {})) EXPECT_NEAR(value, 0.4, 1e-6);
  for (const float value : gap(0.5, {})) EXPECT_EQ(value, 2);
  for (const float value : gap(0.5, {square(0.007)})) EXPECT_NEAR(value, 0.7, 1e-6);
}

TEST(PictureValues, ContactLeavesOutWhatIsNearInTheMaterial) {
  // A strip folded once: its ends lie 0.01 apart, and are 2 apart in the material.
  Mesh mesh;
  for (int i = 0; i <= 40; ++i) {
    const double s = i * 0.05, z = s < 1 ? 0 : 0.01;
    for (const double y : {0.0, 0.05}) {
      mesh.positions.push_back({s < 1 ? s : 2 - s, y, z});
      mesh.material.push_back({s, y});
    }
  }
  for (Index i = 0; i < 40; ++i) {
    mesh.triangles.push_back({{2 * i, 2 * i + 2, 2 * i + 1}});
    mesh.triangles.push_back({{2 * i + 1, 2 * i + 2, 2 * i + 3}});
  }
  const auto values = contact_values({{"strip", mesh}}, {}, 0.02, 2)[0];
  EXPECT_NEAR(values[0], 0.5, 1e-6) << "the other end lies above";
  Mesh straight = mesh;
  for (std::size_t v = 0; v < straight.positions.size(); ++v)
    straight.positions[v] = {straight.material[v][0], straight.material[v][1], 0};
  for (const float value : first_of(contact_values({{"strip", straight}}, {}, 0.02, 2)))
    EXPECT_EQ(value, 2) << "a flat strip touches nothing";
}

TEST(PictureValues, ColourTheClothAndLeaveObstaclesAlone) {
  PictureOptions options;
  options.width = 80, options.height = 60, options.samples = 4;
  options.automatic_camera = false;
  options.eye = {0.5, 0.5, 3}, options.look_at = {0.5, 0.5, 0}, options.up = {0, 1, 0};
  const auto middle = [&](float value) {
    const PictureValues values{{std::vector<float>(6, value)}, 10, 20};
    const Image image = render_picture({square(0)}, {}, options, &values);
    // In the first triangle.
    const std::uint8_t* p = image.rgb.data() + 3 * (35 * 80 + 45);
    return Vec3<float>{p[0] / 255.0f, p[1] / 255.0f, p[2] / 255.0f};
  };
  for (const float t : {0.0f, 0.4f, 1.0f}) {
    const Vec3<float> shown = middle(10 + 10 * t), wanted = colour_of(t);
    for (int k = 0; k < 3; ++k) EXPECT_NEAR(shown[k], wanted[k], 0.08) << t << ' ' << k;
  }
  EXPECT_EQ(middle(5), middle(10)) << "clamped";
  const PictureValues few{{std::vector<float>(5, 1.0f)}, 0, 1};
  EXPECT_THROW(render_picture({square(0)}, {}, options, &few), SceneError);
  const PictureValues empty{{std::vector<float>(6, 1.0f)}, 1, 1};
  EXPECT_THROW(render_picture({square(0)}, {}, options, &empty), SceneError);
}

TEST(PictureValues, EdgesAreDarkerThanTheMiddleOfATriangle) {
  PictureOptions options;
  options.width = 80, options.height = 60, options.samples = 4;
  options.automatic_camera = false;
  options.eye = {0.5, 0.5, 3}, options.look_at = {0.5, 0.5, 0}, options.up = {0, 1, 0};
  const Image plain = render_picture({square(0)}, {}, options);
  options.edges = true;
  const Image lined = render_picture({square(0)}, {}, options);
  const auto red = [](const Image& image, int x, int y) { return image.rgb[3 * (y * 80 + x)] + 0; };
  EXPECT_LT(red(lined, 40, 29), red(plain, 40, 29) - 15) << "on the diagonal";
  EXPECT_EQ(red(lined, 44, 38), red(plain, 44, 38)) << "inside a triangle";
}

}  // namespace
}  // namespace weft::io
