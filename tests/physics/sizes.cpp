// Cloth of a millimetre and of a kilometre: with fabric, times and thickness scaled so that all
// dimensionless groups are equal, the same shape.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "host/lab/chart/compare.hpp"
#include "host/scene/suitable_precision.hpp"
#include "tests/physics/measured.hpp"
#include "weft/shapes.hpp"
#include "weft/simulation.hpp"

namespace weft::physics {
namespace {

/// The scene `drape` with 1,152 triangles, all lengths `size` times as long. Gravity and mass per
/// area stay, so times grow with the root of the size, forces per length with the size.
Scene drape(double size) {
  Scene scene;
  scene.time.step = std::sqrt(size) / 200;
  scene.time.frame_rate = 25 / std::sqrt(size);
  scene.contact.thickness = 0.002 * size;
  Material material;
  material.stretch_stiffness = 1000 * size;
  material.bending_stiffness = 1e-5 * size * size * size;
  material.damping_stiffness = 0.0005 * std::sqrt(size);
  scene.materials.push_back(material);
  Cloth cloth;
  cloth.name = "sheet";
  cloth.mesh = make_grid({size, size}, {24, 24}, Diagonals::alternating);
  for (auto& x : cloth.mesh.positions) x[2] = 0.33 * size;
  scene.cloths.push_back(cloth);
  Obstacle ball;
  ball.name = "ball";
  ball.mesh = make_icosphere(0.3 * size, 3);
  ball.friction = 0.3;
  scene.obstacles.push_back(ball);
  scene.precision = suitable_precision(scene);
  return scene;
}

/// Mean place and spread of the cloth after each tenth of the time in which it drapes, over its
/// size.
std::vector<lab::Statistics> shapes(double size) {
  Simulation simulation(drape(size), host_devices(1));
  std::vector<lab::Statistics> found;
  for (int step = 1; step <= 120; ++step) {
    const StepReport report = simulation.step();
    EXPECT_EQ(Failure::none, report.failure) << report.failure_detail;
    if (report.failure != Failure::none) break;
    if (step % 12 != 0) continue;
    Mesh mesh = simulation.scene().cloths[0].mesh;
    mesh.positions = simulation.frame().cloth_positions[0];
    for (auto& x : mesh.positions) x = (1 / size) * x;
    found.push_back(lab::statistics(mesh));
  }
  return found;
}

class Sizes : public testing::TestWithParam<double> {};

TEST_P(Sizes, DrapeIsTheSameShape) {
  const std::vector<lab::Statistics> right = shapes(1), found = shapes(GetParam());
  ASSERT_EQ(right.size(), found.size());
  double farthest = 0;
  for (std::size_t k = 0; k < right.size(); ++k)
    farthest = std::max(farthest, lab::difference(right[k], found[k]));
  expect_at_most("difference over the size", farthest, 0.01, Known::holds);
}

INSTANTIATE_TEST_SUITE_P(FromAMillimetreToAKilometre, Sizes,
                         testing::Values(1e-3, 1e-2, 0.1, 10, 100, 1e3));

}  // namespace
}  // namespace weft::physics
