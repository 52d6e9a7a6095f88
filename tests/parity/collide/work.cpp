#include "weft/kernels/collide/work.hpp"
#include "host/exec/host_devices.hpp"

#include <bit>

#include "tests/parity/collide/scene.hpp"

namespace weft::parity {
namespace {

struct Tables {
  std::vector<Offset> face, edge;
};

/// Tables of the folded scene. The cells' sizes are given, because mean extents may differ in their
/// last bit between backends.
template <class T>
class CollideWorkParity : public testing::Test {
 protected:
  SweptMesh mesh_ = folded_scene(40);

  Tables count(Device& device, bool self, CollideWork<T>* used = nullptr,
               std::vector<Box>* hulls = nullptr) const {
    BoxBuffers<T> boxes(device, mesh_);
    boxes.args.reach = T(0.0005);
    boxes.run();
    std::vector<GridBuffers> grids;
    CollideWork<T> args;
    for (int kind = 0; kind < cluster_kinds; ++kind) {
      args.lists[kind] = boxes.args.lists[kind];
      const std::vector<Box> all = boxes.hulls(kind);
      if (hulls != nullptr) hulls[kind] = all;
      if (kind < cloth_faces) continue;
      grids.emplace_back(device, all, std::vector<float>{0.2f, 0.1f},
                         std::bit_ceil(4 * all.size() + 16));
      grids.back().run();
      args.grids[kind] = grids.back().view();
    }
    const auto groups = [&](int kind) {
      return static_cast<std::size_t>(args.lists[kind].group_count());
    };
    const Buffer<Offset> face(device, groups(cloth_vertices) + groups(obstacle_vertices) + 1);
    const Buffer<Offset> edge(device, groups(cloth_edges) + 1);
    args.self = self;
    args.face_work = face.span();
    args.edge_work = edge.span();
    launch(device.compute(), args);
    Tables tables{download(face), download(edge)};
    if (used != nullptr) *used = args;
    return tables;
  }
};

using Precisions = testing::Types<float, double>;
TYPED_TEST_SUITE(CollideWorkParity, Precisions);

/// Whatever stands in cells that a hull covers counts, hence at least the groups that it meets.
TYPED_TEST(CollideWorkParity, HostCountsNoLessThanMeets) {
  const DeviceSet devices = host_devices(1, {.poison = true});
  CollideWork<TypeParam> args;
  std::vector<Box> hulls[cluster_kinds];
  const Tables tables = this->count(devices[0], true, &args, hulls);
  const auto meeting = [&](ClusterKind kind, const Box& box, std::size_t lowest) {
    Offset count = 0;
    for (std::size_t i = lowest; i < hulls[kind].size(); ++i)
      count += boxes_meet(box, hulls[kind][i]) ? 1 : 0;
    return count;
  };
  EXPECT_EQ(tables.edge.front(), 0);
  for (std::size_t g = 0; g < hulls[cloth_edges].size(); ++g)
    EXPECT_GE(tables.edge[g + 1] - tables.edge[g],
              1 + meeting(cloth_edges, hulls[cloth_edges][g], g) +
                  meeting(obstacle_edges, hulls[cloth_edges][g], 0));
  const std::size_t cloth = hulls[cloth_vertices].size();
  for (std::size_t g = 0; g < cloth; ++g)
    EXPECT_GE(tables.face[g + 1] - tables.face[g],
              1 + meeting(cloth_faces, hulls[cloth_vertices][g], 0) +
                  meeting(obstacle_faces, hulls[cloth_vertices][g], 0));
  for (std::size_t g = 0; g < hulls[obstacle_vertices].size(); ++g)
    EXPECT_GE(tables.face[cloth + g + 1] - tables.face[cloth + g],
              1 + meeting(cloth_faces, hulls[obstacle_vertices][g], 0));
  const Tables apart = this->count(devices[0], false);
  EXPECT_LT(apart.edge.back(), tables.edge.back());
}

TYPED_TEST(CollideWorkParity, CudaGivesTheHostsTables) {
  std::string why;
  const std::optional<DeviceSet> cuda = find_cuda({0}, why);
  if (!cuda) GTEST_SKIP() << why;
  const DeviceSet host = host_devices(1);
  for (const bool self : {true, false}) {
    const Tables found = this->count((*cuda)[0], self);
    const Tables reference = this->count(host[0], self);
    EXPECT_EQ(found.face, reference.face);
    EXPECT_EQ(found.edge, reference.edge);
  }
}

}  // namespace
}  // namespace weft::parity
