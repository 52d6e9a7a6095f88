#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "host/base/scratch_folder.hpp"
#include "tests/support/small_scenes.hpp"
#include "weft/error.hpp"
#include "weft/simulation.hpp"

namespace weft {
namespace {

Scene free_sheet(Integrator integrator, double step) {
  Scene s;
  s.precision = Precision::double_precision;
  s.integrator = integrator;
  s.materials.push_back(test::cotton());
  s.cloths.push_back(test::sheet(6, 0));
  s.time.step = step;
  s.time.frame_rate = 10;
  s.solver.tolerance = 1e-13;
  return s;
}

double height_after(Scene s, int steps) {
  Simulation simulation(std::move(s), host_devices(2));
  for (int k = 0; k < steps; ++k) EXPECT_EQ(Failure::none, simulation.step().failure);
  return simulation.frame().cloth_positions[0][17][2];
}

TEST(ImplicitStep, ImplicitEulerFallsAsItsFormulaSays) {
  const double h = 0.01;
  const double t = 10 * h;
  EXPECT_NEAR(-9.81 * t * (t + h) / 2, height_after(free_sheet(Integrator::implicit_euler, h), 10),
              1e-12);
}

TEST(ImplicitStep, Bdf2FallsToSecondOrder) {
  const double exact = -9.81 * 0.01 / 2;
  const double coarse = std::abs(height_after(free_sheet(Integrator::bdf2, 0.01), 10) - exact);
  const double fine = std::abs(height_after(free_sheet(Integrator::bdf2, 0.005), 20) - exact);
  EXPECT_NEAR(2, std::log2(coarse / fine), 0.25);
}

TEST(ImplicitStep, AggregatesSaveIterationsAndChangeNothingElse) {
  Scene s = free_sheet(Integrator::implicit_euler, 0.005);
  s.cloths[0] = test::sheet(40, 0);
  for (auto& p : s.cloths[0].mesh.positions) p[1] *= 1.05 + 0.1 * p[0];
  // Else the initial guess has what gravity does.
  Pin corner;
  corner.vertices = {0};
  s.pins = {corner};
  s.solver.tolerance = 1e-9;
  Simulation multilevel(s, host_devices(2));
  s.solver.preconditioner = Preconditioner::block_jacobi;
  Simulation jacobi(s, host_devices(2));
  const StepReport with = multilevel.step();
  const StepReport without = jacobi.step();
  ASSERT_EQ(Failure::none, with.failure);
  ASSERT_EQ(Failure::none, without.failure);
  EXPECT_LT(with.iterations, 0.75 * without.iterations);
  const auto x = multilevel.frame().cloth_positions[0];
  const auto y = jacobi.frame().cloth_positions[0];
  for (std::size_t v = 0; v < x.size(); ++v) EXPECT_LT(length(x[v] - y[v]), 1e-9) << v;
}

Scene sheet_in_wind() {
  Scene s = free_sheet(Integrator::implicit_euler, 0.01);
  s.gravity = {0, 0, 0};
  s.contact.self = false;
  return s;
}

/// A rigidly moving sheet: (m / A) dv/dt = C (w - v), with |w - v| of the step's start across it.
TEST(ImplicitStep, WindAcrossASheetDragsWithTheSquareOfItsSpeed) {
  Scene s = sheet_in_wind();
  s.wind = {1.2, {0, 0, 5}, 0};
  const double density = s.materials[0].density;
  Simulation simulation(s, host_devices(2));
  double v = 0;
  double z = s.cloths[0].mesh.positions[17][2];
  for (int k = 0; k < 20; ++k) {
    ASSERT_EQ(Failure::none, simulation.step().failure);
    const double c = 1.2 * (5 - v) * 0.01 / density;
    v = (v + c * 5) / (1 + c);
    z += 0.01 * v;
  }
  const auto positions = simulation.frame().cloth_positions[0];
  double mean = 0;
  for (const auto& p : positions) mean += p[2] / static_cast<double>(positions.size());
  EXPECT_NEAR(z, positions[24][2], 1e-9);
  EXPECT_NEAR(z, mean, 1e-9);
}

TEST(ImplicitStep, WindAlongASheetDragsWithItsSpeed) {
  Scene s = sheet_in_wind();
  s.wind = {0, {2, 0, 0}, 0.3};
  const double c = 0.3 * 0.01 / s.materials[0].density;
  const double x0 = s.cloths[0].mesh.positions[24][0];
  Simulation simulation(s, host_devices(1));
  double v = 0;
  double x = x0;
  for (int k = 0; k < 20; ++k) {
    ASSERT_EQ(Failure::none, simulation.step().failure);
    v = (v + c * 2) / (1 + c);
    x += 0.01 * v;
  }
  EXPECT_NEAR(x, simulation.frame().cloth_positions[0][24][0], 1e-9);
}

TEST(ImplicitStep, FreeFlightKeepsLinearMomentum) {
  Scene s = free_sheet(Integrator::implicit_euler, 0.005);
  s.gravity = {0, 0, 0};
  s.cloths[0].velocity = {0.3, -0.2, 0.1};
  // Stretched and creased at the start, so that it moves in itself.
  for (auto& p : s.cloths[0].mesh.positions) {
    p[2] += 0.02 * std::sin(20 * p[0]);
    p[1] *= 1.05;
  }
  Simulation simulation(s, host_devices(3));
  for (int k = 0; k < 20; ++k) {
    const StepReport r = simulation.step();
    ASSERT_EQ(Failure::none, r.failure) << r.failure_detail;
  }
  const Frame frame = simulation.frame();
  // Lumped masses: a third of the area of the triangles around.
  std::vector<double> mass(frame.cloth_positions[0].size(), 0);
  const Mesh& mesh = s.cloths[0].mesh;
  for (const Tri& t : mesh.triangles) {
    const auto a = mesh.material[static_cast<std::size_t>(t.v[1])] -
                   mesh.material[static_cast<std::size_t>(t.v[0])];
    const auto b = mesh.material[static_cast<std::size_t>(t.v[2])] -
                   mesh.material[static_cast<std::size_t>(t.v[0])];
    for (const Index v : t.v)
      mass[static_cast<std::size_t>(v)] += s.materials[0].density * (a[0] * b[1] - a[1] * b[0]) / 6;
  }
  Vec3<double> momentum{};
  double total = 0;
  for (std::size_t v = 0; v < mass.size(); ++v) {
    momentum += mass[v] * frame.cloth_velocities[0][v];
    total += mass[v];
  }
  for (int c = 0; c < 3; ++c)
    EXPECT_NEAR(s.cloths[0].velocity[c] * total, momentum[c], 1e-11 * total);
}

TEST(ImplicitStep, NeverGainsEnergyWithoutContact) {
  Scene s = test::hanging_sheet(Precision::double_precision, Integrator::implicit_euler);
  s.pins.pop_back();
  Simulation simulation(s, host_devices(1));
  const auto total = [&] {
    const Energy e = simulation.energy();
    return e.kinetic + e.elastic + e.gravitational;
  };
  double before = total();
  for (int k = 0; k < 40; ++k) {
    simulation.step();
    const double now = total();
    EXPECT_LE(now, before + 1e-6);
    before = now;
  }
}

TEST(ImplicitStep, PinnedVerticesAreWhereTheirPinsWantThem) {
  const Scene s = test::hanging_sheet(Precision::double_precision, Integrator::implicit_euler);
  Simulation simulation(s, host_devices(2));
  while (simulation.time() < 0.1 - 1e-9) simulation.step();
  const Frame frame = simulation.frame();
  for (int c = 0; c < 3; ++c) {
    EXPECT_NEAR(s.cloths[0].mesh.positions[0][c], frame.cloth_positions[0][0][c], 1e-15);
    EXPECT_NEAR(s.cloths[0].mesh.positions[10][c] + s.pins[1].motion[1].transform.translate[c],
                frame.cloth_positions[0][10][c], 1e-12);
  }
}

class CheckpointTest : public testing::Test {
 protected:
  const ScratchFolder folder_;
  const std::filesystem::path file_ = folder_ / "checkpoint.weft";
};

TEST_F(CheckpointTest, ResumesBitForBit) {
  for (const Integrator integrator : {Integrator::implicit_euler, Integrator::bdf2}) {
    Scene s = test::sheet_on_sphere(Precision::single_precision, 10);
    s.integrator = integrator;
    Simulation whole(s, host_devices(2));
    for (int k = 0; k < 9; ++k) whole.step();
    whole.save(file_);
    for (int k = 0; k < 9; ++k) whole.step();
    Simulation resumed(s, host_devices(3));
    resumed.resume(file_);
    EXPECT_EQ(9, resumed.step_number());
    for (int k = 0; k < 9; ++k) resumed.step();
    EXPECT_EQ(whole.state_hash(), resumed.state_hash());
    EXPECT_EQ(whole.time(), resumed.time());
  }
}

/// What triangles can bend changes when a pin lets go, which no checkpoint says.
TEST_F(CheckpointTest, ResumesBitForBitAroundARelease) {
  const Scene s = test::curled_sheet(Precision::single_precision, Bending::plate);
  Simulation whole(s, host_devices(2));
  std::vector<std::uint64_t> hashes;
  std::vector<double> energies;
  for (int k = 0; k < 20; ++k) {
    ASSERT_EQ(Failure::none, whole.step().failure);
    hashes.push_back(whole.state_hash());
    energies.push_back(whole.energy().elastic);
  }
  const int release = static_cast<int>(std::lround(s.pins[0].release_time / whole.step_length()));
  for (const int stop : {release - 2, release - 1, release, release + 1}) {
    Simulation before(s, host_devices(1));
    for (int k = 0; k < stop; ++k) before.step();
    before.save(file_);
    Simulation resumed(s, host_devices(3));
    resumed.resume(file_);
    EXPECT_EQ(energies[static_cast<std::size_t>(stop - 1)], resumed.energy().elastic);
    for (int k = stop; k < 20; ++k) resumed.step();
    EXPECT_EQ(hashes.back(), resumed.state_hash()) << "stopped after " << stop;
    EXPECT_EQ(energies.back(), resumed.energy().elastic);
  }
}

TEST(ImplicitStep, ATriangleThatIsHeldDoesNotBend) {
  Scene s = test::released_sheet(Precision::double_precision);
  s.materials[0].stretch_stiffness = 1e-9;
  s.gravity = {0, 0, 0};
  auto& x = s.cloths[0].mesh.positions;
  for (auto& p : x) p[2] = p[0] * p[0];
  for (std::size_t v = 22; v < x.size(); ++v) s.pins[0].vertices.push_back(static_cast<Index>(v));
  Simulation held(s, host_devices(1));
  EXPECT_LT(held.energy().elastic, 1e-9);
  s.pins.clear();
  Simulation free(s, host_devices(1));
  EXPECT_NEAR(0.5 * 1e-3 * 4 * 0.16, free.energy().elastic, 1e-9);
}

/// A resumed run has no pairs of earlier steps, so it searches at other times than the whole run,
/// and vertices leave other swept AABBs within a step.
TEST_F(CheckpointTest, WhenPairsWereSearchedChangesNothing) {
  int rebuilds = 0;
  for (const bool first : {true, false}) {
    Scene s = test::sheet_on_sphere(Precision::single_precision, first ? 10 : 14);
    s.cloths[0].velocity = first ? Vec3<double>{0, 0, -6} : Vec3<double>{0.3, 0.06, -4};
    s.materials[0].stretch_stiffness = 800;
    s.contact.thickness = 1e-3;
    Simulation whole(s, host_devices(1));
    std::vector<std::uint64_t> hashes;
    for (int k = 0; k < 40; ++k) {
      rebuilds += whole.step().rebuilds;
      hashes.push_back(whole.state_hash());
    }
    for (int stop = 3; stop < 40; stop += 4) {
      Simulation before(s, host_devices(1));
      for (int k = 0; k < stop; ++k) before.step();
      before.save(file_);
      Simulation resumed(s, host_devices(2));
      resumed.resume(file_);
      for (int k = stop; k < 40; ++k) {
        resumed.step();
        ASSERT_EQ(hashes[static_cast<std::size_t>(k)], resumed.state_hash())
            << "stopped after " << stop << ", step " << k + 1;
      }
    }
  }
  EXPECT_GT(rebuilds, 0);
}

TEST_F(CheckpointTest, EveryDamageIsRefused) {
  const Scene s = test::sheet_on_sphere(Precision::single_precision, 4);
  Simulation simulation(s, host_devices(1));
  simulation.save(file_);
  std::ifstream in(file_, std::ios::binary);
  const std::string bytes(std::istreambuf_iterator<char>(in), {});
  in.close();
  const auto write = [&](const std::string& text) {
    std::ofstream(file_, std::ios::binary | std::ios::trunc)
        .write(text.data(), static_cast<std::streamsize>(text.size()));
  };
  for (std::size_t size = 0; size < bytes.size(); size += 37) {
    write(bytes.substr(0, size));
    EXPECT_THROW(simulation.resume(file_), SceneError) << size << " bytes";
  }
  for (std::size_t place = 0; place < bytes.size(); place += 41) {
    std::string damaged = bytes;
    damaged[place] = static_cast<char>(damaged[place] ^ 0x10);
    write(damaged);
    EXPECT_THROW(simulation.resume(file_), SceneError) << "byte " << place;
  }
  write(bytes);
  simulation.resume(file_);
}

TEST_F(CheckpointTest, OfAnotherSceneIsRefused) {
  Simulation a(test::sheet_on_sphere(Precision::single_precision, 4), host_devices(1));
  Simulation b(test::sheet_on_sphere(Precision::single_precision, 5), host_devices(1));
  Simulation c(test::sheet_on_sphere(Precision::double_precision, 4), host_devices(1));
  a.save(file_);
  EXPECT_THROW(b.resume(file_), SceneError);
  EXPECT_THROW(c.resume(file_), SceneError);
  EXPECT_THROW(a.resume("/nowhere/at/all.weft"), SceneError);
}

}  // namespace
}  // namespace weft
