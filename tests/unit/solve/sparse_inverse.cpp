#include "weft/state/sparse_inverse.hpp"

#include <gtest/gtest.h>

#include "benchmarks/support/grid_system.hpp"
#include "host/implicit/linear/preconditioners/sparse_inverse_buffers.hpp"

namespace weft {
namespace {

TEST(SparseInverseEntry, KeepsABlockToEightBits) {
  Mat3<double> block{};
  for (int k = 0; k < 9; ++k) block.e[k] = (k - 4) * 0.37e-3 * (k % 2 == 0 ? 1 : -1);
  const SparseInverseEntry entry = sparse_inverse_entry(17, block);
  EXPECT_EQ(entry.column, 17);
  for (int i = 0; i < 3; ++i) {
    Vec3<double> unit{}, product{};
    unit[i] = 1;
    add_entry(entry, unit, product);
    for (int k = 0; k < 3; ++k) EXPECT_NEAR(product[k], block(k, i), 4 * 0.37e-3 / 240);
  }
}

TEST(SparseInverseEntry, OfNothingIsNothing) {
  Vec3<float> product{};
  add_entry(sparse_inverse_entry(3, Mat3<float>{}), {1, 2, 3}, product);
  for (int k = 0; k < 3; ++k) EXPECT_EQ(product[k], 0);
}

TEST(FactorPattern, TakesTheNearestRowsBefore) {
  // A line of 12 rows, each joined to its neighbours.
  std::vector<std::vector<Index>> neighbours(12);
  std::vector<Vec2<double>> points;
  for (Index i = 0; i < 12; ++i) {
    if (i > 0) neighbours[static_cast<std::size_t>(i)].push_back(i - 1);
    if (i < 11) neighbours[static_cast<std::size_t>(i)].push_back(i + 1);
    points.push_back({double(i), 0});
  }
  const auto pattern = sparse_inverse_pattern(neighbours, points, 12);
  EXPECT_TRUE(pattern[0].empty());
  EXPECT_EQ(pattern[1], (std::vector<Index>{0}));
  EXPECT_EQ(pattern[7], (std::vector<Index>{5, 6}));
  const auto divided = sparse_inverse_pattern(neighbours, points, 6);
  EXPECT_EQ(divided[5], pattern[5]);
  EXPECT_TRUE(divided[6].empty());
  EXPECT_EQ(divided[7], (std::vector<Index>{6}));
}

SolveStatus solve_sheet(Index cells, Preconditioner preconditioner, bool folded) {
  Scene scene = wavy_sheet(cells);
  scene.solver.preconditioner = preconditioner;
  scene.solver.tolerance = 1e-3;
  scene.solver.partial_rows = 1024;  // as of a large cloth
  FirstSystem<float> system(scene, host_devices(1, {.poison = true}), folded);
  system.assemble();
  system.solve();
  system.sync();
  EXPECT_EQ(system.status().converged, 1);
  return system.status();
}

TEST(SparseInverse, SavesIterations) {
  for (const bool folded : {false, true}) {
    const int with = solve_sheet(60, Preconditioner::sparse_inverse, folded).iterations;
    EXPECT_LT(with, 0.8 * solve_sheet(60, Preconditioner::multilevel, folded).iterations);
  }
}

}  // namespace
}  // namespace weft
