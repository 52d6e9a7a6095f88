#include "weft/state/coarse_basis.hpp"

#include <gtest/gtest.h>

#include <Eigen/Dense>

#include "benchmarks/support/grid_system.hpp"
#include "host/solve/coarse_correction.hpp"
#include "tests/parity/solve/coarse_basis.hpp"

namespace weft {

namespace parity {
GTEST_ALLOW_UNINSTANTIATED_PARAMETERIZED_TEST(KernelParity);  // only its systems are of use here
}

namespace {

using parity::SheetSystem;

/// The levels' part of the preconditioner as a dense matrix, column by column.
template <Index partial_rows>
Eigen::MatrixXd dense(const parity::CoarseBasisSystem<double, partial_rows>& of) {
  const DeviceSet devices = host_devices(1, {.poison = true});
  CoarseBasisBuffers<double> modes;
  modes.make(devices[0], of.table, 0, of.system.count);
  parity::galerkin_product_rows(devices[0], of, modes, 0, of.system.count);
  modes.launch_coarse_inverse(devices[0].compute());
  devices[0].compute().sync();
  const CoarseBasisLevels<double> view = modes.view();
  CoarseCorrection<double> moves(view, 0, of.system.count);
  const auto rows = static_cast<std::size_t>(of.system.count);
  const auto partials = static_cast<std::size_t>(view.upper[0].aggregates);
  std::vector<unsigned char> fixed = of.system.fixed;
  Eigen::MatrixXd matrix(3 * of.system.count, 3 * of.system.count);
  for (Index k = 0; k < matrix.cols(); ++k) {
    std::vector<Vec3<double>> r(rows), u(rows);
    // Residuals of fixed rows are zero.
    if (fixed[static_cast<std::size_t>(k / 3)] == 0) r[static_cast<std::size_t>(k / 3)][k % 3] = 1;
    moves.sum(r, 0);
    moves.take(view, 0, 0, partials);
    moves.restart();
    moves.correct(r, fixed, u);
    for (Index i = 0; i < matrix.rows(); ++i)
      matrix(i, k) = u[static_cast<std::size_t>(i / 3)][i % 3];
  }
  return matrix;
}

/// @param allowed asymmetry, as a share of the norm
template <Index partial_rows>
void expect_positive(const parity::CoarseBasisSystem<double, partial_rows>& of,
                     double allowed = 1e-12) {
  const Eigen::MatrixXd matrix = dense(of);
  const double size = matrix.norm();
  EXPECT_LT((matrix - matrix.transpose()).norm(), allowed * size);
  // Block Jacobi, which is positive definite, comes on top of this.
  const Eigen::VectorXd values =
      Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(matrix).eigenvalues();
  EXPECT_GT(values.minCoeff(), -1e-12 * size);
  EXPECT_GT(values.maxCoeff(), 0.01 * size);
}

/// Contacts, fixed vertices and units without any free one included.
TEST(CoarseBasisLevels, ArePositiveWithoutAFineLevel) {
  expect_positive(parity::CoarseBasisSystem<double, 8>(14, 12, 5));
}
TEST(CoarseBasisLevels, ArePositiveWithAFineLevel) {
  expect_positive(parity::CoarseBasisSystem<double, 128>(20, 16, 5));
}

/// Where all vertices are at one place, or in a line, modes are not independent: what rounding
/// makes of sums that should vanish is divided by coarse_shift.
TEST(CoarseBasisLevels, ArePositiveWhereModesDependOnEachOther) {
  parity::CoarseBasisSystem<double, 128> point(19, 17, 5), line(19, 17, 5);
  std::vector<Vec2<double>> places(static_cast<std::size_t>(point.system.count));
  point.table = make_coarse_basis_table(places, 128);
  for (std::size_t v = 0; v < places.size(); ++v) places[v] = {double(v % 7), 2.0 * double(v % 7)};
  line.table = make_coarse_basis_table(places, 128);
  expect_positive(point, 2e-16 / coarse_shift);
  expect_positive(line, 2e-16 / coarse_shift);
}

SolveStatus solve_sheet(Index cells, Preconditioner preconditioner, bool folded = false) {
  Scene scene = wavy_sheet(cells);
  scene.solver.preconditioner = preconditioner;
  scene.solver.tolerance = 1e-3;
  FirstSystem<float> system(scene, host_devices(2, {.poison = true}), folded);
  system.assemble();
  system.solve();
  system.sync();
  EXPECT_EQ(system.status().converged, 1);
  return system.status();
}

/// At twice the resolution, block Jacobi takes about twice the iterations. What is saved grows with
/// the sheet: fine ones are in weft_bench_pcg.
TEST(CoarseBasisLevels, HoldIterationsAsResolutionGrows) {
  const auto linear = Preconditioner::multilevel_linear;
  const int coarse = solve_sheet(80, linear).iterations;
  const int fine = solve_sheet(160, linear).iterations;
  EXPECT_LT(fine, 1.5 * coarse);
  EXPECT_LT(fine, solve_sheet(160, Preconditioner::multilevel).iterations);
  EXPECT_LT(fine, 0.4 * solve_sheet(160, Preconditioner::block_jacobi).iterations);
}

TEST(CoarseBasisLevels, SaveIterationsWithContactsToo) {
  const int with = solve_sheet(60, Preconditioner::multilevel_linear, true).iterations;
  EXPECT_LT(with, solve_sheet(60, Preconditioner::multilevel, true).iterations);
}

}  // namespace
}  // namespace weft
