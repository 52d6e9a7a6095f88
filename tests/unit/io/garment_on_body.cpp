#include "host/io/pattern/garment_on_body.hpp"

#include <gtest/gtest.h>

#include "host/io/pattern/pattern_file.hpp"
#include "weft/shapes.hpp"

namespace weft::io {
namespace {

/// A tunic before and behind a body, from 0.6 to 1.4 m. [cm]
Garment tunic() {
  const auto panel = [](double z) {
    nlohmann::json edges = nlohmann::json::array();
    for (int k = 0; k < 4; ++k) edges.push_back({{"endpoints", {k, (k + 1) % 4}}});
    return nlohmann::json{{"vertices", {{-30, 60}, {30, 60}, {30, 140}, {-30, 140}}},
                          {"edges", edges},
                          {"translation", {0, 0, z}}};
  };
  const nlohmann::json document{
      {"pattern", {{"panels", {{"front", panel(25)}, {"back", panel(-25)}}}}}};
  return make_garment(read_sewing_pattern(document, "t.json"), 0.1);
}

/// An ellipsoid. [m]
Mesh body(const Vec3<double>& centre, const Vec3<double>& radii) {
  Mesh mesh = make_icosphere(1, 3);
  for (Vec3<double>& x : mesh.positions)
    x = centre + Vec3<double>{x[0] * radii[0], x[1] * radii[1], x[2] * radii[2]};
  return mesh;
}

TEST(GarmentOnBody, StandsAroundABodyThatStands) {
  const Garment garment = tunic();
  EXPECT_EQ(height_around_body(garment, body({0, 0.85, 0}, {0.6, 0.85, 0.15})), 1);
  // With z up, and lying along x.
  EXPECT_EQ(height_around_body(garment, body({0, 0, 0.85}, {0.6, 0.15, 0.85})), 0);
  EXPECT_LT(height_around_body(garment, body({0.85, 0, 0}, {0.85, 0.65, 0.15})), 0.2);
  // A body of 1.1 m reaches up to the middle of the panels at 1 m, and a little farther.
  EXPECT_NEAR(height_around_body(garment, body({0, 0.55, 0}, {0.4, 0.55, 0.15})), 0.625, 0.03);
  // Out of the panels' reach to the side.
  EXPECT_EQ(height_around_body(garment, body({2, 0.85, 0}, {0.6, 0.85, 0.15})), 0);
}

}  // namespace
}  // namespace weft::io
