#include "host/geometry/outline.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "host/geometry/mesh_check.hpp"
#include "weft/shapes.hpp"

/// Meshes made from an outline.
namespace weft {
namespace {

void expect_sound(const Mesh& mesh, bool cloth) {
  EXPECT_NO_THROW(check_mesh(mesh, {"", "mesh", ""}, cloth));
}

double area_of(const Mesh& mesh) {
  double area = 0;
  for (const Tri& t : mesh.triangles) {
    const auto& a = mesh.positions[static_cast<std::size_t>(t.v[0])];
    const auto& b = mesh.positions[static_cast<std::size_t>(t.v[1])];
    const auto& c = mesh.positions[static_cast<std::size_t>(t.v[2])];
    area += length(cross(b - a, c - a)) / 2;
  }
  return area;
}

/// Volume that a closed surface holds, positive if its front is outside.
double volume_of(const Mesh& mesh) {
  double volume = 0;
  for (const Tri& t : mesh.triangles)
    volume += dot(mesh.positions[static_cast<std::size_t>(t.v[0])],
                  cross(mesh.positions[static_cast<std::size_t>(t.v[1])],
                        mesh.positions[static_cast<std::size_t>(t.v[2])])) /
              6;
  return volume;
}

const std::vector<PanelWidth> dress{{0, -0.4, 0.4}, {0.5, -0.25, 0.3}, {0.6, -0.2, 0.1}};

TEST(Panel, KeepsToItsOutline) {
  const Mesh mesh = make_panel(dress, {4, 9});
  expect_sound(mesh, true);
  ASSERT_EQ(mesh.positions.size(), 5u * 10u);
  EXPECT_NEAR(area_of(mesh), panel_area(dress), 1e-15);
  EXPECT_NEAR(panel_area(dress), 0.5 * (0.8 + 0.55) / 2 + 0.1 * (0.55 + 0.3) / 2, 1e-15);
  // 9 rows over heights of 0.5 and 0.1: 7.5 of them, rounded, belong to the first.
  const auto at = [&](Index i, Index j) {
    return mesh.positions[static_cast<std::size_t>(grid_vertex(4, i, j))];
  };
  EXPECT_NEAR(length(at(0, 8) - Vec3<double>{-0.25, 0.5, 0}), 0, 1e-15);
  EXPECT_NEAR(length(at(4, 8) - Vec3<double>{0.3, 0.5, 0}), 0, 1e-15);
  EXPECT_NEAR(length(at(2, 8) - Vec3<double>{0.025, 0.5, 0}), 0, 1e-15);
  EXPECT_NEAR(length(at(0, 4) - Vec3<double>{-0.325, 0.25, 0}), 0, 1e-15);
  EXPECT_NEAR(length(at(4, 9) - Vec3<double>{0.1, 0.6, 0}), 0, 1e-15);
  for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
    EXPECT_EQ(mesh.material[v][0], mesh.positions[v][0]);
    EXPECT_EQ(mesh.material[v][1], mesh.positions[v][1]);
  }
}

TEST(Panel, EveryHeightHasARowHoweverFewThereAre) {
  const std::vector<PanelWidth> steep{{0, -1, 1}, {0.01, -1, 1}, {0.02, -1, 1}, {1, -1, 1}};
  const Mesh mesh = make_panel(steep, {1, 3});
  expect_sound(mesh, true);
  for (std::size_t k = 0; k < 4; ++k) EXPECT_EQ(mesh.positions[2 * k][1], steep[k].height);
}

TEST(Annulus, RingsFromTheHole) {
  for (const Index rings : {1, 4, 11}) {
    const Mesh mesh = make_annulus(0.1, 0.5, rings);
    expect_sound(mesh, true);
    const auto start = static_cast<double>(annulus_start(0.1, 0.5, rings));
    const double outer = start + rings;
    EXPECT_EQ(static_cast<double>(mesh.triangles.size()), 6 * (outer * outer - start * start));
    for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
      const double radius = length(mesh.positions[v]);
      if (static_cast<double>(v) < 6 * start) {
        EXPECT_NEAR(radius, 0.1, 1e-15);
      }
      if (static_cast<double>(v) >= static_cast<double>(mesh.positions.size()) - 6 * outer) {
        EXPECT_NEAR(radius, 0.5, 1e-15);
      }
    }
  }
  EXPECT_NEAR(area_of(make_annulus(0.1, 0.5, 60)), std::numbers::pi * 0.24, 3e-4);
}

TEST(RevolutionMesh, RingIsClosedWithItsFrontOutside) {
  // A ring of square section, in both directions.
  Revolution ring{{{0.3, 0}, {0.4, 0}, {0.4, 0.1}, {0.3, 0.1}}, true};
  const double exact = std::numbers::pi * (0.16 - 0.09) * 0.1;
  for (int turn = 0; turn < 2; ++turn) {
    const Mesh mesh = make_revolution(ring, 120, 0.03);
    expect_sound(mesh, false);
    EXPECT_NEAR(volume_of(mesh), exact, 0.002 * exact);
    EXPECT_EQ(static_cast<double>(mesh.triangles.size()), revolution_triangles(ring, 120, 0.03));
    EXPECT_EQ(mesh.triangles.size(), 2 * mesh.positions.size());  // a torus
    std::reverse(ring.profile.begin(), ring.profile.end());
  }
}

TEST(RevolutionMesh, PolesAtItsEnds) {
  const Revolution cone{{{0, -0.5}, {0.2, 0}, {0, 0.5}}, false};
  const Mesh mesh = make_revolution(cone, 60, 10);
  expect_sound(mesh, false);
  EXPECT_EQ(mesh.positions.size(), 62u);
  EXPECT_EQ(mesh.triangles.size(), 120u);
  EXPECT_NEAR(volume_of(mesh), std::numbers::pi * 0.04 / 3, 1e-4);
}

TEST(RevolutionMesh, WhatCannotBeRevolved) {
  EXPECT_FALSE(can_revolve({{{1, 0}}, false}));
  EXPECT_FALSE(can_revolve({{{1, 0}, {1, 1}}, true}));
  EXPECT_FALSE(can_revolve({{{1, 0}, {1, 0}}, false}));
  EXPECT_FALSE(can_revolve({{{1, 0}, {0, 1}, {1, 2}}, false}));
  EXPECT_FALSE(can_revolve({{{0, 0}, {1, 1}, {1, 2}}, true}));
  EXPECT_FALSE(can_revolve({{{0, 0}, {0, 1}}, false}));
  EXPECT_TRUE(can_revolve({{{0, 0}, {1, 1}}, false}));
}

}  // namespace
}  // namespace weft
