#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <functional>
#include <map>
#include <utility>

#include "host/model/model.hpp"
#include "tests/support/small_scenes.hpp"
#include "weft/simulation.hpp"

// One linearly implicit step of a stretched sheet against a dense system whose energy is written
// down here once more and differentiated numerically: no code of the elements is shared.

namespace weft {
namespace {

using Real = long double;
using Point = Eigen::Matrix<Real, 3, 1>;
using Vector = Eigen::Matrix<Real, Eigen::Dynamic, 1>;
using Matrix = Eigen::Matrix<Real, Eigen::Dynamic, Eigen::Dynamic>;

class Oracle {
 public:
  explicit Oracle(const Scene& scene)
      : mesh_(scene.cloths[0].mesh),
        material_(scene.materials[0]),
        plate_(scene.bending == Bending::plate) {
    mass_.setZero(static_cast<Eigen::Index>(mesh_.positions.size()));
    std::map<std::pair<Index, Index>, std::pair<std::size_t, Index>> open;
    for (std::size_t t = 0; t < mesh_.triangles.size(); ++t)
      for (int j = 0; j < 3; ++j) {
        const Index* v = mesh_.triangles[t].v;
        mass_[v[j]] += material_.density * rest_area(t) / 3;
        const auto key = std::minmax(v[j], v[(j + 1) % 3]);
        const auto [place, first] = open.try_emplace(key, t, v[(j + 2) % 3]);
        if (!first)
          wings_.push_back({key.first, key.second, place->second.second, v[(j + 2) % 3],
                            place->second.first, t});
      }
  }

  Real rest_area(std::size_t t) const { return rest(t).determinant() / 2; }

  /// Energy of all triangles and hinges at the 3 n coordinates x.
  Real energy(const Vector& x) const {
    Real sum = 0;
    const Real nu = material_.poisson_ratio;
    const Real k = material_.stretch_stiffness;
    for (std::size_t t = 0; t < mesh_.triangles.size(); ++t) {
      const Index* v = mesh_.triangles[t].v;
      Eigen::Matrix<Real, 3, 2> d;
      d << at(x, v[1]) - at(x, v[0]), at(x, v[2]) - at(x, v[0]);
      const Eigen::Matrix<Real, 3, 2> f = d * rest(t).inverse();
      const Eigen::Matrix<Real, 2, 2> g =
          (f.transpose() * f - Eigen::Matrix<Real, 2, 2>::Identity()) / 2;
      // Plane stress: E h / (2 (1 - nu^2)) ((1 - nu) |G|^2 + nu tr^2).
      sum += rest_area(t) * k / (2 * (1 - nu * nu)) *
             ((1 - nu) * g.squaredNorm() + nu * g.trace() * g.trace());
    }
    for (const Wing& w : wings_) {
      if (plate_) break;
      const Point e = at(x, w.b) - at(x, w.a);
      const Point n1 = e.cross(at(x, w.c) - at(x, w.a)).normalized();
      const Point n2 = (at(x, w.d) - at(x, w.a)).cross(e).normalized();
      const Real angle = std::atan2(n1.cross(n2).norm(), n1.dot(n2));
      const Real edge_sq = (material_point(w.b) - material_point(w.a)).squaredNorm();
      sum += material_.bending_stiffness / 2 * edge_sq / (rest_area(w.t1) + rest_area(w.t2)) *
             angle * angle;
    }
    return sum;
  }

  const Vector& mass() const { return mass_; }

 private:
  struct Wing {
    Index a, b, c, d;
    std::size_t t1, t2;
  };
  static Point at(const Vector& x, Index v) { return x.segment<3>(3 * v); }
  Eigen::Matrix<Real, 2, 1> material_point(Index v) const {
    const auto& m = mesh_.material[static_cast<std::size_t>(v)];
    return {m[0], m[1]};
  }
  Eigen::Matrix<Real, 2, 2> rest(std::size_t t) const {
    const Index* v = mesh_.triangles[t].v;
    Eigen::Matrix<Real, 2, 2> m;
    m << material_point(v[1]) - material_point(v[0]), material_point(v[2]) - material_point(v[0]);
    return m;
  }

  const Mesh& mesh_;
  const Material& material_;
  bool plate_;  ///< bending is not among the energies
  Vector mass_;
  std::vector<Wing> wings_;
};

/// The plate's matrix for all coordinates, which tests of its own compare with closed forms.
struct PlateOracle {
  Matrix stiffness;

  explicit PlateOracle(const Scene& scene) {
    const Model model = make_model(scene);
    const PlateMatrix plate =
        make_plate(scene, model, std::vector<unsigned char>(model.area.size(), 0));
    const auto n = static_cast<Eigen::Index>(scene.cloths[0].mesh.positions.size());
    stiffness = Matrix::Zero(3 * n, 3 * n);
    for (std::size_t i = 0; i + 1 < plate.row_offset.size(); ++i)
      for (auto e = static_cast<std::size_t>(plate.row_offset[i]);
           e < static_cast<std::size_t>(plate.row_offset[i + 1]); ++e)
        for (Eigen::Index c = 0; c < 3; ++c)
          stiffness(3 * model.to_input[i] + c,
                    3 * model.to_input[static_cast<std::size_t>(plate.column[e])] + c) =
              plate.stiffness[e];
  }
};

/// Central differences of a scalar function.
Vector gradient(const std::function<Real(const Vector&)>& f, Vector x, Real step) {
  Vector g(x.size());
  for (Eigen::Index i = 0; i < x.size(); ++i) {
    const Real middle = x[i];
    x[i] = middle + step;
    const Real up = f(x);
    x[i] = middle - step;
    g[i] = (up - f(x)) / (2 * step);
    x[i] = middle;
  }
  return g;
}

Matrix hessian(const std::function<Real(const Vector&)>& f, Vector x, Real step) {
  Matrix h(x.size(), x.size());
  for (Eigen::Index i = 0; i < x.size(); ++i) {
    const Real middle = x[i];
    x[i] = middle + step;
    const Vector up = gradient(f, x, step);
    x[i] = middle - step;
    h.col(i) = (up - gradient(f, x, step)) / (2 * step);
    x[i] = middle;
  }
  return h;
}

class ImplicitStepOracle : public testing::TestWithParam<Bending> {};

TEST_P(ImplicitStepOracle, OneStepOfAStretchedSheet) {
  Scene s;
  s.precision = Precision::double_precision;
  s.materials.push_back(test::cotton());
  s.cloths.push_back(test::sheet(3, 0));
  s.cloths[0].velocity = {0.1, 0.2, -0.3};
  s.materials[0].bending_stiffness = 1e-3;
  s.contact.self = false;
  s.bending = GetParam();
  s.solver.tolerance = 1e-12;
  Mesh& mesh = s.cloths[0].mesh;
  // Stretched both ways everywhere and flat: there the projected Jacobian is the exact one.
  for (auto& p : mesh.positions) p = {p[0] * (1.05 + 0.1 * p[1]), p[1] * (1.04 + 0.1 * p[0]), p[2]};
  const Oracle oracle(s);
  const PlateOracle plate(s);
  const auto n = static_cast<Eigen::Index>(mesh.positions.size());
  Vector x(3 * n);
  Vector v(3 * n);
  Vector weight(3 * n);
  Matrix mass = Matrix::Zero(3 * n, 3 * n);
  for (Eigen::Index i = 0; i < n; ++i)
    for (Eigen::Index c = 0; c < 3; ++c) {
      x[3 * i + c] = mesh.positions[static_cast<std::size_t>(i)][static_cast<int>(c)];
      v[3 * i + c] = s.cloths[0].velocity[static_cast<int>(c)];
      weight[3 * i + c] = oracle.mass()[i] * s.gravity[static_cast<int>(c)];
      mass(3 * i + c, 3 * i + c) = oracle.mass()[i];
    }
  const auto energy = [&](const Vector& y) { return oracle.energy(y); };
  Simulation simulation(s, host_devices(2));
  const Real h = simulation.step_length();
  const Real b = s.materials[0].damping_stiffness;
  const Matrix k = hessian(energy, x, 1e-5L) + plate.stiffness;
  const Vector force = weight - gradient(energy, x, 1e-5L) - plate.stiffness * x;
  const Vector expected = (mass + h * (h + b) * k).ldlt().solve(mass * v + h * force);

  ASSERT_EQ(Failure::none, simulation.step().failure);
  const Frame frame = simulation.frame();
  const Real scale = expected.cwiseAbs().maxCoeff();
  for (Eigen::Index i = 0; i < n; ++i)
    for (int c = 0; c < 3; ++c)
      EXPECT_NEAR(static_cast<double>(expected[3 * i + c]),
                  frame.cloth_velocities[0][static_cast<std::size_t>(i)][c],
                  static_cast<double>(1e-7L * scale));
}

INSTANTIATE_TEST_SUITE_P(Bending, ImplicitStepOracle,
                         testing::Values(Bending::hinge, Bending::plate));

/// A sheet pushed together to two thirds, creased so that it knows which way to give, and a long
/// step: far from where a linearisation holds.
Scene crumpled_sheet() {
  Scene s;
  s.precision = Precision::double_precision;
  s.materials.push_back(test::cotton());
  s.materials[0].damping_stiffness = 0;
  s.cloths.push_back(test::sheet(3, 0));
  s.contact.self = false;
  s.bending = Bending::hinge;
  s.time.step = 0.02;
  s.solver.tolerance = 1e-6;
  s.solver.newton_iterations = 200;
  s.solver.newton_tolerance = 1e-11;
  for (auto& p : s.cloths[0].mesh.positions)
    p = {0.7 * p[0], 0.65 * p[1], 0.02 * std::sin(13 * p[0] + 5 * p[1])};
  return s;
}

TEST(NewtonOracle, NewtonMeetsBackwardEuler) {
  const Scene s = crumpled_sheet();
  const Mesh& mesh = s.cloths[0].mesh;
  const Oracle oracle(s);
  Simulation simulation(s, host_devices(2));
  const StepReport report = simulation.step();
  ASSERT_EQ(Failure::none, report.failure) << report.failure_detail;
  EXPECT_LE(report.newton_residual, s.solver.newton_tolerance);
  EXPECT_GT(report.newton_iterations, 2);

  // M (x - x0 - h v0 - h^2 g) / h^2 = -dE/dx, term by term at where the step ended.
  const Real h = simulation.step_length();
  const Frame frame = simulation.frame();
  const auto n = static_cast<Eigen::Index>(mesh.positions.size());
  Vector x(3 * n);
  Vector inertia(3 * n);
  for (Eigen::Index i = 0; i < n; ++i)
    for (int c = 0; c < 3; ++c) {
      const auto v = static_cast<std::size_t>(i);
      x[3 * i + c] = frame.cloth_positions[0][v][c];
      inertia[3 * i + c] =
          oracle.mass()[i] * ((x[3 * i + c] - mesh.positions[v][c]) / (h * h) - Real(s.gravity[c]));
    }
  const Vector forces = -gradient([&](const Vector& y) { return oracle.energy(y); }, x, 1e-6L);
  EXPECT_LT(static_cast<double>((inertia - forces).norm()),
            1e-7 * static_cast<double>(forces.norm()));
}

/// A stretched and creased sheet that springs back within one long step, past its rest shape: full
/// steps overshoot.
TEST(NewtonOracle, LineSearchShortensStepsAndEndsAtTheSameSolution) {
  Scene s = crumpled_sheet();
  s.cloths[0].mesh = test::sheet(6, 0).mesh;
  for (auto& p : s.cloths[0].mesh.positions)
    p = {1.3 * p[0], 1.3 * p[1], 0.02 * std::sin(13 * p[0] + 5 * p[1])};
  s.time.step = 0.5;
  s.time.frame_rate = 2;
  Simulation searching(s, host_devices(1));
  const StepReport with = searching.step();
  s.solver.line_search = false;
  Simulation straight(s, host_devices(1));
  const StepReport without = straight.step();
  EXPECT_GT(with.line_steps, 0);
  EXPECT_EQ(0, without.line_steps);
  EXPECT_LE(with.newton_residual, s.solver.newton_tolerance);
  EXPECT_LE(without.newton_residual, s.solver.newton_tolerance);
  const auto x = searching.frame().cloth_positions[0];
  const auto y = straight.frame().cloth_positions[0];
  for (std::size_t v = 0; v < x.size(); ++v) EXPECT_LT(length(x[v] - y[v]), 1e-8) << v;
}

}  // namespace
}  // namespace weft
