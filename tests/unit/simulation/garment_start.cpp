// Garments whose seams are welded at the start, or closed by springs before gravity sets in.
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <memory>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "host/exec/host_device.hpp"
#include "tests/support/small_scenes.hpp"
#include "weft/error.hpp"
#include "weft/shapes.hpp"
#include "weft/simulation.hpp"

namespace weft {
namespace {

constexpr double gap = 0.03;        ///< [m] between the panels before they are sewn
constexpr double wall_place = -1;   ///< [m] x of a wall
constexpr double into_wall = -0.9;  ///< [m] along x, takes the left panel there

std::vector<Vec3<double>> moved(std::vector<Vec3<double>> positions, double x) {
  for (Vec3<double>& p : positions) p[0] += x;
  return positions;
}

/// Two square panels side by side and a seam between them; their meshes touch along it.
Scene two_panels(SewnStart start) {
  Scene s;
  s.precision = Precision::double_precision;
  s.materials.push_back(test::cotton());
  s.time.step = 0.005;
  s.time.frame_rate = 50;
  s.contact.untangle = true;
  Seam seam;
  for (int side = 0; side < 2; ++side) {
    Cloth cloth;
    cloth.mesh = make_grid({0.3, 0.3}, {3, 3});
    cloth.name = side == 0 ? "left" : "right";
    cloth.mesh.positions = moved(cloth.mesh.positions, side == 0 ? -0.15 : 0.15);
    s.garment_starts.push_back({side, start, moved(cloth.mesh.positions, side == 0 ? 0 : gap), {}});
    s.cloths.push_back(cloth);
    seam.cloths[side] = side;
  }
  seam.vertices[0] = {3, 7, 11, 15};
  seam.vertices[1] = {0, 4, 8, 12};
  seam.stiffness = 200;
  seam.ramp_time = 0.1;
  s.seams.push_back(seam);
  return s;
}

/// Sewn, the left panel passes through a wall and is held on both sides of it.
Scene through_a_wall(SewnStart start) {
  Scene s = two_panels(start);
  Obstacle wall;
  wall.name = "wall";
  wall.mesh = make_grid({1, 1}, {4, 4});
  wall.transform.rotation_axis = {0, 1, 0};
  wall.transform.rotation_angle = std::numbers::pi / 2;
  wall.transform.translate = {wall_place, 0, 0};
  s.obstacles.push_back(wall);
  s.pins.push_back({0, {0, 4, 8, 12, 3, 7, 11, 15}, {}});
  for (Cloth& cloth : s.cloths) cloth.mesh.positions = moved(cloth.mesh.positions, into_wall);
  return s;
}

double lowest(const Simulation& simulation) {
  double least = 1e9;
  for (const auto& cloth : simulation.frame().cloth_positions)
    for (const Vec3<double>& x : cloth) least = std::min(least, x[2]);
  return least;
}

void step_until(Simulation& simulation, double time) {
  while (simulation.time() < time - 1e-9) {
    const StepReport report = simulation.step();
    ASSERT_EQ(report.failure, Failure::none) << report.failure_detail;
  }
}

bool open(const Simulation& simulation) {
  return simulation.seams()[0].open > 0;
}

TEST(GarmentStart, WeldedFallsAtOnce) {
  for (const SewnStart start : {SewnStart::welded, SewnStart::automatic}) {
    Simulation s(two_panels(start), host_devices(1));
    for (const GarmentStart& done : s.scene().garment_starts) {
      EXPECT_EQ(done.start, SewnStart::welded);
      EXPECT_EQ(done.reason, "");
      EXPECT_TRUE(done.apart.empty());
    }
    EXPECT_FALSE(open(s));
    step_until(s, 0.1);
    EXPECT_NEAR(lowest(s), -9.81 / 2 * 0.1 * 0.1, 5e-3);
  }
}

TEST(GarmentStart, SpringsCloseSeamsBeforeGravitySetsIn) {
  Scene scene = two_panels(SewnStart::springs);
  Simulation s(scene, host_devices(1));
  EXPECT_TRUE(open(s));
  EXPECT_NEAR(s.frame().cloth_positions[1][0][0], gap, 1e-12);
  while (open(s) && s.time() < 1) {
    EXPECT_EQ(length(s.scene().gravity), 0);
    EXPECT_NEAR(lowest(s), 0, 1e-6);
    ASSERT_EQ(s.step().failure, Failure::none);
  }
  ASSERT_FALSE(open(s));
  EXPECT_EQ(s.scene().gravity, scene.gravity);
  const double closed = s.time();
  step_until(s, closed + 0.2);
  EXPECT_NEAR(lowest(s), -9.81 / 2 * 0.2 * 0.2, 0.02);
}

TEST(GarmentStart, ClothDoesNotRestBeforeItsSeamsHaveHadTheirTime) {
  Scene scene = two_panels(SewnStart::springs);
  scene.time.until = RunUntil::rest;
  scene.time.frames = 100;
  // Held apart, the seam never closes: the cloth rests, with its seam open.
  for (Index c = 0; c < 2; ++c) {
    Pin pin{c, {}, {}};
    for (Index v = 0; v < 16; ++v) pin.vertices.push_back(v);
    scene.pins.push_back(pin);
  }
  Simulation s(scene, host_devices(1));
  while (!s.rest().rested && s.frame_number() < 100) ASSERT_EQ(s.step().failure, Failure::none);
  EXPECT_TRUE(open(s));
  EXPECT_GT(s.time(), 4 * scene.seams[0].ramp_time);
  EXPECT_LT(s.time(), 4 * scene.seams[0].ramp_time + 0.3);
}

/// Panels held apart, whose seam has springs that are too weak to close it.
Scene held_apart(double distance, Precision precision) {
  Scene s = two_panels(SewnStart::springs);
  s.precision = precision;
  s.garment_starts[1].apart = moved(s.cloths[1].mesh.positions, distance);
  s.pins.push_back({0, {0, 4, 8, 12}, {}});
  s.pins.push_back({1, {3, 7, 11, 15}, {}});
  s.seams[0].stiffness = 0.1;
  s.seams[0].weld_distance = 0.002;
  s.seams[0].ramp_time = 0.02;
  return s;
}

TEST(GarmentStart, PairsThatSpringsLeaveOpenAreWeldedIfTheyAreNear) {
  for (const Precision precision : {Precision::single_precision, Precision::double_precision}) {
    const Scene scene = held_apart(0.008, precision);
    Simulation s(scene, host_devices(1));
    step_until(s, 0.075);
    EXPECT_TRUE(open(s));
    EXPECT_GT(s.seams()[0].largest_gap, scene.seams[0].weld_distance);
    const std::string before = s.state();
    step_until(s, 0.085);
    EXPECT_FALSE(open(s));
    EXPECT_EQ(s.scene().gravity, scene.gravity);
    step_until(s, 0.3);
    Simulation again(scene, host_devices(2));
    again.restore(before);
    step_until(again, 0.3);
    EXPECT_EQ(again.state_hash(), s.state_hash());
  }
}

/// Asks its set to stop when its compute queue has been asked for a number of times.
class StoppingDevice final : public Device {
 public:
  StoppingDevice(std::atomic<bool>& stop, int& uses_left) : stop_(stop), uses_left_(uses_left) {}
  Backend backend() const noexcept override { return Backend::host; }
  std::string name() const override { return device_.name(); }
  Queue& compute() noexcept override {
    if (--uses_left_ == 0) stop_ = true;
    return device_.compute();
  }
  Queue& transfer() noexcept override { return device_.transfer(); }
  bool reaches_peers() const noexcept override { return device_.reaches_peers(); }
  void* allocate(std::size_t bytes) override { return device_.allocate(bytes); }
  void release(void* memory, std::size_t bytes) noexcept override {
    device_.release(memory, bytes);
  }
  std::size_t peak_bytes() const noexcept override { return device_.peak_bytes(); }
  std::int64_t allocation_count() const noexcept override { return device_.allocation_count(); }

 private:
  std::atomic<bool>& stop_;
  int& uses_left_;
  HostDevice device_{0, true, {}};
};

TEST(GarmentStart, StoppedWhileOpenPairsAreWeldedTheStepIsTakenBack) {
  std::atomic<bool> stop{false};
  int uses_left = 0;
  std::vector<std::unique_ptr<Device>> devices;
  devices.push_back(std::make_unique<StoppingDevice>(stop, uses_left));
  DeviceSet set(std::move(devices));
  set.stop_on(&stop);
  Scene scene = held_apart(0.008, Precision::double_precision);
  // Stands in the gap, so that what is welded has to be parted from it in rounds.
  Cloth strip;
  strip.name = "strip";
  strip.mesh = make_grid({0.02, 0.01}, {4, 2});
  for (Vec3<double>& x : strip.mesh.positions) x = {0.004, 0.05 + x[0], 0.004 + x[1]};
  scene.cloths.push_back(strip);
  scene.contact.thickness = 0.0005;
  Simulation s(scene, std::move(set));
  step_until(s, 0.075);
  const std::string before = s.state();
  const std::uint64_t hash_before = s.state_hash();
  uses_left = 0;
  ASSERT_EQ(s.step().failure, Failure::none);
  const int uses = -uses_left;
  ASSERT_FALSE(open(s));
  const std::uint64_t hash_after = s.state_hash();
  int stopped = 0;
  for (int use = uses; use > 0; --use) {
    s.restore(before);
    uses_left = use;
    const StepReport report = s.step();
    stop = false;
    if (report.failure == Failure::none) continue;
    ++stopped;
    ASSERT_EQ(report.failure, Failure::stopped);
    EXPECT_EQ(s.state_hash(), hash_before);
    EXPECT_EQ(report.open_seam_pairs, 4);
    EXPECT_EQ(length(s.scene().gravity), 0);
    ASSERT_EQ(s.step().failure, Failure::none);
    EXPECT_EQ(s.state_hash(), hash_after);
  }
  EXPECT_GT(stopped, 0);
}

TEST(GarmentStart, PairsThatAreFarApartOrHeldOrCannotBePartedStayOpen) {
  const Scene far = held_apart(0.02, Precision::double_precision);
  Scene held = held_apart(0.008, Precision::double_precision), barred = held;
  held.pins.push_back({0, {3, 7, 11, 15}, {}});
  Obstacle bar;
  bar.mesh = make_box({0.002, 0.4, 0.02}, {1, 8, 1});
  bar.transform.translate = {0.154, 0, 0};
  barred.obstacles.push_back(bar);
  for (const Scene& scene : {far, held, barred}) {
    Simulation s(scene, host_devices(1));
    step_until(s, 0.1);
    EXPECT_EQ(s.seams()[0].open, 4);
    EXPECT_EQ(s.scene().gravity, scene.gravity);
  }
}

TEST(GarmentStart, GoesOnFromACheckpoint) {
  const Scene scene = two_panels(SewnStart::springs);
  Simulation s(scene, host_devices(1));
  step_until(s, 0.04);
  ASSERT_TRUE(open(s));
  const std::string early = s.state();
  step_until(s, 0.4);
  ASSERT_FALSE(open(s));
  const std::string late = s.state();
  step_until(s, 0.5);
  for (const std::string& state : {early, late}) {
    Simulation again(scene, host_devices(2));
    again.restore(state);
    step_until(again, 0.5);
    EXPECT_EQ(again.state_hash(), s.state_hash());
    EXPECT_EQ(again.scene().gravity, scene.gravity);
  }
  // Back to when it was weightless.
  s.restore(early);
  EXPECT_EQ(length(s.scene().gravity), 0);
  const double before = lowest(s);
  step_until(s, 0.5);
  EXPECT_EQ(s.scene().gravity, scene.gravity);
  EXPECT_LT(lowest(s), before - 0.05);
}

TEST(GarmentStart, TheProgramMayLetGravityActSooner) {
  Simulation s(two_panels(SewnStart::springs), host_devices(1));
  s.set_gravity({0, 0, -1});
  step_until(s, 0.5);
  EXPECT_FALSE(open(s));
  EXPECT_EQ(s.scene().gravity, (Vec3<double>{0, 0, -1}));
}

TEST(GarmentStart, SpringsReplaceAWeldedStartThatCannotBeParted) {
  Simulation s(through_a_wall(SewnStart::automatic), host_devices(1));
  for (const GarmentStart& done : s.scene().garment_starts) {
    EXPECT_EQ(done.start, SewnStart::springs);
    EXPECT_NE(done.reason.find("wall"), std::string::npos) << done.reason;
  }
  EXPECT_TRUE(open(s));
  step_until(s, 0.5);
  EXPECT_FALSE(open(s));
}

TEST(GarmentStart, IsRefusedIfNeitherCanBeParted) {
  EXPECT_THROW(Simulation(through_a_wall(SewnStart::welded), host_devices(1)), SceneError);
  Scene scene = through_a_wall(SewnStart::automatic);
  for (GarmentStart& start : scene.garment_starts) start.apart = moved(start.apart, into_wall);
  std::string welded;
  try {
    Simulation s(through_a_wall(SewnStart::welded), host_devices(1));
  } catch (const SceneError& error) {
    welded = error.what();
  }
  try {
    Simulation s(scene, host_devices(1));
    FAIL() << "accepted";
  } catch (const SceneError& error) {
    EXPECT_EQ(error.what(), welded);
  }
}

TEST(GarmentStart, NeedsAPlaceForEachVertex) {
  Scene scene = two_panels(SewnStart::automatic);
  scene.garment_starts[1].apart.pop_back();
  try {
    Simulation s(scene, host_devices(1));
    FAIL() << "accepted";
  } catch (const SceneError& error) {
    EXPECT_NE(std::string(error.what()).find("garment_starts[1].apart: 15 places"),
              std::string::npos)
        << error.what();
  }
}

}  // namespace
}  // namespace weft
