#include "weft/kernels/collide/candidate_update.hpp"
#include "host/exec/host_devices.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "host/implicit/contact/broad_phase.hpp"
#include "host/implicit/parallel/exchange.hpp"
#include "host/state/store.hpp"
#include "tests/unit/collide/brute_force.hpp"
#include "tests/unit/collide/meshes.hpp"

namespace weft {
namespace {

using test::numbers_of;
using test::Pairs;
using test::Points;
using test::Random;

/// The lists of one search, which what out_of_bounds is added to.
template <class T>
class Search {
 public:
  Search(const SweptMesh& mesh, int ranks, double margin, double split_motion)
      : mesh_(mesh),
        devices_(host_devices(ranks, {true, 0})),
        broad_phase_(devices_, mesh.counts, true),
        margin_(static_cast<T>(margin)),
        split_motion_(static_cast<T>(split_motion)) {
    for (int r = 0; r < ranks; ++r) {
      Queue& queue = devices_[r].compute();
      Device& device = devices_[r];
      ranks_.push_back(
          {Buffer<Vec3<T>>(device), Buffer<Vec3<T>>(device), Buffer<Tri>(device),
           Buffer<Edge>(device), Buffer<Pair>(device, 200'000), Buffer<Pair>(device, 200'000),
           Buffer<CollideCounts>(device, 1), Buffer<Index>(device, mesh.positions_t0.size()),
           Buffer<OutOfBoundsVertex<T>>(device, out_of_bounds_max),
           Buffer<DirtyPrimitive>(device, 16 * out_of_bounds_max), Buffer<Pair>(device, 20'000),
           Buffer<Pair>(device, 20'000), Buffer<CandidateUpdateCounts>(device, 1)});
      upload(queue, ranks_.back().t0, cast_all<T>(mesh.positions_t0));
      upload(queue, ranks_.back().t1, cast_all<T>(mesh.positions_t1));
      upload(queue, ranks_.back().triangles, mesh.triangles);
      upload(queue, ranks_.back().edges, mesh.edges);
    }
    std::vector<CollideBoxes<T>> motions;
    for (int r = 0; r < ranks; ++r) motions.push_back(boxes(r));
    broad_phase_.launch_boxes(motions);
    for (int r = 0; r < ranks; ++r) broad_phase_.launch_pairs(r, pairs(r));
    sync_ranks(devices_);
    for (const Rank& rank : ranks_) {
      const CollideCounts& counts = rank.counts.data()[0];
      const auto first = [](const Buffer<Pair>& list, Index count) {
        return numbers_of({list.data(), list.data() + count});
      };
      face_pairs.push_back(first(rank.face_pairs, counts.face_pairs));
      edge_pairs.push_back(first(rank.edge_pairs, counts.edge_pairs));
    }
  }

  /// Other ends of the motion; adds what that takes, each pair to one rank.
  bool add(const Points& ends) {
    bool all = true;
    for (std::size_t n = 0; n < ranks_.size(); ++n) {
      const auto r = static_cast<int>(n);
      const Rank& rank = ranks_[n];
      Queue& queue = devices_[r].compute();
      upload(queue, ranks_[n].t1, cast_all<T>(ends));
      launch(queue, CollideCandidateUpdate<T>{broad_phase_.boxes_of(r, boxes(r)), true, true,
                                              rank.out_of_bounds_index.span(),
                                              rank.out_of_bounds.span(), rank.dirty.span(),
                                              rank.updated_faces.span(), rank.updated_edges.span(),
                                              rank.candidate_update_counts.span()});
      queue.sync();
      const CandidateUpdateCounts& counts = rank.candidate_update_counts.data()[0];
      if (counts.obstacles > 0 || counts.out_of_bounds > out_of_bounds_max) {
        all = false;
        continue;
      }
      if (n > 0) continue;
      add_once(face_pairs.front(), rank.updated_faces, counts.face_pairs);
      add_once(edge_pairs.front(), rank.updated_edges, counts.edge_pairs);
    }
    return all;
  }

  /// All pairs whose boxes meet, by comparing all with all; and that the lists have these boxes.
  void expect_all() const {
    const CollideBoxes<T> a = broad_phase_.boxes_of(0, boxes(0));
    const bool split = a.split.data()[0] != 0;
    const auto all_boxes = [&](int kind, Index count) {
      std::vector<SplitBox<T>> all;
      for (Index i = 0; i < count; ++i) {
        const BoxOf<T> end = primitive_box(a, kind, i);
        all.push_back({split ? start_box(a, kind, i) : end, end});
      }
      return all;
    };
    const PrimitiveCounts& n = mesh_.counts;
    const auto vertex_boxes = all_boxes(cloth_vertices, n.vertices);
    const auto face_boxes = all_boxes(cloth_faces, n.triangles);
    const auto edge_boxes = all_boxes(cloth_edges, n.edges);
    const auto meet = [](const std::vector<SplitBox<T>>& p, Index i,
                         const std::vector<SplitBox<T>>& q, Index j) {
      return may_meet(p[static_cast<std::size_t>(i)], q[static_cast<std::size_t>(j)]);
    };
    Pairs faces, edges;
    for (Index f = 0; f < n.triangles; ++f)
      for (Index v = 0; v < (f < n.cloth_triangles ? n.vertices : n.cloth_vertices); ++v)
        if (shares_no_vertex(v, mesh_.triangles[static_cast<std::size_t>(f)]) &&
            meet(face_boxes, f, vertex_boxes, v))
          faces.emplace_back(v, f);
    for (Index f = 0; f < n.edges; ++f)
      for (Index e = 0; e < std::min(f, n.cloth_edges); ++e)
        if (shares_no_vertex(mesh_.edges[static_cast<std::size_t>(e)],
                             mesh_.edges[static_cast<std::size_t>(f)]) &&
            meet(edge_boxes, e, edge_boxes, f))
          edges.emplace_back(e, f);
    std::sort(faces.begin(), faces.end());
    std::sort(edges.begin(), edges.end());
    EXPECT_EQ(joined(face_pairs), faces);
    EXPECT_EQ(joined(edge_pairs), edges);
    for (int kind = 0; kind < cluster_kinds; ++kind) expect_listed(a, kind, split);
    for (Index v = 0; v < n.vertices; ++v)
      EXPECT_TRUE(keeps_to(a.swept_aabb.data()[v], a.positions_t1.data()[v])) << v;
  }

  std::vector<Pairs> face_pairs, edge_pairs;  ///< [ranks]
  std::size_t added = 0;

 private:
  static constexpr Index out_of_bounds_max = 100;

  struct Rank {
    Buffer<Vec3<T>> t0, t1;
    Buffer<Tri> triangles;
    Buffer<Edge> edges;
    Buffer<Pair> face_pairs, edge_pairs;
    Buffer<CollideCounts> counts;
    Buffer<Index> out_of_bounds_index;
    Buffer<OutOfBoundsVertex<T>> out_of_bounds;
    Buffer<DirtyPrimitive> dirty;
    Buffer<Pair> updated_faces, updated_edges;
    Buffer<CandidateUpdateCounts> candidate_update_counts;
  };

  void add_once(Pairs& list, const Buffer<Pair>& found, Index count) {
    ASSERT_LE(static_cast<std::size_t>(count), found.size());
    Pairs fresh = numbers_of({found.data(), found.data() + count});
    std::sort(fresh.begin(), fresh.end());
    fresh.erase(std::unique(fresh.begin(), fresh.end()), fresh.end());
    added += fresh.size();
    list.insert(list.end(), fresh.begin(), fresh.end());
  }

  static void expect_inside(const BoxOf<float>& inner, const BoxOf<float>& outer) {
    const BoxOf<float> both = hull(inner, outer);
    for (int c = 0; c < 3; ++c) {
      EXPECT_EQ(both.lo[c], outer.lo[c]);
      EXPECT_EQ(both.hi[c], outer.hi[c]);
    }
  }
  /// Each primitive's box in its place, and inside those of its cluster and its group.
  static void expect_listed(const CollideBoxes<T>& a, int kind, bool split) {
    const ClusterList<T>& list = a.lists[kind];
    const auto& clusters = split ? list.ends : list.clusters;
    const auto& groups = split ? list.group_ends : list.groups;
    for (Index i = 0; i < list.count; ++i) {
      const BoxOf<T> box = primitive_box(a, kind, list.first + i);
      const Index k = i / cluster_size, g = k / cluster_size;
      const BoxOf<T> listed = lane_of<T>(clusters.data()[k], i % cluster_size);
      for (int c = 0; c < 3; ++c) {
        EXPECT_EQ(listed.lo[c], box.lo[c]);
        EXPECT_EQ(listed.hi[c], box.hi[c]);
      }
      expect_inside(around(box), lane_of<float>(groups.data()[g], k % cluster_size));
      expect_inside(around(box), list.hulls.data()[g]);
    }
  }

  static Pairs joined(const std::vector<Pairs>& lists) {
    Pairs all;
    for (const Pairs& list : lists) all.insert(all.end(), list.begin(), list.end());
    std::sort(all.begin(), all.end());
    return all;
  }

  CollideBoxes<T> boxes(int r) const {
    const Rank& rank = ranks_[static_cast<std::size_t>(r)];
    CollideBoxes<T> a{};
    a.positions_t0 = rank.t0.span();
    a.positions_t1 = rank.t1.span();
    a.edges = rank.edges.span();
    a.triangles = rank.triangles.span();
    a.margin = a.margin_at_rest = margin_;
    a.reach = T(0.002);
    a.split_motion = split_motion_;
    return a;
  }
  CollidePairs<T> pairs(int r) const {
    const Rank& rank = ranks_[static_cast<std::size_t>(r)];
    CollidePairs<T> a{};
    a.edges = rank.edges.span();
    a.triangles = rank.triangles.span();
    a.face_pairs = rank.face_pairs.span();
    a.edge_pairs = rank.edge_pairs.span();
    a.counts = rank.counts.span();
    return a;
  }

  const SweptMesh& mesh_;
  DeviceSet devices_;
  BroadPhase<T> broad_phase_;
  std::vector<Rank> ranks_;
  T margin_, split_motion_;
};

constexpr int cells = 18;
constexpr double edge = 1.0 / cells;

/// Crumpled cloth above a bumpy obstacle, both moved on.
SweptMesh scene(Random& random) {
  const SweptMesh cloth = test::sheet(cells, edge, 0.2 * edge, random, [&](double x, double y) {
    return Vec3<double>{x, y, 0.06 * std::sin(12 * x)} + random.within(0.2 * edge);
  });
  const SweptMesh obstacle = test::sheet(9, 1.0 / 9, 0.1 * edge, random, [&](double x, double y) {
    return Vec3<double>{x, y, -0.05} + random.within(0.02);
  });
  return test::joined(cloth, obstacle);
}

/// Some of the cloth's vertices end up to two edges elsewhere.
Points strayed(const Points& ends, Index cloth, int count, Random& random) {
  Points moved = ends;
  for (int k = 0; k < count; ++k) {
    const auto v = static_cast<std::size_t>(random.uniform(0, cloth - 1));
    moved[v] += random.within(2 * edge);
  }
  return moved;
}

template <class T>
void add_twice(double split_motion, int ranks) {
  Random random(17);
  const SweptMesh mesh = scene(random);
  Search<T> search(mesh, ranks, 0.05 * edge, split_motion);
  search.expect_all();
  Points ends = mesh.positions_t1;
  // The second time, some that have grown already meet others that have.
  for (int round = 0; round < 2; ++round) {
    const std::size_t before = search.added;
    ends = strayed(ends, mesh.counts.cloth_vertices, 10, random);
    ASSERT_TRUE(search.add(ends));
    EXPECT_GT(search.added, before + 100);
    search.expect_all();
  }
}

TEST(CollideCandidateUpdate, ListsAreThoseOfASearchWithTheGrownBoxes) {
  for (const int ranks : {1, 3})
    for (const double split_motion : {0.0, 1.0}) {
      SCOPED_TRACE(std::to_string(ranks) + " ranks, split from " + std::to_string(split_motion));
      add_twice<float>(split_motion, ranks);
      add_twice<double>(split_motion, ranks);
    }
}

TEST(CollideCandidateUpdate, NothingIsOutOfBounds) {
  Random random(5);
  const SweptMesh mesh = scene(random);
  Search<float> search(mesh, 1, 0.05 * edge, 1);
  EXPECT_TRUE(search.add(mesh.positions_t1));
  EXPECT_EQ(search.added, 0u);
  search.expect_all();
}

/// Where a whole search is called for, boxes and lists stay as they are.
TEST(CollideCandidateUpdate, TooManyAndObstaclesAreLeftAlone) {
  Random random(6);
  const SweptMesh mesh = scene(random);
  Search<float> search(mesh, 2, 0.05 * edge, 1);
  EXPECT_FALSE(search.add(strayed(mesh.positions_t1, mesh.counts.cloth_vertices, 200, random)));
  Points ends = mesh.positions_t1;
  ends.back() += Vec3<double>{0.3, 0, 0};
  EXPECT_FALSE(search.add(ends));
  EXPECT_TRUE(search.add(mesh.positions_t1));
  EXPECT_EQ(search.added, 0u);
  search.expect_all();
}

}  // namespace
}  // namespace weft
