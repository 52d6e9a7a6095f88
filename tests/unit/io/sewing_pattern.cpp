#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <map>
#include <numbers>
#include <set>
#include <string>

#include "host/base/file_bytes.hpp"
#include "host/geometry/mesh_check.hpp"
#include "host/geometry/triangle_pair.hpp"
#include "host/io/json/json_fields.hpp"
#include "host/io/pattern/edge_curve.hpp"
#include "host/io/pattern/garment.hpp"
#include "host/io/pattern/pattern_file.hpp"
#include "host/io/pattern/start_shape.hpp"
#include "host/meshing/planar_mesher.hpp"
#include "weft/core/at.hpp"
#include "weft/error.hpp"
#include "weft/shapes.hpp"

namespace weft::io {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

/// Two panels of 40 x 60 cm before and behind a body, sewn at both sides. Their outlines run
/// counter-clockwise seen from outside.
json tube() {
  return json::parse(R"({
    "pattern": {
      "panels": {
        "front": {"label": "body", "translation": [0, 10, 20], "rotation": [0, 0, 0],
          "vertices": [[-20, 0], [20, 0], [20, 60], [-20, 60]],
          "edges": [{"endpoints": [0, 1]}, {"endpoints": [1, 2]},
                    {"endpoints": [2, 3], "label": "top"}, {"endpoints": [3, 0]}]},
        "rear": {"label": "body", "translation": [0, 10, -20], "rotation": [0, 0, 0],
          "vertices": [[-20, 0], [-20, 60], [20, 60], [20, 0]],
          "edges": [{"endpoints": [0, 1]}, {"endpoints": [1, 2], "label": "top"},
                    {"endpoints": [2, 3]}, {"endpoints": [3, 0]}]}
      },
      "stitches": [[{"panel": "front", "edge": 1}, {"panel": "rear", "edge": 2}],
                   [{"panel": "front", "edge": 3}, {"panel": "rear", "edge": 0}]]
    },
    "properties": {"curvature_coords": "relative", "units_in_meter": 100}
  })");
}

json& edge(json& document, const std::string& panel, std::size_t k) {
  return document["pattern"]["panels"][panel]["edges"][k];
}

SewingPattern pattern_of(const json& document) {
  return read_sewing_pattern(document, "t_specification.json");
}

Garment garment_of(const json& document, double length = 0.02) {
  return make_garment(pattern_of(document), length);
}

TEST(SewingPattern, ReadsPanelsInMetres) {
  EXPECT_TRUE(is_sewing_pattern(tube()));
  EXPECT_FALSE(is_sewing_pattern(json::parse(R"({"pattern": 3})")));
  EXPECT_FALSE(is_sewing_pattern(json::parse("[]")));
  const SewingPattern pattern = pattern_of(tube());
  EXPECT_EQ(pattern.name, "t");
  ASSERT_EQ(pattern.panels.size(), 2u);
  const PatternPanel& front = pattern.panels[0];
  EXPECT_EQ(front.name, "front");
  EXPECT_EQ(front.label, "body");
  EXPECT_EQ(front.edges[2].label, "top");
  EXPECT_NEAR(length(placed(front, front.vertices[2]) - Vec3<double>{0.2, 0.7, 0.2}), 0, 1e-15);
  ASSERT_EQ(pattern.stitches.size(), 2u);
  EXPECT_EQ(pattern.stitches[0].sides[1].edge, 2);
  EXPECT_FALSE(pattern.stitches[0].right_wrong);
}

TEST(SewingPattern, ReadsOtherUnitsAndKeysThatItDoesNotKnow) {
  json document = tube();
  document["properties"]["units_in_meter"] = 1000;
  document["properties"]["made_by"] = {1, 2};
  document["pattern"]["panels"]["front"]["colour"] = "red";
  document["pattern"]["panels"]["front"]["edges"][0]["width"] = nullptr;
  document["pattern"]["stitches"][0].push_back("right_wrong");
  const SewingPattern pattern = pattern_of(document);
  EXPECT_NEAR(pattern.panels[0].vertices[2][1], 0.06, 1e-15);
  EXPECT_TRUE(pattern.stitches[0].right_wrong);
}

TEST(SewingPattern, SaysThatNothingIsSewn) {
  json document = tube();
  document["pattern"]["panel_order"] = {"front", "rear"};
  EXPECT_TRUE(pattern_of(document).notes.empty());
  json& pattern = document["pattern"];
  const std::vector<std::string> unsewn{"pattern.stitches: no stitch, so panels are not sewn"};
  const json stitches = pattern["stitches"];
  pattern["stitches"] = json::array();
  EXPECT_EQ(pattern_of(document).notes, unsewn);
  pattern.erase("stitches");
  EXPECT_EQ(pattern_of(document).notes, unsewn);
  pattern["stiches"] = stitches;
  EXPECT_EQ(pattern_of(document).notes,
            std::vector<std::string>{
                "pattern.stiches: not read, so nothing is sewn; did you mean \"stitches\"?"});
  // A scarf has no stitches.
  pattern.erase("stiches");
  pattern["panels"].erase("rear");
  EXPECT_TRUE(pattern_of(document).notes.empty());
}

/// About x first, then y, then z, all of them axes of the room: (1, 2) in a panel goes to the z
/// axis with its y by the first turn, which the second takes to the x axis, and the third to the y
/// axis.
TEST(SewingPattern, TurnsAboutFixedAxesInOrder) {
  PatternPanel panel;
  panel.rotation = {90, 90, 90};
  panel.translation = {1, 0, 0};
  const Vec3<double> x = placed(panel, {1, 2});
  EXPECT_NEAR(length(x - Vec3<double>{1, 2, -1}), 0, 1e-12) << x[0] << " " << x[1] << " " << x[2];
}

/// The origin of the panel is the mean of its vertices, about which it turns.
TEST(SewingPattern, CentresPanelsIfTheFileSaysSo) {
  json document = tube();
  document["properties"]["normalize_panel_translation"] = true;
  document["pattern"]["panels"]["front"]["rotation"] = {0, 0, 180};
  const PatternPanel panel = pattern_of(document).panels[0];
  EXPECT_NEAR(length(placed(panel, panel.vertices[2]) - Vec3<double>{-0.2, 0.1, 0.2}), 0, 1e-12);
}

/// Curves from (0, 0) to (0, 2 cm), whose left is the negative x direction.
PatternPanel curved(const json& curvature, bool relative = true) {
  json document = tube();
  document["properties"]["curvature_coords"] = relative ? "relative" : "absolute";
  json& panel = document["pattern"]["panels"]["front"];
  panel["vertices"] = {{0, 0}, {0, 2}, {-9, 9}};
  panel["edges"] = {{{"endpoints", {0, 1}}, {"curvature", curvature}},
                    {{"endpoints", {1, 2}}},
                    {{"endpoints", {2, 0}}}};
  document["pattern"]["stitches"] = json::array();
  return pattern_of(document).panels[0];
}

Vec2<double> middle(const PatternPanel& panel) {
  return EdgeCurve(panel, panel.edges[0]).sample(2)[1];
}

TEST(EdgeCurve, FollowsBezierCurves) {
  const json quadratic{{"type", "quadratic"}, {"params", {{0.5, -1}}}};
  EXPECT_NEAR(length(middle(curved(quadratic)) - Vec2<double>{0.01, 0.01}), 0, 1e-6);
  EXPECT_NEAR(length(middle(curved(json({0.5, -1}))) - Vec2<double>{0.01, 0.01}), 0, 1e-6);
  const json absolute{{"type", "quadratic"}, {"params", {{2, 1}}}};
  EXPECT_NEAR(length(middle(curved(absolute, false)) - Vec2<double>{0.01, 0.01}), 0, 1e-6);
  const json cubic{{"type", "cubic"}, {"params", {{0, -1}, {1, -1}}}};
  EXPECT_NEAR(length(middle(curved(cubic)) - Vec2<double>{0.015, 0.01}), 0, 1e-6);
}

/// A parabola y = x^2 / 2 from 0 to 1 has the length (sqrt 2 + asinh 1) / 2.
TEST(EdgeCurve, KnowsLengths) {
  PatternPanel panel;
  panel.vertices = {{0, 0}, {1, 0.5}};
  panel.edges.resize(1);
  panel.edges[0].to = 1;
  panel.edges[0].shape = PatternEdge::Shape::bezier;
  panel.edges[0].controls = {{0.5, 0}};
  const EdgeCurve curve(panel, panel.edges[0]);
  EXPECT_NEAR(curve.length(), (std::numbers::sqrt2 + std::asinh(1.0)) / 2, 1e-6);
  const auto points = curve.sample(64);
  ASSERT_EQ(points.size(), 65u);
  EXPECT_TRUE(points.front() == panel.vertices[0] && points.back() == panel.vertices[1]);
  for (std::size_t k = 0; k + 1 < points.size(); ++k)
    EXPECT_NEAR(length(points[k + 1] - points[k]), curve.length() / 64, 1e-5);
}

TEST(EdgeCurve, FollowsArcs) {
  const auto arc = [](double radius, int large, int left) {
    return json{{"type", "circle"}, {"params", {radius, large, left}}};
  };
  // The chord is 2 cm long; an arc that turns left bulges to the right, to positive x.
  const double r = std::numbers::sqrt2, h = 1;
  EXPECT_NEAR(length(middle(curved(arc(r, 0, 1))) - Vec2<double>{(r - h) / 100, 0.01}), 0, 1e-6);
  EXPECT_NEAR(length(middle(curved(arc(r, 1, 1))) - Vec2<double>{(r + h) / 100, 0.01}), 0, 1e-6);
  EXPECT_NEAR(length(middle(curved(arc(r, 0, 0))) - Vec2<double>{(h - r) / 100, 0.01}), 0, 1e-6);
  EXPECT_NEAR(length(middle(curved(arc(r, 1, 0))) + Vec2<double>{(r + h) / 100, -0.01}), 0, 1e-6);
  const PatternPanel half = curved(arc(1, 0, 1));
  EXPECT_NEAR(EdgeCurve(half, half.edges[0]).length(), std::numbers::pi / 100, 1e-6);
}

/// [pairs] by the vertices that become one
std::map<Index, std::set<Index>> sewn(const Garment& garment) {
  std::map<Index, std::set<Index>> partners;
  for (const GarmentSeam& seam : garment.seams)
    for (const auto& [a, b] : seam.pairs) {
      partners[a].insert(b);
      partners[b].insert(a);
    }
  return partners;
}

void expect_good(const Garment& garment, const std::string& what, double least = 20) {
  const Mesh& mesh = garment.mesh;
  ASSERT_NO_THROW(check_mesh(mesh, {"", what, ""}, true));
  double smallest = 180;
  for (const Tri& t : mesh.triangles)
    smallest = std::min(smallest, least_angle(mesh.material[at(t.v[0])], mesh.material[at(t.v[1])],
                                              mesh.material[at(t.v[2])]));
  EXPECT_GE(smallest, least) << what;
  Index vertices = 0, triangles = 0;
  for (std::size_t p = 0; p < garment.panels.size(); ++p) {
    const GarmentPanel& panel = garment.panels[p];
    EXPECT_EQ(panel.first_vertex, vertices);
    EXPECT_EQ(panel.first_triangle, triangles);
    vertices += panel.vertex_count;
    triangles += panel.triangle_count;
    for (Index t = panel.first_triangle; t < triangles; ++t) {
      EXPECT_EQ(mesh.group[at(t)], static_cast<Index>(p));
      for (const Index v : mesh.triangles[at(t)].v)
        EXPECT_TRUE(v >= panel.first_vertex && v < vertices);
    }
  }
  EXPECT_EQ(at(vertices), mesh.positions.size());
  EXPECT_EQ(at(triangles), mesh.triangles.size());
  // Panels are flat, and material coordinates are their lengths.
  for (const Tri& t : mesh.triangles)
    for (int k = 0; k < 3; ++k) {
      const auto a = at(t.v[k]), b = at(t.v[(k + 1) % 3]);
      EXPECT_NEAR(length(mesh.positions[a] - mesh.positions[b]),
                  length(mesh.material[a] - mesh.material[b]), 1e-12);
    }
}

TEST(MakeGarment, SewsATube) {
  const Garment garment = garment_of(tube());
  expect_good(garment, "tube");
  EXPECT_TRUE(garment.notes.empty());
  ASSERT_EQ(garment.seams.size(), 2u);
  // 60 cm in parts of 2 cm; both sides stand 40 cm apart, one behind the other.
  for (const GarmentSeam& seam : garment.seams) {
    EXPECT_EQ(seam.pairs.size(), 31u);
    for (const auto& [a, b] : seam.pairs)
      EXPECT_NEAR(length(garment.mesh.positions[at(a)] - garment.mesh.positions[at(b)] -
                         Vec3<double>{0, 0, 0.4}),
                  0, 1e-12);
  }
  ASSERT_EQ(garment.labels.size(), 1u);
  EXPECT_EQ(garment.labels[0].label, "top");
  EXPECT_EQ(garment.labels[0].vertices.size(), 42u);
  EXPECT_EQ(garment.mesh.group_names, (std::vector<std::string>{"front", "rear"}));
  EXPECT_EQ(garment.mesh.part_names, (std::vector<std::string>{"body"}));
  // Fronts look away from the body.
  for (std::size_t t = 0; t < garment.mesh.triangles.size(); ++t) {
    const auto& v = garment.mesh.triangles[t].v;
    const auto& x = garment.mesh.positions;
    const double z = cross(x[at(v[1])] - x[at(v[0])], x[at(v[2])] - x[at(v[0])])[2];
    EXPECT_TRUE(garment.mesh.group[t] == 0 ? z > 0 : z < 0);
  }
}

/// The warp runs along the height of a panel that hangs, and along a sleeve that leans.
TEST(MakeGarment, PutsTheWarpAlongTheSteeperAxis) {
  const auto extent_along_warp = [](const Garment& garment) {
    double low = 1e9, high = -1e9;
    for (Index v = 0; v < garment.panels[0].vertex_count; ++v) {
      low = std::min(low, garment.mesh.material[at(v)][0]);
      high = std::max(high, garment.mesh.material[at(v)][0]);
    }
    return high - low;
  };
  EXPECT_NEAR(extent_along_warp(garment_of(tube())), 0.6, 1e-12);
  json document = tube();
  document["pattern"]["panels"]["front"]["rotation"] = {0, 0, 50};
  document["pattern"]["panels"]["rear"]["rotation"] = {0, 0, 50};
  EXPECT_NEAR(extent_along_warp(garment_of(document)), 0.4, 1e-12);
}

TEST(MakeGarment, GathersUpToThreeToOne) {
  json document = tube();
  for (const std::size_t k : {2u, 3u})
    document["pattern"]["panels"]["front"]["vertices"][k][1] = 179;
  const Garment garment = garment_of(document, 0.03);
  expect_good(garment, "gathered");
  // as many as the geometric mean of 60 and 179 cm has parts of 3 cm
  EXPECT_EQ(garment.seams[0].pairs.size(), 36u);
  for (const std::size_t k : {2u, 3u})
    document["pattern"]["panels"]["front"]["vertices"][k][1] = 181;
  EXPECT_THROW(garment_of(document, 0.03), SceneError);
}

/// A dart in the front: its tip stays one vertex, and both of its legs become one.
json with_dart() {
  json document = tube();
  json& front = document["pattern"]["panels"]["front"];
  front["vertices"] = {{-20, 0}, {20, 0}, {20, 60}, {2, 60}, {0, 42}, {-2, 60}, {-20, 60}};
  json edges = json::array();
  for (int k = 0; k < 7; ++k) edges.push_back({{"endpoints", {k, (k + 1) % 7}}});
  front["edges"] = edges;
  document["pattern"]["stitches"][1][0]["edge"] = 6;
  document["pattern"]["stitches"].push_back(
      {{{"panel", "front"}, {"edge", 3}}, {{"panel", "front"}, {"edge", 4}}});
  return document;
}

TEST(MakeGarment, KeepsTheTipOfADart) {
  for (const double length : {0.007, 0.02, 0.05, 0.2}) {
    const Garment garment = garment_of(with_dart(), length);
    expect_good(garment, "dart at " + std::to_string(length), length < 0.1 ? 20 : 5);
    const GarmentSeam& dart = garment.seams[2];
    ASSERT_FALSE(dart.pairs.empty());
    for (const auto& [a, b] : dart.pairs) {
      const Vec3<double>&p = garment.mesh.positions[at(a)], &q = garment.mesh.positions[at(b)];
      EXPECT_NEAR(p[0], -q[0], 1e-12);
      EXPECT_NEAR(p[1], q[1], 1e-12);
      EXPECT_NE(a, b);
    }
  }
}

/// Four panels around a body: at their corners, three or four vertices become one.
TEST(MakeGarment, SharesCornersOfSeveralStitches) {
  json document = tube();
  // a skirt below the tube
  for (const char* name : {"front", "rear"}) {
    json skirt = document["pattern"]["panels"][name];
    skirt["translation"][1] = -50;
    document["pattern"]["panels"][std::string("skirt_") + name] = skirt;
  }
  json& stitches = document["pattern"]["stitches"];
  const auto side = [](const std::string& panel, int edge) {
    return json{{"panel", panel}, {"edge", edge}};
  };
  stitches.push_back({side("skirt_front", 1), side("skirt_rear", 2)});
  stitches.push_back({side("skirt_front", 3), side("skirt_rear", 0)});
  stitches.push_back({side("front", 0), side("skirt_front", 2)});
  stitches.push_back({side("rear", 3), side("skirt_rear", 1)});
  const Garment garment = garment_of(document);
  expect_good(garment, "dress");
  EXPECT_TRUE(garment.notes.empty());
  std::map<Index, std::set<Index>> partners = sewn(garment);
  int corners = 0;
  for (const auto& [v, others] : partners) corners += others.size() > 1 ? 1 : 0;
  EXPECT_EQ(corners, 8);
  Garment placed = garment;
  relax_start(placed, 0.02, {});
  for (const auto& [v, others] : partners)
    for (const Index w : others)
      EXPECT_EQ(placed.mesh.positions[at(v)][0], placed.mesh.positions[at(w)][0]);
  // The seams are 20 cm from either panel, and edges 2 cm long.
  EXPECT_LT(largest_stretch(placed), 4);
  EXPECT_GT(largest_stretch(placed), 1.1);
}

/// A panel whose outline runs the wrong way, as mirrored ones may, is turned over; its stitches
/// then run from beginning to beginning, which is said.
TEST(MakeGarment, RepairsDirections) {
  json document = tube();
  json& rear = document["pattern"]["panels"]["rear"];
  rear["vertices"] = {{-20, 0}, {20, 0}, {20, 60}, {-20, 60}};
  document["pattern"]["stitches"][0][1]["edge"] = 1;
  document["pattern"]["stitches"][1][1]["edge"] = 3;
  const Garment garment = garment_of(document);
  ASSERT_EQ(garment.notes.size(), 2u);
  EXPECT_NE(garment.notes[0].find("pattern.stitches[0]: pattern.panels.front.edges[1] and "
                                  "pattern.panels.rear.edges[1] are sewn beginning to beginning"),
            std::string::npos)
      << garment.notes[0];
  for (const GarmentSeam& seam : garment.seams)
    for (const auto& [a, b] : seam.pairs)
      EXPECT_NEAR(length(garment.mesh.positions[at(a)] - garment.mesh.positions[at(b)]), 0.4,
                  1e-12);
  // what the file says already needs no line
  for (json& stitch : document["pattern"]["stitches"]) stitch.push_back("right_wrong");
  EXPECT_TRUE(garment_of(document).notes.empty());
}

/// The ends of a seam that is short beside the distance of its panels do not tell how it is sewn.
/// The long ones beside it do.
TEST(MakeGarment, LongSeamsTellHowShortOnesAreSewn) {
  json document = tube();
  json& panels = document["pattern"]["panels"];
  for (const char* name : {"front", "rear"}) {
    panels[name]["vertices"] = {{-20, 0}, {20, 0}, {20, 60}, {12, 60}, {-20, 60}};
    panels[name]["edges"] = json::array();
    for (int k = 0; k < 5; ++k) panels[name]["edges"].push_back({{"endpoints", {k, (k + 1) % 5}}});
  }
  json& stitches = document["pattern"]["stitches"];
  stitches = json::array();
  for (const int edge : {1, 2, 4})
    stitches.push_back({{{"panel", "front"}, {"edge", edge}}, {{"panel", "rear"}, {"edge", edge}}});
  const Garment garment = garment_of(document);
  EXPECT_EQ(garment.notes.size(), 3u);
  for (const GarmentSeam& seam : garment.seams)
    for (const auto& [a, b] : seam.pairs)
      EXPECT_NEAR(length(garment.mesh.positions[at(a)] - garment.mesh.positions[at(b)]), 0.4,
                  1e-12);
}

/// If all seams of two panels are short beside their distance, nothing tells how they are sewn.
TEST(MakeGarment, SaysThatADirectionIsNotSure) {
  json document = tube();
  json& panels = document["pattern"]["panels"];
  for (const char* name : {"front", "rear"})
    for (json& vertex : panels[name]["vertices"])
      if (vertex[1] == 60) vertex[1] = 15;
  EXPECT_TRUE(garment_of(document).notes.empty());
  panels["rear"]["vertices"] = {{-20, 0}, {20, 0}, {20, 15}, {-20, 15}};
  document["pattern"]["stitches"][0][1]["edge"] = 1;
  document["pattern"]["stitches"][1][1]["edge"] = 3;
  const Garment garment = garment_of(document);
  ASSERT_EQ(garment.notes.size(), 1u);
  EXPECT_EQ(garment.notes[0],
            "pattern.stitches[0] and 1 more stitch of these panels: the direction is not sure "
            "along pattern.panels.front.edges[1] and pattern.panels.rear.edges[1], sewn as the "
            "file says: the ends are nearer to each other the other way round; do all outlines "
            "run counter-clockwise, seen from outside?");
}

TEST(MakeGarment, IsAPureFunction) {
  Garment a = garment_of(with_dart()), b = garment_of(with_dart());
  relax_start(a, 0.02, {});
  relax_start(b, 0.02, {});
  EXPECT_TRUE(a.mesh.positions == b.mesh.positions);
  EXPECT_TRUE(a.mesh.material == b.mesh.material);
}

/// A body that fills most of the tube, and a thin one that its cloth could step over.
TEST(RelaxStart, KeepsOutOfTheBody) {
  for (const double radius : {0.14, 0.02}) {
    Mesh body = make_icosphere(radius, 2);
    for (Vec3<double>& x : body.positions) x += Vec3<double>{0, 0.4, radius > 0.1 ? 0 : 0.1};
    Garment garment = garment_of(tube());
    relax_start(garment, 0.02, body);
    const auto corners = [](const Mesh& mesh, const Tri& t) {
      return Corners{mesh.positions[at(t.v[0])], mesh.positions[at(t.v[1])],
                     mesh.positions[at(t.v[2])]};
    };
    int meeting = 0;
    double top = 0;
    for (const Tri& t : garment.mesh.triangles) {
      const Corners cloth = corners(garment.mesh, t);
      for (const Vec3<double>& x : cloth) top = std::max(top, x[2]);
      for (const Tri& u : body.triangles)
        meeting += triangles_intersect({{0, 1, 2}}, {{3, 4, 5}}, cloth, corners(body, u)) ? 1 : 0;
    }
    EXPECT_EQ(meeting, 0) << radius;
    // It is drawn in from the 20 cm at which the panels stood, as far as the body lets it.
    EXPECT_LT(top, 0.199);
    EXPECT_GT(top, radius);
    EXPECT_LT(largest_stretch(garment), 2.5);
  }
}

/// An arm on the line of a side seam: it would be drawn past the arm, to either side. The other
/// side is drawn in.
TEST(RelaxStart, LeavesClothThatBeginsWithinTheBody) {
  Mesh arm = make_icosphere(0.03, 2);
  for (Vec3<double>& x : arm.positions) x += Vec3<double>{0.2, 0.4, 0};
  Garment garment = garment_of(tube());
  relax_start(garment, 0.02, arm);
  int held = 0, drawn_in = 0;
  for (const GarmentSeam& seam : garment.seams)
    for (const auto& [a, b] : seam.pairs) {
      const Vec3<double>& x = garment.mesh.positions[at(a)];
      EXPECT_TRUE(x == garment.mesh.positions[at(b)]);
      if (x[0] > 0 && std::abs(x[1] - 0.4) < 0.06) {
        EXPECT_EQ(x[0], 0.2);
        EXPECT_EQ(x[2], 0);
        ++held;
      }
      if (x[0] < 0 && x[0] > -0.19) ++drawn_in;
    }
  EXPECT_GE(held, 5);
  EXPECT_GE(drawn_in, 20);
}

struct Wrong {
  const char* name;
  std::function<void(json&)> change;
  const char* field;  ///< the message must hold both
  const char* value;
};

void PrintTo(const Wrong& w, std::ostream* out) {
  *out << w.name;
}

class WrongPattern : public testing::TestWithParam<Wrong> {};

TEST_P(WrongPattern, GetsItsLine) {
  json document = tube();
  GetParam().change(document);
  try {
    garment_of(document);
    FAIL() << "accepted";
  } catch (const SceneError& error) {
    const std::string text = error.what();
    EXPECT_TRUE(text.starts_with("t_specification.json: ")) << text;
    EXPECT_NE(text.find(GetParam().field), std::string::npos) << text;
    EXPECT_NE(text.find(GetParam().value), std::string::npos) << text;
    EXPECT_EQ(text.find('\n'), std::string::npos) << text;
    EXPECT_LT(text.size(), 500u) << text;
  }
}

json& front_vertex(json& document, std::size_t k) {
  return document["pattern"]["panels"]["front"]["vertices"][k];
}

INSTANTIATE_TEST_SUITE_P(
    Files, WrongPattern,
    testing::Values(
        Wrong{"NoPanels", [](json& d) { d["pattern"]["panels"] = json::object(); },
              "pattern.panels: ", "0 panels"},
        Wrong{"PanelsOfAnotherType", [](json& d) { d["pattern"]["panels"] = 3; },
              "pattern.panels: ", "3;"},
        Wrong{"OpenOutline",
              [](json& d) {
                edge(d, "front", 2)["endpoints"] = {2, 0};
              },
              "pattern.panels.front.edges[3].endpoints: ", "edge 2 ends at vertex 0"},
        Wrong{"MissingEdge", [](json& d) { d["pattern"]["panels"]["front"]["edges"].erase(3); },
              "pattern.panels.front.edges[0].endpoints: ", "an outline that is open"},
        Wrong{"Crossing",
              [](json& d) {
                front_vertex(d, 2) = {-30, 50};
              },
              "pattern.panels.front: ", "edges 1 and 3 cross"},
        Wrong{"CurveThatCrosses",
              [](json& d) {
                edge(d, "front", 0)["curvature"] = {{"type", "quadratic"}, {"params", {{0.5, 4}}}};
              },
              "pattern.panels.front: ", "edges 0 and 2 cross"},
        Wrong{"NoLength",
              [](json& d) {
                edge(d, "front", 0)["endpoints"] = {0, 0};
              },
              "pattern.panels.front.edges[0].endpoints: ", "0.0 apart"},
        Wrong{"FarVertex", [](json& d) { front_vertex(d, 1)[0] = 1e9; },
              "pattern.panels.front.vertices[1]: ", "1000000000"},
        Wrong{"Infinite",
              [](json& d) { front_vertex(d, 1)[0] = std::numeric_limits<double>::infinity(); },
              "pattern.panels.front.vertices[1]: ", "finite"},
        Wrong{"NotANumber",
              [](json& d) { front_vertex(d, 1)[0] = std::numeric_limits<double>::quiet_NaN(); },
              "pattern.panels.front.vertices[1]: ", "finite"},
        Wrong{"TextForAVertex", [](json& d) { front_vertex(d, 1)[0] = "20"; },
              "pattern.panels.front.vertices[1][0]: ", "\"20\""},
        Wrong{"TextForARotation",
              [](json& d) { d["pattern"]["panels"]["front"]["rotation"] = "none"; },
              "pattern.panels.front.rotation: ", "\"none\""},
        Wrong{"NoSuchVertex",
              [](json& d) {
                edge(d, "front", 0)["endpoints"] = {0, 4};
              },
              "pattern.panels.front.edges[0].endpoints[1]: ", "4;"},
        Wrong{"NoSuchCurve",
              [](json& d) {
                edge(d, "front", 0)["curvature"] = {{"type", "spiral"}};
              },
              "pattern.panels.front.edges[0].curvature.type: ", "\"spiral\""},
        Wrong{"TooFewControls",
              [](json& d) {
                edge(d, "front", 0)["curvature"] = {{"type", "cubic"}, {"params", {{0.5, 0.1}}}};
              },
              "pattern.panels.front.edges[0].curvature.params: ", "1 point;"},
        Wrong{"SmallArc",
              [](json& d) {
                edge(d, "front", 0)["curvature"] = {{"type", "circle"}, {"params", {19, 0, 1}}};
              },
              "pattern.panels.front.edges[0].curvature.params: ", "19;"},
        Wrong{"ArcWithoutFlags",
              [](json& d) {
                edge(d, "front", 0)["curvature"] = {{"type", "circle"}, {"params", {25, 2, 1}}};
              },
              "pattern.panels.front.edges[0].curvature.params: ", "0 or 1"},
        Wrong{"StitchToNoPanel",
              [](json& d) { d["pattern"]["stitches"][1][0]["panel"] = "collar"; },
              "pattern.stitches[1][0].panel: ", "\"collar\""},
        Wrong{"StitchToNoEdge", [](json& d) { d["pattern"]["stitches"][1][0]["edge"] = 4; },
              "pattern.stitches[1][0].edge: ", "0 to 3, the edges of panel \"front\""},
        Wrong{"StitchToItself",
              [](json& d) { d["pattern"]["stitches"][1][1] = d["pattern"]["stitches"][1][0]; },
              "pattern.stitches[1]: ", "two different edges"},
        Wrong{"StitchTwice",
              [](json& d) { d["pattern"]["stitches"][1] = d["pattern"]["stitches"][0]; },
              "pattern.stitches[1]: ", "each pair of edges once"},
        Wrong{"StitchOfOneSide", [](json& d) { d["pattern"]["stitches"][1].erase(1); },
              "pattern.stitches[1]: ", "two sides"},
        Wrong{"Ratio",
              [](json& d) {
                front_vertex(d, 2)[1] = 200;
                front_vertex(d, 3)[1] = 200;
              },
              "pattern.stitches[0]: ", "more than 3"},
        Wrong{"FrontToBack",
              [](json& d) {
                // the front half sewn to the rear, the other half to the front: a Möbius strip
                d["pattern"]["panels"]["rear"]["rotation"] = {0, 0, 0};
                d["pattern"]["stitches"][1] = {{{"panel", "front"}, {"edge", 3}},
                                               {{"panel", "rear"}, {"edge", 0}},
                                               "right_wrong"};
                d["pattern"]["panels"]["rear"]["translation"] = {0, 500, -20};
              },
              "pattern.stitches[1]: ", "front sewn to back"},
        Wrong{"Units", [](json& d) { d["properties"]["units_in_meter"] = 0; },
              "properties.units_in_meter: ", "0.0;"},
        Wrong{"Coordinates", [](json& d) { d["properties"]["curvature_coords"] = "polar"; },
              "properties.curvature_coords: ", "\"polar\""}),
    [](const testing::TestParamInfo<Wrong>& w) { return std::string(w.param.name); });

TEST(MakeGarment, RefusesEdgeLengthsThatMakeTooManyTriangles) {
  EXPECT_THROW(garment_of(tube(), 1e-5), SceneError);
  EXPECT_THROW(garment_of(tube(), 0), SceneError);
  EXPECT_THROW(garment_of(tube(), -1), SceneError);
  EXPECT_THROW(garment_of(tube(), std::numeric_limits<double>::quiet_NaN()), SceneError);
}

fs::path data_file(const std::string& name) {
  const char* data = std::getenv("WEFT_TEST_DATA");
  const fs::path file = fs::path(data != nullptr ? data : "") / "garments" / name;
  return data != nullptr && fs::exists(file) ? file : fs::path();
}

/// Patterns of GarmentCode: panels face the body, seams are as short as the panels stand apart, and
/// nothing has to be repaired.
class GivenPattern : public testing::TestWithParam<const char*> {};

TEST_P(GivenPattern, BecomesAGarment) {
  const fs::path file = data_file(std::string(GetParam()) + "_specification.json");
  if (file.empty()) GTEST_SKIP() << "WEFT_TEST_DATA holds no garments/" << GetParam();
  const SewingPattern pattern =
      read_sewing_pattern(parse_json(read_file_bytes(file), file.string()), file.string());
  EXPECT_EQ(pattern.name, GetParam());
  for (const double length : {0.01, 0.015, 0.02, 0.03}) {
    const Garment garment = make_garment(pattern, length);
    expect_good(garment, std::string(GetParam()) + " at " + std::to_string(length),
                length > 0.02 ? 13 : 20);
    EXPECT_TRUE(garment.notes.empty()) << garment.notes.front();
    ASSERT_EQ(garment.seams.size(), pattern.stitches.size());
    const auto& x = garment.mesh.positions;
    for (const GarmentSeam& seam : garment.seams)
      for (const auto& [a, b] : seam.pairs) EXPECT_LT(length_sq(x[at(a)] - x[at(b)]), 0.56 * 0.56);
    for (std::size_t t = 0; t < garment.mesh.triangles.size(); ++t) {
      const auto& v = garment.mesh.triangles[t].v;
      const Vec3<double> normal = cross(x[at(v[1])] - x[at(v[0])], x[at(v[2])] - x[at(v[0])]);
      EXPECT_GT(normal[2] * x[at(v[0])][2], 0) << "faces the body: triangle " << t;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Files, GivenPattern, testing::Values("shirt_mean", "dress_pencil"),
                         [](const testing::TestParamInfo<const char*>& name) {
                           return std::string(name.param);
                         });

}  // namespace
}  // namespace weft::io
