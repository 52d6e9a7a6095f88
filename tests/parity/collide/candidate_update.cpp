#include "weft/kernels/collide/candidate_update.hpp"

#include <set>

#include "tests/parity/collide/scene.hpp"

namespace weft::parity {
namespace {

/// Boxes of folded cloth, of which some vertices then end elsewhere, twice.
template <class T>
class CollideCandidateUpdateParity : public testing::Test {
 protected:
  SweptMesh mesh_ = folded_scene(40);

  struct Found {
    std::set<std::pair<Index, Index>> face, edge;
    Index out_of_bounds = 0, dirty = 0, obstacles = 0;
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
    Buffer<Index> out_of_bounds_index(device, mesh_.positions_t0.size());
    Buffer<OutOfBoundsVertex<T>> out_of_bounds(device, 40);
    Buffer<DirtyPrimitive> dirty(device, 1000);
    Buffer<Pair> faces(device, 20000), edges(device, 20000);
    Buffer<CandidateUpdateCounts> counts(device, 1);
    std::vector<Found> all;
    Random random(35);
    std::vector<Vec3<double>> ends = mesh_.positions_t1;
    for (int round = 0; round < 2; ++round) {
      for (const Index v : vertices)
        ends[static_cast<std::size_t>(v + round)] += random.vector<double>(-0.05, 0.05);
      boxes.move(mesh_.positions_t0, ends);
      launch(device.compute(),
             CollideCandidateUpdate<T>{boxes.args, self, true, out_of_bounds_index.span(),
                                       out_of_bounds.span(), dirty.span(), faces.span(),
                                       edges.span(), counts.span()});
      const CandidateUpdateCounts found = download(counts).front();
      all.push_back({pairs(faces, found.face_pairs), pairs(edges, found.edge_pairs),
                     found.out_of_bounds, found.dirty, found.obstacles, boxes.outputs()});
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
      EXPECT_EQ(found[k].out_of_bounds, reference[k].out_of_bounds);
      EXPECT_EQ(found[k].dirty, reference[k].dirty);
      EXPECT_EQ(found[k].obstacles, reference[k].obstacles);
      expect_same_bits(found[k].boxes, reference[k].boxes);
    }
  }
};

using Precisions = testing::Types<float, double>;
TYPED_TEST_SUITE(CollideCandidateUpdateParity, Precisions);

/// The host's are held against all with all in tests/unit/collide/candidate_update.cpp.
TYPED_TEST(CollideCandidateUpdateParity, CudaFindsTheHostsPairsAndBoxes) {
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

TYPED_TEST(CollideCandidateUpdateParity, CudaLeavesTooManyAndObstaclesAlone) {
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
    EXPECT_EQ(reference[0].dirty, 0);
    this->expect_same(this->find((*cuda)[0], true, true, vertices), reference);
  }
}

}  // namespace
}  // namespace weft::parity
