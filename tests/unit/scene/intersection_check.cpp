#include "host/scene/intersection_check.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "host/geometry/box_tree.hpp"
#include "host/geometry/triangle_pair.hpp"
#include "host/scene/surfaces.hpp"
#include "weft/error.hpp"
#include "weft/shapes.hpp"

namespace weft {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;
using testing::StartsWith;

/// What the refusal says; empty if the scene is accepted.
std::string refusal(const Scene& scene) {
  try {
    refuse_intersecting_start(scene);
  } catch (const SceneError& e) {
    return e.what();
  }
  return {};
}

Mesh placed(Mesh mesh, const Transform& transform) {
  for (auto& x : mesh.positions) x = apply(transform, x);
  return mesh;
}

Mesh raised(Mesh mesh, double height) {
  return placed(std::move(mesh), {{0, 0, height}, {0, 0, 1}, 0, 1});
}

Mesh grid(Index cells, double height) {
  return raised(make_grid({1, 1}, {cells, cells}, Diagonals::alternating), height);
}

/// Two triangles of 1 m, far coarser than grid(8, ...).
Mesh square(double height) {
  return raised(make_grid({1, 1}, {1, 1}, Diagonals::same), height);
}

Scene scene_of(std::vector<Mesh> cloths) {
  Scene scene;
  scene.file = "made.json";
  scene.materials.push_back({});
  for (auto& mesh : cloths)
    scene.cloths.push_back(
        {"sheet" + std::to_string(scene.cloths.size()), std::move(mesh), 0, {0, 0, 0}});
  return scene;
}

void add_obstacle(Scene& scene, const std::string& name, Mesh mesh,
                  const Transform& transform = {}) {
  Obstacle obstacle;
  obstacle.name = name;
  obstacle.mesh = std::move(mesh);
  obstacle.transform = transform;
  scene.obstacles.push_back(std::move(obstacle));
}

/// Any tilt, so that rounding makes no coordinate exact.
Transform tilted() {
  const double third = 1 / std::sqrt(3.0);
  return {{0.3, -1.7, 2.9}, {third, third, third}, 0.7, 1};
}

TEST(Tangle, AcceptsGridOverSphere) {
  Scene scene = scene_of({grid(20, 0.51)});
  add_obstacle(scene, "ball", make_icosphere(0.5, 3));
  EXPECT_THAT(refusal(scene), IsEmpty());
}

TEST(Tangle, AcceptsStackWithGaps) {
  std::vector<Mesh> sheets;
  for (int i = 0; i < 5; ++i) sheets.push_back(placed(grid(10, 0.002 * i), tilted()));
  Scene scene = scene_of(sheets);
  EXPECT_THAT(refusal(scene), IsEmpty());
}

TEST(Tangle, AcceptsFineGapAndRefusesNone) {
  for (const Transform& all : {Transform{}, tilted()}) {
    EXPECT_THAT(refusal(scene_of({placed(grid(8, 0), all), placed(square(1e-9), all)})), IsEmpty());
    EXPECT_THAT(refusal(scene_of({placed(grid(8, 0), all), placed(square(0), all)})),
                HasSubstr("intersect, "));
  }
}

TEST(Tangle, RefusesSameSheetTwice) {
  // Of the two times two triangles, all four pairs overlap or touch.
  EXPECT_EQ(refusal(scene_of({square(0), square(0)})),
            "made.json: cloths[0] (sheet0): triangles 0 of sheet0 and 0 of sheet1, "
            "0 of sheet0 and 1 of sheet1, 1 of sheet0 and 0 of sheet1, "
            "1 of sheet0 and 1 of sheet1 intersect, 4 pairs in all; "
            "allowed: a start free of intersections, touching included, or contact.untangle true, "
            "which moves cloth apart");
}

TEST(Tangle, RefusesClothThroughSphere) {
  Scene scene = scene_of({grid(20, 2), grid(20, 0.3)});
  add_obstacle(scene, "ball", make_icosphere(0.5, 3));
  const std::string what = refusal(scene);
  EXPECT_THAT(what, StartsWith("made.json: cloths[1] (sheet1): triangles "));
  EXPECT_THAT(what, HasSubstr(" of sheet1 and "));
  EXPECT_THAT(what, HasSubstr(" of ball"));
}

// So many triangles that threads share them out: every pair is found once.
TEST(Tangle, CountsAllPairsOfLargeSheets) {
  const Scene scene = scene_of({placed(grid(48, 0), tilted()), placed(grid(48, 1e-4), tilted()),
                                placed(make_grid({1, 1}, {3, 3}, Diagonals::same),
                                       {tilted().translate, {1, 0, 0}, 1.3, 1})});
  const Surfaces all = surfaces_at_start(scene, {});
  std::vector<Aabb> boxes;
  for (const Tri& t : all.triangles) {
    Aabb box;
    for (const Index v : t.v)
      box.include(all.points[static_cast<std::size_t>(v)], all.points[static_cast<std::size_t>(v)]);
    boxes.push_back(box);
  }
  int count = 0;
  for (std::size_t a = 0; a < boxes.size(); ++a)
    for (std::size_t b = a + 1; b < boxes.size(); ++b)
      if (boxes[a].overlaps(boxes[b]) && triangles_intersect(all.triangles[a], all.triangles[b],
                                                             all.corners(static_cast<Index>(a)),
                                                             all.corners(static_cast<Index>(b))))
        ++count;
  EXPECT_GT(count, 20);
  EXPECT_THAT(refusal(scene), HasSubstr(" " + std::to_string(count) + " pairs in all"));
}

TEST(Tangle, NamesThePairByInputNumbers) {
  // A needle of an obstacle through one triangle: the second of cell (2, 1).
  Mesh sheet = make_grid({4, 4}, {4, 4}, Diagonals::same);
  const Mesh needle{{{0.3, -0.3, -1}, {0.3, -0.3, 1}, {0.31, -0.3, -1}}, {}, {{{0, 1, 2}}}};
  Mesh far = needle;
  for (auto& x : far.positions) x[0] += 100;
  far.positions.insert(far.positions.end(), needle.positions.begin(), needle.positions.end());
  far.triangles.push_back({{3, 4, 5}});
  Index expected = -1;
  for (std::size_t t = 0; t < sheet.triangles.size(); ++t) {
    const auto& v = sheet.triangles[t].v;
    Vec3<double> centre{0, 0, 0};
    for (const Index i : v) centre += sheet.positions[static_cast<std::size_t>(i)] * (1.0 / 3);
    if (length(centre - Vec3<double>{1.0 / 3, -1.0 / 3, 0}) < 1e-9)
      expected = static_cast<Index>(t);
  }
  ASSERT_GE(expected, 0);
  Scene scene = scene_of({sheet});
  add_obstacle(scene, "needles", far);
  EXPECT_THAT(refusal(scene), HasSubstr("triangles " + std::to_string(expected) +
                                        " of sheet0 and 1 of needles intersect, 1 pair in all"));
}

TEST(Tangle, FollowsTransformAndMotionOfObstacles) {
  Scene scene = scene_of({grid(10, 0)});
  add_obstacle(scene, "ball", make_icosphere(0.5, 2), {{0, 0, 3}, {0, 0, 1}, 0, 1});
  EXPECT_THAT(refusal(scene), IsEmpty());
  scene.obstacles[0].motion = {{0, {}}, {1, scene.obstacles[0].transform}};
  EXPECT_THAT(refusal(scene), HasSubstr("of ball"));
}

TEST(Tangle, RefusesClothInsideClosedObstacle) {
  Scene scene = scene_of({grid(4, 5), grid(4, 0)});
  add_obstacle(scene, "ball", make_icosphere(2, 2));
  EXPECT_EQ(refusal(scene),
            "made.json: cloths[1] (sheet1): a start inside obstacles[0] (ball), with vertex 0 and "
            "all that hangs together with it; "
            "allowed: a start outside of closed obstacles, such as sheet1 lifted by 2.01 m along "
            "(0, 0, 1)");
  scene.contact.untangle = true;
  EXPECT_THAT(refusal(scene), HasSubstr("; contact.untangle moves out only cloth that passes"));
}

/// The distance that a refusal names; 0: none.
double lift_of(const Scene& scene) {
  const std::string what = refusal(scene);
  const std::string before = " lifted by ";
  const std::size_t at = what.find(before);
  return at == std::string::npos ? 0 : std::stod(what.substr(at + before.size()));
}

Scene lifted(Scene scene, const Vec3<double>& offset) {
  for (auto& x : scene.cloths[0].mesh.positions) x += offset;
  return scene;
}

TEST(Tangle, SaysHowFarToLiftFromATable) {
  Scene scene = scene_of({grid(4, 0)});
  add_obstacle(scene, "table", make_box({3, 3, 1}, {3, 3, 1}), {{0, 0, -0.5}, {0, 0, 1}, 0, 1});
  EXPECT_THAT(refusal(scene), HasSubstr("pairs in all, one at ("));
  EXPECT_THAT(refusal(scene), HasSubstr(" of table"));
  EXPECT_THAT(refusal(scene), HasSubstr("such as sheet0 lifted by 0.001 m along (0, 0, 1), or "
                                        "contact.untangle true"));
  EXPECT_THAT(refusal(lifted(scene, {0, 0, 0.001})), IsEmpty());
  EXPECT_NEAR(lift_of(lifted(scene, {0, 0, -0.02})), 0.021, 1e-4);
  // Against gravity, wherever it points.
  scene.gravity = {0, 0, 4};
  EXPECT_NEAR(lift_of(scene), 1.001, 0.01);
  EXPECT_THAT(refusal(scene), HasSubstr(" along (0, 0, -1)"));
}

TEST(Tangle, TheLiftThatItNamesClearsTheCloth) {
  Scene scene = scene_of({grid(8, 0.3)});
  scene.contact.thickness = 0.002;
  add_obstacle(scene, "ball", make_icosphere(0.5, 3));
  for (const Vec3<double>& gravity : {Vec3<double>{0, 0, -9.81}, {0, 0, 0}, {3, -2, -9}}) {
    scene.gravity = gravity;
    const double g = length(gravity);
    const Vec3<double> up = g > 0 ? (-1 / g) * gravity : Vec3<double>{0, 0, 1};
    const double lift = lift_of(scene);
    ASSERT_GT(lift, 0.15);
    EXPECT_THAT(refusal(lifted(scene, lift * up)), IsEmpty());
    EXPECT_THAT(refusal(lifted(scene, (lift - 0.004) * up)), HasSubstr(" of ball"));
  }
  // Up through a lid nothing clears it sooner than above that.
  scene.gravity = {0, 0, -9.81};
  add_obstacle(scene, "lid", make_box({3, 3, 0.1}, {1, 1, 1}), {{0, 0, 0.52}, {0, 0, 1}, 0, 1});
  EXPECT_NEAR(lift_of(scene), 0.272, 0.002);
}

TEST(Tangle, NamesRepairForVerticesAtOnePlace) {
  Mesh torn = grid(2, 0);
  const auto first = static_cast<Index>(torn.positions.size());
  const Mesh half = torn;
  torn.positions.insert(torn.positions.end(), half.positions.begin(), half.positions.end());
  for (std::size_t t = 4; t < torn.triangles.size(); ++t)
    for (Index& v : torn.triangles[t].v) v += first;
  EXPECT_THAT(refusal(scene_of({torn})),
              HasSubstr("or \"repair\": true of a mesh file, which joins vertices at one place"));
}

TEST(Tangle, LooksAtEachPartOfACloth) {
  Mesh parts = grid(2, 5);
  const auto first = static_cast<Index>(parts.positions.size());
  const Mesh second = grid(2, 0);
  parts.positions.insert(parts.positions.end(), second.positions.begin(), second.positions.end());
  for (const Tri& t : second.triangles)
    parts.triangles.push_back({{first + t.v[0], first + t.v[1], first + t.v[2]}});
  Scene scene = scene_of({parts});
  add_obstacle(scene, "ball", make_icosphere(2, 2));
  EXPECT_THAT(refusal(scene), HasSubstr("inside obstacles[0] (ball), with vertex 9 "));
}

TEST(Tangle, AcceptsClothInOpenOrInsideOutObstacle) {
  Scene scene = scene_of({grid(4, 0)});
  Mesh open = make_icosphere(2, 2);
  open.triangles.pop_back();
  add_obstacle(scene, "open", open);
  Mesh room = make_box({3, 3, 3}, {2, 2, 2});
  for (Tri& t : room.triangles) std::swap(t.v[1], t.v[2]);
  add_obstacle(scene, "room", room);
  EXPECT_THAT(refusal(scene), IsEmpty());
}

TEST(Tangle, RefusesTouching) {
  // A corner on the inside of a face, two edges across, a corner on a corner; then the same tilted,
  // where rounding may leave a gap of its own.
  const Mesh floor = raised(Mesh{{{-1, -1, 0}, {1, -1, 0}, {0, 1, 0}}, {}, {{{0, 1, 2}}}}, 0);
  const Mesh on_face{{{0.1, 0.07, 0}, {0.3, 0.2, 1}, {-0.3, 0.1, 1}}, {}, {{{0, 1, 2}}}};
  const Mesh on_edge{{{0.1, -2, 1}, {0.1, 0, -1}, {0.3, -2, 3}}, {}, {{{0, 1, 2}}}};
  const Mesh on_corner{{{0, 1, 0}, {0.3, 2, 1}, {-0.3, 2, 1}}, {}, {{{0, 1, 2}}}};
  for (const Transform& all : {Transform{}, tilted()})
    for (const Mesh& other : {on_face, on_edge, on_corner}) {
      Scene scene = scene_of({placed(floor, all)});
      add_obstacle(scene, "other", other, all);
      EXPECT_THAT(refusal(scene),
                  HasSubstr("triangles 0 of sheet0 and 0 of other intersect, 1 pair"));
    }
}

TEST(Tangle, RefusesSelfIntersectionUnlessSelfContactIsOff) {
  // A strip rolled up so far that its end runs through its beginning.
  Mesh strip = make_grid({2, 0.3}, {40, 6}, Diagonals::alternating);
  for (auto& x : strip.positions) {
    const double turn = 1.1 * std::numbers::pi * x[0];
    const double radius = 0.3 + 0.02 * std::fabs(x[0]) + 0.2 * (x[0] > 0 ? x[0] - 0.9 : 0);
    x = {radius * std::sin(turn), x[1], radius * std::cos(turn)};
  }
  Scene scene = scene_of({strip});
  const std::string what = refusal(scene);
  EXPECT_THAT(what, StartsWith("made.json: cloths[0] (sheet0): triangles "));
  EXPECT_THAT(what, HasSubstr(" of sheet0 intersect, "));
  scene.contact.self = false;
  EXPECT_THAT(refusal(scene), IsEmpty());
}

TEST(Tangle, SelfContactOffStillSeesObstacles) {
  Scene scene = scene_of({grid(8, 0), grid(8, 0)});
  scene.contact.self = false;
  EXPECT_THAT(refusal(scene), IsEmpty());
  add_obstacle(scene, "ball", make_icosphere(0.3, 2));
  EXPECT_THAT(refusal(scene), HasSubstr("of ball"));
}

TEST(Tangle, AcceptsFoldsAndRefusesNeighboursThatOverlap) {
  // Two triangles on the edge 0-1, the second turned over onto the first by an angle.
  const auto folded = [](double angle) {
    Mesh mesh{
        {{0, 0, 0}, {1, 0, 0}, {0.4, 1, 0}, {0.6, 0.5 * std::cos(angle), 0.5 * std::sin(angle)}},
        {},
        {{{0, 1, 2}}, {{1, 0, 3}}}};
    return scene_of({mesh});
  };
  EXPECT_THAT(refusal(folded(std::numbers::pi)), IsEmpty());
  EXPECT_THAT(refusal(folded(1e-6)), IsEmpty());
  EXPECT_THAT(refusal(folded(0)), HasSubstr("triangles 0 and 1 of sheet0 intersect, 1 pair"));

  // Two on vertex 0, the far edge of the second through the first.
  Mesh bow{{{0, 0, 0}, {1, -1, 0}, {1, 1, 0}, {0.5, 0.1, 1}, {0.5, 0, -1}},
           {},
           {{{0, 1, 2}}, {{0, 3, 4}}}};
  EXPECT_THAT(refusal(scene_of({bow})), HasSubstr("triangles 0 and 1 of sheet0 intersect, 1 pair"));
  bow.positions[4] = {0.5, 0, 0.5};
  EXPECT_THAT(refusal(scene_of({bow})), IsEmpty());
}

TEST(Tangle, IgnoresObstaclesThatOverlap) {
  Scene scene = scene_of({grid(8, 3)});
  add_obstacle(scene, "ball", make_icosphere(0.5, 2));
  add_obstacle(scene, "box", make_box({1, 1, 1}, {2, 2, 2}));
  add_obstacle(scene, "box again", make_box({1, 1, 1}, {2, 2, 2}));
  EXPECT_THAT(refusal(scene), IsEmpty());
}

TEST(Tangle, PiercingIsExact) {
  // A spike whose tip passes a large sloping face by a part in 10^11 of its size or stops as short
  // of it.
  const Mesh face{{{-1, -1, -1.1}, {1, -1, 0.7}, {0.2, 1, 0.3}}, {}, {{{0, 1, 2}}}};
  const auto spike = [](double beyond) {
    const Vec3<double> n = [] {
      const Vec3<double> raw = cross(Vec3<double>{2, 0, 1.8}, Vec3<double>{1.2, 2, 1.4});
      return raw * (1 / length(raw));
    }();
    const Vec3<double> middle{0.2 / 3, -1.0 / 3, -0.1 / 3};
    return Mesh{
        {middle - n * beyond, middle + n + Vec3<double>{0.1, 0, 0}, middle + n}, {}, {{{0, 1, 2}}}};
  };
  EXPECT_THAT(refusal(scene_of({face, spike(2e-11)})), HasSubstr("1 pair in all"));
  EXPECT_THAT(refusal(scene_of({face, spike(-2e-11)})), IsEmpty());
}

}  // namespace
}  // namespace weft
