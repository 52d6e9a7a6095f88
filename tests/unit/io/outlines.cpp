// Outlines of panels from SVG and DXF, and the patterns that add stitches and places to them.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numbers>
#include <string>
#include <vector>

#include "host/io/json/json_fields.hpp"
#include "host/io/pattern/edge_curve.hpp"
#include "host/io/pattern/garment.hpp"
#include "host/io/pattern/outline_file.hpp"
#include "host/io/pattern/pattern_file.hpp"
#include "host/io/pattern/svg_path.hpp"
#include "tests/unit/io/directories.hpp"
#include "weft/core/at.hpp"
#include "weft/error.hpp"

namespace weft::io {
namespace {

using Names = std::vector<std::string>;
using Shape = PatternEdge::Shape;

/// What a refusal says.
std::string refusal(const std::function<void()>& work) {
  try {
    work();
  } catch (const SceneError& error) {
    const std::string text = error.what();
    EXPECT_EQ(text.find('\n'), std::string::npos) << text;
    return text;
  }
  return "nothing was refused";
}

void expect_refusal(const std::function<void()>& work, const std::string& part) {
  const std::string text = refusal(work);
  EXPECT_NE(text.find(part), std::string::npos) << text;
}

// ------------------------------------------------------------------------------------------- DXF
using Pairs = std::vector<std::pair<int, std::string>>;

std::string lines(const Pairs& pairs) {
  std::string text;
  for (const auto& [code, value] : pairs) text += std::to_string(code) + "\n" + value + "\n";
  return text;
}

std::string polyline(int layer, const std::vector<std::array<int, 2>>& points, bool closed = true) {
  const std::string own = std::to_string(layer);
  std::string text = lines({{0, "POLYLINE"}, {8, own}, {70, closed ? "1" : "0"}});
  for (const auto& p : points)
    text +=
        lines({{0, "VERTEX"}, {8, own}, {10, std::to_string(p[0])}, {20, std::to_string(p[1])}});
  return text + lines({{0, "SEQEND"}});
}

std::string line(int layer, std::array<int, 2> a, std::array<int, 2> b) {
  return lines({{0, "LINE"},
                {8, std::to_string(layer)},
                {10, std::to_string(a[0])},
                {20, std::to_string(a[1])},
                {11, std::to_string(b[0])},
                {21, std::to_string(b[1])}});
}

std::string point(int layer, std::array<int, 2> p) {
  return lines({{0, "POINT"},
                {8, std::to_string(layer)},
                {10, std::to_string(p[0])},
                {20, std::to_string(p[1])}});
}

std::string block(const std::string& name, const std::string& content) {
  return lines({{0, "BLOCK"}, {8, "1"}, {2, name}}) + content + lines({{0, "ENDBLK"}});
}

/// In millimetres.
std::string dxf(const std::string& blocks, const std::string& entities = "",
                const std::string& units = "Units: METRIC") {
  return lines({{0, "SECTION"}, {2, "BLOCKS"}}) + blocks +
         lines({{0, "ENDSEC"}, {0, "SECTION"}, {2, "ENTITIES"}}) + entities +
         lines({{0, "TEXT"}, {8, "1"}, {1, units}, {0, "ENDSEC"}, {0, "EOF"}});
}

PatternPanel dxf_panel(const std::string& text, const std::string& name) {
  return parse_dxf_outlines(text, "p.dxf", {})->panel(name, "field");
}

const std::vector<std::array<int, 2>> rectangle{{0, 0}, {100, 0}, {200, 0}, {200, 300}, {0, 300}};

void expect_near(const Vec2<double>& a, const Vec2<double>& b) {
  EXPECT_NEAR(a[0], b[0], 1e-12);
  EXPECT_NEAR(a[1], b[1], 1e-12);
}

TEST(DxfOutlines, PieceIsAPanelInMetres) {
  const std::string text =
      dxf(block("P1", polyline(1, rectangle) + polyline(8, {{1, 1}, {2, 2}}, false) +
                          line(7, {50, 10}, {50, 200}) + point(4, {200, 150}) +
                          lines({{0, "TEXT"}, {8, "1"}, {1, "Piece Name: FRONT"}})));
  const auto outlines = parse_dxf_outlines(text, "p.dxf", {});
  EXPECT_EQ(outlines->names(), (Names{"FRONT"}));
  const PatternPanel panel = outlines->panel("FRONT", "field");
  ASSERT_EQ(panel.edges.size(), 4u);
  expect_near(panel.vertices[2], {0.2, 0.3});
  EXPECT_EQ(panel.edges[0].shape, Shape::polyline);  // through the point in its middle
  EXPECT_EQ(panel.edges[1].shape, Shape::line);
  expect_near(panel.grain, {0, 0.19});
  ASSERT_EQ(panel.notches.size(), 1u);
  expect_near(panel.notches[0], {0.2, 0.15});
}

TEST(DxfOutlines, NotchesOfHalfAPanelAreUnfolded) {
  const PatternPanel panel =
      dxf_panel(dxf(block("P1", polyline(1, rectangle) + line(6, {0, 300}, {0, 0}) +
                                    point(4, {200, 150}) + point(4, {0, 300}))),
                "P1");
  ASSERT_EQ(panel.notches.size(), 3u);
  expect_near(panel.notches[2], {-0.2, 0.15});
}

TEST(DxfOutlines, TurnPointsAreCorners) {
  const std::string corners = point(2, {0, 0}) + point(2, {200, 300}) + point(3, {200, 0});
  const PatternPanel panel = dxf_panel(dxf(block("P1", polyline(1, rectangle) + corners)), "P1");
  ASSERT_EQ(panel.edges.size(), 2u);
  EXPECT_EQ(panel.edges[0].controls.size(), 2u);
  EXPECT_NEAR(EdgeCurve(panel, panel.edges[0]).length(), 0.5, 1e-12);
}

TEST(DxfOutlines, SmoothVerticesAreNoCornersWithoutTurnPoints) {
  // A half disc with a vertex every 10 degrees.
  std::vector<std::array<int, 2>> points;
  for (int k = 0; k <= 18; ++k)
    points.push_back({static_cast<int>(1000 * std::cos(k * std::numbers::pi / 18)),
                      static_cast<int>(1000 * std::sin(k * std::numbers::pi / 18))});
  const PatternPanel panel = dxf_panel(dxf(block("D", polyline(1, points))), "D");
  ASSERT_EQ(panel.edges.size(), 2u);
  EXPECT_EQ(panel.edges[0].controls.size(), 17u);
  EXPECT_NEAR(EdgeCurve(panel, panel.edges[0]).length(), std::numbers::pi, 0.01);
}

TEST(DxfOutlines, MirrorLineUnfoldsAPiece) {
  const std::string half = polyline(1, {{0, 0}, {200, 0}, {200, 300}, {0, 400}});
  for (const std::string& fold : {line(6, {0, 0}, {0, 400}), line(6, {0, 400}, {0, 0})}) {
    const PatternPanel panel = dxf_panel(dxf(block("P", half + fold)), "P");
    double width = 0, area = 0;
    for (std::size_t k = 0; k < panel.vertices.size(); ++k) {
      const Vec2<double> a = panel.vertices[k], b = panel.vertices[(k + 1) % panel.vertices.size()];
      width = std::max(width, std::abs(a[0]));
      area += (a[0] * b[1] - b[0] * a[1]) / 2;
    }
    EXPECT_NEAR(width, 0.2, 1e-12);
    EXPECT_NEAR(std::abs(area), 2 * 0.2 * 0.35, 1e-12);
    // The hem runs on across the fold, the neck has a corner there.
    ASSERT_EQ(panel.edges.size(), 5u);
  }
  expect_refusal(
      [&] {
        dxf_panel(dxf(block("P", half + line(6, {0, 500}, {200, 500}))), "P");
      },
      "block P: a mirror line beside the outline");
}

TEST(DxfOutlines, SewLineStandsAboveTheCutLine) {
  const std::string sewn = polyline(14, {{10, 10}, {190, 10}, {190, 290}, {10, 290}});
  const PatternPanel panel = dxf_panel(dxf(block("P", polyline(1, rectangle) + sewn)), "P");
  expect_near(panel.vertices[0], {0.01, 0.01});
  const std::string open = polyline(14, {{10, 10}, {190, 10}}, false);
  expect_near(dxf_panel(dxf(block("P", polyline(1, rectangle) + open)), "P").vertices[0], {0, 0});
}

TEST(DxfOutlines, BulgesAreArcs) {
  const PatternPanel panel = dxf_panel(dxf("", lines({{0, "LWPOLYLINE"},
                                                      {8, "1"},
                                                      {70, "1"},
                                                      {10, "0"},
                                                      {20, "0"},
                                                      {10, "100"},
                                                      {20, "0"},
                                                      {42, "1"},
                                                      {10, "100"},
                                                      {20, "200"},
                                                      {10, "0"},
                                                      {20, "200"}})),
                                       "panel");
  double most = 0;
  for (const PatternEdge& edge : panel.edges)
    for (const Vec2<double>& p : edge.controls) most = std::max(most, p[0]);
  EXPECT_NEAR(most, 0.2, 1e-6);  // half a circle to the right of x = 100 mm
}

TEST(DxfOutlines, UnitsComeFromTheFileOrThePattern) {
  const std::string outline = block("P", polyline(1, rectangle));
  const auto size = [&](const std::string& text, std::optional<double> unit = {}) {
    return parse_dxf_outlines(text, "p.dxf", unit)->panel("P", "field").vertices[1][0];
  };
  EXPECT_NEAR(size(dxf(outline, "", "Units: ENGLISH")), 200 * 0.0254, 1e-12);
  EXPECT_NEAR(size(dxf(outline), 0.01), 2, 1e-12);
  const auto header = [&](const std::string& variable, const std::string& value) {
    return lines({{0, "SECTION"}, {2, "HEADER"}, {9, variable}, {70, value}, {0, "ENDSEC"}});
  };
  EXPECT_NEAR(size(header("$INSUNITS", "5") + dxf(outline, "", "")), 2, 1e-12);
  EXPECT_NEAR(size(header("$MEASUREMENT", "0") + dxf(outline, "", "")), 200 * 0.0254, 1e-12);
  expect_refusal([&] { size(dxf(outline, "", "")); }, "p.dxf: units: missing");
  EXPECT_NEAR(size(dxf(outline, "", ""), 0.001), 0.2, 1e-12);
}

TEST(DxfOutlines, SizesOfOnePieceKeepTheNamesOfTheirBlocks) {
  const std::string content =
      polyline(1, rectangle) + lines({{0, "TEXT"}, {8, "1"}, {1, "piece name: FRONT"}});
  EXPECT_EQ(
      parse_dxf_outlines(dxf(block("F_S", content) + block("F_M", content)), "p.dxf", {})->names(),
      (Names{"F_S", "F_M"}));
}

TEST(DxfOutlines, WrongFilesGetOneLine) {
  const auto read = [](const std::string& text) { return [text] { dxf_panel(text, "P"); }; };
  const std::string good = dxf(block("P", polyline(1, rectangle)));
  EXPECT_EQ(refusal(read(good)), "nothing was refused");
  expect_refusal(read("AutoCAD Binary DXF\r\n"), "p.dxf: format: binary DXF");
  expect_refusal(read(""), "p.dxf: EOF: missing");
  expect_refusal(read(good.substr(0, good.size() / 2)), "p.dxf: ");
  expect_refusal(read("x\nSECTION\n"), "line 1: group code: \"x\"");
  expect_refusal(read("99999\nSECTION\n"), "line 1: group code: \"99999\"");
  expect_refusal(read("0\n"), "end of file");
  expect_refusal(read(dxf(block("P", polyline(1, rectangle) + line(6, {0, 0}, {0, 999999999})))),
                 "block P: a coordinate beyond 100 m");
  expect_refusal(read(dxf(block("P", polyline(1, rectangle) + line(7, {0, 0}, {0, 999999999})))),
                 "block P: a coordinate beyond 100 m");
  expect_refusal(read(dxf(block("P", polyline(1, rectangle, false)))),
                 "block P: an outline that is open");
  expect_refusal(read(dxf(block("P", polyline(1, {{0, 0}, {1, 1}})))), "block P: 2 points");
  expect_refusal(read(dxf(block("P", polyline(2, rectangle)))), "blocks: no piece");
  expect_refusal(read(dxf(block("Q", polyline(1, rectangle)))),
                 "no piece of this name; allowed: one of Q");
  expect_refusal(read(dxf(block("P", polyline(1, {{0, 0}, {1000000, 0}, {0, 9}})))),
                 "beyond 100 m");
  expect_refusal(
      read(dxf(block("P", lines({{0, "POLYLINE"}, {8, "1"}, {0, "VERTEX"}, {10, "1e"}})))),
      "code 10: \"1e\"");
  expect_refusal(
      read(dxf(block("P", lines({{0, "LWPOLYLINE"}, {8, "1"}, {10, "1"}, {10, "2"}, {20, "3"}})))),
      "LWPOLYLINE: \"2 x and 1 y\"");
}

// ------------------------------------------------------------------------------------------- SVG
std::string svg(const std::string& content,
                const std::string& size = R"(width="400mm" height="400mm" viewBox="0 0 400 400")") {
  return "<svg xmlns=\"http://www.w3.org/2000/svg\" "
         "xmlns:inkscape=\"http://www.inkscape.org/namespaces/inkscape\" " +
         size + ">" + content + "</svg>";
}

PatternPanel svg_panel(const std::string& text, const std::string& name = "a") {
  return parse_svg_outlines(text, "p.svg", {})->panel(name, "field");
}

PatternPanel path(const std::string& d) {
  return svg_panel(svg("<path id=\"a\" d=\"" + d + "\"/>"));
}

TEST(SvgOutlines, CommandsAreEdges) {
  // Absolute, relative, and repeated without their letters.
  for (const char* d :
       {"M10,20 L110,20 110,70 10,70 Z", "m10 20h100v50h-100z", "M10 20H110V70H10V20",
        "M10 20l100 0 0 50-100 0Z", "M1e1,+20L110 20,110 70,10 70,10 20"}) {
    const PatternPanel panel = path(d);
    ASSERT_EQ(panel.edges.size(), 4u) << d;
    for (const PatternEdge& edge : panel.edges) EXPECT_EQ(edge.shape, Shape::line) << d;
    expect_near(panel.vertices[0], {0.01, -0.02});  // y up
    expect_near(panel.vertices[2], {0.11, -0.07});
    EXPECT_EQ(panel.edges[3].to, 0);
  }
}

TEST(SvgOutlines, CurvesKeepTheirControlPoints) {
  const PatternPanel panel =
      path("M0 0 C10 0 20 10 20 20 S10 40 0 40 Q-10 40-10 30 T-10 10 c-5-5,0-10,10-10");
  ASSERT_EQ(panel.edges.size(), 5u);
  ASSERT_EQ(panel.edges[1].controls.size(), 2u);
  expect_near(panel.edges[1].controls[0], {0.02, -0.03});  // mirrored
  expect_near(panel.edges[2].controls[0], {-0.01, -0.04});
  ASSERT_EQ(panel.edges[3].controls.size(), 1u);
  expect_near(panel.edges[3].controls[0], {-0.01, -0.02});
  expect_near(panel.edges[4].controls[1], {-0.01, 0});
  // Without a curve before it, S and T have their control point where they begin.
  expect_near(path("M0 0h30S30 30 0 30z").edges[1].controls[0], {0.03, 0});
  expect_near(path("M0 0h30T0 30z").edges[1].controls[0], {0.03, 0});
}

TEST(SvgOutlines, ArcsHaveTheirLengths) {
  const PatternPanel disc = path("M0 0A50 50 0 0 1 100 0A50 50 0 0 1 0 0");
  ASSERT_EQ(disc.edges.size(), 2u);
  for (const PatternEdge& edge : disc.edges)
    EXPECT_NEAR(EdgeCurve(disc, edge).length(), 0.05 * std::numbers::pi, 1e-4);
  for (const PatternEdge& edge : disc.edges)
    for (const Vec2<double>& p : edge.controls)
      EXPECT_NEAR(length(p - Vec2<double>{0.05, 0}), 0.05, 1e-12);
  // Flags without spaces; the longer way; radii that do not reach grow.
  EXPECT_NEAR(
      EdgeCurve(path("M0 0a50 50 0 1150 50z"), path("M0 0a50 50 0 1150 50z").edges[0]).length(),
      0.075 * std::numbers::pi, 1e-3);
  const PatternPanel small = path("M0 0a1 1 0 0 1 100 0z");
  EXPECT_NEAR(EdgeCurve(small, small.edges[0]).length(), 0.05 * std::numbers::pi, 1e-4);
  // An ellipse that is turned by 90 degrees.
  const PatternPanel upright = path("M0 0A100 50 90 0 1 100 0z");
  double highest = 0;
  for (const Vec2<double>& p : upright.edges[0].controls) highest = std::max(highest, p[1]);
  EXPECT_NEAR(highest, 0.1, 1e-3);
}

TEST(SvgOutlines, TransformsAndUnits) {
  const std::string shape = "<path id=\"a\" d=\"M0 0h10v20z\"/>";
  const auto corner = [&](const std::string& transform, const std::string& size) {
    return svg_panel(svg("<g transform=\"" + transform + "\">" + shape + "</g>", size)).vertices[1];
  };
  const std::string mm = R"(width="100mm" viewBox="0 0 100 100")";
  expect_near(corner("", mm), {0.01, 0});
  expect_near(corner("translate(5)", mm), {0.015, 0});
  expect_near(corner("translate(5,7) scale(2)", mm), {0.025, -0.007});
  expect_near(corner("rotate(90)", mm), {0, -0.01});
  expect_near(corner("rotate(90 10 0)", mm), {0.01, 0});
  expect_near(corner("matrix(1 2 3 4 5 6)", mm), {0.015, -0.026});
  expect_near(corner("skewY(45)", mm), {0.01, -0.01});
  expect_near(corner("scale(1,-1) skewX(45)", mm), {0.01, 0});
  expect_near(corner("", R"(width="10cm" viewBox="0 0 50 50")"), {0.02, 0});
  expect_near(corner("", R"(width="2in" height="4in" viewBox="0 0 2 2")"), {0.254, 0});
  expect_near(corner("", R"(width="96" viewBox="0 0 96 96")"), {0.254 / 96, 0});
  expect_near(corner("", ""), {0.254 / 96, 0});
  expect_near(parse_svg_outlines(svg(shape), "p.svg", 1.0)->panel("a", "f").vertices[1], {10, 0});
}

TEST(SvgOutlines, NamesAreLabelsOrIdsOfClosedOutlines) {
  const std::string text = svg(
      R"(<defs><path id="hidden" d="M0 0h1v1z"/></defs><path id="p1" inkscape:label="front" d="M0 0h9v9z"/>)"
      R"(<polygon id="back" points="0,0 1,0 1,1"/><rect id="strip" width="3" height="2"/>)"
      R"(<rect id="paper" width="100%" height="100%"/><path id="mark" d="M0 0h9"/><path d="M0 0h9v9z"/>)"
      R"(<path id="two" d="M0 0h9v9zM1 1h1v1z"/>)");
  const auto outlines = parse_svg_outlines(text, "p.svg", {});
  EXPECT_EQ(outlines->names(), (Names{"front", "back", "strip"}));
  EXPECT_EQ(outlines->panel("strip", "field").edges.size(), 4u);
  expect_refusal([&] { (void)outlines->panel("hidden", "pattern.panels.hidden"); },
                 "p.svg: pattern.panels.hidden: no shape of this id or label");
  expect_refusal([&] { (void)outlines->panel("mark", "f"); },
                 "path \"mark\": d: an outline that is open");
  expect_refusal([&] { (void)outlines->panel("two", "f"); }, "path \"two\": d: 2 subpaths");
}

TEST(SvgOutlines, GrainIsALineBesideThePanel) {
  const std::string text = svg(R"x(<g transform="rotate(90)"><path id="a" d="M0 0h9v9z"/>)x"
                               R"(<line id="a-grain" x1="1" y1="2" x2="5" y2="2"/></g>)");
  expect_near(svg_panel(text).grain, {0, -0.004});
  EXPECT_EQ(path("M0 0h9v9z").grain, (Vec2<double>{0, 0}));
  expect_refusal(
      [] { svg_panel(svg(R"(<path id="a" d="M0 0h9v9z"/><path id="a-grain" d="M0 0h9v9z"/>)")); },
      "a-grain\": d: no line");
}

TEST(SvgOutlines, WrongFilesGetOneLine) {
  expect_refusal([] { path("M0 0h9v9"); }, "an outline that is open");
  expect_refusal([] { path("L0 0h9z"); }, "d at character 0: \"L0 0h9z\"");
  expect_refusal([] { path("M0 0h9x9z"); }, "d at character 6: \"x9z\"");
  expect_refusal([] { path("M0 0h9v"); }, "d at character 7: the end");
  expect_refusal([] { path("M0 0h9v1e999z"); }, "a finite number");
  expect_refusal([] { path("M0 0h9v-infz"); }, "a finite number");
  expect_refusal([] { path("M0 0h9v9z 5 5"); }, "a command");
  expect_refusal([] { path("M0 0a5 5 0 2 0 9 9z"); }, "allowed: 0 or 1");
  expect_refusal([] { path("M0 0h900000v9z"); }, "beyond 100 m");
  expect_refusal([] { path("M0 0h9c5 5 5-5 0 0v9z"); }, "edge 1: ends at one place");
  expect_refusal([] { path("M0 0z"); }, "d: 0 subpaths");
  const auto reads = [](const std::string& text) {
    return [text] { parse_svg_outlines(text, "p.svg", {}); };
  };
  expect_refusal(reads(""), "p.svg: line 1");
  expect_refusal(reads("<html/>"), "no svg");
  expect_refusal(reads("<svg><g></svg>"), "p.svg: line 1: mismatched tag");
  expect_refusal(reads("<!DOCTYPE svg [<!ENTITY a \"b\">]><svg/>"), "an entity declaration");
  expect_refusal(reads("<svg viewBox=\"0 0 0 9\"/>"), "viewBox: 0 0 0 9");
  expect_refusal(reads("<svg><g transform=\"turn(3)\"/></svg>"), "transform: turn with 1 number;");
  expect_refusal(reads("<svg><g transform=\"rotate(3\"/></svg>"), "\")\" after up to 6 numbers");
  std::string deep = "<svg>";
  for (int k = 0; k < 2000; ++k) deep += "<g>";
  expect_refusal(reads(deep), "more than 1000 elements within each other");
}

// -------------------------------------------------------------------------------------- patterns
class OutlinedPatterns : public DirectoryTest {
 protected:
  SewingPattern read(const std::string& text) const {
    put("t.json", text);
    return read_sewing_pattern(parse_json(text, "t.json"), (directory_ / "t.json").string());
  }
};

const char* const tube = R"({"pattern": {"outlines": "t.svg", "panels": {
  "front": {"label": "body", "translation": [0, 100, 20], "edge_labels": {"2": "waist"}},
  "back": {"translation": [0, 100, -20], "rotation": [0, 180, 0]}},
  "stitches": [[{"panel": "front", "edge": 1}, {"panel": "back", "edge": 3}],
               [{"panel": "front", "edge": 3}, {"panel": "back", "edge": 1}]]}})";
const char* const tube_outlines =
    R"(<path id="front" d="M0 0h300v200h-300z"/><path id="back" d="M350 0h300v200h-300z"/>)";

TEST_F(OutlinedPatterns, BecomeGarments) {
  put("t.svg", svg(tube_outlines));
  const SewingPattern pattern = read(tube);
  ASSERT_EQ(pattern.panels.size(), 2u);  // in the order of their names
  const PatternPanel& front = pattern.panels[1];
  EXPECT_EQ(front.name, "front");
  EXPECT_EQ(front.label, "body");
  expect_near(front.vertices[0], {-0.15, 0.1});  // about the middle of its box
  EXPECT_EQ(front.edges[2].label, "waist");
  EXPECT_EQ(front.translation, (Vec3<double>{0, 1, 0.2}));
  const Garment garment = make_garment(pattern, 0.05);
  EXPECT_EQ(garment.seams.size(), 2u);
  EXPECT_GT(garment.mesh.triangles.size(), 50u);
}

TEST_F(OutlinedPatterns, GrainTurnsTheWarp) {
  put("t.svg", svg(std::string(tube_outlines) + R"(<path id="front-grain" d="M10 10l30 40"/>)"));
  const SewingPattern pattern = read(tube);
  const Garment garment = make_garment(pattern, 0.05);
  const GarmentPanel& front = garment.panels[1];
  const Mesh& mesh = garment.mesh;
  // Places of the panel are its plane moved, with z towards the viewer: x along (0.6, -0.8) is
  // warp.
  const auto a = at(front.first_vertex);
  for (Index k = 1; k < front.vertex_count; ++k) {
    const auto b = a + at(k);
    const Vec3<double> d = mesh.positions[b] - mesh.positions[a];
    const double warp = 0.6 * d[0] - 0.8 * d[1];
    EXPECT_NEAR(std::abs(mesh.material[b][0] - mesh.material[a][0]), std::abs(warp), 1e-12);
  }
}

TEST_F(OutlinedPatterns, DxfPanelsBecomeGarmentsToo) {
  put("t.dxf", dxf(block("front", polyline(1, rectangle)) + block("back", polyline(1, rectangle))));
  std::string text = tube;
  text.replace(text.find("t.svg"), 5, "t.dxf");
  const Garment garment = make_garment(read(text), 0.05);
  EXPECT_EQ(garment.seams.size(), 2u);
}

TEST_F(OutlinedPatterns, WrongOnesGetOneLine) {
  put("t.svg", svg(tube_outlines));
  const auto with = [&](const std::string& from, const std::string& to) {
    std::string text = tube;
    text.replace(text.find(from), from.size(), to);
    return [this, text] { read(text); };
  };
  expect_refusal(with("t.svg", "missing.svg"), "missing.svg");
  expect_refusal(with("t.svg", "t.pdf"), "pattern.outlines: \"t.pdf\"");
  expect_refusal(with("t.svg", "../t.svg"), "pattern.outlines");
  expect_refusal(with("t.svg", "/etc/t.svg"), "pattern.outlines");
  expect_refusal(with("\"outlines\": \"t.svg\"", "\"outlines\": 7"), "pattern.outlines: 7");
  expect_refusal(with("\"t.svg\"", "\"t.svg\", \"outlines_unit\": \"ell\""),
                 "outlines_unit: \"ell\"");
  expect_refusal(with("\"front\": {", "\"side\": {"), "pattern.panels.side: no shape");
  expect_refusal(with("\"edge\": 1", "\"edge\": 4"), "stitches[0][0].edge: 4");
  expect_refusal(with("{\"2\":", "{\"4\":"), "edge_labels: \"4\"");
  expect_refusal(with("{\"2\":", "{\"x\":"), "edge_labels: \"x\"");
  expect_refusal(with("\"label\": \"body\"", "\"grain\": [0, 0]"),
                 "pattern.panels.front.grain: [0");
  expect_refusal(with("\"label\": \"body\"", "\"grain\": [1e200, 0]"),
                 "pattern.panels.front.grain: [1e");
  EXPECT_NO_THROW(with("\"t.svg\"", "\"t.svg\", \"outlines_unit\": \"mm\"")());
}

}  // namespace
}  // namespace weft::io
