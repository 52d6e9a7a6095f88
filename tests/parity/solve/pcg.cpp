#include "weft/kernels/solve/pcg.hpp"
#include "host/exec/host_devices.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Sparse>

#include "tests/parity/solve/solve_rank.hpp"

namespace weft::parity {
namespace {

/// By a sparse factorisation.
std::vector<Vec3<double>> factorised(const SheetSystem& system) {
  const Index size = 3 * system.count;
  std::vector<Eigen::Triplet<double>> entries;
  Eigen::VectorXd b(size);
  const auto fixed = [&](Index v) { return system.fixed[SheetSystem::at(v)] != 0; };
  const auto add = [&](Index row, Index column, int i, int j, double value) {
    if (fixed(row)) return;
    if (fixed(column))
      b[3 * row + i] -= value * prescribed(column)[j];
    else
      entries.emplace_back(3 * row + i, 3 * column + j, value);
  };
  for (Index v = 0; v < system.count; ++v)
    for (int i = 0; i < 3; ++i) {
      b[3 * v + i] = fixed(v) ? prescribed(v)[i] : system.rhs[SheetSystem::at(v)][i];
      if (fixed(v)) entries.emplace_back(3 * v + i, 3 * v + i, 1.0);
    }
  for (Index v = 0; v < system.count; ++v) {
    for (const auto* part : {&system.mesh, &system.contact})
      for (const auto& [column, block] : (*part)[SheetSystem::at(v)])
        for (int i = 0; i < 3; ++i)
          for (int j = 0; j < 3; ++j) add(v, column, i, j, block(i, j));
    for (const auto& [column, value] : system.far[SheetSystem::at(v)])
      for (int i = 0; i < 3; ++i) add(v, column, i, i, value);
  }
  Eigen::SparseMatrix<double> matrix(size, size);
  matrix.setFromTriplets(entries.begin(), entries.end());
  const Eigen::VectorXd x = Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>>(matrix).solve(b);
  std::vector<Vec3<double>> result;
  for (Index v = 0; v < system.count; ++v) result.push_back({x[3 * v], x[3 * v + 1], x[3 * v + 2]});
  return result;
}

/// What a solution leaves of b: in the 2-norm, and in sqrt(r . P r) with P block Jacobi.
struct Left {
  double norm = 0, scaled = 0;
};

Left left_by(const SheetSystem& system, const std::vector<Vec3<double>>& x) {
  Left left;
  for (Index v = 0; v < system.count; ++v) {
    const std::size_t row = SheetSystem::at(v);
    if (system.fixed[row] != 0) continue;
    Vec3<double> r = system.rhs[row];
    Eigen::Matrix3d diagonal = Eigen::Matrix3d::Zero();
    for (const auto* part : {&system.mesh, &system.contact})
      for (const auto& [column, block] : (*part)[row]) {
        r -= block * x[SheetSystem::at(column)];
        if (column != v) continue;
        for (int i = 0; i < 3; ++i)
          for (int j = 0; j < 3; ++j) diagonal(i, j) += block(i, j);
      }
    for (const auto& [column, value] : system.far[row]) r -= value * x[SheetSystem::at(column)];
    const Eigen::Vector3d e(r[0], r[1], r[2]);
    left.norm += e.squaredNorm();
    left.scaled += e.dot(diagonal.ldlt().solve(e));
  }
  return {std::sqrt(left.norm), std::sqrt(left.scaled)};
}

/// Two solutions of one system, each with a residual of `tolerance`, differ by no more than that
/// times the system's condition, which is below a thousand.
template <class T>
class SolvePcgTest : public testing::Test {
 protected:
  static constexpr double solver_tolerance = sizeof(T) == sizeof(float) ? 1e-5 : 1e-11;
  static constexpr double allowed = 100 * solver_tolerance;

  /// Every kind of partial sum and of level; the last tile of 1,024 rows is not full.
  static std::vector<Options> cases() {
    std::vector<Options> all;
    for (const Index partial_rows : {1, 8, 32, 64, 256, 512, 1024, 2048})
      for (const auto preconditioner : {Preconditioner::block_jacobi, Preconditioner::multilevel})
        all.push_back({partial_rows, preconditioner, solver_tolerance});
    return all;
  }
  static std::string describe(const Options& o) {
    return "partial sums of " + std::to_string(o.partial_rows) + " rows, preconditioner " +
           std::to_string(static_cast<int>(o.preconditioner));
  }
  SheetSystem system_{61, 43, 17};
};

using Scalars = testing::Types<float, double>;
TYPED_TEST_SUITE(SolvePcgTest, Scalars);

TYPED_TEST(SolvePcgTest, HostSolvesTheSystem) {
  const std::vector<Vec3<double>> reference = factorised(this->system_);
  for (const Options& options : this->cases()) {
    SCOPED_TRACE(this->describe(options));
    const auto one = solve<TypeParam>(host_devices(1, {.poison = true}), this->system_, options);
    EXPECT_EQ(one.status.converged, 1);
    EXPECT_LE(one.status.residual, options.tolerance);
    expect_close({output("x", one.x)}, {output("x", reference)}, this->allowed);
    for (const int ranks : {3, 5})
      expect_same_bits(
          solve<TypeParam>(host_devices(ranks, {.poison = true}), this->system_, options).outputs(),
          one.outputs());
  }
}

TYPED_TEST(SolvePcgTest, AggregatesSaveIterations) {
  Options options{1024, Preconditioner::block_jacobi, this->solver_tolerance};
  const auto jacobi = solve<TypeParam>(host_devices(1), this->system_, options);
  options.preconditioner = Preconditioner::multilevel;
  const auto multilevel = solve<TypeParam>(host_devices(1), this->system_, options);
  EXPECT_LT(multilevel.status.iterations, jacobi.status.iterations);
}

TYPED_TEST(SolvePcgTest, CudaAgreesWithHost) {
  std::string why;
  const std::optional<DeviceSet> cuda = find_cuda({0}, why);
  if (!cuda) GTEST_SKIP() << why;
  for (const Options& options : this->cases()) {
    SCOPED_TRACE(this->describe(options));
    const auto host = solve<TypeParam>(host_devices(1, {.poison = true}), this->system_, options);
    const auto one = solve<TypeParam>(*cuda, this->system_, options);
    EXPECT_EQ(one.status.converged, 1);
    EXPECT_LE(one.status.residual, options.tolerance);
    EXPECT_NEAR(one.status.iterations, host.status.iterations, 2 + 0.05 * host.status.iterations);
    expect_close({output("x", one.x)}, {output("x", host.x)}, this->allowed);
  }
}

/// Between vertices that move alike nothing acts, however stiff they are joined: with the right
/// guess not even rounding leaves anything to solve for.
TYPED_TEST(SolvePcgTest, TranslationsAreMultipliedByMassAlone) {
  SheetSystem stiff = this->system_;
  stiff.part_contacts();
  stiff.fixed.assign(stiff.fixed.size(), 0);
  stiff.drag.clear();
  // Powers of two, so that their products with masses are not rounded.
  const Vec3<double> way{0.5, -2, 0.25};
  for (Index v = 0; v < stiff.count; ++v) {
    const std::size_t row = SheetSystem::at(v);
    for (auto& [column, block] : stiff.mesh[row]) block = 1e9 * block;
    for (auto& [column, value] : stiff.far[row]) value *= 1e9;
    stiff.rhs[row] = stiff.mass[row] * way;
  }
  Options options{64, Preconditioner::multilevel, this->solver_tolerance};
  options.guess = way;
  const auto expect_nothing_left = [&](const DeviceSet& devices) {
    const auto solution = solve<TypeParam>(devices, stiff, options);
    EXPECT_EQ(solution.status.reference, 0);
    EXPECT_EQ(solution.status.iterations, 0);
  };
  for (const Transport transport : {Transport::peer, Transport::pipelined}) {
    options.transport = transport;
    for (const int ranks : {1, 3}) expect_nothing_left(host_devices(ranks, {.poison = true}));
    std::string why;
    if (const std::optional<DeviceSet> cuda = find_cuda({0}, why)) expect_nothing_left(*cuda);
  }
}

TYPED_TEST(SolvePcgTest, CudaGivesTheSameBitsForAnyNumberOfRanks) {
  for (const Options& options : this->cases()) {
    SCOPED_TRACE(this->describe(options));
    std::optional<Outputs> first;
    for (const std::vector<int>& gpus : gpu_lists()) {
      std::string why;
      const std::optional<DeviceSet> cuda = find_cuda(gpus, why);
      if (!cuda) GTEST_SKIP() << why;
      const auto solution = solve<TypeParam>(*cuda, this->system_, options);
      if (first)
        expect_same_bits(solution.outputs(), *first);
      else
        first = solution.outputs();
    }
  }
}

/// Short enough for compute-sanitizer's racecheck, with every kind of level.
TYPED_TEST(SolvePcgTest, GivesUpAfterTheLastIterationOnBoth) {
  std::string why;
  const std::optional<DeviceSet> cuda = find_cuda({0}, why);
  for (Options options : this->cases()) {
    if (options.partial_rows > 64) continue;
    SCOPED_TRACE(this->describe(options));
    options.max_iterations = 3;
    const auto host = solve<TypeParam>(host_devices(2), this->system_, options);
    EXPECT_EQ(host.status.iterations, 3);
    EXPECT_EQ(host.status.converged, 0);
    EXPECT_GT(host.status.residual, options.tolerance);
    if (!cuda) continue;
    const auto found = solve<TypeParam>(*cuda, this->system_, options);
    EXPECT_EQ(found.status.iterations, 3);
    EXPECT_EQ(found.status.converged, 0);
    EXPECT_NEAR(found.status.residual, host.status.residual, 1e-3 * host.status.residual);
  }
  if (!cuda) GTEST_SKIP() << why;
}

/// In the 2-norm a few stiff rows under load outweigh all others.
template <class T>
void expect_end_by_both_norms(const DeviceSet& devices, SheetSystem system) {
  constexpr double stiffer = 1e3, load = 1e-2, tolerance = 0.01;
  const std::vector<Vec3<double>> random = system.rhs;
  std::vector<Vec3<double>> guess;
  for (Index v = 0; v < system.count; ++v)
    guess.push_back(system.fixed[SheetSystem::at(v)] != 0 ? prescribed(v) : Vec3<double>{});
  for (Index v = 0; v < system.count; ++v)
    for (auto& [column, block] : system.contact[SheetSystem::at(v)]) {
      block = stiffer * block;
      const std::size_t c = SheetSystem::at(column);
      system.rhs[SheetSystem::at(v)] += block * (guess[c] + load * random[c]);
    }
  for (ContactOperatorEntry<double>& link : system.links)
    for (double& component : link.block) component *= stiffer;
  const Left first = left_by(system, guess);
  // A residual in single precision is off by what its row's numbers are rounded to.
  constexpr double off = sizeof(T) == sizeof(float) ? 1.02 : 1 + 1e-9;
  const auto run = [&](const Options& options, const char* what) {
    SCOPED_TRACE(what);
    const auto solution = solve<T>(devices, system, options);
    EXPECT_EQ(solution.status.converged, 1);
    std::vector<Vec3<double>> x;
    for (const Vec3<T>& each : solution.x) x.push_back(vec_cast<double>(each));
    return std::pair{solution.status, left_by(system, x)};
  };
  Options options{64, Preconditioner::block_jacobi, tolerance};
  const auto [both, both_left] = run(options, "both norms");
  EXPECT_NEAR(both.reference, first.norm, 1e-5 * first.norm);
  EXPECT_NEAR(both.scale, first.scaled, (off - 1) * first.scaled);
  EXPECT_LE(both_left.norm, off * tolerance * first.norm);
  EXPECT_LE(both_left.scaled, off * tolerance * first.scaled);

  options.scale_min = 1000 * first.scaled;
  const auto [one, one_left] = run(options, "an earlier solve had a larger scale");
  EXPECT_LE(one_left.norm, off * tolerance * first.norm);
  EXPECT_GT(one_left.scaled, tolerance * first.scaled) << "the 2-norm alone is met long before";
  EXPECT_LT(one.iterations, both.iterations);
  EXPECT_NEAR(one.scale, options.scale_min, 1e-9 * options.scale_min);

  options.scale_min = 0;
  options.left_max = 0.1 * both_left.scaled;
  const auto [further, further_left] = run(options, "no more than so much may be left");
  EXPECT_LE(further_left.scaled, off * options.left_max);
  EXPECT_GT(further.iterations, both.iterations);

  options.max_iterations = (both.iterations + further.iterations) / 2;
  const auto [bounded, bounded_left] = run(options, "as long as there are iterations left");
  EXPECT_EQ(bounded.iterations, options.max_iterations);
  EXPECT_GT(bounded_left.scaled, options.left_max);

  options.gain = 0.3;
  const auto [early, early_left] = run(options, "a share of the first residual is enough");
  EXPECT_LE(early_left.norm, off * options.gain * first.norm);
  EXPECT_LE(early_left.scaled, off * options.gain * first.scaled);
  EXPECT_GT(early_left.scaled, options.left_max);
  EXPECT_LT(early.iterations, both.iterations);

  options.gain = 1e-3;
  options.left_max = 0;
  options.max_iterations = 1000;
  const auto [same, same_left] = run(options, "the tolerance is less to ask for");
  EXPECT_EQ(same.iterations, both.iterations);
}

TYPED_TEST(SolvePcgTest, HostEndsByBothNorms) {
  expect_end_by_both_norms<TypeParam>(host_devices(2), this->system_);
}

TYPED_TEST(SolvePcgTest, CudaEndsByBothNorms) {
  std::string why;
  const std::optional<DeviceSet> cuda = find_cuda({0}, why);
  if (!cuda) GTEST_SKIP() << why;
  expect_end_by_both_norms<TypeParam>(*cuda, this->system_);
}

TYPED_TEST(SolvePcgTest, PausesChangeNoBits) {
  for (const auto preconditioner : {Preconditioner::block_jacobi, Preconditioner::multilevel}) {
    SCOPED_TRACE(static_cast<int>(preconditioner));
    const auto expect_same = [&](const DeviceSet& devices) {
      Options options{64, preconditioner, this->solver_tolerance};
      const auto whole = solve<TypeParam>(devices, this->system_, options);
      options.pause = 0.03;
      for (const Transport transport : {Transport::peer, Transport::pipelined}) {
        options.transport = transport;
        const auto resumed = solve<TypeParam>(devices, this->system_, options);
        EXPECT_GT(resumed.paused_iterations, 0);
        EXPECT_LT(resumed.paused_iterations, resumed.status.iterations);
        expect_same_bits(resumed.outputs(), whole.outputs());
      }
    };
    for (const int ranks : {1, 3}) expect_same(host_devices(ranks, {.poison = true}));
    for (const std::vector<int>& gpus : gpu_lists()) {
      std::string why;
      if (const std::optional<DeviceSet> cuda = find_cuda(gpus, why)) expect_same(*cuda);
    }
  }
}

TYPED_TEST(SolvePcgTest, PausesAtTheToleranceIfMoreIsAskedFor) {
  const auto expect_pause = [&](const DeviceSet& devices) {
    Options options{64, Preconditioner::block_jacobi, 1e-2};
    const auto to_tolerance = solve<TypeParam>(devices, this->system_, options);
    const double scale = to_tolerance.status.scale;
    options.left_max = 1e-3 * scale;
    const auto nearer = solve<TypeParam>(devices, this->system_, options);
    options.left_max = 1e-4 * scale;
    const auto whole = solve<TypeParam>(devices, this->system_, options);
    EXPECT_GT(nearer.status.iterations, to_tolerance.status.iterations);
    EXPECT_GT(whole.status.iterations, nearer.status.iterations);
    for (const Transport transport : {Transport::peer, Transport::pipelined}) {
      options.transport = transport;
      options.pause_left = scale;
      const auto at_tolerance = solve<TypeParam>(devices, this->system_, options);
      EXPECT_EQ(at_tolerance.paused_iterations, to_tolerance.status.iterations);
      expect_same_bits(at_tolerance.outputs(), whole.outputs());
      options.pause_left = 1e-3 * scale;
      const auto later = solve<TypeParam>(devices, this->system_, options);
      EXPECT_EQ(later.paused_iterations, nearer.status.iterations);
      expect_same_bits(later.outputs(), whole.outputs());
    }
  };
  for (const int ranks : {1, 3}) expect_pause(host_devices(ranks, {.poison = true}));
  for (const std::vector<int>& gpus : gpu_lists()) {
    std::string why;
    if (const std::optional<DeviceSet> cuda = find_cuda(gpus, why)) expect_pause(*cuda);
  }
}

TYPED_TEST(SolvePcgTest, NotANumberEndsTheSolveOnBoth) {
  this->system_.rhs[100][1] = std::nan("");
  this->system_.fixed[100] = 0;
  const Options options{64, Preconditioner::multilevel, this->solver_tolerance};
  EXPECT_EQ(solve<TypeParam>(host_devices(2), this->system_, options).status.finite, 0);
  std::string why;
  const std::optional<DeviceSet> cuda = find_cuda({0}, why);
  if (!cuda) GTEST_SKIP() << why;
  EXPECT_EQ(solve<TypeParam>(*cuda, this->system_, options).status.finite, 0);
}

}  // namespace
}  // namespace weft::parity
