#include "weft/kernels/collide/candidate_update.hpp"

#include <set>

#include "tests/parity/collide/scene.hpp"

namespace weft::parity {
namespace {

/// Boxes of folded cloth, of which some vertices then end elsewhere, twice.
template <class T>
class CollideStraysParity : public testing::Test {
 protected:
  SweptMesh mesh_ = folded_scene(40);

  struct Found {
    std::set<std::pair<Index, Index>> face, edge;
    Index strays = 0, touched = 0, obstacles = 0;
    Outputs boxes;
  };

  /// @param vertices of the mesh that end elsewhere in each of two rounds
  std::vector<Found> find(Device& device, bool split, bool self,
                          const std::vector<Index>& vertices) const {
    BoxBuffers<T> boxes(device, mesh_);
    boxes.args.margin = boxes.args.margin_at_rest = T(0.002);
    boxes.args.change_time = T(0.001);
    boxes.args.inertial_time = T(0.001);
    boxes.args.reach = T(0.0005);
    boxes.args.split_motion = split ? T(0) : std::numeric_limits<T>::infinity();
    boxes.run();
    Buffer<Index> stray_of(device, mesh_.positions_t0.size());
    Buffer<Stray<T>> strays(device, 40);
    Buffer<TouchedPrimitive> touched(device, 1000);
    Buffer<Pair> faces(device, 20000), edges(device, 20000);
    Buffer<StrayCounts> counts(device, 1);
    std::vector<Found> all;
    Random random(35);
    std::vector<Vec3<double>> ends = mesh_.positions_t1;
    for (int round = 0; round < 2; ++round) {
      for (const Index v : vertices)
        ends[static_cast<std::size_t>(v + round)] += random.vector<double>(-0.05, 0.05);
      boxes.move(mesh_.positions_t0, ends);
      launch(device.compute(),
             CollideStrays<T>{boxes.args, self, true, stray_of.span(), strays.span(),
                              touched.span(), faces.span(), edges.span(), counts.span()});
      const StrayCounts found = download(counts).front();
      all.push_back({pairs(faces, found.face_pairs), pairs(edges, found.edge_pairs), found.strays,
                     found.touched, found.obstacles, boxes.outputs()});
    }
    return all;
  }

  static std::set<std::pair<Index, Index>> pairs(const Buffer<Pair>& buffer, Index count) {
    std::vector<Pair> list = download(buffer);
    EXPECT_LE(static_cast<std::size_t>(count), list.size());
    list.resize(static_cast<std::size_t>(count));
    std::set<std::pair<Index, Index>> found;
    for (const Pair& p : list) found.emplace(p.a, p.b);
    return found;
  }

  static void expect_same(const std::vector<Found>& found, const std::vector<Found>& reference) {
    ASSERT_EQ(found.size(), reference.size());
    for (std::size_t k = 0; k < found.size(); ++k) {
      SCOPED_TRACE("round " + std::to_string(k));
      EXPECT_EQ(found[k].face, reference[k].face);
      EXPECT_EQ(found[k].edge, reference[k].edge);
      EXPECT_EQ(found[k].strays, reference[k].strays);
      EXPECT_EQ(found[k].touched, reference[k].touched);
      EXPECT_EQ(found[k].obstacles, reference[k].obstacles);
      expect_same_bits(found[k].boxes, reference[k].boxes);
    }
  }
};

using Precisions = testing::Types<float, double>;
TYPED_TEST_SUITE(CollideStraysParity, Precisions);

/// The host's are held against all with all in tests/unit/collide/candidate_update.cpp.
TYPED_TEST(CollideStraysParity, CudaFindsTheHostsPairsAndBoxes) {
  std::string why;
  const std::optional<DeviceSet> cuda = find_cuda({0}, why);
  if (!cuda) GTEST_SKIP() << why;
  const DeviceSet host = host_devices(1);
  const std::vector<Index> vertices{3, 200, 777, 778, 1200, 1500};
  for (const bool split : {false, true})
    for (const bool self : {true, false}) {
      const auto reference = this->find(host[0], split, self, vertices);
      EXPECT_GT(reference[1].face.size(), self ? 100u : 0u);
      EXPECT_GT(reference[1].edge.size(), self ? 100u : 0u);
      this->expect_same(this->find((*cuda)[0], split, self, vertices), reference);
    }
}

TYPED_TEST(CollideStraysParity, CudaLeavesTooManyAndObstaclesAlone) {
  std::string why;
  const std::optional<DeviceSet> cuda = find_cuda({0}, why);
  if (!cuda) GTEST_SKIP() << why;
  const DeviceSet host = host_devices(1);
  std::vector<Index> many;
  for (Index v = 0; v < 100; ++v) many.push_back(10 * v);
  const std::vector<Index> of_obstacle{this->mesh_.counts.cloth_vertices + 5};
  for (const auto& vertices : {many, of_obstacle}) {
    const auto reference = this->find(host[0], true, true, vertices);
    EXPECT_TRUE(reference[0].face.empty());
    EXPECT_EQ(reference[0].touched, 0);
    this->expect_same(this->find((*cuda)[0], true, true, vertices), reference);
  }
}

}  // namespace
}  // namespace weft::parity
