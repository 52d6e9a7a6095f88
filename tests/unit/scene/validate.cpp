#include "host/scene/validate.hpp"

#include <gtest/gtest.h>

#include <functional>
#include <limits>

#include "weft/error.hpp"
#include "weft/shapes.hpp"

namespace weft {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr double inf = std::numeric_limits<double>::infinity();

Scene small_scene() {
  Scene scene;
  scene.file = "made.json";
  scene.materials.push_back({});
  scene.materials[0].name = "cotton";
  scene.cloths.push_back({"cloth", make_grid({1, 1}, {2, 2}, Diagonals::same), 0, {}, {}, {}, {}});
  Obstacle ball;
  ball.name = "ball";
  ball.mesh = make_icosphere(1, 1);
  ball.motion = {{0, {}}, {1, {}}};
  scene.obstacles.push_back(ball);
  scene.pins.push_back({0, {0, 2}, {}, -1, inf});
  return scene;
}

/// A handle that the ball carries.
Handle& carried(Scene& scene) {
  Handle& handle = scene.handles.emplace_back();
  handle.vertices = {3, 4};
  const auto& ball = scene.obstacles[0].mesh.positions;
  handle.carrier = {0, {0, 1, 2}, {ball[0], ball[1], ball[2]}};
  return handle;
}

struct Case {
  std::function<void(Scene&)> spoil;
  const char* field;
  const char* value;
};

const std::vector<Case>& cases() {
  static const std::vector<Case> all{
      {[](Scene& s) { s.gravity[2] = nan; }, "gravity[2]", "nan"},
      {[](Scene& s) { s.time.step = 0; }, "time.step", "0"},
      {[](Scene& s) { s.time.step = -0.005; }, "time.step", "-0.005"},
      {[](Scene& s) { s.time.step = nan; }, "time.step", "nan"},
      {[](Scene& s) { s.time.step = inf; }, "time.step", "inf"},
      {[](Scene& s) { s.time.step = 1e-9; }, "time.step", "1e-09"},
      {[](Scene& s) { s.time.frame_rate = -1; }, "time.frame_rate", "-1"},
      {[](Scene& s) { s.time.frames = 0; }, "time.frames", "0"},
      {[](Scene& s) { s.method = "magic"; }, "method.type", "\"magic\""},
      {[](Scene& s) {
         s.materials[0].strain_limits = StrainLimits{-0.1, 1.1};
       },
       "materials.cotton.strain_limits[0]", "-0.1"},
      {[](Scene& s) {
         s.materials[0].strain_limits = StrainLimits{1, 1.1};
       },
       "materials.cotton.strain_limits[0]", "1"},
      {[](Scene& s) {
         s.materials[0].strain_limits = StrainLimits{nan, 1.1};
       },
       "materials.cotton.strain_limits[0]", "nan"},
      {[](Scene& s) {
         s.materials[0].strain_limits = StrainLimits{0.9, 1};
       },
       "materials.cotton.strain_limits[1]", "1"},
      {[](Scene& s) {
         s.materials[0].strain_limits = StrainLimits{0.9, nan};
       },
       "materials.cotton.strain_limits[1]", "nan"},
      {[](Scene& s) { s.cloths[0].pressure = nan; }, "cloths[0].pressure", "nan"},
      {[](Scene& s) { s.cloths[0].pressure = inf; }, "cloths[0].pressure", "inf"},
      {[](Scene& s) { s.materials[0].density = -1; }, "materials.cotton.density", "-1"},
      {[](Scene& s) { s.materials[0].density = inf; }, "materials.cotton.density", "inf"},
      {[](Scene& s) { s.materials[0].stretch_stiffness = 0; }, "materials.cotton.stretch_stiffness",
       "0"},
      {[](Scene& s) { s.materials[0].poisson_ratio = -1; }, "materials.cotton.poisson_ratio", "-1"},
      {[](Scene& s) { s.materials[0].poisson_ratio = 0.51; }, "materials.cotton.poisson_ratio",
       "0.51"},
      {[](Scene& s) { s.materials[0].bending_stiffness = nan; },
       "materials.cotton.bending_stiffness", "nan"},
      {[](Scene& s) { s.materials[0].damping_mass = -2; }, "materials.cotton.damping.mass", "-2"},
      {[](Scene& s) { s.materials[0].damping_stiffness = -3; },
       "materials.cotton.damping.stiffness", "-3"},
      {[](Scene& s) { s.contact.thickness = 0; }, "contact.thickness", "0"},
      {[](Scene& s) { s.contact.thickness = 1e39; }, "contact.thickness", "1e+39"},
      {[](Scene& s) {
         // 20,000 triangles, all of them neighbours of each other; half of them may be.
         s.cloths[0].mesh = make_grid({1, 1}, {100, 100}, Diagonals::same);
         s.contact.thickness = 0.6;
       },
       "contact.thickness", "at most 0.49"},
      {[](Scene& s) {
         s.cloths[0].mesh = make_grid({1, 4e-5}, {1, 1}, Diagonals::same);
         s.precision = Precision::single_precision;
       },
       "cloths[0].mesh.material", "sliver (triangles 0, 1)"},
      {[](Scene& s) { s.materials[0].density = 1e-50; }, "materials.cotton.density", "1e-50"},
      {[](Scene& s) {
         for (Vec3<double>& x : s.cloths[0].mesh.positions) x[1] += 2e7;
       },
       "cloths[0].mesh.positions", "vertices 0: 19999999.5"},
      {[](Scene& s) {
         for (Vec3<double>& x : s.cloths[0].mesh.positions) x *= 1e-10;
       },
       "cloths[0].mesh.triangles", "triangle too small"},
      {[](Scene& s) { s.obstacles[0].motion[1].transform.scale = 1e9; },
       "obstacles[0].motion[1].scale", "as far as 1e+09 m"},
      {[](Scene& s) {
         s.materials[0].density = 1e-9;
         s.contact.stiffness = 1e-6;
         s.time.step = 1e6;
         s.time.frame_rate = 1e-6;
         for (Vec2<double>& u : s.cloths[0].mesh.material) u *= 1e-4;
       },
       "time.step", "a least repulsion of"},
      {[](Scene& s) {
         s.method = "adaptive";
         s.adaptive.remeshing.size_min = s.adaptive.remeshing.size_max = 1e-6;
       },
       "remeshing.size[1]", "triangles)"},
      {[](Scene& s) { s.contact.friction = -0.5; }, "contact.friction", "-0.5"},
      {[](Scene& s) { s.contact.stiffness = -1; }, "contact.stiffness", "-1"},
      {[](Scene& s) { s.contact.zone_rounds = 0; }, "contact.zone_rounds", "0"},
      {[](Scene& s) { s.contact.substep_bisections = 21; }, "contact.substep_bisections", "21"},
      {[](Scene& s) { s.contact.compliance_distance = -0.5; }, "contact.compliance_distance",
       "-0.5"},
      {[](Scene& s) { s.contact.compliance_distance = nan; }, "contact.compliance_distance", "nan"},
      {[](Scene& s) { s.solver.tolerance = 1; }, "solver.tolerance", "1"},
      {[](Scene& s) { s.solver.max_iterations = 0; }, "solver.max_iterations", "0"},
      {[](Scene& s) { s.solver.newton_iterations = -1; }, "solver.newton_iterations", "-1"},
      {[](Scene& s) { s.solver.newton_tolerance = 0; }, "solver.newton_tolerance", "0"},
      {[](Scene& s) { s.solver.partial_rows = 96; }, "solver.partial_rows", "96"},
      {[](Scene& s) { s.solver.partial_rows = -1; }, "solver.partial_rows", "-1"},
      {[](Scene& s) { s.output.checkpoint_every = -1; }, "output.checkpoint_every", "-1"},
      {[](Scene& s) { s.cloths.clear(); }, "cloths", "none"},
      {[](Scene& s) { s.cloths[0].material = 1; }, "cloths[0].material", "1"},
      {[](Scene& s) { s.cloths[0].material = -1; }, "cloths[0].material", "-1"},
      {[](Scene& s) { s.cloths[0].velocity[1] = inf; }, "cloths[0].velocity[1]", "inf"},
      {[](Scene& s) { s.cloths[0].mesh.positions[4][0] = nan; }, "cloths[0].mesh.positions",
       "vertex 4: nan"},
      {[](Scene& s) { s.cloths[0].mesh.material.clear(); }, "cloths[0].mesh.material",
       "no material"},
      {[](Scene& s) { s.cloths[0].rest_positions.resize(8); }, "cloths[0].rest", "8 positions"},
      {[](Scene& s) {
         s.cloths[0].rest_positions = s.cloths[0].mesh.positions;
         s.cloths[0].rest_positions[3][1] = inf;
       },
       "cloths[0].rest.positions", "vertex 3: inf"},
      {[](Scene& s) {
         s.cloths[0].rest_positions.assign(9, {1, 2, 3});
       },
       "cloths[0].rest.triangles", "area"},
      {[](Scene& s) { s.obstacles[0].friction = nan; }, "obstacles[0].friction", "nan"},
      {[](Scene& s) { s.obstacles[0].transform.scale = 0; }, "obstacles[0].transform.scale", "0"},
      {[](Scene& s) {
         s.obstacles[0].transform.rotation_axis = {1, 1, 0};
       },
       "obstacles[0].transform.rotate", "1.41"},
      {[](Scene& s) { s.obstacles[0].motion.pop_back(); }, "obstacles[0].motion", "one key"},
      {[](Scene& s) { s.obstacles[0].motion[1].time = 0; }, "obstacles[0].motion[1].time", "0"},
      {[](Scene& s) { s.obstacles[0].motion[0].time = nan; }, "obstacles[0].motion[0].time", "nan"},
      {[](Scene& s) { s.obstacles[0].motion[1].transform.translate[2] = inf; },
       "obstacles[0].motion[1].translate[2]", "inf"},
      {[](Scene& s) { s.obstacles[0].motion[1].transform.rotation_angle = nan; },
       "obstacles[0].motion[1].rotate", "nan"},
      {[](Scene& s) { s.obstacles[0].mesh.triangles.clear(); }, "obstacles[0].mesh.triangles",
       "no triangles"},
      {[](Scene& s) { s.pins[0].cloth = 1; }, "pins[0].cloth", "1"},
      {[](Scene& s) { s.pins[0].vertices.clear(); }, "pins[0].vertices", "none"},
      {[](Scene& s) { s.pins[0].vertices[1] = 9; }, "pins[0].vertices[1]", "9"},
      {[](Scene& s) { s.pins[0].vertices[1] = -1; }, "pins[0].vertices[1]", "-1"},
      {[](Scene& s) { s.pins[0].vertices[1] = 0; }, "pins[0].vertices[1]", "0"},
      {[](Scene& s) {
         s.pins.push_back({0, {2}, {}, -1, inf});
       },
       "pins[1].vertices[0]", "2"},
      {[](Scene& s) { s.pins[0].release_time = 0; }, "pins[0].release_time", "0"},
      {[](Scene& s) { s.pins[0].release_time = nan; }, "pins[0].release_time", "nan"},
      {[](Scene& s) {
         s.pins[0].motion = {{0, {}}};
       },
       "pins[0].motion", "one key"},
      {[](Scene& s) { carried(s).carrier.obstacle = 1; }, "handles[0].carrier.obstacle", "1"},
      {[](Scene& s) { carried(s).carrier.vertices[2] = 42; }, "handles[0].carrier.vertices", "42"},
      {[](Scene& s) { carried(s).carrier.start.pop_back(); }, "handles[0].carrier",
       "3 vertices and 2 places"},
      {[](Scene& s) { carried(s).shape = Handle::Shape::glue; }, "handles[0].carrier",
       "beside glue"},
  };
  return all;
}

TEST(Validate, AcceptsAGoodScene) {
  Scene scene = small_scene();
  EXPECT_NO_THROW(validate(scene));
  carried(scene);
  EXPECT_NO_THROW(validate(scene));
}

TEST(Validate, NamesFileFieldAndValue) {
  for (const Case& c : cases()) {
    Scene scene = small_scene();
    c.spoil(scene);
    try {
      validate(scene);
      ADD_FAILURE() << c.field << " = " << c.value << " was accepted";
    } catch (const SceneError& error) {
      const std::string message = error.what();
      EXPECT_EQ(message.find(std::string("made.json: ") + c.field + ": "), 0u) << message;
      EXPECT_NE(message.find(c.value), std::string::npos) << message;
      EXPECT_NE(message.find("; allowed: "), std::string::npos) << message;
      EXPECT_EQ(message.find('\n'), std::string::npos) << message;
    }
  }
}

TEST(Validate, ASceneInMemoryHasNoFile) {
  Scene scene = small_scene();
  scene.file.clear();
  scene.time.step = -1;
  try {
    validate(scene);
    ADD_FAILURE();
  } catch (const SceneError& error) {
    EXPECT_EQ(std::string(error.what()).find("time.step: -1"), 0u) << error.what();
  }
}

}  // namespace
}  // namespace weft
