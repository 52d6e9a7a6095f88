#include "host/model/plate.hpp"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <numeric>
#include <random>
#include <utility>
#include <vector>

#include "weft/core/at.hpp"
#include "weft/shapes.hpp"

namespace weft {
namespace {

enum class Kind { alternating, same, shifted, shuffled, slender };

/// A rectangle of `width` by 1, moved inside; `shuffled` has no two triangles alike.
Mesh plate(double width, int cells, Kind kind) {
  const Diagonals diagonals = kind == Kind::same ? Diagonals::same : Diagonals::alternating;
  const Index nx = static_cast<Index>(std::lround(width * cells));
  Mesh mesh = make_grid({width, 1}, {kind == Kind::slender ? nx / 4 : nx, cells}, diagonals);
  std::mt19937_64 engine(3);
  const double amount = kind == Kind::shifted ? 0.2 : kind == Kind::shuffled ? 0.3 : 0;
  for (auto& p : mesh.material) {
    const bool side = std::abs(std::abs(p[0]) - width / 2) < 1e-9;
    const bool end = std::abs(std::abs(p[1]) - 0.5) < 1e-9;
    for (int c = 0; c < 2; ++c) {
      const double r = static_cast<double>(engine() >> 11) * 0x1p-53 * 2 - 1;
      if (!side && !end) p[c] += amount * r / cells;
    }
  }
  return mesh;
}

/// A plate whose first row of cells is clamped, up to a straight line.
struct Clamped {
  Mesh mesh;
  double clamp;  ///< where that line is along u
  double row;    ///< width of the clamped row
};

Clamped clamped_plate(double length, int cells, Kind kind) {
  const double row = (kind == Kind::slender ? 4.0 : 1.0) / cells;
  const double width = length + row;
  Clamped result{plate(width, cells, kind), -width / 2 + row, row};
  for (auto& p : result.mesh.material)
    if (std::abs(p[0] - result.clamp) < 0.5 * row) p[0] = result.clamp;
  return result;
}

std::vector<Eigen::Index> free_vertices(const Clamped& c) {
  std::vector<Eigen::Index> free;
  for (std::size_t v = 0; v < c.mesh.material.size(); ++v)
    if (c.mesh.material[v][0] > c.clamp + 1e-9) free.push_back(static_cast<Eigen::Index>(v));
  return free;
}

/// Area of the plate that belongs to each vertex.
std::vector<double> vertex_areas(const Mesh& mesh) {
  std::vector<double> areas(mesh.material.size(), 0);
  for (const Tri& t : mesh.triangles) {
    const auto a = mesh.material[at(t.v[1])] - mesh.material[at(t.v[0])];
    const auto b = mesh.material[at(t.v[2])] - mesh.material[at(t.v[0])];
    for (const Index v : t.v) areas[at(v)] += (a[0] * b[1] - a[1] * b[0]) / 6;
  }
  return areas;
}

Mat3<double> isotropic(double nu) {
  return {{1, nu, 0, nu, 1, 0, 0, 0, 2 * (1 - nu)}};
}

/// @param clamp triangles up to there along u are held
PlateMatrix matrix_of(const Mesh& mesh, const Mat3<double>& rigidity, double damping = 0,
                      double clamp = -1e9) {
  std::vector<PlateTriangle> triangles;
  for (const Tri& t : mesh.triangles) {
    PlateTriangle p{t, {}, &rigidity, damping, true};
    for (std::size_t j = 0; j < 3; ++j) {
      p.rest[j] = mesh.material[at(t.v[j])];
      p.held = p.held && p.rest[j][0] < clamp + 1e-9;
    }
    triangles.push_back(p);
  }
  return make_plate_matrix(static_cast<Index>(mesh.material.size()), triangles);
}

Eigen::MatrixXd dense(const PlateMatrix& m) {
  const auto n = static_cast<Eigen::Index>(m.row_offset.size() - 1);
  Eigen::MatrixXd k = Eigen::MatrixXd::Zero(n, n);
  for (Eigen::Index i = 0; i < n; ++i)
    for (Offset e = m.row_offset[static_cast<std::size_t>(i)];
         e < m.row_offset[static_cast<std::size_t>(i) + 1]; ++e)
      k(i, m.column[static_cast<std::size_t>(e)]) = m.stiffness[static_cast<std::size_t>(e)];
  return k;
}

double energy_of(const Mesh& mesh, double nu, Vec3<double> (*shape)(const Vec2<double>&)) {
  std::vector<Vec3<double>> x;
  for (const auto& p : mesh.material) x.push_back(shape(p));
  return plate_energy(matrix_of(mesh, isotropic(nu)), x);
}

class PlateOnMeshes : public testing::TestWithParam<Kind> {};

TEST_P(PlateOnMeshes, OfAQuadraticIsExact) {
  const Mesh mesh = plate(1, 8, GetParam());
  // z = a u^2 + b u v + c v^2 has second derivatives 2a, 2c, b everywhere.
  const double nu = 0.3;
  const double expected = 0.5 * (std::pow(0.7 + 1.1, 2) - 2 * (1 - nu) * (0.7 * 1.1 - 0.4 * 0.4));
  EXPECT_NEAR(expected,
              energy_of(mesh, nu,
                        [](const Vec2<double>& p) {
                          return Vec3<double>{
                              p[0], p[1],
                              0.35 * p[0] * p[0] + 0.4 * p[0] * p[1] + 0.55 * p[1] * p[1]};
                        }),
              1e-10);
}

TEST_P(PlateOnMeshes, RigidMotionIsFreeAndNothingElseIs) {
  const PlateMatrix matrix = matrix_of(plate(1, 8, GetParam()), isotropic(0.35));
  const Eigen::MatrixXd k = dense(matrix);
  EXPECT_EQ(0, (k - k.transpose()).cwiseAbs().maxCoeff());
  const Eigen::VectorXd values = k.selfadjointView<Eigen::Lower>().eigenvalues();
  const double top = values[values.size() - 1];
  for (int i = 0; i < 3; ++i) EXPECT_NEAR(0, values[i], 1e-11 * top);
  EXPECT_GT(values[3], 1e-7 * top);
}

/// Leissa's frequencies of a cantilevered square plate, in sqrt(D / rho) / a^2.
TEST_P(PlateOnMeshes, CantileverHasItsFrequencies) {
  const Clamped c = clamped_plate(1, GetParam() == Kind::slender ? 64 : 16, GetParam());
  const Eigen::MatrixXd k = dense(matrix_of(c.mesh, isotropic(0.3), 0, c.clamp));
  const std::vector<double> mass = vertex_areas(c.mesh);
  const std::vector<Eigen::Index> free = free_vertices(c);
  Eigen::VectorXd scale(static_cast<Eigen::Index>(free.size()));
  for (std::size_t i = 0; i < free.size(); ++i)
    scale[static_cast<Eigen::Index>(i)] = 1 / std::sqrt(mass[static_cast<std::size_t>(free[i])]);
  const Eigen::MatrixXd reduced = scale.asDiagonal() * k(free, free) * scale.asDiagonal();
  const Eigen::VectorXd values = reduced.selfadjointView<Eigen::Lower>().eigenvalues();
  const double expected[3] = {3.4711, 8.5067, 21.285};
  for (int m = 0; m < 3; ++m)
    EXPECT_NEAR(1, std::sqrt(values[m]) / expected[m], 0.02) << "mode " << m;
}

/// Flat up to a clamp and of one curvature behind it.
TEST_P(PlateOnMeshes, PastAClampAQuadraticIsExact) {
  const Clamped c = clamped_plate(2, 8, GetParam());
  const PlateMatrix matrix = matrix_of(c.mesh, isotropic(0.3), 0, c.clamp);
  std::vector<Vec3<double>> x;
  for (const auto& p : c.mesh.material) {
    const double u = std::max(0.0, p[0] - c.clamp);
    x.push_back({p[0], p[1], 0.6 * u * u});
  }
  EXPECT_NEAR(0.5 * 1.2 * 1.2 * 2, plate_energy(matrix, x), 1e-10);
  const Eigen::VectorXd values = dense(matrix).selfadjointView<Eigen::Lower>().eigenvalues();
  EXPECT_GT(values[0], -1e-11 * values[values.size() - 1]);
}

/// A cantilever's tip under an even load q against q L^4 / (8 D): the error falls with the square
/// of the cell.
TEST_P(PlateOnMeshes, ClampConvergesToSecondOrder) {
  double errors[2];
  for (const int refined : {0, 1}) {
    const Clamped c = clamped_plate(4, 4 << refined, GetParam());
    const Eigen::MatrixXd k = dense(matrix_of(c.mesh, isotropic(0), 0, c.clamp));
    const std::vector<double> areas = vertex_areas(c.mesh);
    const std::vector<Eigen::Index> free = free_vertices(c);
    Eigen::VectorXd load(static_cast<Eigen::Index>(free.size()));
    Eigen::VectorXd at_tip(load.size());
    for (Eigen::Index i = 0; i < load.size(); ++i) {
      const auto v = static_cast<std::size_t>(free[static_cast<std::size_t>(i)]);
      load[i] = areas[v];
      at_tip[i] = c.mesh.material[v][0] > c.clamp + 4 - 1e-9 ? 1 : 0;
    }
    const Eigen::VectorXd w = Eigen::MatrixXd(k(free, free)).ldlt().solve(load);
    errors[refined] = w.dot(at_tip) / at_tip.sum() / (256.0 / 8) - 1;
  }
  EXPECT_LT(std::abs(errors[0]), 0.06) << errors[1];
  EXPECT_LT(std::abs(errors[1]), 0.35 * std::abs(errors[0])) << errors[0] << ' ' << errors[1];
}

TEST_P(PlateOnMeshes, HalfCylinderHasItsEnergy) {
  const Mesh mesh = plate(2, 24, GetParam());
  const double radius = 2 / std::numbers::pi;
  const double energy = energy_of(mesh, 0.3, [](const Vec2<double>& p) {
    const double r = 2 / std::numbers::pi;
    return Vec3<double>{r * std::sin(p[0] / r), p[1], r * std::cos(p[0] / r)};
  });
  EXPECT_NEAR(1, energy / (2 / (2 * radius * radius)), 0.02);
}

INSTANTIATE_TEST_SUITE_P(Meshes, PlateOnMeshes,
                         testing::Values(Kind::alternating, Kind::same, Kind::shifted,
                                         Kind::shuffled, Kind::slender));

TEST(Plate, MeshesOfFewTrianglesBend) {
  for (const std::size_t count : {1u, 2u, 3u}) {
    Mesh mesh;
    mesh.material = {{0, 0}, {1, 0}, {1, 1}, {0, 1}, {-0.5, 0.5}};
    mesh.triangles = {{{0, 1, 2}}, {{0, 2, 3}}, {{0, 3, 4}}};
    mesh.triangles.resize(count);
    mesh.material.resize(count + 2);
    const Eigen::MatrixXd k = dense(matrix_of(mesh, isotropic(0.3)));
    const Eigen::VectorXd values = k.selfadjointView<Eigen::Lower>().eigenvalues();
    EXPECT_GT(values[0], -1e-12);
    EXPECT_EQ(count > 1, values[values.size() - 1] > 0.1);
  }
}

TEST(Plate, RoundingDecidesNothingWhereAllPointsLieOnTwoLines) {
  // Two lines are a conic, so that the points around a triangle of a ladder fix no quadratic.
  const auto ladder = [](double noise) {
    Mesh mesh = make_grid({2, 0.2}, {10, 1}, Diagonals::alternating);
    for (std::size_t v = 0; v < mesh.material.size(); ++v)
      mesh.material[v][1] += noise * std::sin(7.0 * static_cast<double>(v));
    return dense(matrix_of(mesh, isotropic(0.3)));
  };
  const Eigen::MatrixXd exact = ladder(0);
  const double scale = exact.cwiseAbs().maxCoeff();
  for (const double noise : {1e-15, 1e-12, 1e-9, 1e-7})
    EXPECT_LT((ladder(noise) - exact).cwiseAbs().maxCoeff(), 1e3 * (noise + 1e-15) * scale)
        << noise;
}

/// The hem of a disc: a row of many points on the circle, one of few further in.
Mesh hem(int fine, int coarse) {
  Mesh mesh;
  const auto add = [&](double radius, double angle) {
    mesh.material.push_back({radius * std::cos(angle), radius * std::sin(angle)});
    return static_cast<Index>(mesh.material.size()) - 1;
  };
  const double span = 1;
  std::vector<Index> outer, inner;
  for (int i = 0; i <= fine; ++i) outer.push_back(add(1, span * i / fine));
  for (int i = 0; i <= coarse; ++i) inner.push_back(add(0.85, span * i / coarse));
  for (int i = 0, k = 0; i < fine || k < coarse;)
    if (k == coarse || (i < fine && (i + 1) * coarse <= (2 * k + 1) * fine / 2)) {
      mesh.triangles.push_back({{outer[at(i)], outer[at(i + 1)], inner[at(k)]}});
      ++i;
    } else {
      mesh.triangles.push_back({{inner[at(k)], outer[at(i)], inner[at(k + 1)]}});
      ++k;
    }
  return mesh;
}

TEST(Plate, AHemOnACircleIsNotStifferThanItsFreeEdge) {
  // Points on a circle are on a conic: what bends across it cannot be read off from them, and must
  // not be read off from how little the circle is bent.
  const Mesh mesh = hem(40, 5);
  std::vector<Vec3<double>> x;
  for (const auto& p : mesh.material) x.push_back({p[0], p[1], 0});
  const PlateMatrix matrix = matrix_of(mesh, isotropic(0.3));
  // Lifting a point by h bends the two hem triangles at it by h / height, over their length.
  const double h = 1e-3, along = 1.0 / 40, height = 0.15;
  const double kink = std::pow(2 * h / along, 2) * height / along;
  for (std::size_t v = 5; v < 36; ++v) {
    x[v][2] = h;
    EXPECT_LT(plate_energy(matrix, x), 50 * kink) << v;
    EXPECT_GT(plate_energy(matrix, x), 0.02 * kink) << v;
    x[v][2] = 0;
  }
}

TEST(Plate, EnergyOfAllTrianglesIsThatOfTheMatrix) {
  for (const Kind kind : {Kind::shuffled, Kind::slender}) {
    const Clamped c = clamped_plate(2, 8, kind);
    const Mat3<double> rigidity = isotropic(0.3);
    std::vector<PlateTriangle> triangles;
    for (const Tri& t : c.mesh.triangles) {
      PlateTriangle p{t, {}, &rigidity, 0, true};
      for (std::size_t j = 0; j < 3; ++j) {
        p.rest[j] = c.mesh.material[at(t.v[j])];
        p.held = p.held && p.rest[j][0] < c.clamp + 1e-9;
      }
      triangles.push_back(p);
    }
    std::vector<Vec3<double>> x;
    for (const auto& p : c.mesh.material)
      x.push_back({p[0], p[1] + 0.1 * p[0] * p[1], 0.1 * std::sin(5 * p[0] + 3 * p[1])});
    const double whole = plate_energy(matrix_of(c.mesh, isotropic(0.3), 0, c.clamp), x);
    EXPECT_NEAR(plate_energy(triangles, triangles.size(), x), whole, 1e-11 * whole);
  }
}

/// With vertices numbered at random, nearly all triangles and edges belong to rows of several
/// blocks.
TEST(Plate, LargePlatesAreAddedUpWholeInBlocksOfRows) {
  const Mesh mesh = plate(2, 48, Kind::shuffled);
  const auto count = static_cast<Index>(mesh.material.size());
  std::vector<Index> number(mesh.material.size());
  std::iota(number.begin(), number.end(), 0);
  std::shuffle(number.begin(), number.end(), std::mt19937_64(1));
  const Mat3<double> rigidity = isotropic(0.3);
  std::vector<PlateTriangle> triangles;
  for (const Tri& t : mesh.triangles) {
    PlateTriangle p{t, {}, &rigidity, 0};
    for (std::size_t j = 0; j < 3; ++j) {
      p.rest[j] = mesh.material[at(t.v[j])];
      p.v.v[j] = number[at(t.v[j])];
    }
    triangles.push_back(p);
  }
  std::vector<Vec3<double>> x(mesh.material.size());
  for (std::size_t v = 0; v < x.size(); ++v) {
    const auto& u = mesh.material[v];
    x[at(number[v])] = {u[0], u[1], 0.1 * std::sin(5 * u[0] + 3 * u[1])};
  }
  const PlateMatrix m = make_plate_matrix(count, triangles);
  const double energy = plate_energy(triangles, triangles.size(), x);
  EXPECT_NEAR(plate_energy(m, x), energy, 1e-11 * energy);
  std::map<std::pair<Index, Index>, double> entries;
  for (Index i = 0; i < count; ++i)
    for (Offset e = m.row_offset[at(i)]; e < m.row_offset[at(i) + 1]; ++e) {
      const auto place = static_cast<std::size_t>(e);
      if (e > m.row_offset[at(i)]) {
        EXPECT_LT(m.column[place - 1], m.column[place]);
      }
      entries[{i, m.column[place]}] = m.stiffness[place];
    }
  for (const auto& [place, stiffness] : entries) {
    const auto mirrored = entries.find({place.second, place.first});
    ASSERT_NE(mirrored, entries.end());
    EXPECT_EQ(mirrored->second, stiffness);
  }
}

/// A pocket on a plate: at its outline the plate goes on, and the pocket ends.
TEST(Plate, WhereThreeTrianglesMeetThoseOfOnePieceBend) {
  const Mesh mesh = plate(1, 6, Kind::shifted);
  const Mat3<double> rigidity = isotropic(0.3);
  std::vector<PlateTriangle> below, pocket;
  for (const Tri& t : mesh.triangles) {
    PlateTriangle p{t, {}, &rigidity, 0};
    bool inside = true;
    for (std::size_t j = 0; j < 3; ++j) {
      p.rest[j] = mesh.material[at(t.v[j])];
      inside = inside && std::abs(p.rest[j][0]) < 0.36 && std::abs(p.rest[j][1]) < 0.36;
    }
    p.source = t;
    below.push_back(p);
    if (!inside) continue;
    // Its inner vertices are its own; those of its outline have been welded to the plate.
    for (Index& v : p.v.v) {
      const auto& u = mesh.material[at(v)];
      if (std::abs(u[0]) < 0.3 && std::abs(u[1]) < 0.3) v += 1000;
    }
    for (Index& v : p.source.v) v += 1000;
    pocket.push_back(p);
  }
  ASSERT_GT(pocket.size(), 8u);
  ASSERT_LT(pocket.size(), below.size());
  std::vector<Vec3<double>> x(1000 + mesh.material.size());
  for (std::size_t v = 0; v < mesh.material.size(); ++v) {
    const auto& u = mesh.material[v];
    x[v] = {u[0], u[1], 0.1 * u[0] * u[0]};
    x[1000 + v] = {u[0], u[1], 0.02 + 0.05 * u[1] * u[1]};
  }
  std::vector<PlateTriangle> both = below;
  both.insert(both.end(), pocket.begin(), pocket.end());
  const auto energy = [&](const std::vector<PlateTriangle>& triangles) {
    return plate_energy(make_plate_matrix(static_cast<Index>(x.size()), triangles), x);
  };
  EXPECT_NEAR(energy(both), energy(below) + energy(pocket), 1e-12 * energy(both));
  EXPECT_GT(energy(below), 0.019);
}

TEST(Plate, PiecesThatMeetInASeamAreOnePlate) {
  const Mesh mesh = plate(1, 6, Kind::shifted);
  const PlateMatrix whole = matrix_of(mesh, isotropic(0.3));
  const Mat3<double> rigidity = isotropic(0.3);
  std::vector<PlateTriangle> triangles;
  for (const Tri& t : mesh.triangles) {
    PlateTriangle p{t, {}, &rigidity, 0};
    double middle = 0;
    for (const Index v : t.v) middle += mesh.material[at(v)][0] / 3;
    for (std::size_t j = 0; j < 3; ++j) {
      const auto& m = mesh.material[at(t.v[j])];
      // One half of the pattern lies elsewhere, turned.
      p.rest[j] =
          middle < 0 ? m : Vec2<double>{3 - 0.6 * m[0] - 0.8 * m[1], 0.8 * m[0] - 0.6 * m[1]};
    }
    triangles.push_back(p);
  }
  const PlateMatrix sewn = make_plate_matrix(static_cast<Index>(mesh.material.size()), triangles);
  EXPECT_LT((dense(whole) - dense(sewn)).cwiseAbs().maxCoeff(),
            1e-10 * dense(whole).cwiseAbs().maxCoeff());
}

TEST(Plate, DampingGoesWithTheStiffness) {
  const PlateMatrix m = matrix_of(plate(1, 4, Kind::shifted), isotropic(0.2), 0.25);
  for (std::size_t e = 0; e < m.column.size(); ++e)
    EXPECT_NEAR(0.25 * m.stiffness[e], m.damping[e], 1e-12 * std::abs(m.stiffness[e]) + 1e-14);
}

}  // namespace
}  // namespace weft
