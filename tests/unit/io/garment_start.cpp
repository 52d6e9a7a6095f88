// How garments stand at time 0: below the arms, over other garments, sewn without cloth on the
// wrong side of a seam.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <set>
#include <string>

#include "host/geometry/triangle_pair.hpp"
#include "host/io/pattern/arm_clearance.hpp"
#include "host/io/pattern/garment.hpp"
#include "host/io/pattern/inner_layers.hpp"
#include "host/io/pattern/pattern_file.hpp"
#include "host/io/pattern/start_shape.hpp"
#include "weft/core/at.hpp"
#include "weft/elements/distance.hpp"
#include "weft/error.hpp"
#include "weft/shapes.hpp"

namespace weft::io {
namespace {

using nlohmann::json;

/// A flat panel of straight edges. [cm]
json panel(const json& vertices, double z, const std::string& label = "") {
  json edges = json::array();
  for (std::size_t k = 0; k < vertices.size(); ++k)
    edges.push_back({{"endpoints", {k, (k + 1) % vertices.size()}}});
  json made{{"vertices", vertices}, {"edges", edges}, {"translation", {0, 0, z}}};
  if (!label.empty()) made["label"] = label;
  return made;
}

json stitch(const std::string& a, int i, const std::string& b, int j) {
  return {{{"panel", a}, {"edge", i}}, {{"panel", b}, {"edge", j}}};
}

Garment garment_of(const json& panels, const json& stitches, double edge) {
  const json document{{"pattern", {{"panels", panels}, {"stitches", stitches}}}};
  return make_garment(read_sewing_pattern(document, "t.json"), edge);
}

/// Front and back of equal width, sewn at both sides.
Garment tube(double half_width, double low, double high, double z, double edge,
             const std::string& label = "") {
  const double w = half_width;
  return garment_of({{"front", panel({{-w, low}, {w, low}, {w, high}, {-w, high}}, z, label)},
                     {"rear", panel({{-w, low}, {-w, high}, {w, high}, {w, low}}, -z, label)}},
                    {stitch("front", 1, "rear", 2), stitch("front", 3, "rear", 0)}, edge);
}

/// A ball that is stretched, turned about z and moved. [m]
void add_ball(Mesh& mesh, const Vec3<double>& radii, double degrees, const Vec3<double>& centre) {
  const Mesh ball = make_icosphere(1, 3);
  const auto first = static_cast<Index>(mesh.positions.size());
  const double c = std::cos(degrees * 0.0174532925), s = std::sin(degrees * 0.0174532925);
  for (const Vec3<double>& p : ball.positions) {
    const Vec3<double> q{p[0] * radii[0], p[1] * radii[1], p[2] * radii[2]};
    mesh.positions.push_back(centre + Vec3<double>{c * q[0] - s * q[1], s * q[0] + c * q[1], q[2]});
  }
  for (const Tri& t : ball.triangles)
    mesh.triangles.push_back({{t.v[0] + first, t.v[1] + first, t.v[2] + first}});
}

/// A trunk, and arms that are lowered by 40 degrees.
Mesh body_with_arms() {
  Mesh body;
  add_ball(body, {0.15, 0.5, 0.12}, 0, {0, 0.9, 0});
  add_ball(body, {0.3, 0.04, 0.04}, -40, {0.36, 1.05, 0});
  add_ball(body, {0.3, 0.04, 0.04}, 40, {-0.36, 1.05, 0});
  return body;
}

Corners corners_of(const Mesh& mesh, const Tri& t) {
  return {mesh.positions[at(t.v[0])], mesh.positions[at(t.v[1])], mesh.positions[at(t.v[2])]};
}

int meeting(const Mesh& a, const Mesh& b) {
  int count = 0;
  for (const Tri& t : a.triangles)
    for (const Tri& u : b.triangles) {
      const Corners p = corners_of(a, t), q = corners_of(b, u);
      if (plainly_apart(p, q, 0)) continue;
      count += triangles_intersect({{0, 1, 2}}, {{3, 4, 5}}, p, q) ? 1 : 0;
    }
  return count;
}

/// A skirt as wide as its arms reach: front and back would be sewn to each other through them.
TEST(ArmClearance, PutsAWideSkirtBelowTheArms) {
  const Mesh body = body_with_arms();
  for (const char* label : {"leg", ""}) {
    Garment skirt = tube(60, 60, 108, 20, 0.03, label);
    relax_start(skirt, 0.03, body);
    EXPECT_EQ(meeting(skirt.mesh, body), 0);
    // The arms lie on the line from (0.13, 1.24) to (0.59, 0.86), and all cloth below them.
    for (const Vec3<double>& x : skirt.mesh.positions) {
      if (std::abs(x[0]) < 0.2 || std::abs(x[0]) > 0.55) continue;
      EXPECT_LT(x[1], 1.24 - (std::abs(x[0]) - 0.13) * 0.83) << x[0] << " " << x[2];
    }
    // Before the trunk it keeps its height.
    double top = 0;
    for (const Vec3<double>& x : skirt.mesh.positions)
      if (std::abs(x[0]) < 0.05) top = std::max(top, x[1]);
    EXPECT_NEAR(top, 1.08, 0.02);
  }
}

TEST(ArmClearance, LeavesWhatIsWornOnTheArmOrAboveIt) {
  const Mesh body = body_with_arms();
  const auto moved = [&](Garment garment) {
    const auto before = garment.mesh.positions;
    clear_arms(garment, body);
    return !(garment.mesh.positions == before);
  };
  EXPECT_TRUE(moved(tube(60, 60, 108, 20, 0.03)));
  EXPECT_FALSE(moved(tube(60, 80, 150, 20, 0.03, "body")));  // reaches above the armpits
  EXPECT_FALSE(moved(tube(14, 60, 108, 20, 0.03, "leg")));   // narrow
  json cuff = panel({{40, 85}, {52, 85}, {52, 100}, {40, 100}}, 12, "arm");
  EXPECT_FALSE(moved(garment_of({{"cuff", cuff}}, json::array(), 0.03)));
}

TEST(InnerLayers, OuterGarmentStartsOutside) {
  Mesh body;
  add_ball(body, {0.12, 0.5, 0.1}, 0, {0, 0.4, 0});
  Garment inner = tube(20, 10, 70, 20, 0.03), outer = tube(21, 20, 60, 15, 0.025);
  relax_start(inner, 0.03, body);
  InnerLayers layers(body);
  layers.add(inner);
  relax_start(outer, 0.025, body, layers);
  EXPECT_EQ(meeting(outer.mesh, body), 0);
  EXPECT_EQ(meeting(outer.mesh, inner.mesh), 0);
  // Each outer vertex has an inner one that is nearer to the axis in its direction.
  const auto radius = [](const Vec3<double>& x) { return std::hypot(x[0], x[2]); };
  int beneath = 0;
  for (const Vec3<double>& x : outer.mesh.positions) {
    double nearest = 1e9, there = 0;
    for (const Vec3<double>& y : inner.mesh.positions) {
      const Vec3<double> across{x[0] / radius(x) - y[0] / radius(y), (x[1] - y[1]) * 5,
                                x[2] / radius(x) - y[2] / radius(y)};
      if (length_sq(across) < nearest) {
        nearest = length_sq(across);
        there = radius(y);
      }
    }
    beneath += radius(x) < there - 0.01 ? 1 : 0;
  }
  EXPECT_EQ(beneath, 0);
}

/// Left and right leg of trousers from behind: both reach beyond the middle, where they are sewn.
TEST(RelaxStart, ClothFollowsSeamsOfPanelsThatOverlap) {
  const json left = panel({{2, 0}, {20, 0}, {20, 40}, {0, 40}, {-2, 25}, {-12, 18}}, 15);
  const json right = panel({{-2, 0}, {12, 18}, {2, 25}, {0, 40}, {-20, 40}, {-20, 0}}, 15);
  const json stitches{stitch("left", 3, "right", 2), stitch("left", 4, "right", 1),
                      stitch("left", 5, "right", 0)};
  Garment legs = garment_of({{"left", left}, {"right", right}}, stitches, 0.015);
  relax_start(legs, 0.015, {});
  // Nothing of the left leg stands to the right of the middle.
  const GarmentPanel& part = legs.panels[0];
  ASSERT_EQ(part.name, "left");
  for (Index v = 0; v < part.vertex_count; ++v)
    EXPECT_GT(legs.mesh.positions[at(part.first_vertex + v)][0], -0.015) << v;  // an edge
}

/// A tube that is far too narrow for its body contracts onto it, but no nearer than single
/// precision resolves.
TEST(TightenStart, ContractsOutsideOfTheBody) {
  Mesh body;
  add_ball(body, {0.12, 0.5, 0.1}, 0, {0, 0.4, 0});
  Garment narrow = tube(12, 20, 60, 15, 0.02);
  for (Vec3<double>& x : narrow.mesh.positions) x[0] *= 1.5;
  const Vec3<double> before = narrow.mesh.positions[0];
  relax_start(narrow, 0.02, body);
  ASSERT_EQ(meeting(narrow.mesh, body), 0);
  EXPECT_FALSE(narrow.mesh.positions[0] == before);
  const double stretch = largest_stretch(narrow);
  for (int k = 0; k < 3; ++k) tighten_start(narrow, 0.02, body, InnerLayers(body));
  EXPECT_LE(largest_stretch(narrow), stretch);
  double nearest = 1;
  for (const Tri& t : narrow.mesh.triangles)
    for (const Tri& u : body.triangles) {
      const Corners p = corners_of(narrow.mesh, t), q = corners_of(body, u);
      if (plainly_apart(p, q, 1e-2)) continue;
      for (std::size_t k = 0; k < 3; ++k) {
        const Vec3<double> x[4]{p[k], q[0], q[1], q[2]}, y[4]{q[k], p[0], p[1], p[2]};
        nearest =
            std::min({nearest, vertex_triangle(x).distance_sq, vertex_triangle(y).distance_sq});
      }
    }
  EXPECT_LT(std::sqrt(nearest), 5e-3);
  EXPECT_GE(std::sqrt(nearest), 0.99e-5);
}

TEST(RefuseFarPanels, NamesThePanelAndItsDistance) {
  const Mesh body = body_with_arms();
  EXPECT_NO_THROW(refuse_far_panels(tube(20, 60, 108, 55, 0.05), body, "t.json"));
  EXPECT_NO_THROW(refuse_far_panels(tube(20, 60, 108, 300, 0.05), {}, "t.json"));
  try {
    refuse_far_panels(tube(20, 60, 108, 80, 0.05), body, "t.json");
    FAIL() << "accepted";
  } catch (const SceneError& error) {
    const std::string text = error.what();
    EXPECT_TRUE(text.starts_with("t.json: pattern.panels.front: 0.68 m from the body")) << text;
    EXPECT_NE(text.find("at most 0.5 m away"), std::string::npos) << text;
  }
}

TEST(MakeGarment, SaysThatUnitsAreMissing) {
  const json panels{{"front", panel({{0, 0}, {20, 0}, {0, 20}}, 0)}};
  json document{{"pattern", {{"panels", panels}}}};
  const auto notes = [&] {
    return make_garment(read_sewing_pattern(document, "t.json"), 0.05).notes;
  };
  ASSERT_EQ(notes().size(), 1u);
  EXPECT_EQ(notes()[0], "properties.units_in_meter: missing; lengths are taken for centimetres");
  document["properties"]["units_in_meter"] = 100;
  EXPECT_TRUE(notes().empty());
}

/// The two halves of a pleat that is one edge deep have a triangle each, with the same third
/// corner.
TEST(MakeGarment, PleatsMayBeOneEdgeDeep) {
  const json vertices{{0, 0}, {30, 0}, {30, 20}, {17.5, 20}, {15, 20}, {12.5, 20}, {0, 20}};
  for (const double edge : {0.012, 0.02, 0.024, 0.028, 0.03, 0.035, 0.04, 0.05}) {
    const Garment skirt = garment_of({{"front", panel(vertices, 20)}},
                                     json::array({stitch("front", 3, "front", 4)}), edge);
    std::map<Index, Index> same;
    for (const GarmentSeam& seam : skirt.seams)
      for (const auto& [a, b] : seam.pairs) same[std::max(a, b)] = std::min(a, b);
    std::set<std::array<Index, 3>> seen;
    for (const Tri& t : skirt.mesh.triangles) {
      std::array<Index, 3> v{t.v[0], t.v[1], t.v[2]};
      for (Index& w : v)
        if (const auto found = same.find(w); found != same.end()) w = found->second;
      std::sort(v.begin(), v.end());
      EXPECT_TRUE(seen.insert(v).second) << edge;
      EXPECT_TRUE(v[0] != v[1] && v[1] != v[2]) << edge;
    }
  }
}

}  // namespace
}  // namespace weft::io
