#include "weft/elements/strain_limit.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "tests/unit/elements/sheets.hpp"

namespace weft {
namespace {

using test::Random;
using test::RestTriangle;
using Strain = detail::Symmetric2<double>;

constexpr double infinity = std::numeric_limits<double>::infinity();

struct Limits {
  double min, max, stiffness;
  template <class T>
  MembraneLimits<T> law() const {
    return membrane_limits(static_cast<T>(min), static_cast<T>(max), static_cast<T>(stiffness));
  }
  /// The largest that phi'' grows to.
  double scale() const { return stiffness; }
};

/// Both limits, either, and tight ones.
template <class Visit>
void each_case(const Visit& visit) {
  Random random(31);
  int turn = 0;
  test::each_triangle(random, [&](const RestTriangle& s) {
    const double k = random.uniform(100, 20000);
    const Limits all[] = {{random.uniform(0.7, 0.95), random.uniform(1.05, 1.4), k},
                          {0, random.uniform(1.05, 1.4), k},
                          {random.uniform(0.3, 0.9), infinity, k},
                          {0.99, 1.01, k}};
    visit(s, all[turn++ % 4]);
  });
}

// The energy's third derivatives jump at the ends of the bands: differences over less than that is
// off by.
constexpr double step = 1e-8;

TEST(StrainLimit, gradient_is_the_derivative_of_the_energy) {
  each_case([](const RestTriangle& s, const Limits& limits) {
    test::expect_gradient(s, limits.law<double>(), limits.law<test::Long>(), limits.scale(), step,
                          1e-8);
  });
}

TEST(StrainLimit, hessian_is_the_derivative_of_the_gradient) {
  each_case([](const RestTriangle& s, const Limits& limits) {
    test::expect_hessian(s, limits.law<double>(), limits.law<test::Long>(), limits.scale(), step,
                         1e-6);
  });
}

TEST(StrainLimit, projected_hessian_is_semidefinite_and_fused_form_the_same) {
  each_case([](const RestTriangle& s, const Limits& limits) {
    test::expect_projection(s, limits.law<double>(), limits.scale());
    test::expect_fused(s, limits.law<double>());
  });
}

TEST(StrainLimit, energy_ignores_rotation_and_forces_carry_no_momentum) {
  Random random(32);
  each_case([&](const RestTriangle& s, const Limits& limits) {
    test::expect_invariance(s, limits.law<double>(), random, limits.scale());
  });
}

Strain along(double angle, double g1, double g2) {
  const double c = std::cos(angle), s = std::sin(angle);
  return {g1 * c * c + g2 * s * s, (g1 - g2) * c * s, g1 * s * s + g2 * c * c};
}

double green(double stretch) {
  return (stretch * stretch - 1) / 2;
}

TEST(StrainLimit, is_nothing_well_within_the_limits) {
  const auto law = membrane_limits(0.9, 1.1, 1000.0);
  for (const double share : {-0.49, -0.2, 0.0, 0.3, 0.49}) {
    const double g = share < 0 ? -share * green(0.9) : share * green(1.1);
    const Strain strain = along(0.4, g, 0);
    EXPECT_EQ(0, law.energy(strain));
    const auto r = law.response(strain, true);
    EXPECT_EQ(0, r.stress.xx);
    for (const double t : r.tangent) EXPECT_EQ(0, t);
  }
  EXPECT_GT(law.energy(along(0.4, 0.51 * green(1.1), 0)), 0);
  EXPECT_GT(law.energy(along(0.4, 0, 0.51 * green(0.9))), 0);
  EXPECT_FALSE(membrane_limits(0.0, infinity, 1000.0).any());
}

/// The header's own formulas in the eigenvectors' frame.
TEST(StrainLimit, values_at_the_limits) {
  const double k = 1000;
  for (const bool upper : {false, true}) {
    const double g = green(upper ? 1.1 : 0.9);
    const double w = g / 2;
    const auto law = membrane_limits(0.9, 1.1, k);
    for (const double angle : {0.0, 0.7, 2.1}) {
      const Strain strain = along(angle, g, 0);
      EXPECT_NEAR(k * w * w / 12, law.energy(strain), 1e-12);
      const auto r = law.response(strain, false);
      const Strain expected = along(angle, k * w / 3, 0);
      EXPECT_NEAR(expected.xx, r.stress.xx, 1e-11);
      EXPECT_NEAR(expected.xy, r.stress.xy, 1e-11);
      EXPECT_NEAR(expected.yy, r.stress.yy, 1e-11);
      // stretching further along the axis
      const Strain n = along(angle, 1, 0);
      const double e[3] = {n.xx, n.yy, 2 * n.xy};
      const double* t = r.tangent;
      const double curvature = e[0] * (t[0] * e[0] + 2 * t[1] * e[1] + 2 * t[2] * e[2]) +
                               e[1] * (t[3] * e[1] + 2 * t[4] * e[2]) + t[5] * e[2] * e[2];
      EXPECT_NEAR(k, curvature, 1e-9);
    }
  }
}

TEST(StrainLimit, holds_a_load_and_takes_up_an_energy_before_it_is_reached) {
  const auto energy = membrane_limits(0.9, 1.01, 10.0, 0.6);
  auto load = membrane_limits(0.9, 1.01, 10.0);
  load.force = 2;
  load = load.of_triangle(0.0025);
  for (const double stretch : {0.9, 1.01}) {
    EXPECT_NEAR(0.6, energy.energy(along(0.3, green(stretch), 0)), 1e-9) << stretch;
    EXPECT_NEAR(stretch > 1 ? 40 : -40, load.response(along(0, green(stretch), 0), false).stress.xx,
                1e-9)
        << stretch;
  }
  EXPECT_EQ(1000, membrane_limits(0.9, 1.1, 1000.0, 1e-3).high.stiffness) << "stiff enough";
}

TEST(StrainLimit, tells_by_how_much_it_is_exceeded) {
  const auto law = membrane_limits(0.9, 1.01, 1000.0);
  for (const double angle : {0.0, 0.9}) {
    const auto excess = [&](double a, double b) {
      return law.excess(along(angle, green(a), green(b)));
    };
    EXPECT_EQ(0, excess(1, 1));
    EXPECT_EQ(0, excess(1.009999, 0.900001));
    EXPECT_NEAR(0.04, excess(1.0104, 1), 1e-9);
    EXPECT_NEAR(0.5, excess(1, 0.85), 1e-9);
    EXPECT_NEAR(0.5, excess(1.0104, 0.85), 1e-9);
    EXPECT_TRUE(law.holds(along(angle, green(1.009999), green(0.900001))));
    EXPECT_FALSE(law.holds(along(angle, green(1.010001), green(1))));
    EXPECT_FALSE(law.holds(along(angle, green(1), green(0.899999))));
  }
  EXPECT_EQ(0, membrane_limits(0.0, 1.1, 1000.0).excess(along(0.3, green(1), green(0.01))))
      << "no limit below";
}

TEST(StrainLimit, is_convex_and_continuous_where_it_changes_its_form) {
  const auto law = membrane_limits(0.9, 1.1, 1000.0);
  double slope = -infinity;
  for (int i = -500; i <= 3000; ++i) {
    const double g = 1e-3 * i;
    const auto r = law.response({g, 0, 0}, false);
    EXPECT_GE(r.stress.xx, slope) << g;
    slope = r.stress.xx;
    const auto next = law.response({g + 1e-9, 0, 0}, false);
    EXPECT_NEAR(r.tangent[0], next.tangent[0], 1e-3) << g;
    EXPECT_GE(r.tangent[0], 0) << g;
  }
}

TEST(StrainLimit, equal_stretches_make_no_difference) {
  const auto law = membrane_limits(0.9, 1.1, 1000.0);
  const auto round = law.response({0.1, 0, 0.1}, false);
  for (const double off : {1e-18, 1e-9, 1e-5, 9.4e-5, 9.6e-5, 3e-4}) {
    const auto r = law.response(along(0.3, 0.1 + off, 0.1 - off), false);
    EXPECT_NEAR(round.stress.xx, r.stress.xx, 1200 * off + 1e-12) << off;
    EXPECT_NEAR(round.tangent[0], r.tangent[0], 1e6 * off + 1e-9) << off;
    EXPECT_NEAR(round.tangent[5], r.tangent[5], 1e6 * off + 1e-9) << off;
    // each is the difference quotient of the other
    const double eps = 1e-6;
    const auto more = law.response(along(0.3, 0.1 + off + eps, 0.1 - off + eps), false);
    EXPECT_NEAR((more.stress.xx - r.stress.xx) / eps, r.tangent[0] + r.tangent[1], 0.1) << off;
  }
}

TEST(StrainLimit, is_finite_in_single_precision_for_any_triangle) {
  const auto law = membrane_limits(0.9f, 1.01f, 20000.0f);
  for (const float size : {0.0f, 1e-30f, 1e-6f, 1.0f, 100.0f, 1e5f}) {
    const Vec3<float> x[3] = {{0, 0, 0}, {size, 0, 0}, {0, size, 0}};
    const Vec3<float> line[3] = {{0, 0, 0}, {size, 0, 0}, {size / 2, 0, 0}};
    const Mat2<float> rest = Mat2<float>::identity();
    for (const auto& corners : {x, line}) {
      Vec3<float> g[3];
      Mat3<float> h[6];
      membrane_law_gradient(corners, rest, 0.5f, law, g);
      membrane_law_hessian(corners, rest, 0.5f, law, true, h);
      for (const auto& v : g)
        for (const float e : v.e) EXPECT_TRUE(std::isfinite(e)) << size;
      for (const auto& b : h)
        for (const float e : b.e) EXPECT_TRUE(std::isfinite(e)) << size;
    }
  }
}

TEST(StrainLimit, single_precision_follows_double) {
  Random random(33);
  const auto fine = membrane_limits(0.9, 1.1, 1000.0);
  const auto law = membrane_limits(0.9f, 1.1f, 1000.0f);
  for (int i = 0; i < 2000; ++i) {
    const double g = random.uniform(-0.2, 0.3);
    const Strain s = along(random.uniform(0, 3), g, g + random.decade(-8, -1));
    const detail::Symmetric2<float> f{static_cast<float>(s.xx), static_cast<float>(s.xy),
                                      static_cast<float>(s.yy)};
    const auto r = fine.response({f.xx, f.xy, f.yy}, false);
    const auto q = law.response(f, false);
    EXPECT_NEAR(r.stress.xx, q.stress.xx, 1e-6 * 1000);
    for (int k = 0; k < 6; ++k) EXPECT_NEAR(r.tangent[k], q.tangent[k], 1e-4 * 1000);
  }
}

}  // namespace
}  // namespace weft
