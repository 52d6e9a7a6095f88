// Forces of four triangles side by side are those of each alone.
#include "host/asynchronous/sheet.hpp"

#include <gtest/gtest.h>

#include <numeric>
#include <random>

#include "tests/unit/asynchronous/scenes.hpp"

namespace weft::test {
namespace {

/// Velocities after one kick of 1 ms of a crumpled sheet that moves, from the same start.
std::vector<Vec3<double>> kicked(const Scene& scene) {
  const Model model = make_model(scene);
  const auto count = static_cast<std::size_t>(model.vertex_count);
  std::vector<Index> same(count);
  std::iota(same.begin(), same.end(), 0);
  Sheet sheet(model, same, same);
  VertexMotion motion;
  std::mt19937 random(5);
  std::uniform_real_distribution<double> unit(-1, 1);
  for (std::size_t i = 0; i < count; ++i) {
    Vec3<double> x = model.positions[i], v;
    for (int k = 0; k < 3; ++k) {
      x[k] += 0.01 * unit(random);
      v[k] = unit(random);
    }
    motion.x.push_back(x);
    motion.v.push_back(v);
    motion.t.push_back(0);
    motion.inv_mass.push_back(1 / model.mass[i]);
  }
  Workers workers(1);
  const std::vector<unsigned char> held(static_cast<std::size_t>(model.cloth_triangle_count), 0);
  sheet.kick(1e-3, make_plate(scene, model, held), motion, workers);
  return motion.v;
}

/// 50 triangles: twelve blocks and a rest.
Scene crumpled(double damping) {
  Scene s = asynchronous_scene();
  s.materials[0].damping_stiffness = damping;
  s.cloths.push_back(sheet(5, 0));
  return s;
}

TEST(Sheet, BlocksDoWhatSingleTrianglesDo) {
  for (const double damping : {0.0, 1e-3}) {
    Scene s = crumpled(damping);
    const auto by_four = kicked(s);
    // The same law under another name goes triangle by triangle.
    const Material& m = s.materials[0];
    s.materials[0].orthotropic =
        OrthotropicStretch{m.stretch_stiffness, m.stretch_stiffness, m.poisson_ratio,
                           m.stretch_stiffness / (2 * (1 + m.poisson_ratio))};
    const auto one_by_one = kicked(s);
    ASSERT_EQ(by_four.size(), one_by_one.size());
    for (std::size_t i = 0; i < by_four.size(); ++i)
      EXPECT_LT(length(by_four[i] - one_by_one[i]), 1e-11 * (1 + length(by_four[i]))) << i;
  }
}

TEST(Sheet, DampingTakesEnergyOnly) {
  const auto without = kicked(crumpled(0));
  const auto with = kicked(crumpled(1e-5));
  double change = 0;
  for (std::size_t i = 0; i < with.size(); ++i) change += dot(with[i] - without[i], without[i]);
  EXPECT_LT(change, 0);
}

}  // namespace
}  // namespace weft::test
