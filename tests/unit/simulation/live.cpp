// What a program sets while a simulation runs: places of obstacles and pins, gravity, wind.
#include <gtest/gtest.h>
#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <functional>
#include <limits>
#include <memory>
#include <stdexcept>
#include <stop_token>
#include <string>
#include <thread>
#include <vector>
#include "weft/shapes.hpp"
#include "weft/weft.hpp"

namespace weft {
namespace {

constexpr double frame_length = 1.0 / 25;
constexpr int frames = 6;

/// A sheet of 8 x 8 cells at height 0.3 above a plate, held at two corners.
struct Door {
  Scene scene;
  ClothId cloth;
  ObstacleId plate;
  PinId corners;
};

Door door() {
  Door d;
  const MaterialId cotton = d.scene.add(fabric("cotton_polyester"));
  d.cloth = d.scene.add(Cloth{.name = "sheet", .mesh = make_grid({0.4, 0.4}, {8, 8})});
  Cloth& sheet = d.scene.cloths[0];
  sheet.material = cotton;
  for (Vec3<double>& x : sheet.mesh.positions) x += {0, 0, 0.3};
  LiveObstacle plate(make_grid({0.6, 0.6}, {4, 4}));
  d.plate = d.scene.add(plate);
  d.corners = d.scene.pin(d.cloth, std::vector<Index>{0, 8});
  d.scene.time.step = 0.01;
  d.scene.contact.thickness = 0.004;
  return d;
}

std::vector<Vec3<double>> moved(std::vector<Vec3<double>> places, const Vec3<double>& by) {
  for (Vec3<double>& x : places) x += by;
  return places;
}

/// Where frame f of the program's motion wants things to be: the plate rises, the corners swing.
std::vector<Vec3<double>> plate_at(const Door& d, int f) {
  return moved(d.scene.obstacles[0].mesh.positions, {0, 0, 0.03 * f});
}
std::vector<Vec3<double>> corners_at(const Door& d, int f) {
  std::vector<Vec3<double>> places;
  for (const Index v : d.scene.pins[0].vertices)
    places.push_back(d.scene.cloths[0].mesh.positions[static_cast<std::size_t>(v)] +
                     Vec3<double>{0.02 * std::sin(f), 0.01 * f, 0});
  return places;
}

void set_frame(Simulation& s, const Door& d, int f) {
  s.move(d.plate, plate_at(d, f));
  s.move(d.corners, corners_at(d, f));
  s.set_wind({1.2, {0.5 * f, 0, 0}, 0});
  s.set_gravity({0, 0.1 * f, -9.81});
  if (f == 4) s.release(d.corners);
}

void advance_whole(Simulation& s, const AdvanceOptions& options = {}) {
  while (true) {
    const AdvanceResult result = s.advance(frame_length, options);
    ASSERT_TRUE(result) << result.message();
    if (result.complete) return;
  }
}

std::uint64_t hash_after(const AdvanceOptions& options, int ranks) {
  const Door d = door();
  Simulation s(d.scene, host_devices(ranks));
  for (int f = 1; f <= frames; ++f) {
    set_frame(s, d, f);
    advance_whole(s, options);
  }
  return s.state_hash();
}

TEST(Live, WhatIsMovedIsAtItsTargetAtTheEndOfTheFrame) {
  const Door d = door();
  Simulation s(d.scene, host_devices(1));
  for (int f = 1; f <= 3; ++f) {
    set_frame(s, d, f);
    advance_whole(s);
    const Frame frame = s.frame();
    EXPECT_DOUBLE_EQ(frame.time, f * frame_length);
    EXPECT_FALSE(frame.any_displaced());
    const auto plate = plate_at(d, f);
    const auto corners = corners_at(d, f);
    for (std::size_t v = 0; v < plate.size(); ++v)
      EXPECT_LT(length(frame.obstacle_positions[0][v] - plate[v]), 1e-6);
    for (std::size_t k = 0; k < corners.size(); ++k) {
      const auto v = static_cast<std::size_t>(d.scene.pins[0].vertices[k]);
      EXPECT_LT(length(frame.cloth_positions[0][v] - corners[k]), 1e-6);
    }
  }
}

TEST(Live, GoesOnStraightLinesAndRestsWhereItIsNotMovedAgain) {
  const Door d = door();
  Simulation s(d.scene, host_devices(1));
  s.move(d.plate, plate_at(d, 1));
  AdvanceOptions one_step;
  one_step.budget = std::chrono::nanoseconds(0);
  const AdvanceResult quarter = s.advance(frame_length, one_step);
  EXPECT_TRUE(quarter);
  EXPECT_FALSE(quarter.complete);
  EXPECT_EQ(quarter.steps, 1);
  EXPECT_NEAR(s.frame().obstacle_positions[0][0][2], 0.03 / 4, 1e-7);
  advance_whole(s);
  advance_whole(s);
  EXPECT_NEAR(s.frame().obstacle_positions[0][0][2], 0.03, 1e-7);
}

TEST(Live, NeitherBudgetsNorRanksChangeABit) {
  const std::uint64_t whole = hash_after({}, 1);
  AdvanceOptions one_step;
  one_step.budget = std::chrono::nanoseconds(0);
  EXPECT_EQ(hash_after(one_step, 1), whole);
  EXPECT_EQ(hash_after({}, 3), whole);
}

TEST(Live, WindGravityAndReleaseAct) {
  const Door d = door();
  Simulation still(d.scene, host_devices(1));
  Simulation driven(d.scene, host_devices(1));
  driven.set_wind({1.2, {0, 4, 0}, 0});
  driven.release(d.corners);
  driven.set_gravity({0, 0, -1});
  for (int f = 0; f < 3; ++f) {
    advance_whole(still);
    advance_whole(driven);
  }
  const double fallen = 0.3 - driven.positions(d.cloth)[0][2];
  EXPECT_GT(fallen, 0.3 * 1 * 0.12 * 0.12 / 2) << "it hangs where it was held";
  EXPECT_LT(fallen, 1.3 * 1 * 0.12 * 0.12 / 2);
  EXPECT_EQ(still.positions(d.cloth)[0][2], 0.3f);
  EXPECT_NE(driven.state_hash(), still.state_hash());
}

TEST(Live, EachStepOfAFrameIsReported) {
  const Door d = door();
  Simulation s(d.scene, host_devices(1));
  std::vector<std::int64_t> numbers;
  AdvanceOptions options;
  options.after_step = [&](const StepReport& report) {
    EXPECT_EQ(report.failure, Failure::none);
    EXPECT_TRUE(report.work);
    numbers.push_back(report.number);
  };
  const AdvanceResult first = s.advance(frame_length, options);
  ASSERT_TRUE(first.complete);
  ASSERT_EQ(numbers.size(), static_cast<std::size_t>(first.steps));
  EXPECT_EQ(numbers.front(), 1);
  EXPECT_EQ(numbers.back(), first.steps);
  // What it throws reaches the caller, and the step stands.
  options.after_step = [](const StepReport&) { throw std::runtime_error("enough"); };
  EXPECT_THROW(s.advance(frame_length, options), std::runtime_error);
  EXPECT_EQ(s.step_number(), first.steps + 1);
  EXPECT_EQ(s.advance(frame_length).steps, first.steps - 1);
  // Thrown after the last step of a frame, the next call begins another one.
  options.after_step = [&](const StepReport& report) {
    if (report.number == 3 * first.steps) throw std::runtime_error("enough");
  };
  EXPECT_THROW(s.advance(frame_length, options), std::runtime_error);
  EXPECT_EQ(s.advance(frame_length).steps, first.steps);
}

TEST(Live, WindIsRefusedWhereTheMethodHasNone) {
  Door d = door();
  d.scene.method = "asynchronous";
  d.scene.precision = Precision::double_precision;
  Simulation s(d.scene, host_devices(1));
  EXPECT_THROW(s.set_wind({1.2, {3, 0, 0}, 0}), SceneError);
  EXPECT_EQ(s.scene().wind.density, 0);
}

TEST(Live, ASceneWithoutMaterialsIsADefaultFabricEverywhere) {
  Scene scene;
  scene.add(Cloth{.mesh = make_grid({0.4, 0.4}, {4, 4})});
  EXPECT_NO_THROW(validate(scene));
  EXPECT_EQ(Simulation(scene, auto_device()).scene().materials.at(0).name, "cotton_polyester");
}

TEST(Live, StateInMemoryGoesOnBitForBit) {
  const Door d = door();
  AdvanceOptions one_step;
  one_step.budget = std::chrono::nanoseconds(0);
  for (const bool amid : {false, true}) {
    Simulation s(d.scene, host_devices(1));
    for (int f = 1; f <= 3; ++f) {
      set_frame(s, d, f);
      advance_whole(s);
    }
    set_frame(s, d, 4);
    if (amid) {
      ASSERT_FALSE(s.advance(frame_length, one_step).complete);
    }
    const std::string state = s.state();
    Simulation again(d.scene, host_devices(2));
    again.restore(state);
    for (Simulation* one : {&s, &again}) {
      advance_whole(*one);
      set_frame(*one, d, 5);
      advance_whole(*one);
    }
    EXPECT_EQ(again.state_hash(), s.state_hash()) << "amid a frame: " << amid;
    // A state from before anything was set takes everything back.
    Simulation fresh(d.scene, host_devices(1));
    const std::string start = fresh.state();
    again.restore(start);
    advance_whole(fresh);
    advance_whole(again);
    EXPECT_EQ(again.state_hash(), fresh.state_hash());
  }
}

TEST(Live, FramesOfAnyLengthTakeStepsOfOneLength) {
  const Door d = door();
  AdvanceOptions one_step;
  one_step.budget = std::chrono::nanoseconds(0);
  Simulation s(d.scene, host_devices(1));
  s.move(d.plate, plate_at(d, 1));
  const AdvanceResult result = s.advance(1.0 / 24);  // 4.17 of the scene's
  EXPECT_TRUE(result.complete);
  EXPECT_EQ(result.steps, 5);
  EXPECT_EQ(s.time(), 1.0 / 24);
  EXPECT_NEAR(s.frame().obstacle_positions[0][0][2], 0.03, 1e-7);
  EXPECT_TRUE(s.advance(0.02).complete);
  EXPECT_DOUBLE_EQ(s.time(), 1.0 / 24 + 0.02);
  EXPECT_FALSE(s.advance(1.0 / 24, one_step).complete);
  const std::string state = s.state();
  Simulation again(d.scene, host_devices(1));
  again.restore(state);
  EXPECT_EQ(again.time(), s.time());
  for (Simulation* one : {&s, &again}) {
    EXPECT_TRUE(one->advance(1.0 / 24).complete);
    EXPECT_DOUBLE_EQ(one->time(), 2.0 / 24 + 0.02);
    EXPECT_EQ(one->step().failure, Failure::none);
    EXPECT_DOUBLE_EQ(one->time(), 2.0 / 24 + 0.03);
    EXPECT_EQ(one->frame_number(), 2);
  }
  EXPECT_EQ(again.state_hash(), s.state_hash());
}

TEST(Live, AdvanceAndStepTakeTheSameSteps) {
  const Door d = door();
  Simulation one(d.scene, host_devices(1));
  Simulation other(d.scene, host_devices(1));
  for (int f = 0; f < 2; ++f) {
    ASSERT_TRUE(one.advance(frame_length).complete);
    for (int k = 0; k < other.steps_per_frame(); ++k)
      ASSERT_EQ(other.step().failure, Failure::none);
    EXPECT_EQ(one.time(), other.time());
    EXPECT_EQ(one.frame_number(), f + 1);
    EXPECT_EQ(one.state_hash(), other.state_hash());
  }
}

TEST(Live, SimulationsInSeveralThreadsDoNotKnowEachOther) {
  const std::uint64_t alone = hash_after({}, 2);
  std::vector<std::uint64_t> hashes(3);
  {
    std::vector<std::jthread> threads;
    for (std::uint64_t& hash : hashes) threads.emplace_back([&hash] { hash = hash_after({}, 2); });
  }
  for (const std::uint64_t hash : hashes) EXPECT_EQ(hash, alone);
}

TEST(Live, ADamagedStateChangesNothing) {
  const Door d = door();
  Simulation s(d.scene, host_devices(1));
  set_frame(s, d, 1);
  advance_whole(s);
  const std::string good = s.state();
  const std::uint64_t hash = s.state_hash();
  std::string damaged = good;
  damaged[damaged.size() / 2] ^= 1;
  EXPECT_THROW(s.restore(damaged), SceneError);
  EXPECT_THROW(s.restore(good.substr(0, good.size() - 5)), SceneError);
  EXPECT_THROW(s.restore(""), SceneError);
  EXPECT_EQ(s.state_hash(), hash);
  EXPECT_EQ(s.state(), good);
}

TEST(Live, PositionsAreThoseOfTheFrameInInputOrder) {
  Door d = door();
  const Vec3<double> far{4096, -8192, 512};
  for (auto* mesh : {&d.scene.cloths[0].mesh, &d.scene.obstacles[0].mesh})
    for (Vec3<double>& x : mesh->positions) x += far;
  Simulation s(d.scene, host_devices(1));
  set_frame(s, d, 1);
  advance_whole(s);
  EXPECT_NE(s.origin(), (Vec3<double>{0, 0, 0}));
  const std::span<const Vec3<float>> x = s.positions(d.cloth);
  const Vec3<float>* first = x.data();
  const Frame frame = s.frame();
  ASSERT_EQ(x.size(), frame.cloth_positions[0].size());
  for (std::size_t v = 0; v < x.size(); ++v)
    EXPECT_EQ(x[v], vec_cast<float>(frame.cloth_positions[0][v]));
  EXPECT_EQ(s.positions(d.cloth).data(), first) << "it allocates again";
}

TEST(Live, AStopEndsTheStepAndTheFrameGoesOnLater) {
  const Door d = door();
  Simulation s(d.scene, host_devices(1));
  set_frame(s, d, 1);
  std::stop_source source;
  source.request_stop();
  const std::uint64_t before = s.state_hash();
  const AdvanceResult stopped = s.advance(frame_length, {.stop = source.get_token()});
  EXPECT_FALSE(stopped);
  EXPECT_EQ(stopped.failure, Failure::stopped);
  EXPECT_EQ(s.state_hash(), before);
  advance_whole(s);
  Simulation other(d.scene, host_devices(1));
  set_frame(other, d, 1);
  advance_whole(other);
  EXPECT_EQ(s.state_hash(), other.state_hash());
}

TEST(Live, ObstaclesMoveWithTheOtherMethodsToo) {
  for (const char* method : {"adaptive", "asynchronous"}) {
    SCOPED_TRACE(method);
    Door d = door();
    d.scene.method = method;
    if (d.scene.method == "asynchronous") d.scene.precision = Precision::double_precision;
    std::uint64_t hashes[2];
    for (const bool whole : {false, true}) {
      Simulation s(d.scene, host_devices(1));
      AdvanceOptions options;
      if (!whole) options.budget = std::chrono::nanoseconds(0);
      for (int f = 1; f <= 2; ++f) {
        s.move(d.plate, plate_at(d, f));
        advance_whole(s, options);
      }
      EXPECT_NEAR(s.frame().obstacle_positions[0][0][2], 0.06, 1e-6);
      hashes[whole ? 1 : 0] = s.state_hash();
      if (d.scene.method == "adaptive") {
        EXPECT_THROW(s.move(d.corners, corners_at(d, 1)), SceneError);
      }
    }
    EXPECT_EQ(hashes[0], hashes[1]);
  }
}

/// One line, with the words of `words` in it.
template <class Call>
void refused(Call call, const std::string& words) {
  try {
    call();
    ADD_FAILURE() << "accepted: " << words;
  } catch (const SceneError& error) {
    const std::string line = error.what();
    EXPECT_NE(line.find(words), std::string::npos) << line;
    EXPECT_EQ(line.find('\n'), std::string::npos) << line;
  }
}

TEST(Live, MisuseIsRefusedOnOneLine) {
  Door d = door();
  const Door other = door();
  d.scene.add(Obstacle{.mesh = d.scene.obstacles[0].mesh});
  Simulation s(d.scene, host_devices(1));
  const std::vector<Vec3<double>> plate = plate_at(d, 0);
  const std::vector<Vec3<double>> corners = corners_at(d, 0);
  refused([&] { s.move(other.plate, plate); }, "another scene");
  refused([&] { s.move(other.corners, corners); }, "another scene");
  refused([&] { s.release(other.corners); }, "another scene");
  refused([&] { s.positions(other.cloth); }, "another scene");
  refused([&] { s.move(d.plate, corners); }, "25, one for each of its vertices");
  refused([&] { s.move(d.corners, plate); }, "2, one for each of its vertices");
  refused([&] { s.move(ObstacleId{1, d.plate.scene}, plate); }, "an obstacle that is live");
  refused([&] { s.move(ObstacleId{2, d.plate.scene}, plate); }, "number 2; allowed: 0 to 1");
  std::vector<Vec3<double>> wild = plate;
  wild[3][1] = std::numeric_limits<double>::quiet_NaN();
  refused([&] { s.move(d.plate, wild); }, "vertex 3: nan");
  for (const double seconds : {0.0, -0.01, 1e-12, std::numeric_limits<double>::quiet_NaN()})
    refused([&] { s.advance(seconds); }, "a time from 1e-9 s");
  refused([&] { s.set_gravity({0, 0, std::numeric_limits<double>::infinity()}); }, "gravity[2]");
  refused([&] { s.set_wind({-1, {0, 0, 0}, 0}); }, "wind.density");
  EXPECT_EQ(s.scene().wind.density, 0);
  refused([&] { fabric("velcro"); }, "cotton");
  Scene plain;
  plain.add(Cloth{.mesh = make_icosphere(0.1, 1)});
  refused([&] { Simulation(plain, host_devices(1)); }, "the flat pattern in metres");
  refused([&] { d.scene.pin(d.cloth, group("waist")); }, "waist");
  refused([&] { d.scene.pin(other.cloth, std::vector<Index>{0}); }, "another scene");
  Scene nowhere = d.scene;
  nowhere.origin = {0, std::numeric_limits<double>::quiet_NaN(), 0};
  refused([&] { Simulation(nowhere, host_devices(1)); }, "origin[1]: nan");
  d.scene.obstacles[0].motion = {{0, {}}, {1, {}}};
  refused([&] { Simulation(d.scene, host_devices(1)); }, "live beside a motion");
}

TEST(Live, DevicesServeOneSimulation) {
  DeviceSet devices = host_devices(1);
  const Simulation one(door().scene, std::move(devices));
  try {
    const Simulation two(door().scene, std::move(devices));  // NOLINT(bugprone-use-after-move)
    ADD_FAILURE() << "nothing to run on was accepted";
  } catch (const DeviceError& error) {
    EXPECT_NE(std::string(error.what()).find("devices: none"), std::string::npos) << error.what();
  }
}

TEST(Live, PinsTakeNumbersInBraces) {
  Door d = door();
  const PinId one = d.scene.pin(d.cloth, {0});
  EXPECT_EQ(d.scene.pins[static_cast<std::size_t>(one.index)].vertices, std::vector<Index>{0});
  const PinId two = d.scene.pin(d.cloth, {3, 4});
  EXPECT_EQ(d.scene.pins[static_cast<std::size_t>(two.index)].vertices, (std::vector<Index>{3, 4}));
}

/// A free sheet, and forces in proportion to its vertices' masses: those fall as if gravity had
/// changed, whatever the elements do.
struct Pushed {
  Scene scene;
  ClothId cloth;
  std::vector<Vec3<double>> forces;  ///< [N]
};

Pushed pushed(const Vec3<double>& acceleration) {
  Pushed p;
  const MaterialId cotton = p.scene.add(fabric("cotton_polyester"));
  p.cloth = p.scene.add(Cloth{.mesh = make_grid({0.4, 0.4}, {8, 8}), .material = cotton});
  const Cloth& cloth = p.scene.cloths[0];
  p.forces.resize(cloth.mesh.positions.size());
  const double third = 0.05 * 0.05 / 2 * p.scene.materials[0].density / 3;
  for (const Tri& t : cloth.mesh.triangles)
    for (const Index v : t.v) p.forces[static_cast<std::size_t>(v)] += third * acceleration;
  p.scene.precision = Precision::double_precision;
  p.scene.time.step = 0.01;
  p.scene.solver.tolerance = 1e-8;
  return p;
}

double largest_difference(const std::vector<Vec3<double>>& a, const std::vector<Vec3<double>>& b) {
  double largest = 0;
  for (std::size_t v = 0; v < a.size(); ++v) largest = std::max(largest, length(a[v] - b[v]));
  return largest;
}

TEST(LiveForces, ActAsGravityDoesIfTheyAreInProportionToMass) {
  const Vec3<double> extra{1, 2, 5};
  for (const Integrator integrator : {Integrator::implicit_euler, Integrator::bdf2}) {
    Pushed p = pushed(extra);
    p.scene.integrator = integrator;
    Simulation forced(p.scene, host_devices(1));
    forced.set_forces(p.cloth, p.forces);
    Simulation falls(p.scene, host_devices(2));
    falls.set_gravity(p.scene.gravity + extra);
    for (int k = 0; k < 10; ++k) {
      const StepReport report = forced.step();
      ASSERT_EQ(report.failure, Failure::none);
      // What they give is known, so that an explosion cannot hide behind them.
      ASSERT_TRUE(report.work);
      ASSERT_EQ(falls.step().failure, Failure::none);
    }
    const double fallen = 0.5 * 5 * 0.1 * 0.1;
    EXPECT_LT(
        largest_difference(forced.frame().cloth_positions[0], falls.frame().cloth_positions[0]),
        1e-6 * fallen);
    EXPECT_GT(
        largest_difference(forced.frame().cloth_positions[0], p.scene.cloths[0].mesh.positions),
        fallen / 2);
  }
}

TEST(LiveForces, TheirWorkIsReported) {
  Pushed p = pushed({0, 0, 20});
  Simulation s(p.scene, host_devices(1));
  s.set_forces(p.cloth, p.forces);
  const double before = s.energy().kinetic + s.energy().elastic + s.energy().gravitational;
  double work = 0;
  for (int k = 0; k < 10; ++k) work += s.step().work.value();
  const double after = s.energy().kinetic + s.energy().elastic + s.energy().gravitational;
  EXPECT_GT(work, 0);
  // Implicit Euler loses half of a step's gain in speed.
  EXPECT_NEAR((after - before) / work, 1, 0.1);
  EXPECT_LT(after - before, work);
}

TEST(LiveForces, AreInStatesAndTheSameForAnyRanks) {
  const Pushed p = pushed({0, 3, 12});
  Simulation one(p.scene, host_devices(1));
  Simulation other(p.scene, host_devices(3));
  one.set_forces(p.cloth, p.forces);
  ASSERT_TRUE(one.advance(0.04));
  other.restore(one.state());
  ASSERT_TRUE(one.advance(0.04));
  ASSERT_TRUE(other.advance(0.04));
  EXPECT_EQ(one.state_hash(), other.state_hash());
  one.set_forces(p.cloth, {});
  Simulation none(p.scene, host_devices(1));
  const std::string start = none.state();
  none.set_forces(p.cloth, p.forces);
  none.restore(start);
  EXPECT_EQ(none.state(), start);
}

TEST(LiveForces, AreRefusedByName) {
  Pushed p = pushed({0, 0, 1});
  Simulation s(p.scene, host_devices(1));
  const std::vector<Vec3<double>> few(3);
  refused([&] { s.set_forces(p.cloth, few); }, "cloths[0] (cloth 0): 3 forces; allowed: ");
  p.forces[7] = {0, std::numeric_limits<double>::quiet_NaN(), 0};
  refused([&] { s.set_forces(p.cloth, p.forces); }, "cloths[0] (cloth 0), vertex 7: nan");
  p.scene.method = "adaptive";
  Simulation remeshed(p.scene, host_devices(1));
  refused([&] { remeshed.set_forces(p.cloth, p.forces); }, "neither remeshing nor refine");
}

TEST(Live, PositionsOnTheDeviceAreThoseOnTheHost) {
  for (const int ranks : {1, 2}) {
    const Door d = door();
    Simulation s(d.scene, host_devices(ranks));
    advance_whole(s);
    const std::span<const Vec3<float>> host = s.positions(d.cloth);
    const DevicePositions device = s.device_positions(d.cloth);
    ASSERT_EQ(device.size, host.size());
    EXPECT_EQ(device.gpu, -1);
    for (std::size_t v = 0; v < host.size(); ++v) EXPECT_EQ(device.data[v], host[v]);
    const Vec3<float>* first = device.data;
    advance_whole(s);
    EXPECT_EQ(s.device_positions(d.cloth).data, first);
    EXPECT_EQ(s.positions(d.cloth).data(), host.data());
  }
}

TEST(Live, ThicknessAndWeldDistanceAreThoseOfSceneFiles) {
  Scene scene;
  const MaterialId cotton = scene.add(fabric("cotton_polyester"));
  const ClothId a = scene.add(Cloth{.mesh = make_grid({0.02, 0.02}, {10, 10}), .material = cotton});
  scene.seams.push_back({.cloths = {a, a}, .vertices = {{0}, {120}}});
  const Simulation fine(scene, host_devices(1));
  EXPECT_NEAR(fine.scene().contact.thickness.value(), 0.0005, 1e-12);
  EXPECT_EQ(fine.scene().seams[0].weld_distance, fine.scene().contact.thickness);
  scene.contact.thickness = 0.0004;
  EXPECT_EQ(Simulation(scene, host_devices(1)).scene().contact.thickness, 0.0004);
}

/// Asks `during` while a step runs, and throws if that throws.
struct Asking final : Deformation {
  std::function<void()> during;
  std::vector<Vec3<double>> places;
  void positions(double, Span<Vec3<double>> out) const override {
    if (during) during();
    std::copy(places.begin(), places.end(), out.begin());
  }
  std::uint64_t checksum() const override { return 1; }
};

TEST(Live, AnotherThreadMeanwhileIsRefused) {
  Door d = door();
  auto asking = std::make_shared<Asking>();
  asking->places = d.scene.obstacles[0].mesh.positions;
  d.scene.obstacles[0].live = false;
  d.scene.obstacles[0].deformation = asking;
  Simulation s(d.scene, host_devices(1));
  int refusals = 0;
  const auto use = [&](auto call) {
    try {
      call();
    } catch (const std::logic_error& error) {
      EXPECT_STREQ(error.what(),
                   "the simulation is in use by another thread; allowed: one thread at a time");
      ++refusals;
    }
  };
  asking->during = [&] {
    std::thread([&] {
      use([&] { s.step(); });
      use([&] { s.set_gravity({0, 0, 0}); });
      use([&] { s.positions(d.cloth); });
      s.progress();
    }).join();
    asking->during = nullptr;
  };
  EXPECT_EQ(s.step().failure, Failure::none);
  EXPECT_EQ(refusals, 3);
}

TEST(Live, WhatADeformationThrowsReachesTheCaller) {
  Door d = door();
  auto asking = std::make_shared<Asking>();
  asking->places = d.scene.obstacles[0].mesh.positions;
  d.scene.obstacles[0].live = false;
  d.scene.obstacles[0].deformation = asking;
  for (const int ranks : {1, 2}) {
    asking->during = nullptr;
    Simulation s(d.scene, host_devices(ranks));
    asking->during = [] { throw std::runtime_error("the mesh server is gone"); };
    EXPECT_THROW(s.step(), std::runtime_error);
  }
}

}  // namespace
}  // namespace weft
