#include "weft/shapes.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <utility>

#include "host/geometry/mesh_check.hpp"

namespace weft {
namespace {

const Vec3<double>& corner(const Mesh& mesh, const Tri& tri, int k) {
  return mesh.positions[static_cast<std::size_t>(tri.v[k])];
}

double area(const Mesh& mesh) {
  double sum = 0;
  for (const Tri& t : mesh.triangles)
    sum += length(cross(corner(mesh, t, 1) - corner(mesh, t, 0),
                        corner(mesh, t, 2) - corner(mesh, t, 0))) /
           2;
  return sum;
}

/// Signed volume; positive if the front is outside.
double volume(const Mesh& mesh) {
  double sum = 0;
  for (const Tri& t : mesh.triangles)
    sum += dot(corner(mesh, t, 0), cross(corner(mesh, t, 1), corner(mesh, t, 2))) / 6;
  return sum;
}

/// How many directed edges have no twin that runs the other way. Independent of mesh_check.
std::size_t open_edges(const Mesh& mesh) {
  std::map<std::pair<Index, Index>, int> runs;
  for (const Tri& t : mesh.triangles)
    for (int k = 0; k < 3; ++k) ++runs[{t.v[k], t.v[(k + 1) % 3]}];
  std::size_t open = 0;
  for (const auto& [edge, count] : runs) {
    EXPECT_EQ(count, 1) << "edge " << edge.first << "-" << edge.second;
    if (!runs.contains({edge.second, edge.first})) ++open;
  }
  return open;
}

TEST(Grid, HasTheAreaAndFacesUp) {
  for (const Diagonals diagonals : {Diagonals::alternating, Diagonals::same}) {
    const Mesh mesh = make_grid({2, 0.5}, {7, 3}, diagonals);
    EXPECT_EQ(mesh.positions.size(), 8u * 4u);
    EXPECT_EQ(mesh.triangles.size(), 2u * 7u * 3u);
    EXPECT_NEAR(area(mesh), 1.0, 1e-14);
    EXPECT_EQ(open_edges(mesh), 2u * (7u + 3u));
    EXPECT_NO_THROW(check_mesh(mesh, {"", "grid", ""}, true));
    for (const Tri& t : mesh.triangles)
      EXPECT_GT(cross(corner(mesh, t, 1) - corner(mesh, t, 0),
                      corner(mesh, t, 2) - corner(mesh, t, 0))[2],
                0);
  }
}

TEST(Grid, IsCentredWithMaterialLikeItself) {
  const Mesh mesh = make_grid({1, 3}, {3, 7}, Diagonals::alternating);
  Vec3<double> sum{};
  for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
    sum += mesh.positions[v];
    EXPECT_EQ(mesh.material[v][0], mesh.positions[v][0]);
    EXPECT_EQ(mesh.material[v][1], mesh.positions[v][1]);
  }
  EXPECT_NEAR(length(sum), 0, 1e-14);
  const Vec3<double> low = mesh.positions[static_cast<std::size_t>(grid_vertex(3, 0, 0))];
  const Vec3<double> high = mesh.positions[static_cast<std::size_t>(grid_vertex(3, 3, 7))];
  EXPECT_EQ(low[0], -0.5);
  EXPECT_EQ(low[1], -1.5);
  EXPECT_EQ(high[0], 0.5);
  EXPECT_EQ(high[1], 1.5);
}

TEST(Grid, DiagonalsDiffer) {
  const Mesh alternating = make_grid({1, 1}, {2, 1}, Diagonals::alternating);
  const Mesh same = make_grid({1, 1}, {2, 1}, Diagonals::same);
  // the second cell has corners 1, 2, 5, 4
  EXPECT_EQ(same.triangles[2].v[2], 5);
  EXPECT_EQ(alternating.triangles[2].v[2], 4);
}

TEST(Icosphere, IsClosedAndFacesOutwards) {
  for (int s = 0; s <= 4; ++s) {
    const Mesh mesh = make_icosphere(0.5, s);
    EXPECT_EQ(mesh.triangles.size(), 20u << (2 * s));
    EXPECT_EQ(mesh.positions.size(), (10u << (2 * s)) + 2u);
    EXPECT_EQ(open_edges(mesh), 0u);
    EXPECT_NO_THROW(check_mesh(mesh, {"", "sphere", ""}, false));
    for (const Vec3<double>& x : mesh.positions) EXPECT_NEAR(length(x), 0.5, 1e-15);
    for (const Tri& t : mesh.triangles) {
      const Vec3<double> normal =
          cross(corner(mesh, t, 1) - corner(mesh, t, 0), corner(mesh, t, 2) - corner(mesh, t, 0));
      EXPECT_GT(dot(normal, corner(mesh, t, 0)), 0);
    }
  }
  const double ball = 4.0 / 3.0 * std::numbers::pi;
  EXPECT_NEAR(volume(make_icosphere(1, 5)), ball, 2e-3 * ball);
  EXPECT_LT(volume(make_icosphere(1, 5)), ball);
}

TEST(Icosphere, EdgeEstimateIsClose) {
  for (int s = 0; s <= 5; ++s) {
    const Mesh mesh = make_icosphere(1, s);
    double sum = 0;
    for (const Tri& t : mesh.triangles)
      for (int k = 0; k < 3; ++k) sum += length(corner(mesh, t, (k + 1) % 3) - corner(mesh, t, k));
    const double mean = sum / (3 * static_cast<double>(mesh.triangles.size()));
    EXPECT_NEAR(icosphere_edge(s), mean, 0.05 * mean) << s << " subdivisions";
  }
}

/// Smallest angle of all triangles. [degrees]
double smallest_angle(const Mesh& mesh) {
  double least = 180;
  for (const Tri& t : mesh.triangles)
    for (int k = 0; k < 3; ++k) {
      const Vec3<double> a = corner(mesh, t, (k + 1) % 3) - corner(mesh, t, k);
      const Vec3<double> b = corner(mesh, t, (k + 2) % 3) - corner(mesh, t, k);
      least =
          std::min(least, std::atan2(length(cross(a, b)), dot(a, b)) * (180 / std::numbers::pi));
    }
  return least;
}

/// Distance from the segment of a capsule's axis.
double distance_from_axis(const Vec3<double>& x, double half) {
  return length(x - Vec3<double>{0, 0, std::clamp(x[2], -half, half)});
}

TEST(Capsule, IsClosedAndFacesOutwards) {
  for (const double tube : {0.0, 0.01, 0.3, 2.0})
    for (const Index rings : {1, 2, 5, 16}) {
      const Mesh mesh = make_capsule(0.25, tube, rings);
      EXPECT_EQ(static_cast<double>(mesh.triangles.size()), capsule_triangles(0.25, tube, rings));
      EXPECT_EQ(open_edges(mesh), 0u);
      EXPECT_EQ(mesh.positions.size() * 2, mesh.triangles.size() + 4);  // Euler: one sphere
      EXPECT_NO_THROW(check_mesh(mesh, {"", "capsule", ""}, false));
      for (const Tri& t : mesh.triangles) {
        const Vec3<double> normal =
            cross(corner(mesh, t, 1) - corner(mesh, t, 0), corner(mesh, t, 2) - corner(mesh, t, 0));
        const Vec3<double> centre =
            (corner(mesh, t, 0) + corner(mesh, t, 1) + corner(mesh, t, 2)) * (1.0 / 3);
        EXPECT_GT(dot(normal, centre), 0) << tube << " " << rings;
      }
    }
}

TEST(Capsule, LiesOnTheSurface) {
  const Mesh mesh = make_capsule(0.1, 0.7, 8);
  for (const Vec3<double>& x : mesh.positions) EXPECT_NEAR(distance_from_axis(x, 0.35), 0.1, 1e-15);
  const double exact = std::numbers::pi * 0.01 * (0.7 + 4.0 / 3.0 * 0.1);
  EXPECT_LT(volume(mesh), exact);
  // Chords of 40 around lose 1 - sinc(2 pi / 40) = 0.4 % of the area across; arcs from pole to
  // pole about half as much again.
  EXPECT_GT(volume(mesh), 0.99 * exact);
}

TEST(Capsule, HasWellShapedTriangles) {
  for (const Index rings : {2, 4, 16})
    for (const double tube : {0.5, 1.0, 5.0}) {
      EXPECT_GT(smallest_angle(make_capsule(0.2, tube, rings)), 35) << rings << " " << tube;
    }
}

TEST(Disc, HasTheAreaOfItsPolygonsAndFacesUp) {
  for (const Index rings : {1, 2, 10}) {
    const Mesh mesh = make_disc(0.5, rings);
    EXPECT_EQ(mesh.triangles.size(), 6u * static_cast<std::size_t>(rings * rings));
    EXPECT_EQ(open_edges(mesh), 6u * static_cast<std::size_t>(rings));
    EXPECT_NO_THROW(check_mesh(mesh, {"", "disc", ""}, true));
    const double sides = 6.0 * rings;
    EXPECT_NEAR(area(mesh), 0.125 * sides * std::sin(2 * std::numbers::pi / sides), 1e-14);
    for (const Tri& t : mesh.triangles)
      EXPECT_GT(cross(corner(mesh, t, 1) - corner(mesh, t, 0),
                      corner(mesh, t, 2) - corner(mesh, t, 0))[2],
                0);
    for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
      EXPECT_EQ(mesh.material[v][0], mesh.positions[v][0]);
      EXPECT_EQ(mesh.material[v][1], mesh.positions[v][1]);
    }
  }
  EXPECT_GT(smallest_angle(make_disc(1, 12)), 44);
}

TEST(Tube, StartsWithoutStrainAndFacesOutwards) {
  const Mesh mesh = make_tube(0.3, 0.8, {11, 4});
  EXPECT_EQ(mesh.positions.size(), 11u * 5u);
  EXPECT_EQ(mesh.material.size(), 12u * 5u);
  EXPECT_EQ(mesh.triangles.size(), 2u * 11u * 4u);
  ASSERT_EQ(mesh.material_triangles.size(), mesh.triangles.size());
  EXPECT_EQ(open_edges(mesh), 2u * 11u);
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const Tri& tri = mesh.triangles[t];
    const Vec3<double> normal = cross(corner(mesh, tri, 1) - corner(mesh, tri, 0),
                                      corner(mesh, tri, 2) - corner(mesh, tri, 0));
    const Vec3<double> at = corner(mesh, tri, 0) + corner(mesh, tri, 1) + corner(mesh, tri, 2);
    EXPECT_GT(normal[0] * at[0] + normal[1] * at[1], 0);
    double turned = 0;
    for (int k = 0; k < 3; ++k) {
      const auto u = [&](int c) {
        return mesh.material[static_cast<std::size_t>(mesh.material_triangles[t].v[c % 3])];
      };
      EXPECT_NEAR(length(u(k + 1) - u(k)),
                  length(corner(mesh, tri, (k + 1) % 3) - corner(mesh, tri, k)), 1e-15);
      turned += u(k)[0] * u(k + 1)[1] - u(k)[1] * u(k + 1)[0];
    }
    EXPECT_GT(turned, 0);
  }
}

TEST(Box, IsClosedAndFacesOutwards) {
  const Mesh mesh = make_box({1, 2, 3}, {2, 3, 4});
  EXPECT_EQ(mesh.triangles.size(), 4u * (2 * 3 + 3 * 4 + 4 * 2));
  EXPECT_EQ(open_edges(mesh), 0u);
  EXPECT_NEAR(area(mesh), 2 * (2 + 6 + 3), 1e-13);
  EXPECT_NEAR(volume(mesh), 6, 1e-13);
  EXPECT_NO_THROW(check_mesh(mesh, {"", "box", ""}, false));
  EXPECT_EQ(make_box({1, 1, 1}, {1, 1, 1}).positions.size(), 8u);
}

}  // namespace
}  // namespace weft
