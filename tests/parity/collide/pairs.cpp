#include "weft/kernels/collide/pairs.hpp"
#include "host/exec/host_devices.hpp"

#include "tests/parity/collide/scene.hpp"
#include "tests/unit/collide/brute_force.hpp"

namespace weft::parity {
namespace {

struct Found {
  test::Pairs face, edge;  ///< the ranks' lists joined
  Offset tests = 0;        ///< of all ranks
  int launches = 0;        ///< until the lists were long enough
};

/// The whole broad phase over all ranks of `devices`, with lists that have to grow first.
template <class T>
class PairSearch {
 public:
  PairSearch(DeviceSet& devices, const SweptMesh& mesh, T reach, bool self, T split_motion)
      : devices_(devices), broad_phase_(devices, mesh.counts, self) {
    for (int r = 0; r < devices.size(); ++r) {
      inputs_.push_back(std::make_unique<BoxBuffers<T>>(devices[r], mesh));
      inputs_.back()->args.reach = reach;
      inputs_.back()->args.split_motion = split_motion;
      faces_.emplace_back(devices[r], 3);
      edges_.emplace_back(devices[r], 3);
      counts_.emplace_back(devices[r], 1);
    }
  }

  /// Some ranks ask for more from now on, and some for less.
  void share_out_unevenly() {
    std::vector<double> of_faces, of_edges;
    for (int r = 0; r < devices_.size(); ++r) {
      of_faces.push_back(1 + 5 * (r % 3));
      of_edges.push_back(20.0 - 7 * (r % 2));
    }
    broad_phase_.share_out(of_faces, of_edges);
  }

  Found run() {
    std::vector<CollideBoxes<T>> motions;
    for (const auto& input : inputs_) motions.push_back(input->args);
    broad_phase_.launch_boxes(motions);
    Found found;
    for (bool full = true; full; ++found.launches) full = launch_pairs();
    for (int r = 0; r < devices_.size(); ++r) {
      const CollideCounts counts = download(at(counts_, r)).front();
      append(found.face, download(at(faces_, r)), counts.face_pairs);
      append(found.edge, download(at(edges_, r)), counts.edge_pairs);
      found.tests += counts.tests;
      EXPECT_EQ(counts.contacts + counts.collisions + counts.out_of_bounds + counts.not_finite, 0);
    }
    return found;
  }

 private:
  template <class V>
  static auto& at(V& all, int r) {
    return all[static_cast<std::size_t>(r)];
  }
  static void append(test::Pairs& all, std::vector<Pair> own, Index count) {
    own.resize(static_cast<std::size_t>(count));
    for (const Pair& p : own) all.emplace_back(p.a, p.b);
  }
  /// @return whether a list was too short
  bool launch_pairs() {
    bool full = false;
    for (int r = 0; r < devices_.size(); ++r) {
      CollidePairs<T> pairs{};
      pairs.edges = at(inputs_, r)->args.edges;
      pairs.triangles = at(inputs_, r)->args.triangles;
      pairs.face_pairs = at(faces_, r).span();
      pairs.edge_pairs = at(edges_, r).span();
      pairs.counts = at(counts_, r).span();
      broad_phase_.launch_pairs(r, pairs);
    }
    for (int r = 0; r < devices_.size(); ++r) {
      const CollideCounts counts = download(at(counts_, r)).front();
      const auto grow = [&](Buffer<Pair>& list, Index count) {
        if (static_cast<std::size_t>(count) <= list.size()) return;
        list.resize(static_cast<std::size_t>(count));
        full = true;
      };
      grow(at(faces_, r), counts.face_pairs);
      grow(at(edges_, r), counts.edge_pairs);
    }
    return full;
  }

  DeviceSet& devices_;
  BroadPhase<T> broad_phase_;
  std::vector<std::unique_ptr<BoxBuffers<T>>> inputs_;
  std::vector<Buffer<Pair>> faces_, edges_;
  std::vector<Buffer<CollideCounts>> counts_;
};

constexpr double never = std::numeric_limits<double>::infinity();

/// @param split_motion [m] see CollideBoxes
template <class T>
Found search(DeviceSet& devices, const SweptMesh& mesh, double reach, bool self = true,
             double split_motion = never) {
  return PairSearch<T>(devices, mesh, static_cast<T>(reach), self, static_cast<T>(split_motion))
      .run();
}

/// Thousands of pairs in one cell, of triangles that share nothing.
SweptMesh heap(int count) {
  Random random(35);
  std::vector<Vec3<double>> from, to;
  std::vector<Tri> triangles;
  for (Index k = 0; k < count; ++k) {
    triangles.push_back({{3 * k, 3 * k + 1, 3 * k + 2}});
    for (int j = 0; j < 3; ++j) {
      from.push_back(random.vector<double>(-1, 1));
      to.push_back(random.vector<double>(-1, 1));
    }
  }
  return make_swept_mesh(from, to, triangles);
}

void expect_same(const Found& found, const Found& reference) {
  EXPECT_EQ(found.face, reference.face);
  EXPECT_EQ(found.edge, reference.edge);
  EXPECT_EQ(found.tests, reference.tests);
}

template <class T>
class CollidePairsParity : public testing::Test {
 protected:
  static void compare(const SweptMesh& mesh, double reach, bool self = true,
                      double split_motion = never) {
    std::string why;
    std::optional<DeviceSet> cuda = find_cuda({0}, why);
    if (!cuda) GTEST_SKIP() << why;
    DeviceSet host = host_devices(1);
    const Found reference = search<T>(host, mesh, reach, self, split_motion);
    EXPECT_FALSE(reference.face.empty());
    expect_same(search<T>(*cuda, mesh, reach, self, split_motion), reference);
    for (const std::vector<int>& gpus : gpu_lists()) {
      std::optional<DeviceSet> several = find_cuda(gpus, why);
      SCOPED_TRACE(std::to_string(gpus.size()) + " ranks");
      expect_same(search<T>(*several, mesh, reach, self, split_motion), reference);
    }
  }
};

using Precisions = testing::Types<float, double>;
TYPED_TEST_SUITE(CollidePairsParity, Precisions);

TYPED_TEST(CollidePairsParity, HostFindsWhatBruteForceFinds) {
  const SweptMesh mesh = folded_scene(20);
  const test::BruteForce truth = test::brute_force(mesh, 0);
  DeviceSet devices = host_devices(3, {true, 0});
  const Found found = search<TypeParam>(devices, mesh, 0);
  EXPECT_GE(found.launches, 2);
  const auto holds = [](const test::Pairs& all, const test::Pairs& some) {
    return std::includes(all.begin(), all.end(), some.begin(), some.end());
  };
  EXPECT_TRUE(holds(found.face, truth.face_pairs));
  EXPECT_TRUE(holds(found.edge, truth.edge_pairs));
  if (!std::is_same_v<TypeParam, double>) return;
  EXPECT_EQ(found.face, truth.face_pairs);
  EXPECT_EQ(found.edge, truth.edge_pairs);
}

TYPED_TEST(CollidePairsParity, SharesMayBeOfAnySize) {
  const SweptMesh mesh = folded_scene(60);
  const auto look = [&](DeviceSet& devices, bool unevenly) {
    PairSearch<TypeParam> search(devices, mesh, TypeParam(0.001), true, TypeParam(never));
    if (unevenly) search.share_out_unevenly();
    return search.run();
  };
  DeviceSet one = host_devices(1);
  const Found reference = look(one, false);
  EXPECT_FALSE(reference.face.empty());
  for (const int ranks : {2, 3, 8}) {
    DeviceSet host = host_devices(ranks, {true, 0});
    expect_same(look(host, true), reference);
  }
  std::string why;
  if (!find_cuda({0}, why)) GTEST_SKIP() << why;
  for (const std::vector<int>& gpus : gpu_lists()) {
    std::optional<DeviceSet> several = find_cuda(gpus, why);
    SCOPED_TRACE(std::to_string(gpus.size()) + " ranks");
    expect_same(look(*several, true), reference);
  }
}

TYPED_TEST(CollidePairsParity, CudaFindsTheHostsPairs) {
  this->compare(folded_scene(60), 0.001);
}

TYPED_TEST(CollidePairsParity, CudaFindsTheHostsPairsWithoutReach) {
  this->compare(folded_scene(33), 0);
}

TYPED_TEST(CollidePairsParity, CudaFindsTheHostsPairsWithoutSelfContact) {
  this->compare(folded_scene(33), 0.002, false);
}

/// Cloth carried past what rests by several times the length of its edges.
TYPED_TEST(CollidePairsParity, CudaFindsTheHostsPairsOfASplitMotion) {
  SweptMesh mesh = folded_scene(60);
  for (Index v = 0; v < mesh.counts.cloth_vertices; ++v)
    mesh.positions_t1[static_cast<std::size_t>(v)] += Vec3<double>{0.05, 0.01, -0.08};
  this->compare(mesh, 0.001, true, 0.01);
}

/// Groups that meet hundreds of others, and fill their lists many times over.
TYPED_TEST(CollidePairsParity, CudaFindsTheHostsPairsInAHeap) {
  this->compare(heap(700), 0);
}

TYPED_TEST(CollidePairsParity, CudaFindsTheHostsPairsOfASplitMotionInAHeap) {
  this->compare(heap(700), 0, true, 0.01);
}

TYPED_TEST(CollidePairsParity, CudaFindsNothingWhereNothingIs) {
  std::string why;
  std::optional<DeviceSet> cuda = find_cuda({0}, why);
  if (!cuda) GTEST_SKIP() << why;
  const SweptMesh one = make_swept_mesh({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}},
                                        {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{{0, 1, 2}}});
  const Found found = search<TypeParam>(*cuda, one, 0.1);
  EXPECT_TRUE(found.face.empty());
  EXPECT_TRUE(found.edge.empty());
  EXPECT_EQ(found.launches, 1);
}

}  // namespace
}  // namespace weft::parity
