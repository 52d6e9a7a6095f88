#include "host/geometry/attachment.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <numbers>

#include "host/model/model.hpp"
#include "weft/error.hpp"
#include "weft/shapes.hpp"

/// Points that a moving surface carries along.
namespace weft {
namespace {

TEST(Attachment, TurnsWithItsTriangle) {
  const std::vector<Vec3<double>> flat{{0, 0, 0}, {2, 0, 0}, {0, 2, 0}};
  const std::vector<Tri> one{{{0, 1, 2}}};
  const Attachment held = attach({{0.5, 0.25, 3}}, one, flat).front();
  EXPECT_NEAR(held.weights[0], 0.625, 1e-15);
  EXPECT_NEAR(held.weights[1], 0.25, 1e-15);
  EXPECT_NEAR(held.weights[2], 0.125, 1e-15);
  EXPECT_NEAR(length(attached_position(held, flat) - Vec3<double>{0.5, 0.25, 3}), 0, 1e-15);
  // A quarter turn about the first edge takes the normal from +z to -y.
  const std::vector<Vec3<double>> upright{{0, 0, 0}, {2, 0, 0}, {0, 0, 2}};
  EXPECT_NEAR(length(attached_position(held, upright) - Vec3<double>{0.5, -3, 0.25}), 0, 1e-14);
  // Twice as large: the point on the triangle moves, its height does not change.
  const std::vector<Vec3<double>> large{{0, 0, 0}, {4, 0, 0}, {0, 4, 0}};
  EXPECT_NEAR(length(attached_position(held, large) - Vec3<double>{1, 0.5, 3}), 0, 1e-14);
}

TEST(Attachment, PointBesideTheTriangle) {
  const std::vector<Vec3<double>> flat{{0, 0, 0}, {2, 0, 0}, {0, 2, 0}};
  const std::vector<Tri> one{{{0, 1, 2}}};
  const Attachment held = attach({{1, -0.5, 0.25}}, one, flat).front();
  EXPECT_NEAR(held.weights[2], 0, 1e-15);
  const std::vector<Vec3<double>> upright{{0, 0, 0}, {2, 0, 0}, {0, 0, 2}};
  EXPECT_NEAR(length(attached_position(held, upright) - Vec3<double>{1, -0.25, -0.5}), 0, 1e-15);
}

TEST(Attachment, StaysFiniteWithoutArea) {
  const std::vector<Vec3<double>> flat{{0, 0, 0}, {2, 0, 0}, {0, 2, 0}};
  const std::vector<Tri> one{{{0, 1, 2}}};
  const Attachment held = attach({{0.5, 0.25, 3}}, one, flat).front();
  const std::vector<Vec3<double>> line{{0, 0, 0}, {2, 0, 0}, {4, 0, 0}};
  EXPECT_NEAR(length(attached_position(held, line) - Vec3<double>{1, 0, 0}), 0, 1e-15);
  const std::vector<Vec3<double>> point(3, Vec3<double>{7, 7, 7});
  EXPECT_NEAR(length(attached_position(held, point) - Vec3<double>{7, 7, 7}), 0, 1e-14);
}

TEST(Attachment, TiesGoToTheFirstTriangle) {
  // Two triangles that meet in an edge, and a point above it.
  const std::vector<Vec3<double>> roof{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, -1, 0}};
  const std::vector<Tri> both{{{0, 3, 1}}, {{0, 1, 2}}};
  EXPECT_EQ(attach({{0.5, 0, 1}}, both, roof).front().corners.v[1], 3);
}

TEST(Attachment, FindsTheNearestOfMany) {
  const Mesh sphere = make_icosphere(1, 3);
  std::vector<Vec3<double>> points;
  for (int i = 0; i < 50; ++i)
    points.push_back({1.5 * std::sin(3.0 * i), 1.3 * std::cos(5.0 * i), std::sin(7.0 * i)});
  const std::vector<Attachment> held = attach(points, sphere.triangles, sphere.positions);
  for (std::size_t i = 0; i < points.size(); ++i) {
    // Of a fine sphere, the nearest point lies on the way to the centre.
    Vec3<double> on{0, 0, 0};
    for (int j = 0; j < 3; ++j)
      on += sphere.positions[static_cast<std::size_t>(held[i].corners.v[j])] * held[i].weights[j];
    EXPECT_LT(length(on - points[i] * (1 / length(points[i]))), 0.06) << i;
    EXPECT_NEAR(length(attached_position(held[i], sphere.positions) - points[i]), 0, 1e-14) << i;
  }
}

/// A ring of cloth around a capsule, its lower edge pinned.
Scene belt() {
  Scene scene;
  scene.materials.push_back({});
  Cloth cloth;
  cloth.mesh = make_tube(0.35, 0.2, {16, 2});
  scene.cloths.push_back(cloth);
  Obstacle body;
  body.mesh = make_capsule(0.3, 1, 4);
  scene.obstacles.push_back(body);
  Pin pin;
  for (Index v = 0; v < 16; ++v) pin.vertices.push_back(v);
  scene.pins.push_back(pin);
  return scene;
}

Motion turning() {
  Keyframe a{0, {}};
  a.transform.translate = {0.5, 0, 1};
  Keyframe b{1, {}};
  b.transform.translate = {-1, 2, 0};
  b.transform.rotation_axis = {0.6, 0, 0.8};
  b.transform.rotation_angle = 2.5;
  return {a, b};
}

TEST(PinToObstacle, IsCarriedAsByTheSameMotion) {
  Scene follows = belt();
  follows.obstacles[0].motion = turning();
  for (Vec3<double>& x : follows.cloths[0].mesh.positions) x += Vec3<double>{0.5, 0, 1};
  follows.pins[0].obstacle = 0;
  Scene moved = belt();
  moved.pins[0].motion = turning();
  const Model model = make_model(follows);
  const Model reference = make_model(moved);
  ASSERT_EQ(model.pinned.size(), 16u);
  for (const double time : {0.0, 0.3, 0.7, 1.0, 2.0}) {
    std::vector<Vec3<double>> placed;
    place_obstacles(follows, model, time, placed);
    for (std::size_t i = 0; i < model.pinned.size(); ++i) {
      const Vec3<double> expected = pinned_position(moved, reference.pinned[i], time, {});
      EXPECT_NEAR(length(pinned_position(follows, model.pinned[i], time, placed) - expected), 0,
                  1e-14);
    }
  }
}

TEST(PinToObstacle, HoldsOnWhereItDidWhenTheMeshHasChanged) {
  Scene scene = belt();
  scene.pins[0].obstacle = 0;
  scene.obstacles[0].transform.translate = {0, 0, 0.05};
  const Model before = make_model(scene);
  // Another mesh, whose vertices have other numbers, and one more that is held.
  Mesh& mesh = scene.cloths[0].mesh;
  std::swap(mesh.positions[3], mesh.positions[20]);
  for (Tri& t : mesh.triangles)
    for (Index& v : t.v) v = v == 3 ? 20 : v == 20 ? 3 : v;
  scene.pins[0].vertices[3] = 20;
  scene.pins[0].vertices.push_back(17);
  const Model rebuilt = make_model(scene);
  const Model after = make_model(scene, {}, &before);
  ASSERT_EQ(after.pinned.size(), 17u);
  for (std::size_t i = 0; i < after.pinned.size(); ++i) {
    const Attachment& a = after.pinned[i].attachment;
    const Attachment& b = rebuilt.pinned[i].attachment;
    for (int j = 0; j < 3; ++j) {
      EXPECT_EQ(a.corners.v[j], b.corners.v[j]);
      EXPECT_EQ(a.weights[j], b.weights[j]);
      EXPECT_EQ(a.offset[j], b.offset[j]);
    }
    EXPECT_GT(length_sq(a.offset), 0);
  }
}

/// A capsule that leans over as it goes up: x is moved by time * z.
class Leaning : public Deformation {
 public:
  void positions(double time, Span<Vec3<double>> out) const override {
    const Mesh mesh = make_capsule(0.3, 1, 4);
    for (std::size_t v = 0; v < out.size(); ++v)
      out[v] = mesh.positions[v] + Vec3<double>{time * mesh.positions[v][2], 0, 0};
  }
  std::uint64_t checksum() const override { return 1; }
};

TEST(PinToObstacle, FollowsWhatChangesItsShape) {
  Scene scene = belt();
  scene.obstacles[0].deformation = std::make_shared<Leaning>();
  scene.obstacles[0].transform.translate = {0, 0, -0.1};
  scene.pins[0].obstacle = 0;
  const Model model = make_model(scene);
  const auto first = static_cast<std::size_t>(model.cloth_vertex_count);
  for (const double time : {0.0, 0.5}) {
    std::vector<Vec3<double>> placed;
    place_obstacles(scene, model, time, placed);
    for (const auto& p : model.pinned) {
      const Vec3<double> at = pinned_position(scene, p, time, placed);
      if (time == 0) {
        EXPECT_NEAR(length(at - p.initial), 0, 1e-14);
        continue;
      }
      // The distance from the surface stays: no triangle near it is nearer than at the start.
      const Tri& t = p.attachment.corners;
      Vec3<double> on_t0{0, 0, 0};
      Vec3<double> on_t1{0, 0, 0};
      for (int j = 0; j < 3; ++j) {
        const auto v = static_cast<std::size_t>(t.v[j]);
        on_t0 += model.positions[first + v] * p.attachment.weights[j];
        on_t1 += placed[v] * p.attachment.weights[j];
      }
      EXPECT_NEAR(length(at - on_t1), length(p.initial - on_t0), 1e-14);
      // The pin's height above the middle of the capsule sets how far it is taken.
      EXPECT_NEAR(at[0] - p.initial[0], 0.5 * (p.initial[2] + 0.1), 0.06);
    }
  }
}

TEST(PinToObstacle, BadReferencesAreRefused) {
  Scene scene = belt();
  scene.pins[0].obstacle = 0;
  EXPECT_NO_THROW(validate(scene));
  scene.pins[0].obstacle = 1;
  EXPECT_THROW(validate(scene), SceneError);
  scene.pins[0].obstacle = -2;
  EXPECT_THROW(validate(scene), SceneError);
  scene.pins[0].obstacle = 0;
  scene.pins[0].motion = turning();
  EXPECT_THROW(validate(scene), SceneError);
}

}  // namespace
}  // namespace weft
