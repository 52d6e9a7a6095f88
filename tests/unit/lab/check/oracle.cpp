// The validator against brute force in rational arithmetic: points of intersection are constructed,
// where the validator only ever takes signs.
#include <CGAL/Exact_predicates_exact_constructions_kernel.h>
#include <CGAL/intersections.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <random>
#include <set>

#include "host/lab/check/triangle_pair.hpp"
#include "host/lab/check/validator.hpp"
#include "tests/unit/lab/check/soup.hpp"

namespace weft::lab::test {
namespace {

using Exact = CGAL::Exact_predicates_exact_constructions_kernel;
using Point = Exact::Point_3;
using Segment = Exact::Segment_3;
using Triangle = Exact::Triangle_3;

Point exact(const Vec3<double>& x) {
  return {x[0], x[1], x[2]};
}

/// Corner points of the intersections of all pieces of two triangles. A proper triangle is one
/// piece; the pieces of a flat one are its sides, and a side of no length is a point.
class Common {
 public:
  Common(const std::array<Point, 3>& s, const std::array<Point, 3>& t) {
    each_piece(s, [&](const auto& a) { each_piece(t, [&](const auto& b) { add(a, b); }); });
  }
  const std::vector<Point>& corners() const { return corners_; }

 private:
  template <class F>
  static void each_piece(const std::array<Point, 3>& t, F&& f) {
    if (!CGAL::collinear(t[0], t[1], t[2])) return f(Triangle(t[0], t[1], t[2]));
    for (std::size_t i = 0; i < 3; ++i) {
      const Point &p = t[i], &q = t[(i + 1) % 3];
      if (p == q)
        f(p);
      else
        f(Segment(p, q));
    }
  }
  template <class A, class B>
  void add(const A& a, const B& b) {
    if (const auto common = CGAL::intersection(a, b))
      boost::apply_visitor([this](const auto& part) { take(part); }, *common);
  }
  void add(const Point& a, const Point& b) {
    if (a == b) take(a);
  }
  void take(const Point& p) { corners_.push_back(p); }
  void take(const Segment& s) { corners_.insert(corners_.end(), {s[0], s[1]}); }
  void take(const Triangle& t) { corners_.insert(corners_.end(), {t[0], t[1], t[2]}); }
  void take(const std::vector<Point>& p) { corners_.insert(corners_.end(), p.begin(), p.end()); }

  std::vector<Point> corners_;
};

bool oracle(const Points& x, const Tri& s, const Tri& t) {
  std::set<Index> shared;
  const std::set<Index> others(t.v, t.v + 3);
  for (const Index i : s.v)
    if (others.contains(i)) shared.insert(i);
  if (shared.size() == 3) return true;
  const auto corners_of = [&](const Tri& r) {
    return std::array{exact(x[static_cast<std::size_t>(r.v[0])]),
                      exact(x[static_cast<std::size_t>(r.v[1])]),
                      exact(x[static_cast<std::size_t>(r.v[2])])};
  };
  const Common common(corners_of(s), corners_of(t));
  std::vector<Point> ends;
  for (const Index i : shared) ends.push_back(exact(x[static_cast<std::size_t>(i)]));
  const auto in_shared = [&](const Point& p) {
    if (ends.empty()) return false;
    if (ends.front() == ends.back()) return p == ends.front();
    return Segment(ends.front(), ends.back()).has_on(p);
  };
  for (const Point& p : common.corners())
    if (!in_shared(p)) return true;
  return false;
}

std::string print(const Points& x) {
  std::string text;
  char line[120];
  for (const auto& p : x) {
    std::snprintf(line, sizeof line, "{%a, %a, %a} ", p[0], p[1], p[2]);
    text += line;
  }
  return text;
}

/// Triangles on the points of a small lattice meet in every special way there is.
/// @param place maps a lattice point to the position that is tested
template <class Place>
void compare_on_lattice(int rounds, unsigned seed, Place&& place) {
  std::mt19937 random(seed);
  std::uniform_int_distribution<int> coordinate(0, 3);
  const Tri first{{0, 1, 2}};
  const Tri seconds[] = {{{3, 4, 5}}, {{0, 3, 4}}, {{3, 1, 0}}, {{0, 0, 3}}};
  int met = 0, total = 0;
  for (int round = 0; round < rounds; ++round) {
    Points x(6);
    for (auto& p : x)
      p = place(Vec3<double>{double(coordinate(random)), double(coordinate(random)),
                             double(coordinate(random))},
                random);
    for (const Tri& second : seconds) {
      const bool expected = oracle(x, first, second);
      ASSERT_EQ(intersect(x.data(), first, second), expected)
          << print(x) << second.v[0] << second.v[1] << second.v[2];
      ASSERT_EQ(intersect(x.data(), second, first), expected) << print(x);
      met += expected;
      ++total;
    }
  }
  // The comparison says something only where both answers are frequent.
  EXPECT_GT(met, total / 20);
  EXPECT_LT(met, total - total / 20);
}

TEST(ValidatorOracle, LatticePairs) {
  compare_on_lattice(4000, 1, [](const Vec3<double>& p, std::mt19937&) { return p; });
}

/// In one plane, and on one line: the coplanar and the degenerate branches.
TEST(ValidatorOracle, FlatLatticePairs) {
  compare_on_lattice(2000, 2, [](const Vec3<double>& p, std::mt19937&) {
    return Vec3<double>{p[0] - p[1], p[1], -p[0]};
  });
  compare_on_lattice(1000, 3, [](const Vec3<double>& p, std::mt19937&) {
    return Vec3<double>{p[0], 2 * p[0], -p[0]};
  });
}

/// Rotated by irrational numbers and rounded: everything that was exactly flat or touching is off
/// by less than a double can tell, where a wrong error bound would show.
TEST(ValidatorOracle, RoundedLatticePairs) {
  const auto rotate = [](const Vec3<double>& p, std::mt19937&) {
    const double a = std::sqrt(2.0), b = std::sqrt(3.0), c = std::sqrt(5.0);
    return Vec3<double>{7 + a * p[0] + b * p[1], c * p[0] - a * p[1], b * p[2] + 0.1 * p[0]};
  };
  compare_on_lattice(1000, 4, rotate);
  compare_on_lattice(1000, 5, [&](const Vec3<double>& p, std::mt19937& random) {
    return rotate({p[0], p[1], 0}, random);
  });
}

/// Single steps away from special positions.
TEST(ValidatorOracle, LatticePairsMovedByOneUlp) {
  const auto nudge = [](Vec3<double> p, std::mt19937& random) {
    for (double& c : p.e) {
      const unsigned way = random() % 4;
      if (way == 0) c = std::nextafter(c, 100.0);
      if (way == 1) c = std::nextafter(c, -100.0);
    }
    return p;
  };
  compare_on_lattice(1000, 6, nudge);
  compare_on_lattice(800, 7, [&](const Vec3<double>& p, std::mt19937& random) {
    return nudge({p[0] - p[1], p[1], -p[0]}, random);
  });
}

/// Far from the origin, tiny and huge: the filters must neither overflow nor trust lost bits.
TEST(ValidatorOracle, LatticePairsAtExtremeScales) {
  for (const double scale : {1e-308, 1e-200, 1e-70, 1e-59, 1e59, 1e70, 1e200, 1e307})
    compare_on_lattice(150, 8, [scale](const Vec3<double>& p, std::mt19937&) { return p * scale; });
  compare_on_lattice(500, 9, [](const Vec3<double>& p, std::mt19937&) {
    return Vec3<double>{1e6 + 1e-10 * p[0], 1e6 + 1e-10 * p[1], 1e6 + 1e-10 * p[2]};
  });
}

Mesh random_soup(int points, int triangles, double spread, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> place(0, 1), offset(-spread, spread);
  std::uniform_int_distribution<Index> any(0, points - 1);
  Mesh mesh;
  for (int i = 0; i < points; ++i)
    mesh.positions.push_back({place(random), place(random), place(random)});
  for (int i = 0; i < triangles; ++i) {
    // One corner from the common points, so that vertices and sometimes edges are shared.
    const Index v = any(random);
    Tri t{{v, 0, 0}};
    for (int k = 1; k < 3; ++k) {
      const Vec3<double> c = mesh.positions[static_cast<std::size_t>(v)];
      t.v[k] = static_cast<Index>(mesh.positions.size());
      mesh.positions.push_back(
          {c[0] + offset(random), c[1] + offset(random), c[2] + offset(random)});
    }
    mesh.triangles.push_back(t);
    if (i % 3 == 0) {
      mesh.triangles.push_back({{t.v[2], t.v[1], any(random)}});
      mesh.triangles.push_back({{t.v[0], any(random), t.v[2]}});
    }
  }
  return mesh;
}

TEST(ValidatorOracle, RandomMeshAgainstBruteForce) {
  const Mesh mesh = random_soup(40, 80, 0.3, 10);
  std::vector<TrianglePair> expected;
  for (std::size_t a = 0; a < mesh.triangles.size(); ++a)
    for (std::size_t b = a + 1; b < mesh.triangles.size(); ++b)
      if (oracle(mesh.positions, mesh.triangles[a], mesh.triangles[b]))
        expected.push_back({PairKind::cloth_cloth, static_cast<Index>(a), static_cast<Index>(b)});
  ASSERT_GT(expected.size(), 20u);
  ValidatorOptions options;
  options.list_limit = 100000;
  const FrameVerdict verdict = validate(mesh, nullptr, options);
  EXPECT_EQ(verdict.pairs, expected);
  EXPECT_EQ(verdict.cloth_cloth_count, static_cast<std::int64_t>(expected.size()));
}

TEST(ValidatorOracle, BroadPhaseMissesNothing) {
  const Mesh cloth = random_soup(500, 700, 0.08, 11);
  const Mesh obstacle = random_soup(100, 200, 0.15, 12);
  std::vector<TrianglePair> expected;
  for (std::size_t a = 0; a < cloth.triangles.size(); ++a)
    for (std::size_t b = a + 1; b < cloth.triangles.size(); ++b)
      if (intersect(cloth.positions.data(), cloth.triangles[a], cloth.triangles[b]))
        expected.push_back({PairKind::cloth_cloth, static_cast<Index>(a), static_cast<Index>(b)});
  const auto corners_of = [](const Mesh& m, std::size_t i) {
    const Tri& t = m.triangles[i];
    return Corners{m.positions[static_cast<std::size_t>(t.v[0])],
                   m.positions[static_cast<std::size_t>(t.v[1])],
                   m.positions[static_cast<std::size_t>(t.v[2])]};
  };
  for (std::size_t a = 0; a < cloth.triangles.size(); ++a)
    for (std::size_t b = 0; b < obstacle.triangles.size(); ++b)
      if (triangles_meet(corners_of(cloth, a), corners_of(obstacle, b)))
        expected.push_back(
            {PairKind::cloth_obstacle, static_cast<Index>(a), static_cast<Index>(b)});
  ASSERT_GT(expected.size(), 1000u);
  for (const int threads : {1, 2, 5}) {
    ValidatorOptions options;
    options.list_limit = expected.size();
    options.threads = threads;
    const FrameVerdict verdict = validate(cloth, &obstacle, options);
    EXPECT_EQ(verdict.pairs, expected) << threads;
    EXPECT_EQ(verdict.cloth_cloth_count + verdict.cloth_obstacle_count,
              static_cast<std::int64_t>(expected.size()));
  }
}

TEST(ValidatorOracle, SeparatedSheetsAreCleanInAnyRotation) {
  std::mt19937 random(13);
  std::normal_distribution<double> normal;
  for (int round = 0; round < 10; ++round) {
    Vec3<double> x{normal(random), normal(random), normal(random)};
    x *= 1 / length(x);
    Vec3<double> y = cross(x, Vec3<double>{normal(random), normal(random), normal(random)});
    y *= 1 / length(y);
    const Vec3<double> z = cross(x, y);
    const auto layer = [&](double height, double wave) {
      return sheet(12, [&](double u, double v) {
        return x * u + y * v + z * (height + wave * std::sin(9 * u));
      });
    };
    Mesh cloth = layer(0, 0);
    append(cloth, layer(0.01, 0));
    append(cloth, layer(0.2, 0.05));
    const Mesh obstacle = layer(-0.01, 0);
    const FrameVerdict verdict = validate(cloth, &obstacle);
    EXPECT_TRUE(verdict.clean());
    append(cloth, sheet(12, [&](double u, double v) { return x * u + z * (v - 0.1) + y * 0.501; }));
    EXPECT_GT(validate(cloth, nullptr).cloth_cloth_count, 12);
  }
}

}  // namespace
}  // namespace weft::lab::test
