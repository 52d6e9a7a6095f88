#include <gtest/gtest.h>

#include <limits>
#include <memory>

#include "host/model/model.hpp"
#include "host/scene/intersection_check.hpp"
#include "weft/error.hpp"
#include "weft/shapes.hpp"

/// Where obstacles are over time.
namespace weft {
namespace {

/// A sphere that grows by its radius a second and counts how often it is asked.
class Growing : public Deformation {
 public:
  void positions(double time, Span<Vec3<double>> out) const override {
    ++asked;
    const Mesh mesh = make_icosphere(1 + time, 1);
    for (std::size_t v = 0; v < out.size(); ++v) out[v] = mesh.positions[v];
  }
  std::uint64_t checksum() const override { return 1; }
  mutable int asked = 0;
};

Obstacle sphere(const Vec3<double>& centre) {
  Obstacle obstacle;
  obstacle.mesh = make_icosphere(1, 1);
  obstacle.transform.translate = centre;
  return obstacle;
}

/// A sheet at height 3; a sphere that stands still, one that grows, one that moves.
Scene three_spheres(std::shared_ptr<const Deformation> growing) {
  Scene scene;
  scene.materials.push_back({});
  Cloth cloth;
  cloth.mesh = make_grid({1, 1}, {2, 2}, Diagonals::same);
  for (Vec3<double>& x : cloth.mesh.positions) x[2] = 3;
  scene.cloths.push_back(cloth);
  scene.obstacles = {sphere({-5, 0, 0}), sphere({0, 0, 0}), sphere({5, 0, 0})};
  scene.obstacles[1].deformation = std::move(growing);
  scene.obstacles[1].transform.translate = {0, 0, -1};
  Keyframe there{1, {}};
  there.transform.translate = {0, 0, 7};
  scene.obstacles[2].motion = {{0, {}}, there};
  return scene;
}

TEST(PlaceObstacles, DeformsThenMoves) {
  const Scene scene = three_spheres(std::make_shared<Growing>());
  const Model model = make_model(scene);
  const Mesh unit = make_icosphere(1, 1);
  const std::size_t n = unit.positions.size();
  std::vector<Vec3<double>> out;
  const VertexRun all = place_obstacles(scene, model, 1, out);
  EXPECT_EQ(all.first, 0);
  EXPECT_EQ(all.last, static_cast<Index>(3 * n));
  for (std::size_t v = 0; v < n; ++v) {
    const Vec3<double>& x = unit.positions[v];
    const Vec3<double> grown = make_icosphere(2, 1).positions[v];
    EXPECT_TRUE(out[v] == (x + Vec3<double>{-5, 0, 0}));
    EXPECT_TRUE(out[n + v] == (grown + Vec3<double>{0, 0, -1}));
    EXPECT_TRUE(out[2 * n + v] == (x + Vec3<double>{0, 0, 7}));
  }
}

TEST(PlaceObstacles, LeavesAloneWhatStandsStill) {
  const Scene scene = three_spheres(std::make_shared<Growing>());
  const Model model = make_model(scene);
  std::vector<Vec3<double>> out;
  place_obstacles(scene, model, 0, out);
  const auto n = static_cast<Index>(out.size() / 3);
  out[0] = {77, 77, 77};  // is still there after the next call
  const VertexRun moved = place_obstacles(scene, model, 0.5, out);
  EXPECT_EQ(moved.first, n);
  EXPECT_EQ(moved.last, 3 * n);
  EXPECT_EQ(out[0][0], 77);

  Scene still = scene;
  still.obstacles.resize(1);
  const Model still_model = make_model(still);
  out.clear();
  EXPECT_EQ(place_obstacles(still, still_model, 0, out).last, n);
  const VertexRun none = place_obstacles(still, still_model, 1, out);
  EXPECT_EQ(none.first, none.last);
}

TEST(PlaceObstacles, StartsAsDeformedAtTimeZero) {
  Scene scene = three_spheres(std::make_shared<Growing>());
  // The mesh itself is not what counts.
  for (Vec3<double>& x : scene.obstacles[1].mesh.positions) x *= 100;
  const Model model = make_model(scene);
  const auto first = static_cast<std::size_t>(model.cloth_vertex_count + model.obstacle_offset[1]);
  EXPECT_NEAR(length(model.positions[first] - Vec3<double>{0, 0, -1}), 1, 1e-15);
}

/// Another scale at each time, and NaN at time 0 if that is asked for.
class Scaled : public Deformation {
 public:
  explicit Scaled(double at_zero) : at_zero_(at_zero) {}
  void positions(double time, Span<Vec3<double>> out) const override {
    const Mesh mesh = make_icosphere(1, 1);
    for (std::size_t v = 0; v < out.size(); ++v)
      out[v] = mesh.positions[v] * (time == 0 ? at_zero_ : 1);
  }
  std::uint64_t checksum() const override { return 1; }

 private:
  double at_zero_;
};

TEST(Deformed, StartIsWhatIsTestedForIntersections) {
  Scene scene = three_spheres(std::make_shared<Scaled>(1));
  EXPECT_NO_THROW(refuse_intersecting_start(scene));
  scene.obstacles[1].deformation = std::make_shared<Scaled>(4);  // cuts through the sheet
  EXPECT_THROW(refuse_intersecting_start(scene), SceneError);
  scene.obstacles[1].deformation = std::make_shared<Scaled>(50);  // swallows it
  EXPECT_THROW(refuse_intersecting_start(scene), SceneError);
}

TEST(Deformed, NonFiniteStartIsRefused) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(validate(three_spheres(std::make_shared<Scaled>(nan))), SceneError);
  EXPECT_NO_THROW(validate(three_spheres(std::make_shared<Scaled>(2))));
}

TEST(Deformed, ObstaclesMayRunThroughThemselves) {
  // Two overlapping capsules in one mesh, as a body made of them has.
  Scene scene = three_spheres(nullptr);
  scene.obstacles.resize(1);
  Mesh& mesh = scene.obstacles[0].mesh;
  const Mesh other = make_capsule(0.7, 1, 3);
  const auto first = static_cast<Index>(mesh.positions.size());
  mesh.positions.insert(mesh.positions.end(), other.positions.begin(), other.positions.end());
  for (const Tri& t : other.triangles)
    mesh.triangles.push_back({{first + t.v[0], first + t.v[1], first + t.v[2]}});
  scene.obstacles[0].transform.translate = {0, 0, 0};
  EXPECT_NO_THROW(validate(scene));
  EXPECT_NO_THROW(refuse_intersecting_start(scene));
  // Within one of them, or both, is inside.
  for (Vec3<double>& x : scene.cloths[0].mesh.positions) x = x * 0.01 + Vec3<double>{0, 0, 0.9};
  EXPECT_THROW(refuse_intersecting_start(scene), SceneError);
}

}  // namespace
}  // namespace weft
