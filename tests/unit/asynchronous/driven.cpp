// Bodies that turn about an axis as a torque and the cloth bid them.
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <utility>

#include "host/asynchronous/histories.hpp"
#include "host/base/scratch_folder.hpp"
#include "host/state/energy.hpp"
#include "tests/unit/asynchronous/scenes.hpp"
#include "weft/error.hpp"
#include "weft/shapes.hpp"
#include "weft/simulation.hpp"

namespace weft::test {
namespace {

constexpr double torque = 2e-3, inertia = 1e-3;

/// A rod along z with a sheet above it that it does not touch.
Scene rod_scene(double height) {
  Scene s = asynchronous_scene();
  s.name = "rod";
  s.gravity = {0, 0, 0};
  s.cloths.push_back(sheet(5, height));
  Obstacle rod;
  rod.name = "rod";
  rod.mesh = make_box({0.06, 0.06, 0.3}, {1, 1, 2});
  rod.transform = {{0, 0, -0.2}, {0, 0, 1}, 0.3, 1};
  rod.friction = 0.5;
  rod.driven = DrivenBody{{0, 0, -0.2}, {0, 0, 1}, inertia, torque, 0, 0.05};
  s.obstacles.push_back(rod);
  return s;
}

/// [s] of the tick that the angle in the state is of.
double tick_of(const WindowRun& run) {
  return Ticks{run.windows.internal_step()}.time(
      Ticks{run.windows.internal_step()}.first_from(run.windows.time()));
}

/// theta = torque t^2 / (2 I), and half of I omega^2 is what the torque has done.
TEST(Driven, TorqueTurnsAFreeBodyExactly) {
  Scene s = rod_scene(0.5);
  s.obstacles[0].driven->end_time = 1;
  WindowRun run(s);
  for (int k = 1; k <= 10; ++k) {
    ASSERT_TRUE(run.advance(0.01 * k));
    const double t = tick_of(run);
    const auto state = run.windows.driven();
    const double angle = torque * t * t / (2 * inertia);
    EXPECT_NEAR(state[0], angle, 1e-12);
    // The speed is that of the middle of the last tick.
    const double speed = state[1] + torque / inertia * run.windows.internal_step() / 2;
    EXPECT_NEAR(inertia / 2 * speed * speed, torque * angle, 1e-12 * torque);
  }
}

TEST(Driven, FreeRotationGoesOnExactly) {
  WindowRun run(rod_scene(0.5));
  ASSERT_TRUE(run.advance(0.06));
  const auto before = run.windows.driven();
  const double t0 = tick_of(run);
  // Until half a tick after the last one before 50 ms.
  const double h = run.windows.internal_step();
  EXPECT_NEAR(before[1], torque / inertia * 0.05, torque / inertia * h);
  for (int k = 7; k <= 20; ++k) ASSERT_TRUE(run.advance(0.01 * k));
  const auto after = run.windows.driven();
  EXPECT_EQ(after[1], before[1]) << "nothing turns it, nothing brakes it";
  EXPECT_NEAR(after[0] - before[0], before[1] * (tick_of(run) - t0), 1e-13);
  // Between ticks vertices go straight: off their circle by the height of the arc at most.
  const double sag = std::pow(before[1] * h, 2) / 8;
  const auto first = static_cast<std::size_t>(run.model.cloth_vertex_count);
  for (std::size_t i = first; i < run.positions.size(); ++i) {
    const auto radius = [](const Vec3<double>& x) { return std::hypot(x[0], x[1]); };
    const double r = radius(run.model.positions[i]);
    EXPECT_NEAR(radius(run.positions[i]), r, sag * r + 1e-14);
    EXPECT_EQ(run.positions[i][2], run.model.positions[i][2]);
  }
}

/// A sheet pinned to a bar that whirls it around and lets it hit the bar.
Scene whirl() {
  Scene s = rod_scene(0);
  s.contact.friction = 0.3;
  s.obstacles[0].mesh = make_box({0.3, 0.02, 0.02}, {6, 1, 1});
  s.obstacles[0].transform = {{0, 0.02, -0.02}, {0, 0, 1}, 0, 1};
  s.obstacles[0].driven = DrivenBody{{0, 0, 0}, {1, 0, 0}, 2e-4, 1e-2, 0, 0.06};
  s.pins.push_back({});
  s.pins[0].vertices = {14, 15};
  s.pins[0].obstacle = 0;
  return s;
}

/// [kg m^2] of the body and what is pinned to it
double inertia_of_all(const WindowRun& run) {
  const DrivenBody& body = *run.scene.obstacles[0].driven;
  double sum = body.inertia;
  for (const auto& p : run.model.pinned) {
    const auto v = static_cast<std::size_t>(p.vertex);
    sum += run.model.mass[v] * length_sq(cross(body.axis, run.model.positions[v] - body.origin));
  }
  return sum;
}

bool is_pinned(const WindowRun& run, std::size_t i) {
  for (const auto& p : run.model.pinned)
    if (static_cast<std::size_t>(p.vertex) == i) return true;
  return false;
}

/// What the cloth and the body have about the axis through the origin.
double angular_momentum(const WindowRun& run, const Vec3<double>& axis) {
  double sum = 0;
  for (std::size_t i = 0; i < run.velocities.size(); ++i)
    if (!is_pinned(run, i))
      sum += run.model.mass[i] * dot(axis, cross(run.positions[i], run.velocities[i]));
  const auto state = run.windows.driven();
  return sum + inertia_of_all(run) * state[1] + state[2];
}

/// Without friction, whose two ends are a gap apart.
TEST(Driven, AngularMomentumIsWhatTheTorqueGives) {
  Scene s = whirl();
  s.contact.friction = 0;
  s.obstacles[0].friction = 0;
  WindowRun run(s);
  const double h = run.windows.internal_step();
  for (int k = 1; k <= 20; ++k) {
    const double end = 0.0105 * k;
    ASSERT_TRUE(run.advance(end)) << run.total.failure_detail;
    // Ticks before `end` and 60 ms, the first of which acts for half a step.
    const auto ticks = static_cast<double>(Ticks{h}.first_from(std::min(end, 0.06)));
    EXPECT_NEAR(angular_momentum(run, {1, 0, 0}), 1e-2 * h * (ticks - 0.5), 1e-12) << end;
  }
  EXPECT_GT(run.total.asynchronous.acting_pairs, 0) << "the sheet never met the bar";
  EXPECT_GT(std::abs(run.windows.driven()[0]), 0.1) << "the bar never turned";
}

/// The whirling bar without friction, driven all the time; and a sheet far away that rests, whose
/// cells are 2^-finer of those of the first: its forces and masses set all stable steps.
Scene refined_whirl(int finer) {
  Scene s = whirl();
  s.contact.friction = 0;
  s.obstacles[0].friction = 0;
  s.obstacles[0].driven->end_time = 1;
  s.obstacles[0].driven->torque = 2e-3;
  const double cell = 0.08 / (1 << finer);
  Cloth far;
  far.name = "far";
  far.mesh = make_grid({4 * cell, 4 * cell}, {4, 4}, Diagonals::alternating);
  for (auto& x : far.mesh.positions) x[2] += 10;
  s.cloths.push_back(far);
  return s;
}

/// [J] in the layers, all pairs at the end of the last window
struct LayerEnergy {
  double energy = 0;

  static void look(void* context, const Histories& trajectories, const ActiveLayers& layers,
                   const VertexMotion& motion, const LayerRule& rule) {
    double& sum = static_cast<LayerEnergy*>(context)->energy;
    sum = 0;
    for (const LayeredPair& p : layers.pairs()) {
      Vec3<double> x[4];
      for (int c = 0; c < 4; ++c)
        x[c] = motion.position(static_cast<std::size_t>(p.pair.v[c]), trajectories.last_time());
      const double d = std::sqrt(p.pair.closest(x).distance_sq);
      for (int l = 1; l <= p.depth; ++l)
        sum += rule.stiffness_of(l) / 2 * std::pow(std::max(rule.thickness_of(l) - d, 0.0), 2);
    }
  }
};

struct EnergyError {
  double step;   ///< [s] of the cloth and the body
  double error;  ///< [J] energy of body, cloth and layers less the torque's work
  double bound;  ///< [J] of the torque's part in it, see below
  double work;   ///< [J]
  std::int64_t acting;
};

/// In the middle of the tick next to `about`: what is kicked at ticks is known there to second
/// order, from the last kick's velocities.
EnergyError energy_error(int finer, double about) {
  WindowRun run(refined_whirl(finer));
  LayerEnergy in_layers;
  run.windows.observe(LayerEnergy::look, &in_layers);
  const double h = run.windows.internal_step();
  const double time = (std::round(about / h) + 0.5) * h;
  for (double t = 0.01; t < time; t += 0.01)
    EXPECT_TRUE(run.advance(t)) << run.total.failure_detail;
  EXPECT_TRUE(run.advance(time)) << run.total.failure_detail;
  std::vector<unsigned char> fixed(static_cast<std::size_t>(run.model.vertex_count), 0);
  for (const auto& p : run.model.pinned) fixed[static_cast<std::size_t>(p.vertex)] = 1;
  const auto plate = make_plate(run.scene, run.model, held_triangles(run.model, fixed));
  auto velocities = run.velocities;
  for (std::size_t i = 0; i < velocities.size(); ++i)
    if (is_pinned(run, i)) velocities[i] = {};  // counted with the body
  const Energy cloth = measure_energy(run.scene, run.model, run.positions, velocities, {}, plate);
  const auto state = run.windows.driven();
  const double turning = inertia_of_all(run) / 2 * state[1] * state[1];
  const double whirl_torque = run.scene.obstacles[0].driven->torque;
  const double work = whirl_torque * (state[0] - state[1] * (tick_of(run) - time));
  return {h, turning + cloth.kinetic + cloth.elastic + in_layers.energy - work,
          std::pow(whirl_torque * h, 2) / (8 * inertia_of_all(run)), work,
          run.total.asynchronous.acting_pairs};
}

/// Nothing rubs and nothing is damped: what body and cloth have gained is what the torque has done,
/// but for what steps miss. Without contact all act at the same ticks, which is leapfrog: of second
/// order. A body of inertia I alone has the speed a t in the middle of a tick, and the angle
/// a (t^2 + h^2 / 4) / 2, as the mean of two ticks': its energy is torque^2 h^2 / (8 I) below the
/// work, for good. Cloth adds to the inertia and takes part in the same way.
TEST(Driven, EnergyIsTheTorquesWorkToSecondOrder) {
  double before = 0, step_before = 0;
  for (int finer = 0; finer < 4; ++finer) {
    const EnergyError e = energy_error(finer, 0.16);
    EXPECT_EQ(e.acting, 0);
    EXPECT_LT(std::abs(e.error), e.bound) << e.step;
    EXPECT_LT(e.bound, 2e-5 * e.work);
    if (finer > 0) {
      EXPECT_NEAR(e.error / before, std::pow(e.step / step_before, 2), 0.02) << e.step;
    }
    before = e.error;
    step_before = e.step;
  }
}

/// A body takes what layers give it at its own ticks: of an impulse J in one of them the layers
/// have done the work J v, and the body gains J v + J^2 / (2 I). That is an excess of
/// h / (2 I) times the integral of the squared moment over the contact: of first order.
TEST(Driven, EnergyIsTheTorquesWorkToFirstOrderInContact) {
  double before = 0, step_before = 0;
  for (int finer = 0; finer < 4; ++finer) {
    const EnergyError e = energy_error(finer, 0.4);
    EXPECT_GT(e.acting, 100) << "the sheet never met the bar";
    EXPECT_GT(e.error, 0) << e.step;
    if (finer > 0) {
      // When layers tick after a contact has begun changes its impulses by a few of a hundred.
      EXPECT_NEAR(e.error / before, e.step / step_before, 0.1) << e.step;
    }
    before = e.error;
    step_before = e.step;
  }
}

// A body's vertices tick with the cloth's internal forces, right after them: where they are between
// is part of the ways that detection sees.
TEST(Driven, WaysHaveAKnotAtEachTick) {
  VertexMotion motion;
  motion.x = {{0, 0, 0}, {1, 0, 0}};  // cloth, body
  motion.v = {{0, 0, 0}, {0, 1, 0}};
  motion.t = {0, 0};
  motion.inv_mass = {1, 0};
  Histories trajectories;
  trajectories.reset(motion, 1, 0);
  for (const double time : {0.0, 0.25, 0.5}) {
    trajectories.add_all(time)[0] = motion.position(0, time);
    motion.advance(1, time);
    trajectories.add(1, time, motion.x[1]);
    motion.v[1] += {1, 0, 0};
  }
  trajectories.finish(motion, 1);
  const std::vector<Breakpoint> way = trajectories.way(1);
  ASSERT_EQ(way.size(), 4u);
  for (std::size_t k = 0; k < 3; ++k) EXPECT_EQ(way[k].t, 0.25 * static_cast<double>(k));
  EXPECT_EQ(way[1].x[1], 0.25);
  EXPECT_EQ(way[2].x[0], 1.75);
  EXPECT_EQ(trajectories.way(0).size(), 4u);
}

TEST(Driven, ThreadsAndWindowsChangeNoBit) {
  Scene s = whirl();
  const auto outcome = [&](int threads) {
    WindowRun run(s, threads);
    for (int k = 1; k <= 10; ++k) EXPECT_TRUE(run.advance(0.0105 * k));
    return std::pair{run.positions, run.windows.driven()};
  };
  const auto expected = outcome(1);
  EXPECT_EQ(outcome(3), expected);
  s.asynchronous.window = 0.0007;
  EXPECT_EQ(outcome(1), expected);
}

TEST(Driven, ResumesWithTheSameBits) {
  Scene s = whirl();
  s.time.step = 0.0125;
  s.time.frame_rate = 20;
  const ScratchFolder folder;
  const auto file = folder / "checkpoint.weft";
  Simulation whole(s, host_devices(1));
  for (int k = 0; k < 9; ++k) {
    if (k == 5) whole.save(file);
    ASSERT_EQ(whole.step().failure, Failure::none);
  }
  Simulation resumed(s, host_devices(1));
  resumed.resume(file);
  for (int k = 5; k < 9; ++k) ASSERT_EQ(resumed.step().failure, Failure::none);
  EXPECT_EQ(resumed.state_hash(), whole.state_hash());
}

/// A pin that lets go takes its share along, and the body goes on as fast as it did.
TEST(Driven, PinsThatLetGoKeepTheMomentum) {
  Scene s = whirl();
  s.pins[0].release_time = 0.03;
  s.obstacles[0].driven->end_time = 0.02;
  WindowRun run(s);
  ASSERT_TRUE(run.advance(0.025)) << run.total.failure_detail;
  const double before = angular_momentum(run, {1, 0, 0});
  ASSERT_TRUE(run.advance(0.06)) << run.total.failure_detail;
  run.model.pinned.clear();  // of no use to windows any more: all have let go
  EXPECT_NEAR(angular_momentum(run, {1, 0, 0}), before, 1e-9);
}

TEST(Driven, IsRefusedWhereItCannotBe) {
  const auto refused = [](const Scene& s, const std::string& field) {
    try {
      validate(s);
      ADD_FAILURE() << field << " was taken";
    } catch (const SceneError& error) {
      EXPECT_NE(std::string(error.what()).find(field), std::string::npos) << error.what();
    }
  };
  Scene s = whirl();
  s.method = "implicit";
  refused(s, "obstacles[0].driven");
  s = whirl();
  s.obstacles[0].driven->inertia = 0;
  refused(s, "obstacles[0].driven.inertia");
  s = whirl();
  s.obstacles[0].driven->axis = {0, 0, 2};
  refused(s, "obstacles[0].driven.axis");
  s = whirl();
  s.obstacles[0].motion = {{0, {}}, {1, {}}};
  refused(s, "obstacles[0].driven");
}

}  // namespace
}  // namespace weft::test
