// The method "view": runs whose meshes follow a camera.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <numbers>
#include <string>
#include <vector>

#include "host/base/scratch_folder.hpp"
#include "host/lab/check/validator.hpp"
#include "tests/unit/adaptive/remesh_scenes.hpp"
#include "weft/core/at.hpp"
#include "weft/error.hpp"
#include "weft/shapes.hpp"
#include "weft/simulation.hpp"

namespace weft::test {
namespace {

namespace fs = std::filesystem;

CameraKey key_of(const Vec3<double>& position, const Vec3<double>& look_at, double time = 0,
                 bool jump = false) {
  CameraKey key;
  key.time = time;
  key.position = position;
  key.look_at = look_at;
  key.field_of_view = std::numbers::pi / 5;
  key.jump = jump;
  return key;
}

/// A sheet that hangs by two corners and is hit by a ball, of which the camera sees the right
/// quarter, and after a cut all.
Scene filmed_sheet() {
  Scene scene;
  scene.method = "view";
  scene.precision = Precision::double_precision;
  scene.time.frames = 8;
  scene.materials.emplace_back();
  scene.materials[0].stretch_stiffness = 200;
  Cloth sheet;
  sheet.name = "sheet";
  sheet.mesh = make_grid({0.8, 0.8}, {20, 20}, Diagonals::alternating);
  scene.cloths.push_back(std::move(sheet));
  Obstacle ball;
  ball.name = "ball";
  ball.mesh = make_icosphere(0.12, 2);
  ball.transform.translate = {0.03, -0.05, -0.15};
  scene.obstacles.push_back(std::move(ball));
  Pin pin;
  pin.vertices = {grid_vertex(20, 0, 20), grid_vertex(20, 20, 20)};
  scene.pins.push_back(pin);
  scene.contact.thickness = 0.004;
  scene.adaptive.remeshing.size_min = 0.03;
  scene.adaptive.remeshing.size_max = 0.4;
  scene.view.two_sided = true;
  scene.view.margin = 0.1;
  scene.view.anticipation = 2;
  scene.camera.keys = {key_of({0.85, -0.2, 1.5}, {0.85, 0, 0}),
                       key_of({0, -0.8, 2.5}, {0, 0, 0}, 6 * 0.04, true)};
  return scene;
}

void advance_frame(Simulation& simulation, std::vector<RemeshReport>* reports = nullptr) {
  for (int step = 0; step < simulation.steps_per_frame(); ++step) {
    const StepReport report = simulation.step();
    ASSERT_EQ(report.failure, Failure::none) << report.failure_detail;
    if (reports && report.remesh.triangles > 0) reports->push_back(report.remesh);
  }
}

std::size_t triangle_count(const Simulation& simulation) {
  return simulation.scene().cloths[0].mesh.triangles.size();
}

TEST(ViewRun, IsFineWhereTheCameraLooksAndClean) {
  Simulation simulation(filmed_sheet(), host_devices(1));
  std::vector<RemeshReport> reports;
  for (int frame = 1; frame <= 8; ++frame) {
    advance_frame(simulation, &reports);
    if (HasFatalFailure()) return;
    const Frame now = simulation.frame();
    const Mesh& mesh = simulation.scene().cloths[0].mesh;
    const Mesh cloth{now.cloth_positions[0], mesh.material, mesh.triangles,
                     mesh.material_triangles};
    const Mesh ball{now.obstacle_positions[0], {}, simulation.scene().obstacles[0].mesh.triangles};
    EXPECT_TRUE(lab::validate(cloth, &ball).clean()) << "frame " << frame;
    if (frame != 4) continue;
    int left = 0, right = 0;
    for (const Vec2<double>& u : mesh.material) (u[0] > 0.2 ? right : left) += 1;
    EXPECT_GT(3 * right, 2 * left) << "twice as dense in the quarter that is in view";
  }
  ASSERT_EQ(reports.size(), 8u);
  EXPECT_LT(reports[3].factor_mean, 0.6);
  EXPECT_GT(reports[6].factor_mean, 0.99);
  EXPECT_EQ(reports[6].in_view, reports[6].triangles);
  EXPECT_GT(reports[4].triangles, reports[3].triangles) << "before the cut";
  EXPECT_GT(reports[5].triangles, reports[4].triangles);
  for (const RemeshReport& r : reports) EXPECT_LE(r.rebuild_seconds, r.seconds);
}

/// A disc held at its rim inside, half of it out of view, that falls onto a ball. Its hem keeps the
/// vertices of a circle, and most triangles there have no others near.
Scene filmed_disc() {
  Scene scene;
  scene.method = "view";
  scene.precision = Precision::double_precision;
  scene.time.frames = 14;
  Material viscose;
  viscose.density = 0.13;
  viscose.stretch_stiffness = 600;
  viscose.bending_stiffness = 4e-6;
  viscose.damping_stiffness = 3e-4;
  scene.materials.push_back(viscose);
  Cloth disc;
  disc.name = "disc";
  disc.mesh = make_annulus(0.13, 0.68, 12);
  Pin pin;
  for (std::size_t v = 0; v < disc.mesh.positions.size(); ++v)
    if (length(disc.mesh.positions[v]) < 0.1301) pin.vertices.push_back(static_cast<Index>(v));
  scene.pins.push_back(pin);
  scene.cloths.push_back(std::move(disc));
  Obstacle ball;
  ball.name = "ball";
  ball.mesh = make_icosphere(0.2, 2);
  ball.transform.translate = {0.35, 0.1, -0.3};
  scene.obstacles.push_back(std::move(ball));
  scene.adaptive.remeshing.refine_angle = 0.85;
  scene.adaptive.remeshing.refine_compression = 0.014;
  scene.adaptive.remeshing.refine_velocity = 1.4;
  scene.camera.keys = {key_of({0.6, -1.2, 1}, {0.4, 0, -0.2})};
  return scene;
}

TEST(ViewRun, NoRemeshChangesTheEnergyMuch) {
  for (const std::string method : {"adaptive", "view"}) {
    Scene scene = filmed_disc();
    scene.method = method;
    Simulation simulation(std::move(scene), host_devices(1));
    std::vector<RemeshReport> reports;
    double peak = 0;
    std::int64_t changes = 0;
    for (int frame = 0; frame < 14; ++frame) {
      advance_frame(simulation, &reports);
      if (HasFatalFailure()) return;
      peak = std::max(peak, simulation.energy().kinetic);
      const RemeshReport& r = reports.back();
      changes += r.splits + r.flips + r.collapses;
      // As it goes along: of the largest energy of motion so far.
      EXPECT_LE(std::abs(r.energy_jump), 0.01 * peak * (1 + 1e-6)) << method << " " << frame;
    }
    EXPECT_GT(changes, 500) << method;
  }
}

TEST(ViewRun, FewerPixelsFewerTriangles) {
  std::vector<std::size_t> counts;
  for (const double distance : {1.5, 20.0, 80.0}) {
    Scene scene = filmed_sheet();
    scene.camera.keys = {key_of({0, -0.4 * distance, distance}, {0, 0, 0})};
    Simulation simulation(std::move(scene), host_devices(1));
    for (int frame = 0; frame < 5; ++frame) advance_frame(simulation);
    counts.push_back(triangle_count(simulation));
  }
  EXPECT_GT(counts[0], counts[1] + counts[1] / 4);
  EXPECT_GT(counts[1], counts[2] + counts[2] / 4);
}

TEST(ViewRun, AllInViewAndNearIsTheMethodAdaptive) {
  Scene scene = filmed_sheet();
  scene.camera.keys = {key_of({0, -0.5, 2}, {0, 0, 0})};
  scene.view.pixel_min = 0;
  Scene adaptive = scene;
  adaptive.method = "adaptive";
  Simulation viewed(std::move(scene), host_devices(1)), blind(std::move(adaptive), host_devices(1));
  for (int frame = 0; frame < 4; ++frame) {
    advance_frame(viewed);
    advance_frame(blind);
    EXPECT_EQ(triangle_count(viewed), triangle_count(blind));
  }
}

TEST(ViewRun, SameBitsForAnyNumberOfDevices) {
  Simulation one(filmed_sheet(), host_devices(1));
  Simulation three(filmed_sheet(), host_devices(3));
  for (int frame = 0; frame < 4; ++frame) {
    advance_frame(one);
    advance_frame(three);
    ASSERT_EQ(one.state_hash(), three.state_hash()) << "frame " << frame;
  }
}

class ViewCheckpoint : public testing::Test {
 protected:
  const ScratchFolder folder_;
  const fs::path file_ = folder_ / "checkpoint.weft";
};

/// Saved within a frame: what yields to compression was decided at the start of it.
TEST_F(ViewCheckpoint, GoesOnWithTheSameBits) {
  Simulation whole(filmed_sheet(), host_devices(1));
  for (int frame = 0; frame < 3; ++frame) advance_frame(whole);
  whole.step();
  whole.save(file_);
  const std::uint64_t saved = whole.state_hash();
  for (int step = 1; step < whole.steps_per_frame(); ++step) whole.step();
  for (int frame = 4; frame < 6; ++frame) advance_frame(whole);
  Simulation resumed(filmed_sheet(), host_devices(1));
  resumed.resume(file_);
  EXPECT_EQ(resumed.state_hash(), saved);
  for (int step = 1; step < resumed.steps_per_frame(); ++step) resumed.step();
  for (int frame = 4; frame < 6; ++frame) advance_frame(resumed);
  EXPECT_EQ(resumed.state_hash(), whole.state_hash());
}

/// What is out of view sags more where it need not resist compression.
TEST(ViewRun, CompensationChangesWhatIsOutOfView) {
  std::vector<std::uint64_t> hashes;
  for (const BucklingCompensation kind :
       {BucklingCompensation::none, BucklingCompensation::full, BucklingCompensation::area}) {
    Scene scene = filmed_sheet();
    scene.view.compensation = kind;
    Simulation simulation(std::move(scene), host_devices(1));
    for (int frame = 0; frame < 3; ++frame) advance_frame(simulation);
    hashes.push_back(simulation.state_hash());
  }
  EXPECT_NE(hashes[0], hashes[1]);
  EXPECT_NE(hashes[0], hashes[2]);
  EXPECT_NE(hashes[1], hashes[2]);
}

/// A compressed sheet, held at all vertices, that a cut brings into view, and one that flies.
Scene compressed_sheet() {
  Scene scene;
  scene.method = "view";
  scene.precision = Precision::double_precision;
  scene.gravity = {0, 0, 0};
  scene.time.frames = 30;
  Cloth sheet;
  sheet.name = "sheet";
  sheet.mesh = make_grid({0.4, 0.4}, {4, 4}, Diagonals::alternating);
  Cloth flying = sheet;
  flying.name = "flying";
  for (Vec3<double>& x : flying.mesh.positions) x[2] -= 1;
  flying.velocity = {1, 0, 0};
  Pin rim;
  for (Index v = 0; v < 25; ++v) {
    sheet.mesh.positions[at(v)][0] *= 0.99;
    rim.vertices.push_back(v);
  }
  scene.pins.push_back(rim);
  scene.cloths = {std::move(sheet), std::move(flying)};
  // One size: nothing to split.
  scene.adaptive.remeshing.size_min = scene.adaptive.remeshing.size_max = 0.3;
  scene.adaptive.energy_share = 0.2;
  scene.view.compensation = BucklingCompensation::full;
  scene.view.anticipation = 0;
  const double frame = 1 / scene.time.frame_rate;
  scene.camera.keys = {key_of({9, -0.2, 1.5}, {9, 0, 0}),
                       key_of({0, -0.8, 2.5}, {0, 0, 0}, 3.5 * frame, true)};
  return scene;
}

/// It resists by and by: energy that nothing gives, which the work of a step leaves out.
TEST(ViewRun, ResistsCompressionInViewAsTheEnergyAllows) {
  Scene resisting = compressed_sheet();
  resisting.view.compensation = BucklingCompensation::none;
  const double whole = Simulation(std::move(resisting), host_devices(1)).energy().elastic;
  Simulation simulation(compressed_sheet(), host_devices(1));
  const double kinetic = simulation.energy().kinetic;
  int rises = 0;
  for (int frame = 1; frame <= 30; ++frame) {
    for (int step = 0; step < simulation.steps_per_frame(); ++step) {
      const double before = simulation.energy().total();
      const StepReport report = simulation.step();
      ASSERT_EQ(report.failure, Failure::none) << report.failure_detail;
      const double jump = report.remesh.compression_jump;
      EXPECT_NEAR(simulation.energy().total() - before, jump, 1e-8 * whole);
      EXPECT_NEAR(report.work.value_or(1), 0, 1e-8 * whole);
      EXPECT_LE(jump, simulation.scene().adaptive.energy_share * kinetic * 1.001);
      if (jump > 1e-6 * whole) ++rises;
    }
    if (frame == 3) {
      EXPECT_NEAR(simulation.energy().elastic, 0, 1e-8 * whole) << "out of view";
    }
  }
  EXPECT_GT(rises, 2);
  EXPECT_NEAR(simulation.energy().elastic, whole, 1e-6 * whole);
}

TEST(ViewRun, OcclusionAndPredictionRun) {
  Scene scene = filmed_sheet();
  scene.view.occlusion = true;
  scene.view.predict_obstacles = true;
  Keyframe start, end;
  start.transform = end.transform = scene.obstacles[0].transform;
  end.time = 1;
  end.transform.translate[0] += 0.1;
  scene.obstacles[0].motion = {start, end};
  Simulation simulation(std::move(scene), host_devices(1));
  std::vector<RemeshReport> reports;
  for (int frame = 0; frame < 4; ++frame) advance_frame(simulation, &reports);
  EXPECT_GT(reports.back().factor_mean, 0.01);
}

void expect_refused(Scene scene, const std::string& text) {
  try {
    Simulation simulation(std::move(scene), host_devices(1));
    FAIL() << "not refused: " << text;
  } catch (const SceneError& error) {
    EXPECT_NE(std::string(error.what()).find(text), std::string::npos) << error.what();
  }
}

TEST(ViewRun, RefusesCamerasThatCannotServe) {
  Scene scene = filmed_sheet();
  scene.camera.keys.clear();
  expect_refused(scene, "camera.keys: none");
  scene.camera.keys = {key_of({0, -1, 1}, {0, 0, 0}), key_of({0, -1, 2}, {0, 0, 0}, 0.2)};
  expect_refused(scene, "camera.keys: a track that ends at 0.2 s");
  scene.camera.keys = {key_of({0, -1, 1}, {0, 0, 0}, 0.1), key_of({0, -1, 2}, {0, 0, 0}, 9)};
  expect_refused(scene, "camera.keys: a track that begins at 0.1 s");
  scene.camera.keys = {key_of({0.03, -0.05, -0.1}, {0, 0, 0.5})};
  expect_refused(scene, "camera.keys: inside obstacles[0] (ball) at 0 s");
  // From outside into the ball and out again.
  scene.camera.keys = {key_of({0.03, -0.5, -0.15}, {0, 1, 0}),
                       key_of({0.03, 0.6, -0.15}, {0, 1, 0}, 0.32)};
  expect_refused(scene, "camera.keys: inside obstacles[0] (ball) at 0.12 s");
  scene = filmed_sheet();
  scene.view.factor_out = 0;
  expect_refused(scene, "method.view.factor_out: 0");
  scene = filmed_sheet();
  scene.camera.keys[0].field_of_view = 0;
  expect_refused(scene, "camera.keys[0].field_of_view: 0");
  scene = filmed_sheet();
  scene.adaptive.remeshing.size_max = 0.01;
  expect_refused(scene, "remeshing.size[1]: 0.01");
}

}  // namespace
}  // namespace weft::test
