#include "host/scene/procedural.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <numbers>
#include <utility>

#include "host/scene/mesh_check.hpp"

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
