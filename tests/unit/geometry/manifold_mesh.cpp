#include "host/geometry/manifold_mesh.hpp"

#include <gtest/gtest.h>

#include "host/geometry/mesh_check.hpp"
#include "weft/error.hpp"
#include "weft/shapes.hpp"

namespace weft {
namespace {

Mesh mesh_of(const Mesh& old, const ManifoldMesh& manifold) {
  Mesh mesh;
  for (const Index v : manifold.source)
    mesh.positions.push_back(old.positions[static_cast<std::size_t>(v)]);
  mesh.triangles = manifold.triangles;
  return mesh;
}

TEST(MakeManifold, LeavesAGoodMeshAlone) {
  const Mesh mesh = make_icosphere(1, 2);
  const ManifoldMesh manifold = make_manifold(mesh.positions, mesh.triangles);
  EXPECT_EQ(manifold.dropped, 0u);
  EXPECT_EQ(manifold.detached, 0u);
  EXPECT_EQ(manifold.source.size(), mesh.positions.size());
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    for (int k = 0; k < 3; ++k)
      EXPECT_EQ(manifold.source[static_cast<std::size_t>(manifold.triangles[t].v[k])],
                mesh.triangles[t].v[k]);
}

TEST(MakeManifold, MakesEverythingThatIsRefusedAcceptable) {
  Mesh mesh;
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {2, 0, 0}, {9, 9, 9}};
  mesh.triangles = {{{0, 1, 2}},   // good
                    {{1, 0, 3}},   // its neighbour
                    {{0, 1, 4}},   // a third at the edge
                    {{1, 2, 0}},   // the first again
                    {{0, 1, 5}},   // on a line
                    {{2, 2, 4}},   // a corner twice
                    {{3, 4, 0}}};  // 3-0 runs like the second, and is oriented against it
  EXPECT_THROW(check_mesh(mesh, {"", "mesh", ""}, false), SceneError);
  const ManifoldMesh manifold = make_manifold(mesh.positions, mesh.triangles);
  EXPECT_EQ(manifold.dropped, 3u);
  EXPECT_EQ(manifold.triangles.size(), 4u);
  EXPECT_EQ(manifold.detached, 2u);
  const Mesh result = mesh_of(mesh, manifold);
  EXPECT_NO_THROW(check_mesh(result, {"", "mesh", ""}, false));
  for (const Vec3<double>& x : result.positions) EXPECT_LT(x[0], 9);  // the isolated one is gone
  // Nothing has moved: each kept triangle has the corners it had.
  const std::array<std::size_t, 4> kept{0, 1, 2, 6};
  for (std::size_t t = 0; t < 4; ++t)
    for (int k = 0; k < 3; ++k)
      EXPECT_EQ(manifold.source[static_cast<std::size_t>(manifold.triangles[t].v[k])],
                mesh.triangles[kept[t]].v[k]);
}

TEST(MakeManifold, DetachesATriangleOfTheWrongOrientation) {
  Mesh mesh;
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}};
  mesh.triangles = {{{0, 1, 2}}, {{1, 2, 3}}};
  EXPECT_THROW(check_mesh(mesh, {"", "mesh", ""}, false), SceneError);
  const ManifoldMesh manifold = make_manifold(mesh.positions, mesh.triangles);
  EXPECT_EQ(manifold.detached, 1u);
  EXPECT_EQ(manifold.source.size(), 6u);
  EXPECT_NO_THROW(check_mesh(mesh_of(mesh, manifold), {"", "mesh", ""}, false));
}

}  // namespace
}  // namespace weft
