#include "weft/elements/distance.hpp"

#include <gtest/gtest.h>

#include "tests/unit/elements/closest.hpp"
#include "tests/unit/elements/configurations.hpp"

namespace weft {
namespace {

using test::Long;
using test::Random;

constexpr double eps = epsilon<double>;

/// Largest coordinate of the corners relative to the first.
double size_of(const Vec3<double> (&x)[4]) {
  Vec3<double> local[4];
  for (int j = 0; j < 4; ++j) local[j] = x[j] - x[0];
  return test::largest(local);
}

/// Weights in their simplices, difference and distance as the weights say.
void expect_consistent(const Vec3<double> (&x)[4], const Proximity<double>& p, int first) {
  double sum_first = 0, sum_second = 0;
  Vec3<double> difference{};
  for (int j = 0; j < 4; ++j) {
    ASSERT_TRUE(std::isfinite(p.w[j]));
    (j < first ? sum_first : sum_second) += p.w[j];
    EXPECT_GE(j < first ? p.w[j] : -p.w[j], 0);
    difference += (x[j] - x[0]) * p.w[j];
  }
  EXPECT_NEAR(sum_first, 1, 2 * eps);
  EXPECT_NEAR(sum_second, -1, 2 * eps);
  EXPECT_LE(length(difference - p.difference), 16 * eps * size_of(x));
  EXPECT_EQ(p.distance_sq, length_sq(p.difference));
}

/// Triangles and vertices, and pairs of edges: at random; needles and slivers; corners that
/// coincide; all in a plane or on a line; parallel edges. Sizes and places vary.
void random_corners(Random& random, int kind, Vec3<double> (&x)[4]) {
  for (auto& p : x) p = random.point();
  const double small = random.decade(-17, -1);
  switch (kind) {
    case 1:  // sliver: the last corner almost on the line of the two before
      x[3] = x[1] + (x[2] - x[1]) * random.uniform(-0.5, 1.5) + random.point(small);
      break;
    case 2:  // needle
      x[3] = x[2] + random.point(small);
      break;
    case 3:  // nearly parallel edges
      x[3] = x[2] + (x[1] - x[0]) * random.uniform(-2, 2) + random.point(small);
      break;
    case 4:  // corners that coincide
      x[random.below(4)] = x[random.below(4)];
      x[random.below(4)] = x[random.below(4)];
      break;
    case 5:  // flat
      for (auto& p : x) p[2] *= small;
      break;
    case 6:  // all nearly on a line
      for (auto& p : x) p[1] *= small, p[2] *= small;
      break;
    case 7:  // a close pair of primitives of unlike size
      x[3] = x[2] + random.point(small);
      x[0] = x[2] + random.point(random.decade(-17, -1));
      break;
    default:
      break;
  }
  const double scale = random.decade(-6, 3);
  const Mat3<double> q = random.rotation();
  const Vec3<double> offset = random.point(random.decade(-3, 3)) * (random.below(2) ? 1.0 : 0.0);
  for (auto& p : x) p = q * p * scale + offset;
}

TEST(Distance, agrees_with_long_double_to_some_rounding_errors) {
  Random random(41);
  for (int i = 0; i < 400000; ++i) {
    Vec3<double> x[4];
    random_corners(random, i % 8, x);
    const double tolerance = 12 * eps * size_of(x);
    const auto vt = vertex_triangle(x);
    const auto ee = edge_edge(x);
    const double vt_expected = static_cast<double>(test::vertex_triangle_reference(x));
    const double ee_expected = static_cast<double>(test::edge_edge_reference(x));
    ASSERT_NEAR(std::sqrt(vt.distance_sq), vt_expected, tolerance) << "kind " << i % 8;
    ASSERT_NEAR(std::sqrt(ee.distance_sq), ee_expected, tolerance) << "kind " << i % 8;
    expect_consistent(x, vt, 1);
    expect_consistent(x, ee, 2);
  }
}

TEST(Distance, agrees_with_search_over_the_weights) {
  Random random(42);
  for (int i = 0; i < 2000; ++i) {
    Vec3<double> x[4];
    random_corners(random, i % 8, x);
    const double tolerance = 1e-9 * size_of(x);
    EXPECT_NEAR(std::sqrt(vertex_triangle(x).distance_sq), test::vertex_triangle_search(x),
                tolerance);
    EXPECT_NEAR(std::sqrt(edge_edge(x).distance_sq), test::edge_edge_search(x), tolerance);
  }
}

TEST(Distance, vertex_above_the_inside_of_a_triangle_however_thin) {
  Random random(43);
  for (int i = 0; i < 100000; ++i) {
    // Made so that the answer is known: a point at height d over a point of the triangle.
    const double height = random.decade(-12, 0), d = random.decade(-18, 1);
    const Mat3<Long> q = random.rotation<Long>();
    const Vec3<Long> corner[3] = {{Long(random.uniform(-1, 0)), 0, 0},
                                  {Long(random.uniform(0.1, 1)), 0, 0},
                                  {Long(random.uniform(-2, 2)), Long(height), 0}};
    const Long b1 = Long(random.uniform(0, 1)), b2 = (1 - b1) * Long(random.uniform(0, 1));
    const Vec3<Long> foot = corner[0] * (1 - b1 - b2) + corner[1] * b1 + corner[2] * b2;
    Vec3<double> x[4];
    x[0] = vec_cast<double>(q * (foot + Vec3<Long>{0, 0, Long(d)}));
    for (int j = 0; j < 3; ++j) x[j + 1] = vec_cast<double>(q * corner[j]);
    ASSERT_NEAR(std::sqrt(vertex_triangle(x).distance_sq), d, 12 * eps * size_of(x));
  }
}

TEST(Distance, edges_that_cross_at_any_angle) {
  Random random(44);
  for (int i = 0; i < 100000; ++i) {
    const Long angle = Long(random.decade(-17, 0)), d = Long(random.decade(-18, 1));
    const Mat3<Long> q = random.rotation<Long>();
    const Vec3<Long> u{1, 0, 0}, v{std::cos(angle), std::sin(angle), 0}, up{0, 0, d};
    const Vec3<Long> end[4] = {u * Long(random.uniform(-1, 0)), u * Long(random.uniform(0, 1)),
                               v * Long(random.uniform(-1, 0)) + up,
                               v * Long(random.uniform(0, 1)) + up};
    Vec3<double> x[4];
    for (int j = 0; j < 4; ++j) x[j] = vec_cast<double>(q * end[j]);
    ASSERT_NEAR(std::sqrt(edge_edge(x).distance_sq), static_cast<double>(d), 12 * eps * size_of(x));
  }
}

TEST(Distance, vertex_triangle_by_hand) {
  const Vec3<double> a{0, 0, 0}, b{2, 0, 0}, c{0, 2, 0};
  const auto at = [&](Vec3<double> p) {
    const Vec3<double> x[4] = {p, a, b, c};
    return vertex_triangle(x);
  };
  const auto inside = at({0.5, 0.5, 3});
  EXPECT_EQ(inside.distance_sq, 9);
  EXPECT_EQ(inside.difference, (Vec3<double>{0, 0, 3}));
  EXPECT_EQ(inside.w[0], 1);
  EXPECT_EQ(inside.w[1], -0.5);
  EXPECT_EQ(inside.w[2], -0.25);
  EXPECT_EQ(inside.w[3], -0.25);
  EXPECT_EQ(active_corners(inside), 0b1111u);
  EXPECT_EQ(active_corners(at({-1, -1, 0})), 0b0011u);
  EXPECT_EQ(active_corners(at({4, -1, 0})), 0b0101u);
  EXPECT_EQ(active_corners(at({-1, 4, 0})), 0b1001u);
  EXPECT_EQ(active_corners(at({1, -1, 1})), 0b0111u);
  EXPECT_EQ(active_corners(at({-1, 1, 1})), 0b1011u);
  EXPECT_EQ(active_corners(at({2, 2, 1})), 0b1101u);
  EXPECT_EQ(at({2, 2, 1}).distance_sq, 3);
}

TEST(Distance, edge_edge_by_hand) {
  const auto between = [](Vec3<double> a0, Vec3<double> a1, Vec3<double> b0, Vec3<double> b1) {
    const Vec3<double> x[4] = {a0, a1, b0, b1};
    return edge_edge(x);
  };
  const auto cross_over = between({-1, 0, 1}, {3, 0, 1}, {0, -1, 0}, {0, 1, 0});
  EXPECT_EQ(cross_over.distance_sq, 1);
  EXPECT_EQ(cross_over.difference, (Vec3<double>{0, 0, 1}));
  EXPECT_EQ(cross_over.w[0], 0.75);
  EXPECT_EQ(cross_over.w[1], 0.25);
  EXPECT_EQ(cross_over.w[2], -0.5);
  EXPECT_EQ(cross_over.w[3], -0.5);
  // Parallel and side by side, parallel and apart, on one line and overlapping, two points.
  EXPECT_EQ(between({0, 0, 0}, {1, 0, 0}, {0.5, 2, 0}, {3, 2, 0}).distance_sq, 4);
  EXPECT_EQ(between({0, 0, 0}, {1, 0, 0}, {4, 4, 0}, {2, 4, 0}).distance_sq, 17);
  EXPECT_EQ(between({0, 0, 0}, {1, 0, 0}, {0.5, 0, 0}, {3, 0, 0}).distance_sq, 0);
  EXPECT_EQ(between({0, 0, 0}, {0, 0, 0}, {0, 3, 4}, {0, 3, 4}).distance_sq, 25);
  EXPECT_EQ(between({0, 0, 0}, {0, 0, 0}, {-1, 0, 2}, {1, 0, 2}).distance_sq, 4);
  EXPECT_EQ(active_corners(between({0, 0, 0}, {1, 0, 0}, {2, -1, 0}, {2, 1, 0})), 0b1110u);
}

template <class T>
void test_degenerate_stay_finite() {
  Random random(45);
  for (int i = 0; i < 20000; ++i) {
    const double size = random.decade(sizeof(T) == 4 ? -22 : -160, sizeof(T) == 4 ? 8 : 70);
    Vec3<T> x[4];
    for (auto& p : x) p = random.point<T>() * T(size);
    for (int k = random.below(4); k > 0; --k) x[random.below(4)] = x[random.below(4)];
    if (random.below(2)) x[3] = x[2] + (x[1] - x[2]) * T(random.uniform(-1, 2));
    for (const auto& p : {vertex_triangle(x), edge_edge(x)}) {
      EXPECT_TRUE(std::isfinite(p.distance_sq));
      for (const T w : p.w) EXPECT_TRUE(std::fabs(w) <= T(1));
    }
  }
}

TEST(Distance, degenerate_primitives_of_any_size_stay_finite_in_double) {
  test_degenerate_stay_finite<double>();
}
TEST(Distance, degenerate_primitives_of_any_size_stay_finite_in_float) {
  test_degenerate_stay_finite<float>();
}

TEST(Distance, float_follows_double) {
  Random random(46);
  for (int i = 0; i < 100000; ++i) {
    Vec3<double> x[4];
    Vec3<float> xf[4];
    random_corners(random, i % 8, x);
    test::cast(x, xf);
    test::cast(xf, x);
    const double tolerance = 12 * static_cast<double>(epsilon<float>) * size_of(x);
    ASSERT_NEAR(std::sqrt(static_cast<double>(vertex_triangle(xf).distance_sq)),
                std::sqrt(vertex_triangle(x).distance_sq), tolerance);
    ASSERT_NEAR(std::sqrt(static_cast<double>(edge_edge(xf).distance_sq)),
                std::sqrt(edge_edge(x).distance_sq), tolerance);
  }
}

TEST(Distance, ignores_rotation_translation_and_order) {
  Random random(47);
  for (int i = 0; i < 20000; ++i) {
    Vec3<double> x[4], y[4];
    random_corners(random, i % 8, x);
    const double tolerance = 48 * eps * test::largest(x);
    const Mat3<double> q = random.rotation();
    const Vec3<double> shift = random.point(test::largest(x));
    for (int j = 0; j < 4; ++j) y[j] = q * x[j] + shift;
    const double vt = std::sqrt(vertex_triangle(x).distance_sq);
    const double ee = std::sqrt(edge_edge(x).distance_sq);
    EXPECT_NEAR(std::sqrt(vertex_triangle(y).distance_sq), vt, tolerance);
    EXPECT_NEAR(std::sqrt(edge_edge(y).distance_sq), ee, tolerance);
    const Vec3<double> turned[4] = {x[0], x[2], x[3], x[1]}, swapped[4] = {x[3], x[2], x[0], x[1]};
    EXPECT_NEAR(std::sqrt(vertex_triangle(turned).distance_sq), vt, tolerance);
    EXPECT_NEAR(std::sqrt(edge_edge(swapped).distance_sq), ee, tolerance);
  }
}

/// "Farther" must be the truth for distances just above the true one, and useful otherwise.
template <class T>
void test_farther() {
  Random random(48);
  int told[2] = {0, 0}, far = 0;
  for (int i = 0; i < 200000; ++i) {
    Vec3<double> x[4];
    Vec3<T> xt[4];
    random_corners(random, i % 8, x);
    test::cast(x, xt);
    test::cast(xt, x);
    const Long d[2] = {test::vertex_triangle_reference(x), test::edge_edge_reference(x)};
    for (int k = 0; k < 2; ++k) {
      // The least T that is not below the true distance, and random ones above it.
      T above = static_cast<T>(d[k]);
      while (static_cast<Long>(above) < d[k] * (1 + 1e-18L))
        above = std::nextafter(above, std::numeric_limits<T>::max());
      for (const T limit : {above, above * T(1 + random.decade(-7, 0))})
        ASSERT_FALSE(k == 0 ? vertex_triangle_farther(xt, limit) : edge_edge_farther(xt, limit))
            << "kind " << i % 8;
      if (i % 8 == 0) {
        const T half = static_cast<T>(d[k] / 2);
        told[k] += k == 0 ? vertex_triangle_farther(xt, half) : edge_edge_farther(xt, half);
        far += k == 0;
      }
    }
  }
  EXPECT_GT(told[0], far * 3 / 4);
  EXPECT_GT(told[1], far * 3 / 4);
}

TEST(Distance, farther_never_claims_too_much_in_double) {
  test_farther<double>();
}
TEST(Distance, farther_never_claims_too_much_in_float) {
  test_farther<float>();
}

}  // namespace
}  // namespace weft
