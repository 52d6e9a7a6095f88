#include "host/io/pattern/garment_on_body.hpp"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "host/io/pattern/panel_placement.hpp"
#include "host/io/pattern/pattern_file.hpp"
#include "weft/error.hpp"
#include "weft/shapes.hpp"

namespace weft::io {
namespace {

/// A tunic before and behind a body, from 0.6 to 1.4 m, sewn at its sides. [cm]
Garment tunic() {
  const auto panel = [](double z) {
    nlohmann::json edges = nlohmann::json::array();
    for (int k = 0; k < 4; ++k) edges.push_back({{"endpoints", {k, (k + 1) % 4}}});
    return nlohmann::json{{"vertices", {{-30, 60}, {30, 60}, {30, 140}, {-30, 140}}},
                          {"edges", edges},
                          {"translation", {0, 0, z}}};
  };
  const nlohmann::json document{
      {"pattern",
       {{"panels", {{"front", panel(25)}, {"back", panel(-25)}}},
        {"stitches",
         {{{{"panel", "front"}, {"edge", 1}}, {{"panel", "back"}, {"edge", 1}}},
          {{{"panel", "front"}, {"edge", 3}}, {{"panel", "back"}, {"edge", 3}}}}}}}};
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

TEST(GarmentOnBody, NamesPanelsThatBeginWithinTheBody) {
  const Garment garment = tunic();
  EXPECT_TRUE(misplaced_panels(garment, body({0, 0.85, 0}, {0.6, 0.85, 0.15})).empty());
  EXPECT_TRUE(misplaced_panels(garment, {}).empty());
  // Its front half is open, as a scan may be: rays out of it along z still tell.
  for (const bool open : {false, true}) {
    Mesh around = body({0, 0.85, 0.25}, {0.6, 0.85, 0.15});
    if (open)
      std::erase_if(around.triangles, [&](const Tri& t) {
        return around.positions[static_cast<std::size_t>(t.v[0])][2] > 0.35;
      });
    EXPECT_EQ(misplaced_panels(garment, around),
              std::vector<std::string>{"pattern.panels: of these, more than 40 % begins within the "
                                       "body, around which panels should stand: front (100 %)"});
  }
  // A shoulder of which a fifth sticks in the body.
  EXPECT_TRUE(misplaced_panels(garment, body({0, 0.45, 0.25}, {0.6, 0.3, 0.15})).empty());
}

TEST(GarmentOnBody, NamesPanelsThatStandBesideOthersThanTheyAreSewnTo) {
  Garment garment = tunic();
  const GarmentPanel& back = garment.panels[0];
  ASSERT_EQ(back.name, "back");
  for (Index v = 0; v < back.vertex_count; ++v)
    garment.mesh.positions[static_cast<std::size_t>(back.first_vertex + v)][0] += 1;
  EXPECT_EQ(
      misplaced_panels(garment, body({0, 0.85, 0}, {0.6, 0.85, 0.15})),
      std::vector<std::string>{
          "pattern.stitches[0]: front and back are sewn together, but stand 1.12 m apart, and "
          "the sides of 1 more stitch over 0.77 m; does each panel stand on its own side of "
          "the body?"});
}

TEST(GarmentOnBody, RefusesAnotherUnit) {
  const Mesh tall = body({0, 0.85, 0}, {0.6, 0.85, 0.15});
  Garment garment = tunic();
  nlohmann::json document{{"pattern", nlohmann::json::object()},
                          {"properties", {{"units_in_meter", 100}}}};
  const auto message = [&](double scale) -> std::string {
    Garment scaled = garment;
    for (Vec3<double>& x : scaled.mesh.positions) x *= scale;
    try {
      refuse_other_size(scaled, tall, document, "t.json");
    } catch (const SceneError& error) {
      return error.what();
    }
    return "";
  };
  for (const double scale : {0.22, 1.0, 10.0}) EXPECT_EQ(message(scale), "");
  const std::string allowed =
      "; allowed: panels that together are 0.1 to 5 times as large as the body";
  EXPECT_EQ(message(0.1),
            "t.json: properties.units_in_meter: 100, which makes a garment of 0.08 m for a body "
            "of 1.7 m" +
                allowed);
  EXPECT_NE(message(11), "");
  document.erase("properties");
  EXPECT_EQ(message(0.01),
            "t.json: properties.units_in_meter: missing, which makes a garment of 0.008 m for a "
            "body of 1.7 m" +
                allowed);
  document["pattern"] = {{"outlines", "t.svg"}, {"outlines_unit", "mm"}};
  EXPECT_EQ(message(0.01),
            "t.json: pattern.outlines_unit: \"mm\", which makes a garment of 0.008 m for a body "
            "of 1.7 m" +
                allowed);
}

}  // namespace
}  // namespace weft::io
