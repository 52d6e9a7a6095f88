#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "host/model/material_rows.hpp"
#include "host/scene/fabric/measured.hpp"
#include "tests/unit/elements/sheets.hpp"
#include "weft/kernels/assemble/bending.hpp"
#include "weft/kernels/assemble/membrane.hpp"
#include "weft/kernels/assemble/wind.hpp"

// What kernels put into the linear system, against differences of energies and of each other:
// impulses are -h times a gradient, blocks are h (h + b) times a Hessian, or its semi-definite
// part, and damping acts by b times that.

namespace weft {
namespace {

using test::Deformation;
using test::Long;
using test::Random;
using test::RestTriangle;
using Matrix9 = test::Matrix9;

constexpr double h = 0.01, b = 0.004;
const Tri corners{{0, 1, 2}};

// ------------------------------------------------------------------------------------ membrane
struct NamedMaterial {
  const char* name;
  Material material;
  double stiffness;  ///< [N/m] the largest
  bool has_energy = true;
};

std::vector<NamedMaterial> materials() {
  Material isotropic;
  isotropic.stretch_stiffness = 500;
  isotropic.poisson_ratio = 0.3;
  Material orthotropic = isotropic;
  orthotropic.orthotropic = OrthotropicStretch{800, 200, 0.3, 40};
  MeasuredStretch tables;
  tables.rows = {{{80, 10, 60, 40},
                  {150, 30, 90, 60},
                  {120, 20, 110, 70},
                  {100, 40, 130, 80},
                  {90, 10, 150, 50},
                  {70, 20, 180, 40}}};
  Material fitted = isotropic, samples = isotropic;
  fitted.measured = tables;
  samples.measured = tables;
  samples.measured->form = MeasuredStretch::Form::arcsim;
  std::vector<NamedMaterial> all = {{"isotropic", isotropic, 600},
                                    {"orthotropic", orthotropic, 900},
                                    {"fitted", fitted, 1000},
                                    {"samples", samples, 1000, false}};
  // A band stiffens to 16 times its stiffness, which is 20 times the threads'.
  for (std::size_t n = 0; n < 4; ++n) {
    all.push_back(all[n]);
    all.back().material.strain_limits = StrainLimits{0.9, 1.1};
    all.back().stiffness *= 320;
  }
  for (auto& m : all) m.material.damping_stiffness = b;
  return all;
}

/// A material as the kernel takes it, in any precision.
template <class T>
struct KernelMaterial {
  MaterialRow<T> row;
  std::vector<T> table;

  explicit KernelMaterial(const Material& material) {
    const std::vector<std::vector<double>> tables{stretch_table(material)};
    const MaterialRows<double> all = material_rows<double>({material}, tables);
    const MaterialRow<double>& from = all.rows[0];
    const auto cast = [](double value) { return static_cast<T>(value); };
    const auto band = [&](const LimitBand<double>& l) {
      return LimitBand<T>{cast(l.width), cast(l.width_inv), cast(l.stiffness)};
    };
    const auto& o = from.orthotropic;
    row = {{cast(from.membrane.lambda), cast(from.membrane.mu)},
           cast(from.damping_stiffness),
           from.kind,
           {cast(o.c11), cast(o.c12), cast(o.c22), cast(o.c33)},
           from.table,
           {band(from.limits.low), band(from.limits.high), cast(from.limits.near)}};
    table.assign(all.tables.begin(), all.tables.end());
  }
};

/// The energy by the elements' own functions.
Long energy_of(const KernelMaterial<Long>& m, const RestTriangle& s, const Vec3<Long> (&x)[3]) {
  const Mat2<Long> rest = test::fine_rest(s);
  const auto area = static_cast<Long>(s.area);
  if (m.row.kind == MembraneKind::isotropic) return membrane_energy(x, rest, area, m.row.membrane);
  const Long law = m.row.kind == MembraneKind::orthotropic
                       ? membrane_law_energy(x, rest, area, m.row.orthotropic)
                       : membrane_law_energy(x, rest, area, MembraneRidges<Long>{m.table.data()});
  return law + (m.row.limits.any() ? membrane_law_energy(x, rest, area, m.row.limits) : 0);
}

template <class T>
struct MembraneTerms {
  Vec3<T> impulse[3];
  Mat3<T> block[6];
};

template <class T>
MembraneTerms<T> membrane_terms(const KernelMaterial<T>& m, const RestTriangle& s,
                                const Vec3<T> (&x)[3], Span<const Vec3<T>> velocities) {
  MembraneTerms<T> terms;
  Mat2<T> rest;
  for (int k = 0; k < 4; ++k) rest.e[k] = static_cast<T>(s.inv_rest.e[k]);
  const T area = static_cast<T>(s.area);
  const Index material = 0;
  const AssembleMembrane<T> a{{&corners, 1},      {&rest, 1},       {&area, 1}, {&material, 1},
                              {&m.row, 1},        {x, 3},           velocities, static_cast<T>(h),
                              {terms.impulse, 3}, {terms.block, 6}, m.table};
  assemble_membrane(a, 0);
  return terms;
}

template <class Visit>
void each_membrane(const Visit& visit) {
  Random random(41);
  for (const NamedMaterial& m : materials()) {
    const KernelMaterial<double> coarse(m.material);
    const KernelMaterial<Long> fine(m.material);
    test::each_triangle(random, [&](const RestTriangle& s) {
      SCOPED_TRACE(m.name);
      visit(m, coarse, fine, s);
    });
  }
}

// Third derivatives jump at knots and at the ends of bands: short steps.
constexpr Long step = 1e-8;

TEST(MembraneKernel, ImpulseIsTheGradientOfTheEnergy) {
  each_membrane(
      [](const NamedMaterial& m, const auto& coarse, const auto& fine, const RestTriangle& s) {
        if (!m.has_energy) return;
        const MembraneTerms<double> terms = membrane_terms<double>(coarse, s, s.x, {});
        Vec3<double> g[3];
        test::difference_gradient([&](const Vec3<Long>(&x)[3]) { return energy_of(fine, s, x); },
                                  s.x, step, g);
        for (auto& v : g) v *= -h;
        EXPECT_LE(test::largest_difference(terms.impulse, g),
                  1e-8 * h * m.stiffness * test::stiffness_scale(s));
      });
}

TEST(MembraneKernel, BlocksAreThoseOfTheImpulseOrStifferAndSemidefinite) {
  int equal = 0, stiffer = 0;
  each_membrane(
      [&](const NamedMaterial& m, const auto& coarse, const auto& fine, const RestTriangle& s) {
        const Matrix9 block = test::matrix_of(membrane_terms<double>(coarse, s, s.x, {}).block);
        const double scale = h * (h + b) * m.stiffness * test::stiffness_scale(s);
        EXPECT_EQ((block - block.transpose()).cwiseAbs().maxCoeff(), 0);
        EXPECT_GE(test::least_eigenvalue(block), -1e-12 * scale);
        if (!m.has_energy) return;  // its tangent is that of frozen coefficients
        const auto impulse = [&](const Vec3<Long>(&x)[3], Vec3<Long>(&g)[3]) {
          const auto terms = membrane_terms<Long>(fine, s, x, {});
          std::copy(terms.impulse, terms.impulse + 3, g);
        };
        Mat3<double> slope[3][3];
        test::difference_hessian(impulse, s.x, step, slope);
        Matrix9 exact;
        for (int r = 0; r < 9; ++r)
          for (int c = 0; c < 9; ++c) exact(r, c) = -(h + b) * slope[r / 3][c / 3](r % 3, c % 3);
        const Matrix9 more = block - exact;
        EXPECT_GE(test::least_eigenvalue((more + more.transpose()) / 2), -1e-6 * scale);
        ++(more.cwiseAbs().maxCoeff() < 1e-6 * scale ? equal : stiffer);
      });
  EXPECT_GT(equal, 100);
  EXPECT_GT(stiffer, 1000);
}

TEST(MembraneKernel, DampingIsTheBlockTimesTheVelocitiesAndTakesEnergy) {
  Random random(42);
  each_membrane(
      [&](const NamedMaterial& m, const auto& coarse, const auto&, const RestTriangle& s) {
        const std::vector<Vec3<double>> v{random.point(), random.point(), random.point()};
        const auto still = membrane_terms<double>(coarse, s, s.x, {});
        const auto moving = membrane_terms<double>(coarse, s, s.x, v);
        const Matrix9 block = test::matrix_of(moving.block);
        EXPECT_EQ(block, test::matrix_of(still.block));
        Eigen::Matrix<double, 9, 1> velocity, damping;
        for (int k = 0; k < 9; ++k) {
          velocity[k] = v[static_cast<std::size_t>(k / 3)][k % 3];
          damping[k] = moving.impulse[k / 3][k % 3] - still.impulse[k / 3][k % 3];
        }
        const double scale = h * b * m.stiffness * test::stiffness_scale(s);
        EXPECT_LE((damping + b / (h + b) * block * velocity).cwiseAbs().maxCoeff(), 1e-12 * scale);
        EXPECT_LE(velocity.dot(damping), 1e-12 * scale);
      });
}

// ------------------------------------------------------------------------------------ hinges
struct Fold {
  const char* name;
  Vec3<double> x[4];
};

std::vector<Fold> folds() {
  std::vector<Fold> all;
  Random random(43);
  for (int n = 0; n < 20; ++n) {
    Fold f{"random", {random.point(), random.point(), random.point(), random.point()}};
    if (length(f.x[1] - f.x[0]) > 0.3) all.push_back(f);
  }
  all.push_back({"flat", {{0, 0, 0}, {1, 0, 0}, {0.3, 1, 0}, {0.6, -1, 0}}});
  all.push_back({"nearly shut", {{0, 0, 0}, {1, 0, 0}, {0.3, 1, 0}, {0.6, 1, 1e-3}}});
  all.push_back({"the other way", {{0, 0, 0}, {1, 0, 0}, {0.3, 1, 0}, {0.6, 1, -1e-3}}});
  all.push_back({"a sliver", {{0, 0, 0}, {1, 0, 0}, {0.3, 1e-3, 0}, {0.6, -0.5, 0.5}}});
  all.push_back({"a line", {{0, 0, 0}, {1, 0, 0}, {0.3, 0, 0}, {0.6, -0.5, 0.5}}});
  all.push_back({"an edge of no length", {{0, 0, 0}, {0, 0, 0}, {0.3, 1, 0}, {0.6, -0.5, 0.5}}});
  return all;
}

TEST(BendingKernel, ImpulseIsTheGradientOfTheEnergyAndDampingFollowsTheCurvature) {
  const Hinge hinge{{0, 1, 2, 3}};
  const double c = 3e-3, rest = 0.4;
  Random random(44);
  for (const Fold& f : folds())
    for (const bool moving : {false, true}) {
      SCOPED_TRACE(f.name);
      std::vector<Vec3<double>> v;
      for (int k = 0; moving && k < 4; ++k) v.push_back(random.point());
      Vec3<double> direction[4];
      double scale = 0, curvature = 0;
      AssembleBending<double>{
          {&hinge, 1}, {&c, 1}, {&rest, 1},     {&b, 1},     {f.x, 4},
          v,           h,       {direction, 4}, {&scale, 1}, {&curvature, 1}}(0);
      EXPECT_DOUBLE_EQ(curvature, 2 * c * h * (h + b));
      const auto energy = [&](const Vec3<Long>(&x)[4]) {
        return hinge_energy<Long>(x, static_cast<Long>(rest), static_cast<Long>(c));
      };
      Vec3<double> g[4], impulse[4];
      // Where a triangle has no area there is no energy, and none beside it that is near.
      test::difference_gradient(energy, f.x, 1e-7L, g);
      double rate = 0;
      for (std::size_t k = 0; moving && k < 4; ++k) rate += dot(direction[k], v[k]);
      const bool empty = length(direction[2]) == 0;
      for (int k = 0; k < 4; ++k) {
        impulse[k] = scale * direction[k];
        // block times velocity, by b / (h + b)
        g[k] = empty ? Vec3<double>{} : -h * g[k] - (b / (h + b) * curvature * rate) * direction[k];
      }
      EXPECT_LE(test::largest_difference(impulse, g), 1e-9 * c * (1 + test::largest(direction)));
    }
}

// ------------------------------------------------------------------------------------ wind
struct WindTerms {
  Vec3<double> impulse[3];
  Mat3<double> block[6];
  Mat3<double> corner_drag;
};

constexpr double air = 1.2, drag = 0.3;
const Vec3<double> wind{3, -1, 0.5};

WindTerms wind_terms(const Vec3<double> (&x)[3], const std::vector<Vec3<double>>& start,
                     const std::vector<Vec3<double>>& velocities) {
  WindTerms t{};
  AssembleWind<double>{{&corners, 1},
                       {x, 3},
                       start,
                       velocities,
                       air,
                       drag,
                       wind,
                       h,
                       {t.impulse, 3},
                       {t.block, 6},
                       {&t.corner_drag, 1}}(0);
  return t;
}

/// Its impulse is -h times the derivative, by the velocities, of
///   area / 2 (density s (u . n)^2 + drag |u - (u . n) n|^2),  u = wind - v
/// with s = |u . n| of the start, and the block is h times the second derivative.
TEST(WindKernel, ImpulseAndBlockAreDerivativesOfWhatItDissipates) {
  Random random(45);
  test::each_triangle(random, [&](const RestTriangle& triangle) {
    std::vector<Vec3<double>> start, v;
    for (int k = 0; k < 3; ++k) {
      start.push_back(2 * random.point());
      v.push_back(2 * random.point());
    }
    const auto& x = triangle.x;
    const Vec3<double> twice = cross(x[1] - x[0], x[2] - x[0]);
    const double area = length(twice) / 2;
    const Vec3<double> n = area > 0 ? (0.5 / area) * twice : Vec3<double>{};
    const auto mean = [](const auto& of) { return (of[0] + of[1] + of[2]) * (1.0L / 3); };
    Vec3<Long> first[3], normal[1] = {vec_cast<Long>(n)};
    for (std::size_t k = 0; k < 3; ++k) first[k] = vec_cast<Long>(start[k]);
    const Long speed = std::fabs(dot(vec_cast<Long>(wind) - mean(first), normal[0]));
    const auto dissipated = [&](const Vec3<Long>(&now)[3]) {
      const Vec3<Long> u = vec_cast<Long>(wind) - mean(now);
      const Long across = dot(u, normal[0]);
      return static_cast<Long>(area) / 2 *
             (air * speed * across * across + drag * (length_sq(u) - across * across));
    };
    const auto impulse = [&](const Vec3<double>(&now)[3]) {
      return wind_terms(x, start, std::vector<Vec3<double>>(now, now + 3));
    };
    const Vec3<double> at[3] = {v[0], v[1], v[2]};
    const WindTerms terms = impulse(at);
    Vec3<double> g[3];
    test::difference_gradient(dissipated, at, 1e-3L, g);
    for (auto& f : g) f *= -h;
    EXPECT_LE(test::largest_difference(terms.impulse, g), 1e-12 * h * area + 1e-30);
    const Matrix9 block = test::matrix_of(terms.block);
    EXPECT_EQ((block - block.transpose()).cwiseAbs().maxCoeff(), 0);
    EXPECT_GE(test::least_eigenvalue(block), -1e-14 * h * area);
    // Corners that move alike bear the row's sum each.
    for (int k = 0; k < 9; ++k)
      EXPECT_NEAR(terms.corner_drag.e[k], 3 * terms.block[0].e[k], 1e-14 * h * area);
    // The force is linear in the velocities: the block is exact over any way.
    Eigen::Matrix<double, 9, 1> way, change;
    Vec3<double> there[3];
    for (int k = 0; k < 3; ++k) {
      const Vec3<double> u = random.point();
      there[k] = at[k] + u;
      for (int e = 0; e < 3; ++e) way[3 * k + e] = u[e];
    }
    const WindTerms moved = impulse(there);
    for (int k = 0; k < 9; ++k)
      change[k] = moved.impulse[k / 3][k % 3] - terms.impulse[k / 3][k % 3];
    EXPECT_LE((change + block * way).cwiseAbs().maxCoeff(), 1e-13 * h * area + 1e-30);
    // Seen from its back the triangle is the same.
    const Vec3<double> turned[3] = {x[0], x[2], x[1]};
    const WindTerms back = wind_terms(turned, {start[0], start[2], start[1]}, {v[0], v[2], v[1]});
    EXPECT_LE(length(back.impulse[0] - terms.impulse[0]), 1e-13 * h * area + 1e-30);
  });
}

}  // namespace
}  // namespace weft
