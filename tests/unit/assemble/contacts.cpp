#include "weft/kernels/assemble/contacts.hpp"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <vector>

#include "tests/unit/elements/configurations.hpp"
#include "weft/elements/distance.hpp"

// What contacts and springs put into the linear system, against differences of their energies.

namespace weft {
namespace {

using test::Long;
using test::Random;

constexpr double h = 0.01, thickness = 0.002, stiffness = 150, friction = 0.4;

/// Four corners at the start and the end of a step, and whether they are edges.
struct Pose {
  const char* name;
  bool edges;
  Vec3<double> x0[4], x[4];
  Vec3<double> anchor{};
  double fraction = friction;
};

/// Pairs a thousandth apart, as they are met: at random, and where closest points are ill defined.
std::vector<Pose> poses() {
  const double gap = 0.6 * thickness;
  std::vector<Pose> all;
  const auto add = [&](const char* name, bool edges, std::initializer_list<Vec3<double>> at) {
    Pose p{name, edges, {}, {}};
    std::copy(at.begin(), at.end(), p.x);
    std::copy(at.begin(), at.end(), p.x0);
    all.push_back(p);
  };
  const Vec3<double> a{0, 0, 0}, right{0.01, 0, 0}, up{0, 0.01, 0};
  const Vec3<double> above{0.003, 0.003, gap};
  add("vertex over a face", false, {above, a, right, up});
  add("vertex in a face", false, {{0.003, 0.003, 0}, a, right, up});
  add("vertex at a corner of a face", false, {a, a, right, up});
  add("face folded onto its edge", false, {above, a, right, {0.005, 1e-9, 0}});
  add("face that is a point", false, {above, a, a, a});
  add("edges that cross", true, {a, right, {0.004, -0.005, gap}, {0.004, 0.005, gap}});
  add("edges that meet", true, {a, right, {0.004, -0.005, 0}, {0.004, 0.005, 0}});
  add("edges nearly parallel", true, {a, right, {0, -1e-7, gap}, {0.01, 1e-7, gap}});
  add("edges parallel", true, {a, right, {0.001, 0, gap}, {0.009, 0, gap}});
  add("an edge of no length", true, {a, right, {0.004, 0, gap}, {0.004, 0, gap}});
  add("one edge twice", true, {a, right, a, right});
  add("too far", false, {{0.003, 0.003, 1.5 * thickness}, a, right, up});
  return all;
}

struct Terms {
  Contact<double> contact;
  ContactMotion<double> motion;
  ContactTerms<double> terms;
};

/// @param side -1: the normal is that of before the primitives passed each other
Terms terms_of(const Pose& p, double side = 1) {
  const auto closest = p.edges ? edge_edge(p.x) : vertex_triangle(p.x);
  Terms t{};
  Contact<double>& c = t.contact;
  c = {};
  for (int j = 0; j < 4; ++j) {
    c.v[j] = j;
    c.w[j] = closest.w[j];
  }
  c.n = side * contact_normal(closest.difference, Vec3<double>{0, 0, 1});
  c.stiffness = c.hold = stiffness;
  c.thickness = thickness;
  c.friction = p.fraction;
  c.anchor = tangential(p.anchor, c.n);
  AssembleContacts<double> a;
  a.positions = {p.x, 4};
  a.positions_t0 = {p.x0, 4};
  a.h = h;
  a.as_taken = false;
  t.motion = contact_motion(c, a.positions, a.positions_t0);
  t.terms = contact_terms(a, c);
  return t;
}

/// The energy with normal, weights and the limit of friction as they are at the pose.
Long energy_at(const Contact<double>& c, const Pose& p, Long limit, const Vec3<Long> (&x)[4]) {
  Vec3<Long> slip{};
  Long w[4];
  for (int j = 0; j < 4; ++j) {
    w[j] = c.w[j];
    slip += w[j] * (x[j] - vec_cast<Long>(p.x0[j]));
  }
  const auto n = vec_cast<Long>(c.n);
  const Vec3<Long> u = vec_cast<Long>(c.anchor) + tangential(slip, n);
  const Long gap = contact_gap(n, x, w);
  // Apart there is no friction.
  return repulsion_energy<Long>(gap, thickness, stiffness) +
         (limit > 0 ? friction_potential<Long>(stiffness, limit, length(u)) : 0);
}

void expect_derivatives(const Pose& p, double side) {
  const Terms t = terms_of(p, side);
  const Contact<double>& c = t.contact;
  const Long limit = p.fraction * repulsion_force(t.motion.gap, thickness, stiffness);
  const Long step = 1e-8;
  const double scale = stiffness * thickness;
  Vec3<double> g[4], impulse[4];
  test::difference_gradient([&](const Vec3<Long>(&x)[4]) { return energy_at(c, p, limit, x); }, p.x,
                            step, g);
  for (int j = 0; j < 4; ++j) {
    impulse[j] = c.w[j] * t.terms.impulse;
    g[j] *= -h;
  }
  EXPECT_LE(test::largest_difference(impulse, g), 1e-9 * h * scale);
  const auto gradient = [&](const Vec3<Long>(&x)[4], Vec3<Long>(&out)[4]) {
    for (int j = 0; j < 4; ++j)
      for (int k = 0; k < 3; ++k)
        out[j][k] = test::derivative(
            [&](Long by) {
              Vec3<Long> y[4] = {x[0], x[1], x[2], x[3]};
              y[j][k] += by;
              return energy_at(c, p, limit, y);
            },
            1e-6L);
  };
  Mat3<double> slope[4][4], block[4][4];
  test::difference_hessian(gradient, p.x, 1e-6L, slope);
  Eigen::Matrix<double, 12, 12> m;
  for (int i = 0; i < 4; ++i)
    for (int j = 0; j < 4; ++j) {
      block[i][j] = (c.w[i] * c.w[j]) * t.terms.block;
      slope[i][j] *= h * h;
      for (int r = 0; r < 3; ++r)
        for (int q = 0; q < 3; ++q) m(3 * i + r, 3 * j + q) = block[i][j](r, q);
    }
  EXPECT_LE(test::largest_difference(block, slope), 1e-5 * h * h * stiffness);
  EXPECT_LE((m - m.transpose()).cwiseAbs().maxCoeff(), 1e-16 * h * h * stiffness);
  EXPECT_GE(Eigen::SelfAdjointEigenSolver<decltype(m)>(m).eigenvalues().minCoeff(),
            -1e-14 * h * h * stiffness);
}

/// Where it stands still; sticking by half of the limit; sliding; passed through the other side.
TEST(ContactKernel, ImpulseAndBlockAreDerivativesOfTheEnergy) {
  Random random(51);
  for (const Pose& at : poses())
    for (const double slip : {0.0, 0.5, 3.0})
      for (const double fraction : {friction, 0.0})
        for (const bool passed : {false, true}) {
          SCOPED_TRACE(testing::Message() << at.name << ", slip " << slip << ", " << passed);
          Pose p = at;
          p.fraction = fraction;
          const Terms t = terms_of(p, passed ? -1 : 1);
          const double force = repulsion_force(t.motion.gap, thickness, stiffness);
          const double reach = friction * force / stiffness;
          const Vec3<double> u = tangential(random.unit(), t.contact.n);
          const Vec3<double> along = slip * reach * (1 / length(u)) * u;
          p.anchor = 0.3 * along;
          // The first primitive moves, whose weights sum to one.
          for (int j = 0; j < (p.edges ? 2 : 1); ++j) p.x0[j] = p.x[j] - 0.7 * along;
          expect_derivatives(p, passed ? -1 : 1);
        }
}

TEST(ContactKernel, ContactsThatArePartedAreNothing) {
  for (const Pose& p : poses()) {
    const Terms t = terms_of(p);
    if (t.motion.gap < thickness) continue;
    EXPECT_EQ(length(t.terms.impulse), 0) << p.name;
    for (const double e : t.terms.block.e) EXPECT_EQ(e, 0) << p.name;
  }
}

TEST(SpringKernel, DashpotsResistWhatShortensTheSpringInTheStep) {
  const std::vector<Vec3<double>> start{{0, 0, 0}, {2, 0, 0}};
  // Nearer by 0.2, and beside each other by 0.3, which nothing resists.
  const std::vector<Vec3<double>> end{{0.2, 0.3, 0}, {2, 0, 0}};
  AssembleContacts<double> a;
  a.positions = end;
  a.positions_t0 = start;
  a.h = h;
  const auto terms = [&](double rest, double drag) {
    return spring_terms(a, Spring<double>{{0, 1}, {}, 5, rest, {}, drag});
  };
  const auto without = terms(0, 0), with = terms(0, 40);
  EXPECT_LT(length(with.impulse - without.impulse - Vec3<double>{-h * 40 * 0.2, 0, 0}), 1e-12);
  for (int e = 0; e < 9; ++e)
    EXPECT_NEAR(with.block.e[e] - without.block.e[e], e == 0 ? h * h * 40 : 0, 1e-12) << e;
  // Slack at the start.
  EXPECT_EQ(terms(2, 40).impulse, terms(2, 0).impulse);
}

TEST(SpringKernel, ImpulseAndBlockAreDerivativesOfTheEnergy) {
  Random random(52);
  const double rest = 0.03, k = 20;
  for (const bool to_place : {false, true})
    for (const double reach : {0.0, 1e-9, 0.02, 0.0301, 0.5})
      for (const double slack : {rest, 0.0}) {
        SCOPED_TRACE(testing::Message() << reach << " of " << slack);
        const Vec3<double> way = reach * random.unit();
        const Vec3<double> x[2] = {random.point(), {}};
        std::vector<Vec3<double>> positions{x[0], x[0] - way};
        const Spring<double> s{{0, to_place ? -1 : 1}, x[0] - way, k, slack};
        AssembleContacts<double> a;
        a.positions = positions;
        a.h = h;
        const ContactTerms<double> terms = spring_terms(a, s);
        const Vec3<double> at[2] = {positions[0], positions[1]};
        const auto energy = [&](const Vec3<Long>(&y)[2]) {
          const Vec3<Long> end = to_place ? vec_cast<Long>(s.anchor) : y[1];
          return spring_energy<Long>(y[0] - end, slack, k);
        };
        const auto gradient = [&](const Vec3<Long>(&y)[2], Vec3<Long>(&g)[2]) {
          const Vec3<Long> end = to_place ? vec_cast<Long>(s.anchor) : y[1];
          g[0] = -spring_force<Long>(y[0] - end, slack, k);
          g[1] = to_place ? Vec3<Long>{} : -g[0];
        };
        const Long step = 1e-6;
        Vec3<double> g[2];
        test::difference_gradient(energy, at, step, g);
        const double w[2] = {1, to_place ? 0.0 : -1.0};
        Mat3<double> slope[2][2];
        test::difference_hessian(gradient, at, step, slope);
        for (int i = 0; i < 2; ++i) {
          EXPECT_LE(length(w[i] * terms.impulse + h * g[i]), 1e-9 * h * k);
          for (int j = 0; j < 2; ++j)
            for (int e = 0; e < 9; ++e)
              EXPECT_NEAR(w[i] * w[j] * terms.block.e[e], h * h * slope[i][j].e[e],
                          1e-6 * h * h * k);
        }
      }
}

}  // namespace
}  // namespace weft
