#include "weft/elements/pressure.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "weft/shapes.hpp"

namespace weft {
namespace {

/// A closed surface that is neither round nor about the origin.
Mesh potato() {
  Mesh mesh = make_icosphere(1, 1);
  for (auto& p : mesh.positions) p = {1.3 * p[0] + 0.2 * p[1] * p[1] + 3, p[1] - p[2], 0.7 * p[2]};
  return mesh;
}

double volume(const Mesh& mesh) {
  double sum = 0;
  for (const Tri& t : mesh.triangles) {
    Vec3<double> x[3];
    for (int c = 0; c < 3; ++c) x[c] = mesh.positions[static_cast<std::size_t>(t.v[c])];
    sum += volume_below(x);
  }
  return sum;
}

std::vector<Vec3<double>> forces(const Mesh& mesh, double pressure) {
  std::vector<Vec3<double>> sum(mesh.positions.size(), Vec3<double>{0, 0, 0});
  for (const Tri& t : mesh.triangles) {
    Vec3<double> x[3];
    for (int c = 0; c < 3; ++c) x[c] = mesh.positions[static_cast<std::size_t>(t.v[c])];
    for (const Index v : t.v) sum[static_cast<std::size_t>(v)] += pressure_on_corner(x, pressure);
  }
  return sum;
}

TEST(Pressure, PushesAlongTheNormalOfATriangle) {
  const Vec3<double> x[3] = {{1, 1, 5}, {3, 1, 5}, {1, 4, 5}};
  const Vec3<double> f = pressure_on_corner(x, 7.0);  // 3 m^2 times 7 Pa over 3 corners
  EXPECT_EQ(0, f[0]);
  EXPECT_EQ(0, f[1]);
  EXPECT_NEAR(7, f[2], 1e-14);
}

TEST(Pressure, VolumeOfABox) {
  EXPECT_NEAR(0.5 * 0.7 * 1.1, volume(make_box({0.5, 0.7, 1.1}, {2, 3, 1})), 1e-14);
}

/// The surface flattened, on itself; as a needle; turned inside out; with its half pressed into the
/// other; at a point.
std::vector<Mesh> shapes() {
  std::vector<Mesh> all(6, potato());
  for (auto& p : all[1].positions) p[2] = 0;
  for (auto& p : all[2].positions) p = {p[0], 1e-9 * p[1], 1e-9 * p[2]};
  for (auto& p : all[3].positions) p[0] = -p[0];
  for (auto& p : all[4].positions) p[2] = std::abs(p[2]);
  for (auto& p : all[5].positions) p = {1, 2, 3};
  return all;
}

TEST(Pressure, IsTheGradientOfTheVolumeInside) {
  for (Mesh& mesh : shapes()) {
    const std::vector<Vec3<double>> f = forces(mesh, 2.5);
    const double eps = 1e-4;
    for (std::size_t v = 0; v < mesh.positions.size(); ++v)
      for (int k = 0; k < 3; ++k) {
        const double here = mesh.positions[v][k];
        mesh.positions[v][k] = here + eps;
        const double more = volume(mesh);
        mesh.positions[v][k] = here - eps;
        const double less = volume(mesh);
        mesh.positions[v][k] = here;
        // The volume is linear in each coordinate: the difference is exact but for rounding.
        EXPECT_NEAR(2.5 * (more - less) / (2 * eps), f[v][k], 1e-10) << v << " " << k;
      }
  }
}

/// Derivative of force v, axis a, by vertex w, axis b. Forces are linear in each coordinate.
double force_slope(Mesh mesh, std::size_t v, int a, std::size_t w, int b) {
  mesh.positions[w][b] += 0.5;
  const double more = forces(mesh, 1)[v][a];
  mesh.positions[w][b] -= 1;
  return more - forces(mesh, 1)[v][a];
}

/// What the matrix leaves out: the second derivatives of the volume. Vertices of a border are held.
TEST(Pressure, ItsJacobianIsSymmetricWithAnEmptyDiagonal) {
  Mesh open = potato();
  const Tri hole = open.triangles.back();
  open.triangles.pop_back();
  std::vector<Mesh> all = shapes();
  all.push_back(open);
  for (const Mesh& mesh : all) {
    const bool is_open = mesh.triangles.size() == open.triangles.size();
    const auto held = [&](std::size_t v) {
      return is_open && std::find(hole.v, hole.v + 3, static_cast<Index>(v)) != hole.v + 3;
    };
    for (std::size_t v = 0; v < 12; ++v)
      for (std::size_t w = 0; w < mesh.positions.size(); w += 1 + w / 12)
        for (int a = 0; a < 3; ++a)
          for (int b = 0; b < 3; ++b) {
            if (held(v) || held(w)) continue;
            const double slope = force_slope(mesh, v, a, w, b);
            EXPECT_NEAR(slope, force_slope(mesh, w, b, v, a), 1e-13);
            if (v == w) {
              EXPECT_NEAR(slope, 0, 1e-13);
            }
          }
  }
}

TEST(Pressure, OnAClosedSurfaceHasNeitherForceNorMoment) {
  const Mesh mesh = potato();
  const std::vector<Vec3<double>> f = forces(mesh, 100);
  Vec3<double> force{0, 0, 0}, moment{0, 0, 0};
  for (std::size_t v = 0; v < f.size(); ++v) {
    force += f[v];
    moment += cross(mesh.positions[v], f[v]);
  }
  EXPECT_LT(length(force), 1e-12);
  EXPECT_LT(length(moment), 1e-11);
}

TEST(Pressure, TurnsWithTheTriangle) {
  const Vec3<double> x[3] = {{0.1, 0, 0}, {1, 0.3, -0.2}, {-0.4, 0.8, 0.5}};
  const auto turned = [](const Vec3<double>& p) { return Vec3<double>{p[1], p[2], p[0]}; };
  const Vec3<double> y[3] = {turned(x[0]), turned(x[1]), turned(x[2])};
  EXPECT_LT(length(turned(pressure_on_corner(x, 3.0)) - pressure_on_corner(y, 3.0)), 1e-15);
}

}  // namespace
}  // namespace weft
