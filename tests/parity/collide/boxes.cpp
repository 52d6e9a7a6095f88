#include "weft/kernels/collide/boxes.hpp"
#include "host/exec/host_devices.hpp"

#include "tests/parity/collide/scene.hpp"

namespace weft::parity {
namespace {

template <class T>
class CollideBoxesParity : public testing::Test {
 protected:
  SweptMesh mesh_ = folded_scene(30);

  /// Makes boxes of a first motion, of another one in which the obstacle rests, and of one in which
  /// a part of it moves. Returns the boxes after each.
  /// @param split_motion [m] see CollideBoxes
  std::vector<Outputs> make(Device& device, std::vector<float>& mean_extent,
                            T split_motion = std::numeric_limits<T>::infinity()) const {
    BoxBuffers<T> boxes(device, mesh_);
    boxes.args.margin = T(0.001);
    boxes.args.margin_at_rest = T(0.004);
    boxes.args.change_time = T(0.002);
    boxes.args.change_max = T(0.003);
    boxes.args.inertial_time = T(0.005);
    boxes.args.reach = T(0.0005);
    boxes.args.split_motion = split_motion;
    std::vector<Outputs> all;
    SweptMesh mesh = mesh_;
    const auto cloth = static_cast<std::size_t>(mesh.counts.cloth_vertices);
    for (int step = 0; step < 4; ++step) {
      boxes.args.make_obstacles = step == 0;
      boxes.run();
      all.push_back(boxes.outputs());
      for (std::size_t v = 0; v < mesh.positions_t0.size(); ++v) {
        mesh.positions_t0[v] = mesh.positions_t1[v];
        if (v < cloth) mesh.positions_t1[v][2] -= step == 2 ? 0.0001 : 0.01;
      }
      if (step == 1) mesh.positions_t1.back()[2] -= 0.5;
      boxes.move(mesh.positions_t0, mesh.positions_t1);
    }
    mean_extent = boxes.mean_extent();
    return all;
  }
};

using Precisions = testing::Types<float, double>;
TYPED_TEST_SUITE(CollideBoxesParity, Precisions);

TYPED_TEST(CollideBoxesParity, HostsBoxesHoldTheirCorners) {
  const DeviceSet devices = host_devices(1, {.poison = true});
  BoxBuffers<TypeParam> boxes(devices[0], this->mesh_);
  boxes.run();
  const SweptMesh& mesh = this->mesh_;
  const bool exact = std::is_same_v<TypeParam, double>;
  for (int kind = 0; kind < cluster_kinds; ++kind) {
    const ClusterList<TypeParam>& list = boxes.args.lists[kind];
    const auto clusters = boxes.clusters(kind);
    const auto hulls = boxes.hulls(kind);
    for (Index n = 0; n < list.count; ++n) {
      const auto i = static_cast<std::size_t>(list.first + n);
      std::vector<Index> corners{static_cast<Index>(i)};
      if (kind / 2 == 1) corners.assign(mesh.triangles[i].v, mesh.triangles[i].v + 3);
      if (kind / 2 == 2) corners.assign(mesh.edges[i].v, mesh.edges[i].v + 2);
      const auto box =
          lane_of<TypeParam>(clusters[static_cast<std::size_t>(n / 8)], n % cluster_size);
      const Box& around = hulls[static_cast<std::size_t>(n / 64)];
      for (int c = 0; c < 3; ++c) {
        double lo = 1e300, hi = -1e300;
        for (const Index v : corners)
          for (const auto* x : {&mesh.positions_t0, &mesh.positions_t1}) {
            lo = std::min(lo, (*x)[static_cast<std::size_t>(v)][c]);
            hi = std::max(hi, (*x)[static_cast<std::size_t>(v)][c]);
          }
        ASSERT_TRUE(exact ? box.lo[c] == lo && box.hi[c] == hi : box.lo[c] <= lo && box.hi[c] >= hi)
            << "kind " << kind << ", number " << n;
        ASSERT_LE(around.lo[c], lo);
        ASSERT_GE(around.hi[c], hi);
      }
    }
  }
}

TYPED_TEST(CollideBoxesParity, CudaGivesTheHostsBits) {
  std::string why;
  const std::optional<DeviceSet> cuda = find_cuda({0}, why);
  if (!cuda) GTEST_SKIP() << why;
  const DeviceSet host = host_devices(1);
  std::vector<float> means, reference_means;
  const std::vector<Outputs> found = this->make((*cuda)[0], means);
  const std::vector<Outputs> reference = this->make(host[0], reference_means);
  for (std::size_t step = 0; step < found.size(); ++step) {
    SCOPED_TRACE("step " + std::to_string(step));
    expect_same_bits(found[step], reference[step]);
  }
  // made: at first, and in the two steps that an obstacle's vertex leaves and comes to rest in.
  const auto made = [&](std::size_t step) { return found[step][1].values[0]; };
  EXPECT_EQ(made(0), 1);
  EXPECT_EQ(made(1), 0);
  EXPECT_EQ(made(2), 1);
  EXPECT_EQ(made(3), 1);
  for (std::size_t kind = 0; kind < cluster_kinds; ++kind)
    EXPECT_NEAR(means[kind], reference_means[kind], 1e-6f * reference_means[kind]);
}

/// Split are the motions of all steps but the last, in which nothing moves far.
TYPED_TEST(CollideBoxesParity, CudaGivesTheHostsBitsOfSplitMotions) {
  std::string why;
  const std::optional<DeviceSet> cuda = find_cuda({0}, why);
  if (!cuda) GTEST_SKIP() << why;
  const DeviceSet host = host_devices(1);
  std::vector<float> means, reference_means;
  const std::vector<Outputs> found = this->make((*cuda)[0], means, TypeParam(0.002));
  const std::vector<Outputs> reference = this->make(host[0], reference_means, TypeParam(0.002));
  for (std::size_t step = 0; step < found.size(); ++step) {
    SCOPED_TRACE("step " + std::to_string(step));
    expect_same_bits(found[step], reference[step]);
    EXPECT_EQ(found[step][2].values[0], step == 2 ? 1 : 0);  // an obstacle's vertex moves
    EXPECT_EQ(found[step][3].values[0], step < 3 ? 1 : 0);
  }
}

TYPED_TEST(CollideBoxesParity, CudaGivesTheSameBitsTwice) {
  std::string why;
  const std::optional<DeviceSet> cuda = find_cuda({0}, why);
  if (!cuda) GTEST_SKIP() << why;
  std::vector<float> once, twice;
  this->make((*cuda)[0], once);
  this->make((*cuda)[0], twice);
  EXPECT_EQ(once, twice);
}

}  // namespace
}  // namespace weft::parity
