#include "host/model/surface_tables.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "tests/support/small_scenes.hpp"
#include "weft/elements/normal_cone.hpp"
#include "weft/shapes.hpp"

namespace weft {
namespace {

TEST(SurfaceTables, SayWhatTheTrianglesSay) {
  const Model model = make_model(test::two_sheets(Precision::double_precision));
  const SurfaceTables tables = make_surface_tables(model);
  std::vector<std::set<Index>> ring(model.positions.size());
  for (std::size_t t = 0; t < model.triangles.size(); ++t) {
    const Tri& face = model.triangles[t];
    for (int k = 0; k < 3; ++k) {
      const Index a = face.v[(k + 1) % 3];
      const Index b = face.v[(k + 2) % 3];
      ring[static_cast<std::size_t>(a)].insert(b);
      ring[static_cast<std::size_t>(b)].insert(a);
      const auto e = static_cast<std::size_t>(tables.edges_of_face[t].v[k]);
      EXPECT_EQ(model.edges[e].v[0], std::min(a, b));
      EXPECT_EQ(model.edges[e].v[1], std::max(a, b));
      const EdgeWings& wings = tables.wings[e];
      EXPECT_TRUE(wings.v[0] == face.v[k] || wings.v[1] == face.v[k]);
      EXPECT_LE(wings.first_face, static_cast<Index>(t));
      EXPECT_LE(tables.face_of_vertex[static_cast<std::size_t>(face.v[k])], static_cast<Index>(t));
    }
  }
  for (std::size_t v = 0; v < ring.size(); ++v) {
    const auto first = tables.ring.begin() + tables.ring_offset[v];
    const auto last = tables.ring.begin() + tables.ring_offset[v + 1];
    EXPECT_TRUE(std::equal(first, last, ring[v].begin(), ring[v].end())) << "vertex " << v;
  }
}

/// Two triangles that meet in a ridge or a valley along the y axis: what is above lies in the
/// edge's cone on the ridge only, and on the flat.
TEST(SurfaceTables, NormalConesTellRidgesFromValleys) {
  for (const double height : {-0.2, 0.0, 0.2}) {
    Scene scene;
    scene.materials.push_back(test::cotton());
    Cloth cloth;
    cloth.mesh.positions = {{0, 0, height}, {0, 1, height}, {1, 0.5, 0}, {-1, 0.5, 0}};
    cloth.mesh.triangles = {{{0, 2, 1}}, {{0, 1, 3}}};
    cloth.mesh.material = {{0, 0}, {0, 1}, {1, 0.5}, {-1, 0.5}};
    scene.cloths.push_back(cloth);
    const Model model = make_model(scene);
    const SurfaceTables tables = make_surface_tables(model);
    const Span<const Vec3<double>> positions(model.positions);
    const Vec3<double> up{0, 0, 1};
    for (std::size_t e = 0; e < tables.wings.size(); ++e)
      if (tables.wings[e].v[1] >= 0) {
        EXPECT_EQ(in_edge_cone(model.edges[e], tables.wings[e].v, positions, up, 1e-6),
                  height >= 0);
        EXPECT_EQ(in_edge_cone(model.edges[e], tables.wings[e].v, positions, -up, 1e-6),
                  height <= 0);
      }
    for (Index v = 0; v < 4; ++v) {
      const bool on_ridge = std::abs(positions[static_cast<std::size_t>(v)][0]) < 0.5;
      const Offset* offset = &tables.ring_offset[static_cast<std::size_t>(v)];
      const Span<const Index> ring(tables.ring.data() + offset[0],
                                   static_cast<std::size_t>(offset[1] - offset[0]));
      EXPECT_EQ(in_vertex_cone(ring, positions, v, up, 1e-6), on_ridge ? height >= 0 : height <= 0);
    }
  }
}

}  // namespace
}  // namespace weft
