// The method "adaptive": runs whose meshes change, their frames, checkpoints and energies.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "host/base/scratch_folder.hpp"
#include "host/lab/check/validator.hpp"
#include "weft/error.hpp"
#include "weft/shapes.hpp"
#include "weft/simulation.hpp"

namespace weft::test {
namespace {

namespace fs = std::filesystem;

/// A sheet that falls over a ball and hangs by three points of its edge.
Scene sheet_over_ball(Precision precision = Precision::double_precision) {
  Scene scene;
  scene.method = "adaptive";
  scene.precision = precision;
  scene.time.frames = 8;
  scene.materials.emplace_back();
  scene.materials[0].stretch_stiffness = 200;
  Cloth sheet;
  sheet.name = "sheet";
  sheet.mesh = make_grid({0.6, 0.6}, {16, 16}, Diagonals::alternating);
  scene.cloths.push_back(std::move(sheet));
  Obstacle ball;
  ball.name = "ball";
  ball.mesh = make_icosphere(0.12, 2);
  ball.transform.translate = {0.03, -0.05, -0.15};
  scene.obstacles.push_back(std::move(ball));
  Pin pin;
  pin.vertices = {grid_vertex(16, 0, 16), grid_vertex(16, 16, 16)};
  scene.pins.push_back(pin);
  scene.contact.thickness = 0.004;
  scene.adaptive.remeshing.size_min = 0.03;
  scene.adaptive.remeshing.size_max = 0.3;
  return scene;
}

void advance_frame(Simulation& simulation, std::vector<StepReport>* reports = nullptr) {
  for (int step = 0; step < simulation.steps_per_frame(); ++step) {
    const StepReport report = simulation.step();
    ASSERT_EQ(report.failure, Failure::none) << report.failure_detail;
    if (reports) reports->push_back(report);
  }
}

TEST(AdaptiveRun, FramesFollowTheMeshAndStayClean) {
  for (const Precision precision : {Precision::double_precision, Precision::single_precision}) {
    Simulation simulation(sheet_over_ball(precision), host_devices(1));
    EXPECT_LT(simulation.scene().cloths[0].mesh.triangles.size(), 100u) << "flat at the start";
    std::vector<StepReport> reports;
    std::size_t most = 0;
    double peak = 0;
    for (int frame = 0; frame < 8; ++frame) {
      advance_frame(simulation, &reports);
      if (HasFatalFailure()) return;
      peak = std::max(peak, simulation.energy().kinetic);
      const Frame now = simulation.frame();
      const Mesh& mesh = simulation.scene().cloths[0].mesh;
      ASSERT_EQ(now.cloth_positions[0].size(), mesh.positions.size());
      most = std::max(most, mesh.triangles.size());
      const Mesh cloth{now.cloth_positions[0], mesh.material, mesh.triangles,
                       mesh.material_triangles};
      const Mesh ball{
          now.obstacle_positions[0], {}, simulation.scene().obstacles[0].mesh.triangles};
      EXPECT_TRUE(lab::validate(cloth, &ball).clean()) << "frame " << frame;
    }
    EXPECT_GT(most, 200u);
    int remeshes = 0;
    double jump = 0;
    for (const StepReport& r : reports) {
      remeshes += r.remesh.triangles > 0;
      jump = std::max(jump, std::abs(r.remesh.energy_jump));
    }
    EXPECT_EQ(remeshes, 8);
    EXPECT_LT(jump, 0.01 * peak);
  }
}

TEST(AdaptiveRun, SameBitsForAnyNumberOfDevices) {
  Simulation one(sheet_over_ball(), host_devices(1));
  Simulation three(sheet_over_ball(), host_devices(3));
  for (int frame = 0; frame < 4; ++frame) {
    advance_frame(one);
    advance_frame(three);
    ASSERT_EQ(one.state_hash(), three.state_hash()) << "frame " << frame;
  }
}

class AdaptiveCheckpoint : public testing::Test {
 protected:
  const ScratchFolder folder_;
  const fs::path file_ = folder_ / "checkpoint.weft";
};

TEST_F(AdaptiveCheckpoint, GoesOnWithTheSameBits) {
  Simulation whole(sheet_over_ball(), host_devices(1));
  for (int frame = 0; frame < 3; ++frame) advance_frame(whole);
  whole.step();
  whole.save(file_);
  const std::uint64_t saved = whole.state_hash();
  for (int step = 1; step < whole.steps_per_frame(); ++step) whole.step();
  for (int frame = 4; frame < 6; ++frame) advance_frame(whole);

  Simulation resumed(sheet_over_ball(), host_devices(1));
  resumed.resume(file_);
  EXPECT_EQ(resumed.state_hash(), saved);
  for (int step = 1; step < resumed.steps_per_frame(); ++step) resumed.step();
  for (int frame = 4; frame < 6; ++frame) advance_frame(resumed);
  EXPECT_EQ(resumed.state_hash(), whole.state_hash());
  EXPECT_EQ(resumed.scene().cloths[0].mesh.triangles.size(),
            whole.scene().cloths[0].mesh.triangles.size());
}

TEST_F(AdaptiveCheckpoint, OfAnotherSceneIsRefusedAndChangesNothing) {
  Simulation whole(sheet_over_ball(), host_devices(1));
  advance_frame(whole);
  whole.save(file_);
  Scene other = sheet_over_ball();
  for (Vec2<double>& u : other.cloths[0].mesh.material) u *= 1.01;
  Simulation simulation(other, host_devices(1));
  const std::uint64_t before = simulation.state_hash();
  EXPECT_THROW(simulation.resume(file_), SceneError);
  EXPECT_EQ(simulation.state_hash(), before);
  advance_frame(simulation);
  Scene fixed = sheet_over_ball();
  fixed.method = "implicit";
  Simulation implicit(fixed, host_devices(1));
  EXPECT_THROW(implicit.resume(file_), SceneError);
}

}  // namespace
}  // namespace weft::test
