#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <optional>
#include <string>

#include "tests/unit/elements/configurations.hpp"
#include "tests/unit/elements/exact_contact.hpp"
#include "weft/elements/ccd.hpp"

// Queries made to be hard, with the truth by rational arithmetic.

namespace weft {
namespace {

using test::Random;

template <class T>
struct Query {
  bool edges = false;
  Vec3<T> x_t0[4], x_t1[4];
};

enum class Kind {
  lattice,     ///< coordinates are small integers: every degeneracy there is, in exact form
  nudged,      ///< the same, some of them off by a few roundings
  in_plane,    ///< all corners in one plane all the time
  parallel,    ///< parallel edges, or triangles without area, at one time at least
  grazing,     ///< contact without normal velocity: a double root, or nearly
  at_a_border  ///< contact at a corner or an edge of a primitive
};

Vec3<double> lattice_point(Random& random, int reach) {
  const int x = random.below(2 * reach + 1), y = random.below(2 * reach + 1),
            z = random.below(2 * reach + 1);
  return {double(x - reach), double(y - reach), double(z - reach)};
}

/// Corners of two primitives that touch, or nearly, somewhere within, at an edge or at a corner.
void touching(Random& random, bool edges, bool border, Vec3<double> (&x)[4]) {
  for (auto& corner : x) corner = random.point();
  const auto weight = [&] {
    return border && random.below(3) ? random.below(2) : random.uniform(0, 1);
  };
  if (edges) {
    const double s = weight(), t = weight();
    const Vec3<double> shift = x[0] * (1 - s) + x[1] * s - x[2] * (1 - t) - x[3] * t;
    x[2] += shift;
    x[3] += shift;
  } else {
    double b1 = weight(), b2 = border ? 0 : weight();
    if (b1 + b2 > 1) b1 = 1 - b1, b2 = 1 - b2;
    x[0] = x[1] * (1 - b1 - b2) + x[2] * b1 + x[3] * b2;
  }
}

/// A contact that is planned for a random time, head-on or grazing.
Query<double> planned(Random& random, bool grazing, bool border) {
  Query<double> q;
  q.edges = random.below(2) != 0;
  Vec3<double> x[4];
  touching(random, q.edges, border, x);
  Vec3<double> n = q.edges ? cross(x[1] - x[0], x[3] - x[2]) : cross(x[2] - x[1], x[3] - x[1]);
  n *= 1 / length(n);
  const double t = random.below(4) == 0 ? random.below(2) : random.uniform(0, 1);
  const double speed = random.decade(-3, 2);
  for (int j = 0; j < 4; ++j) {
    Vec3<double> v = random.point(speed);
    if (grazing) v -= n * dot(v, n);
    q.x_t0[j] = x[j] - v * t;
    q.x_t1[j] = x[j] + v * (1 - t);
  }
  return q;
}

Query<double> lattice(Random& random) {
  Query<double> q;
  q.edges = random.below(2) != 0;
  const int reach = 1 + random.below(4);
  for (int j = 0; j < 4; ++j) {
    q.x_t0[j] = lattice_point(random, reach);
    q.x_t1[j] = random.below(3) ? lattice_point(random, reach) : q.x_t0[j];
  }
  return q;
}

/// One primitive's second edge is a multiple of its first, or of the other's, at both ends or at
/// one.
void make_parallel(Random& random, Query<double>& q) {
  const int k = random.below(5) - 2;
  const auto align = [&](Vec3<double>(&x)[4]) {
    if (q.edges)
      x[3] = x[2] + (x[1] - x[0]) * k;
    else
      x[3] = x[1] + (x[2] - x[1]) * k;
  };
  const int which = random.below(3);
  if (which != 1) align(q.x_t0);
  if (which != 0) align(q.x_t1);
}

/// All corners on an integer plane.
void flatten(Random& random, Query<double>& q) {
  const Vec3<double> a = lattice_point(random, 2), b = lattice_point(random, 2);
  for (int j = 0; j < 4; ++j) {
    q.x_t0[j] = a * q.x_t0[j][0] + b * q.x_t0[j][1];
    q.x_t1[j] = a * q.x_t1[j][0] + b * q.x_t1[j][1];
  }
}

void nudge(Random& random, Query<double>& q) {
  for (int n = 1 + random.below(3); n > 0; --n) {
    double& x = (random.below(2) ? q.x_t0 : q.x_t1)[random.below(4)][random.below(3)];
    for (int k = random.below(4); k >= 0; --k)
      x = std::nextafter(x, random.below(2) ? 1e30 : -1e30);
  }
}

/// @param exponent_max of the size as a power of two, so that it scales exactly
Query<double> hard_query(Random& random, Kind kind, int exponent_max) {
  Query<double> q = kind == Kind::grazing || kind == Kind::at_a_border
                        ? planned(random, kind == Kind::grazing, kind == Kind::at_a_border)
                        : lattice(random);
  if (kind == Kind::parallel) make_parallel(random, q);
  if (kind == Kind::in_plane) flatten(random, q);
  if (kind == Kind::nudged) nudge(random, q);
  // Far from the origin, where coordinates round; tiny and huge.
  if (random.below(4) == 0) {
    const Vec3<double> far = random.point(random.decade(0, 4));
    for (int j = 0; j < 4; ++j) {
      q.x_t0[j] += far;
      q.x_t1[j] += far;
    }
  }
  const int exponent = random.below(2) ? random.below(2 * exponent_max + 1) - exponent_max : 0;
  for (int j = 0; j < 4; ++j)
    for (int c = 0; c < 3; ++c) {
      q.x_t0[j][c] = std::ldexp(q.x_t0[j][c], exponent);
      q.x_t1[j][c] = std::ldexp(q.x_t1[j][c], exponent);
    }
  return q;
}

struct Tally {
  int contacts = 0, misses = 0, in_vain = 0;
};

/// Fails where a contact is missed or reported late.
template <class T>
void judge(const Query<double>& given, T input_error, Tally& tally) {
  Query<T> q;
  q.edges = given.edges;
  test::cast(given.x_t0, q.x_t0);
  test::cast(given.x_t1, q.x_t1);
  const std::optional<mpq_class> truth = input_error > T(0)
                                             ? test::first_contact(q.edges, given.x_t0, given.x_t1)
                                             : test::first_contact(q.edges, q.x_t0, q.x_t1);
  const Impact<T> impact = q.edges ? ccd_edge_edge(q.x_t0, q.x_t1, T(0), input_error)
                                   : ccd_vertex_triangle(q.x_t0, q.x_t1, T(0), input_error);
  ++(truth ? tally.contacts : tally.misses);
  if (!truth) {
    tally.in_vain += impact.hit;
    return;
  }
  ASSERT_TRUE(impact.hit) << "missed at " << truth->get_d();
  ASSERT_LE(mpq_class(static_cast<double>(impact.toi)), *truth) << "late";
}

struct Hard {
  Kind kind;
  std::string name;
  double in_vain;  ///< most of the misses that may be answered with a hit
};

class CcdExact : public testing::TestWithParam<Hard> {
 protected:
  template <class T>
  void run(std::uint64_t seed, int queries, int exponent_max) {
    Random random(seed);
    Tally tally;
    for (int i = 0; i < queries; ++i) {
      const Query<double> q = hard_query(random, GetParam().kind, exponent_max);
      ASSERT_NO_FATAL_FAILURE(judge<T>(q, T(0), tally)) << "query " << i;
      if (sizeof(T) == sizeof(double)) continue;
      // As floats that stand for the doubles they were rounded from.
      Vec3<T> x_t0[4], x_t1[4];
      test::cast(q.x_t0, x_t0);
      test::cast(q.x_t1, x_t1);
      Tally rounded;
      ASSERT_NO_FATAL_FAILURE(judge<T>(q, rounding_of_input(x_t0, x_t1), rounded)) << "query " << i;
    }
    RecordProperty("contacts", tally.contacts);
    RecordProperty("in_vain", tally.in_vain);
    EXPECT_GT(tally.contacts, queries / 50);
    EXPECT_LE(tally.in_vain, GetParam().in_vain * tally.misses);
  }
};

// Planned contacts stand within rounding of the truth, on either side.
INSTANTIATE_TEST_SUITE_P(
    , CcdExact,
    testing::Values(Hard{Kind::lattice, "lattice", 0.01}, Hard{Kind::nudged, "nudged", 0.05},
                    Hard{Kind::in_plane, "in_plane", 0.1}, Hard{Kind::parallel, "parallel", 0.01},
                    Hard{Kind::grazing, "grazing", 1}, Hard{Kind::at_a_border, "at_a_border", 1}),
    [](const auto& test) { return test.param.name; });

TEST_P(CcdExact, hundreds_in_double) {
  run<double>(55, 400, 300);
}

TEST_P(CcdExact, hundreds_in_float) {
  run<float>(56, 200, 30);
}

TEST_P(CcdExact, Slow_thousands_in_double) {
  run<double>(57, 20000, 300);
}

TEST_P(CcdExact, Slow_thousands_in_float) {
  run<float>(58, 10000, 30);
}

}  // namespace
}  // namespace weft
