#include "host/scene/seam_check.hpp"

#include <gtest/gtest.h>

#include <functional>
#include <limits>

#include "weft/error.hpp"
#include "weft/shapes.hpp"

namespace weft {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr double inf = std::numeric_limits<double>::infinity();

/// Two panels of 2 x 2 cells, the second turned over, and a seam along one side.
Scene garment(Diagonals diagonals = Diagonals::alternating) {
  Scene scene;
  scene.file = "made.json";
  scene.materials.emplace_back();
  for (const char* name : {"front", "back"}) {
    Cloth cloth;
    cloth.name = name;
    cloth.mesh = make_grid({1, 1}, {2, 2}, diagonals);
    scene.cloths.push_back(cloth);
  }
  for (Vec3<double>& x : scene.cloths[1].mesh.positions) x = {-x[0], x[1], -0.1};
  Seam seam;
  seam.cloths[1] = 1;
  seam.vertices[0] = {0, 3, 6};
  seam.vertices[1] = {2, 5, 8};
  scene.seams.push_back(seam);
  return scene;
}

struct Case {
  std::function<void(Scene&)> spoil;
  const char* field;
  const char* value;
};

TEST(SeamCheck, RefusesWithFieldAndValue) {
  const std::vector<Case> cases{
      {[](Scene& s) { s.seams[0].cloths[1] = 2; }, "seams[0].cloths[1]: ", "2;"},
      {[](Scene& s) { s.seams[0].cloths[0] = -1; }, "seams[0].cloths[0]: ", "-1;"},
      {[](Scene& s) { s.seams[0].vertices[0][1] = 9; }, "seams[0].vertices[0][1]: ", "9;"},
      {[](Scene& s) { s.seams[0].vertices[1][2] = -1; }, "seams[0].vertices[1][2]: ", "-1;"},
      {[](Scene& s) { s.seams[0].vertices[1].pop_back(); }, "seams[0].vertices: ", "3 and 2"},
      {[](Scene& s) { s.seams.emplace_back(); }, "seams[1].vertices: ", "none"},
      {[](Scene& s) { s.seams[0].stiffness = 0; }, "seams[0].stiffness: ", "0;"},
      {[](Scene& s) { s.seams[0].stiffness = inf; }, "seams[0].stiffness: ", "inf"},
      {[](Scene& s) { s.seams[0].start_time = nan; }, "seams[0].start_time: ", "nan"},
      {[](Scene& s) { s.seams[0].ramp_time = -1; }, "seams[0].ramp_time: ", "-1"},
      {[](Scene& s) { s.seams[0].weld_distance = nan; }, "seams[0].weld_distance: ", "nan"},
      {[](Scene& s) { s.seams[0].weld_distance = 4e-4; }, "seams[0].weld_distance: ", "half"},
      {[](Scene& s) { s.refinement.levels = 0; }, "refine.levels: ", "0;"},
      {[](Scene& s) {
         s.seams[0].weld_distance = 0;
         s.refinement.when = Refinement::When::sewn;
       },
       "seams[0].weld_distance: ", "0 beside refine"},
      {[](Scene& s) {
         s.seams.clear();
         s.refinement.when = Refinement::When::sewn;
       },
       "refine.when: ", "without seams"},
      {[](Scene& s) {
         s.seams[0].weld_distance = 1;
         s.refinement.when = Refinement::When::sewn;
         s.output.format = FrameFormat::pc2;
       },
       "output.format: ", "pc2"},
  };
  for (const Case& one : cases) {
    Scene scene = garment();
    EXPECT_NO_THROW(validate_seams(scene)) << one.field;
    one.spoil(scene);
    try {
      validate_seams(scene);
      ADD_FAILURE() << one.field << " accepted";
    } catch (const SceneError& error) {
      const std::string what = error.what();
      EXPECT_NE(what.find(one.field), std::string::npos) << what;
      EXPECT_NE(what.find(one.value), std::string::npos) << what;
    }
  }
}

TEST(SeamCheck, LeastWeldDistanceIsHalfTheThickness) {
  Scene scene = garment();
  scene.seams[0].weld_distance = contact_thickness(scene.contact) / 2;
  EXPECT_NO_THROW(validate_seams(scene));
}

/// Whether the panels can be sewn all around, as a cushion is.
void sew_all_around(Scene& scene) {
  Seam& seam = scene.seams[0];
  seam.weld_distance = 1;
  seam.vertices[0] = {0, 1, 2, 5, 8, 7, 6, 3};
  seam.vertices[1] = {2, 1, 0, 3, 6, 7, 8, 5};
}

TEST(SeamCheck, TakesACushion) {
  for (const Diagonals diagonals : {Diagonals::alternating, Diagonals::same}) {
    // With diagonals that cut off a corner both panels keep an edge whose two ends are sewn.
    Scene scene = garment(diagonals);
    sew_all_around(scene);
    EXPECT_NO_THROW(validate_seams(scene));
  }
}

TEST(SeamCheck, FindsAPanelThatIsNotTurnedOver) {
  // Each edge in a seam of its own: the ends of an edge may be sewn by different ones.
  Scene scene = garment();
  scene.seams[0].vertices[0] = {0};
  scene.seams[0].vertices[1] = {0};
  scene.seams.push_back(scene.seams[0]);
  scene.seams[1].vertices[0] = {3};
  scene.seams[1].vertices[1] = {3};
  try {
    validate_seams(scene);
    ADD_FAILURE() << "accepted";
  } catch (const SceneError& error) {
    const std::string what = error.what();
    EXPECT_NE(what.find("turned over"), std::string::npos) << what;
    EXPECT_NE(what.find("vertex 3 of cloth \"front\" to vertex 0 of cloth \"front\""),
              std::string::npos)
        << what;
    EXPECT_NE(what.find("vertex 3 of cloth \"back\" to vertex 0 of cloth \"back\""),
              std::string::npos)
        << what;
  }
}

TEST(SeamCheck, TakesPanelsThatMeetInOnePointOnly) {
  Scene scene = garment();
  scene.seams[0].vertices[0] = {0, 2, 8, 6};
  scene.seams[0].vertices[1] = {0, 2, 8, 6};
  EXPECT_NO_THROW(validate_seams(scene));
}

TEST(SeamCheck, TakesThreePanelsOnAnEdge) {
  Scene scene = garment();
  scene.cloths.push_back(scene.cloths[1]);
  scene.seams.push_back(scene.seams[0]);
  scene.seams[1].cloths[1] = 2;
  for (const double distance : {0.0, 1.0}) {
    for (Seam& seam : scene.seams) seam.weld_distance = distance;
    EXPECT_NO_THROW(validate_seams(scene));
  }
}

TEST(SeamCheck, FindsTrianglesThatWouldLieOnEachOther) {
  Scene scene = garment();
  scene.cloths[1] = scene.cloths[0];
  scene.cloths[1].name = "back";
  for (Tri& t : scene.cloths[1].mesh.triangles) std::swap(t.v[1], t.v[2]);
  const Tri t = scene.cloths[0].mesh.triangles[3];
  for (int side = 0; side < 2; ++side) scene.seams[0].vertices[side] = {t.v[0], t.v[1], t.v[2]};
  EXPECT_NO_THROW(validate_seams(scene)) << "not welded";
  scene.seams[0].weld_distance = 1;
  try {
    validate_seams(scene);
    ADD_FAILURE() << "accepted";
  } catch (const SceneError& error) {
    const std::string what = error.what();
    EXPECT_NE(what.find("triangle 3 of cloth \"front\" and triangle 3 of cloth \"back\""),
              std::string::npos)
        << what;
  }
}

TEST(SeamCheck, TakesAPocketOnThePanel) {
  // A boundary edge that is sewn onto an edge inside of another cloth.
  Scene scene = garment();
  scene.seams[0].vertices[0] = {1, 4, 7};
  scene.seams[0].weld_distance = 1;
  EXPECT_NO_THROW(validate_seams(scene));
}

}  // namespace
}  // namespace weft
