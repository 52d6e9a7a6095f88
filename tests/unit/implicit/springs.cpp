#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <numbers>
#include <string>

#include "host/base/scratch_folder.hpp"
#include "host/model/model.hpp"
#include "host/model/model_part.hpp"
#include "host/model/seam_stiffness.hpp"
#include "host/model/springs.hpp"
#include "tests/support/small_scenes.hpp"
#include "weft/core/at.hpp"
#include "weft/error.hpp"
#include "weft/simulation.hpp"

namespace weft {
namespace {

Scene bare_scene() {
  Scene s;
  s.precision = Precision::double_precision;
  s.materials.push_back(test::cotton());
  s.time.step = 0.005;
  s.time.frame_rate = 100;
  s.solver.tolerance = 1e-12;
  s.gravity = {0, 0, 0};
  return s;
}

Vec3<double> momentum(const Scene& scene, const Frame& frame) {
  const Model model = make_model(scene);
  Vec3<double> sum{};
  for (std::size_t c = 0; c < frame.cloth_velocities.size(); ++c)
    for (std::size_t v = 0; v < frame.cloth_velocities[c].size(); ++v)
      sum += model.mass[at(model.to_internal[at(model.input_offset[c]) + v])] *
             frame.cloth_velocities[c][v];
  return sum;
}

/// A step of implicit Euler changes momentum by h times the forces at its end; those within the
/// cloth cancel, and springs to places are linear, so that this holds to rounding.
void expect_momentum_balance(const Scene& scene, Simulation& simulation, int steps,
                             double (*strength)(double)) {
  const Model model = make_model(scene);
  double mass = 0;
  for (const double m : model.mass) mass += m;
  const Handle& handle = scene.handles[0];
  for (int n = 0; n < steps; ++n) {
    const Vec3<double> before = momentum(scene, simulation.frame());
    ASSERT_EQ(Failure::none, simulation.step().failure);
    const Frame frame = simulation.frame();
    const double h = simulation.step_length();
    Vec3<double> expected = before + (h * mass) * scene.gravity;
    for (const Index v : handle.vertices) {
      Vec3<double> target = scene.cloths[0].mesh.positions[at(v)];
      if (!handle.motion.empty())
        target = apply(transform_at(handle.motion, simulation.time()), target);
      expected += (h * handle.stiffness * strength(simulation.time())) *
                  (target - frame.cloth_positions[0][at(v)]);
    }
    EXPECT_LT(length(momentum(scene, frame) - expected), 1e-11) << "step " << n;
  }
}

TEST(Handles, DrawTheirVerticesToWhereTheirMotionGoes) {
  Scene s = bare_scene();
  s.gravity = {0, 0, -9.81};
  s.cloths.push_back(test::sheet(6, 0));
  s.handles.push_back({});
  s.handles[0].vertices = {0, 3, 6, 20};
  s.handles[0].stiffness = 50;
  s.handles[0].motion = {{0, {}}, {0.2, {{0.1, 0, 0.05}, {0, 0, 1}, 0.5, 1}}};
  Simulation simulation(s, host_devices(2));
  expect_momentum_balance(s, simulation, 30, [](double) { return 1.0; });
}

TEST(Handles, FadeAfterTheirEnd) {
  Scene s = bare_scene();
  s.gravity = {0, 0, -9.81};
  s.cloths.push_back(test::sheet(6, 0));
  s.handles.push_back({});
  s.handles[0].vertices = {0, 6};
  s.handles[0].stiffness = 50;
  s.handles[0].start_time = 0.0199;
  s.handles[0].end_time = 0.05;
  s.handles[0].fade_time = 0.05;
  Simulation simulation(s, host_devices(1));
  expect_momentum_balance(s, simulation, 30, [](double t) {
    return t < 0.0199 ? 0.0 : t <= 0.05 ? 1.0 : std::max(0.0, 1 - (t - 0.05) / 0.05);
  });
}

TEST(Handles, CircleWindsTheClothOnce) {
  Scene s = bare_scene();
  s.cloths.push_back(test::sheet(8, 0));
  // Bent to a tube of one turn less than its width, so that its edges stay apart.
  const double radius = 0.44 / (2 * std::numbers::pi);
  Mesh& mesh = s.cloths[0].mesh;
  Handle handle;
  handle.shape = Handle::Shape::circle;
  handle.circumference = 0.44;
  handle.center = {1, 2, 3};
  handle.axis0 = {0, 1, 0};
  handle.axis1 = {0, 0, 1};
  handle.stiffness = 1e5;
  std::vector<Vec3<double>> expected;
  for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
    const double angle = mesh.material[v][0] / radius;
    Vec3<double>& x = mesh.positions[v];
    x = {1 + x[1], 2 + 1.05 * radius * std::cos(angle), 3 + 1.05 * radius * std::sin(angle)};
    if (x[0] < 1 - 0.1999) {
      handle.vertices.push_back(static_cast<Index>(v));
      expected.push_back({1, 2 + radius * std::cos(angle), 3 + radius * std::sin(angle)});
    }
  }
  ASSERT_EQ(9u, handle.vertices.size());
  s.handles.push_back(handle);
  s.materials[0].damping_mass = 20;
  Simulation simulation(s, host_devices(2));
  for (int n = 0; n < 80; ++n) ASSERT_EQ(Failure::none, simulation.step().failure);
  const Frame frame = simulation.frame();
  for (std::size_t k = 0; k < expected.size(); ++k)
    EXPECT_LT(length(frame.cloth_positions[0][at(handle.vertices[k])] - expected[k]), 1e-3) << k;
}

TEST(Handles, GlueKeepsMomentum) {
  Scene s = bare_scene();
  s.cloths.push_back(test::sheet(8, 0));
  Handle handle;
  handle.shape = Handle::Shape::glue;
  handle.vertices = {0, 80};  // opposite corners
  handle.stiffness = 2;
  s.handles.push_back(handle);
  for (auto& p : s.cloths[0].mesh.positions) p[2] = 0.02 * std::cos(8 * (p[0] + p[1]));
  Simulation simulation(s, host_devices(2));
  const auto gap = [&] {
    const auto x = simulation.frame().cloth_positions[0];
    return length(x[80] - x[0]);
  };
  const double before = gap();
  for (int n = 0; n < 40; ++n) ASSERT_EQ(Failure::none, simulation.step().failure);
  EXPECT_LT(gap(), 0.9 * before);
  EXPECT_LT(length(momentum(s, simulation.frame())), 1e-11);
}

// ---- seams

/// Two square sheets side by side, sewn along their common side.
Scene two_panels(double gap, Index cells = 6) {
  Scene s = bare_scene();
  for (int k = 0; k < 2; ++k) {
    s.cloths.push_back(test::sheet(static_cast<int>(cells), 0));
    s.cloths.back().name = k == 0 ? "left" : "right";
    if (k == 0) continue;
    for (auto& p : s.cloths[1].mesh.positions) p[0] += 0.4 + gap;
    for (auto& m : s.cloths[1].mesh.material) m[0] += 0.4;
  }
  Seam seam;
  seam.cloths[1] = 1;
  for (Index j = 0; j <= cells; ++j) {
    seam.vertices[0].push_back((cells + 1) * j + cells);
    seam.vertices[1].push_back((cells + 1) * j);
  }
  seam.stiffness = 200;
  seam.ramp_time = 0.1;
  seam.weld_distance = 2e-3;
  s.seams.push_back(seam);
  return s;
}

TEST(Seams, WeldedFromTheStartAreOneSheet) {
  Scene sewn = two_panels(0);
  Scene whole = bare_scene();
  whole.cloths.push_back(sewn.cloths[0]);
  Mesh& mesh = whole.cloths[0].mesh;
  std::vector<Index> number;
  for (std::size_t v = 0; v < 49; ++v) {
    if (v % 7 == 0) {
      number.push_back(static_cast<Index>(v) + 6);
      continue;
    }
    number.push_back(static_cast<Index>(mesh.positions.size()));
    mesh.positions.push_back(sewn.cloths[1].mesh.positions[v]);
    mesh.material.push_back(sewn.cloths[1].mesh.material[v]);
  }
  for (const Tri& t : sewn.cloths[1].mesh.triangles)
    mesh.triangles.push_back({{number[at(t.v[0])], number[at(t.v[1])], number[at(t.v[2])]}});
  for (Scene* s : {&sewn, &whole}) {
    s->gravity = {0, 0, -9.81};
    s->pins.push_back({0, {0, 42}, {}});
  }
  Simulation a(sewn, host_devices(2));
  Simulation b(whole, host_devices(1));
  for (int n = 0; n < 40; ++n) {
    ASSERT_EQ(0, a.step().open_seam_pairs);
    ASSERT_EQ(Failure::none, b.step().failure);
  }
  const Frame x = a.frame();
  const Frame y = b.frame();
  EXPECT_LT(y.cloth_positions[0][56][2], -0.05);  // it has swung down
  for (std::size_t v = 0; v < 49; ++v) {
    EXPECT_LT(length(x.cloth_positions[0][v] - y.cloth_positions[0][v]), 1e-8) << v;
    EXPECT_LT(length(x.cloth_positions[1][v] - y.cloth_positions[0][at(number[v])]), 1e-8) << v;
  }
}

/// Steps until the seams are closed.
void sew(Simulation& simulation, int steps_max) {
  StepReport report;
  do {
    report = simulation.step();
    ASSERT_EQ(Failure::none, report.failure) << report.failure_detail;
  } while (report.open_seam_pairs > 0 && report.number < steps_max);
  ASSERT_EQ(0, report.open_seam_pairs);
}

TEST(Seams, CloseAndWeldAndKeepMomentum) {
  Scene s = two_panels(0.05);
  s.cloths[0].velocity = {0.2, 0.1, 0};
  Simulation simulation(s, host_devices(2));
  const Vec3<double> before = momentum(s, simulation.frame());
  sew(simulation, 400);
  const Frame frame = simulation.frame();
  for (std::size_t k = 0; k < 7; ++k)
    EXPECT_EQ(frame.cloth_positions[0][at(s.seams[0].vertices[0][k])],
              frame.cloth_positions[1][at(s.seams[0].vertices[1][k])])
        << k;
  // Momentum by input would count the masses along the seam of each side with a common velocity.
  EXPECT_LT(length(momentum(s, frame) - before), 1e-10);
  for (int n = 0; n < 20; ++n) ASSERT_EQ(Failure::none, simulation.step().failure);
}

struct Closing {
  double time = 0;    ///< [s]
  double energy = 0;  ///< [J] most kinetic energy on the way
  double speed = 0;   ///< [m/s] of the middle pair in the last step that begins with it open
};

Closing closing_of(const Scene& scene) {
  const Model model = make_model(scene);
  Simulation simulation(scene, host_devices(1));
  Closing closing;
  StepReport report;
  do {
    report = simulation.step();
    EXPECT_EQ(Failure::none, report.failure) << report.failure_detail;
    const Frame frame = simulation.frame();
    double energy = 0;
    for (std::size_t c = 0; c < 2; ++c)
      for (std::size_t v = 0; v < frame.cloth_velocities[c].size(); ++v)
        energy += model.mass[at(model.to_internal[at(model.input_offset[c]) + v])] *
                  length_sq(frame.cloth_velocities[c][v]) / 2;
    closing.energy = std::max(closing.energy, energy);
    const std::size_t middle = scene.seams[0].vertices[0].size() / 2;
    const double speed = length(frame.cloth_velocities[0][at(scene.seams[0].vertices[0][middle])] -
                                frame.cloth_velocities[1][at(scene.seams[0].vertices[1][middle])]);
    if (speed > 0) closing.speed = speed;  // 0: welded
  } while (report.open_seam_pairs > 0 && report.number < 200);
  EXPECT_EQ(0, report.open_seam_pairs);
  closing.time = simulation.time();
  return closing;
}

TEST(Seams, CloseAlikeOnAnyMesh) {
  const auto sewn = [](Index cells) {
    Scene s = two_panels(0.1, cells);
    s.seams[0].stiffness.reset();
    s.seams[0].ramp_time = 0.5;
    return closing_of(s);
  };
  const Closing coarse = sewn(4), fine = sewn(24);
  EXPECT_NEAR(fine.time, coarse.time, 0.1 * coarse.time);
  EXPECT_NEAR(fine.energy, coarse.energy, 0.15 * coarse.energy);
}

TEST(Seams, MeetSlowly) {
  double mean = 0;  // of the speed at the end over the mean speed; with a single ramp it is chance
  for (const double ramp : {1, 2, 3, 4}) {
    Scene s = two_panels(0.1);
    s.seams[0].ramp_time = ramp;
    s.seams[0].stiffness = 1000;
    const Closing closing = closing_of(s);
    mean += closing.speed / (0.1 / closing.time) / 4;
  }
  // 2.9 without dashpots, 2.4 with dashpots half as strong.
  EXPECT_LT(mean, 2);
}

TEST(Seams, StandForTheShorterOfTheirEdges) {
  // Rows of 0.4 m against rows of 0.2 m.
  Scene s = two_panels(0.01);
  for (Vec2<double>& m : s.cloths[1].mesh.material) m[1] /= 2;
  s.seams[0].stiffness.reset();
  // A pair alone, and a seam with a stiffness.
  Seam alone = s.seams[0], given = s.seams[0];
  alone.vertices[0] = {0};
  alone.vertices[1] = {6};
  given.vertices[0] = {42};
  given.vertices[1] = {48};
  given.stiffness = 7;
  s.seams.push_back(alone);
  s.seams.push_back(given);
  const std::vector<double> stiffness = seam_stiffness(s);
  ASSERT_EQ(9u, stiffness.size());
  const double share = 1e5 * 0.2 / 6;
  for (std::size_t k = 0; k < 7; ++k)
    EXPECT_NEAR(stiffness[k], k == 0 || k == 6 ? share / 2 : share, 1e-9 * share) << k;
  EXPECT_EQ(1000, stiffness[7]);
  EXPECT_EQ(7, stiffness[8]);
}

TEST(Seams, PullAsHardInAPartOfAModel) {
  const Scene s = two_panels(0.05);
  const Model model = make_model(s);
  const ModelPart part =
      part_of(model, std::vector<unsigned char>(at(model.cloth_vertex_count), 1));
  const auto springs = springs_at(s, part.model, 0.1);
  ASSERT_EQ(7u, springs.size());
  for (const Spring<double>& spring : springs) EXPECT_EQ(200, spring.stiffness);
}

TEST(Seams, WithoutWeldingStayOpenWithinTheThickness) {
  Scene s = two_panels(0.02);
  s.seams[0].weld_distance = 0;
  s.materials[0].damping_mass = 10;
  Simulation simulation(s, host_devices(1));
  StepReport report;
  for (int n = 0; n < 200; ++n) {
    report = simulation.step();
    ASSERT_EQ(Failure::none, report.failure) << report.failure_detail;
  }
  EXPECT_EQ(7, report.open_seam_pairs);
  const Frame frame = simulation.frame();
  for (std::size_t k = 0; k < 7; ++k) {
    const double gap = length(frame.cloth_positions[0][at(s.seams[0].vertices[0][k])] -
                              frame.cloth_positions[1][at(s.seams[0].vertices[1][k])]);
    EXPECT_GT(gap, 0);
    EXPECT_LE(gap, 1.01 * contact_thickness(s.contact));
  }
}

TEST(Seams, RefineOnceSewn) {
  Scene s = two_panels(0.01);
  s.precision = Precision::single_precision;
  s.solver.tolerance = 1e-4;
  s.gravity = {0, 0, -9.81};
  s.pins.push_back({0, {0, 7, 14}, {}});
  s.refinement = {Refinement::When::sewn, 2};
  const ScratchFolder folder;
  const auto file = folder / "sewn.weft";
  const auto before = folder / "before.weft";
  Simulation one(s, host_devices(1));
  one.step();
  one.save(before);
  sew(one, 400);
  ASSERT_EQ(16 * 72u, one.scene().cloths[0].mesh.triangles.size());
  ASSERT_EQ(625u, one.frame().cloth_positions[1].size());
  EXPECT_EQ(9u, one.scene().pins[0].vertices.size());
  one.save(file);
  for (int n = 0; n < 6; ++n) ASSERT_EQ(Failure::none, one.step().failure);

  Simulation three(s, host_devices(3));
  while (three.step_number() < one.step_number()) three.step();
  EXPECT_EQ(one.state_hash(), three.state_hash());

  Simulation resumed(s, host_devices(2));
  resumed.resume(file);
  ASSERT_EQ(16 * 72u, resumed.scene().cloths[0].mesh.triangles.size());
  while (resumed.step_number() < one.step_number()) resumed.step();
  EXPECT_EQ(one.state_hash(), resumed.state_hash());

  // Back to before it was sewn.
  resumed.resume(before);
  EXPECT_EQ(72u, resumed.scene().cloths[0].mesh.triangles.size());
  while (resumed.step_number() < one.step_number()) resumed.step();
  EXPECT_EQ(one.state_hash(), resumed.state_hash());
}

}  // namespace
}  // namespace weft
