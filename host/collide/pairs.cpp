#include "weft/kernels/collide/pairs.hpp"

#include <algorithm>
#include <bit>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "host/collide/grid_walk.hpp"
#include "host/exec/host_device.hpp"
#include "weft/error.hpp"

namespace weft {
namespace {

/// Bit k: `a` meets box k of `b`. Written so that compilers use vector registers.
template <class T>
std::uint32_t meeting_lanes(const BoxOf<T>& a, const Cluster<T>& b) {
  std::uint32_t hit[cluster_size];
  for (Index k = 0; k < cluster_size; ++k) {
    T gap = a.lo[0] - b.hi[0][k];
    gap = std::max(gap, b.lo[0][k] - a.hi[0]);
    gap = std::max(gap, a.lo[1] - b.hi[1][k]);
    gap = std::max(gap, b.lo[1][k] - a.hi[1]);
    gap = std::max(gap, a.lo[2] - b.hi[2][k]);
    gap = std::max(gap, b.lo[2][k] - a.hi[2]);
    hit[k] = gap <= T(0) ? 1u << k : 0u;
  }
  std::uint32_t bits = 0;
  for (Index k = 0; k < cluster_size; ++k) bits |= hit[k];
  return bits;
}

template <class S, class T>
BoxOf<S> lane_of(const Cluster<T>& cluster, Index lane) {
  BoxOf<S> box;
  for (int c = 0; c < 3; ++c) {
    box.lo[c] = static_cast<S>(cluster.lo[c][lane]);
    box.hi[c] = static_cast<S>(cluster.hi[c][lane]);
  }
  return box;
}

/// Calls visit(k) for each set bit k, in ascending order.
template <class Visit>
void for_each_bit(std::uint32_t bits, Visit visit) {
  for (; bits != 0; bits &= bits - 1) visit(static_cast<Index>(std::countr_zero(bits)));
}

/// Appends to an array of fixed capacity, and counts what does not fit.
class Appender {
 public:
  explicit Appender(Span<Pair> out) : out_(out) {}
  void add(Index a, Index b) {
    if (count_ < out_.size()) out_.data()[count_] = {a, b};
    ++count_;
  }
  Index count() const {
    if (count_ > static_cast<std::size_t>(std::numeric_limits<Index>::max()))
      throw DeviceError("more pairs than an index can number: " + std::to_string(count_));
    return static_cast<Index>(count_);
  }

 private:
  Span<Pair> out_;
  std::size_t count_ = 0;
};

/// A cluster whose hull the asking cluster's boxes meet.
struct Met {
  Index cluster;
  std::uint32_t lanes;  ///< of the asking cluster that do
};

template <class T>
class PairFinder {
 public:
  explicit PairFinder(const CollidePairs<T>& args)
      : a_(args), face_pairs_(args.face_pairs), edge_pairs_(args.edge_pairs) {}

  void find() {
    const Index cloth = a_.lists[cloth_vertices].group_count();
    for (Index g = share_begin(a_.face_work, a_.rank); g < share_begin(a_.face_work, a_.rank + 1);
         ++g)
      g < cloth ? ask_faces(cloth_vertices, g) : ask_faces(obstacle_vertices, g - cloth);
    for (Index g = share_begin(a_.edge_work, a_.rank); g < share_begin(a_.edge_work, a_.rank + 1);
         ++g)
      ask_edges(g);
    CollideCounts counts{};
    counts.face_pairs = face_pairs_.count();
    counts.edge_pairs = edge_pairs_.count();
    counts.tests = tests_;
    a_.counts[0] = counts;
  }

 private:
  /// First group of a rank: where the sum of work reaches its part of the whole.
  Index share_begin(Span<const Offset> work, int rank) const {
    const Offset whole = work[work.size() - 1];
    const Offset part = whole / a_.ranks * rank + whole % a_.ranks * rank / a_.ranks;
    return static_cast<Index>(std::lower_bound(work.begin(), work.end(), part) - work.begin());
  }

  /// Groups of `kind` that the hull `box` meets, in ascending order: pairs then come in an order
  /// that knows nothing of the grids, so that it does not matter when they were searched.
  void collect_groups(ClusterKind kind, const Box& box, Index lowest, std::vector<Index>& out) {
    out.clear();
    for_each_meeting(a_.grids[kind], a_.lists[kind].hulls, box, lowest,
                     [&](Index number) { out.push_back(number); });
    std::sort(out.begin(), out.end());
  }

  /// Clusters of the groups that the asking cluster k of list `asking` meets, in ascending order.
  void collect_clusters(ClusterKind kind, const std::vector<Index>& groups, ClusterKind asking,
                        Index k, Index lowest, std::vector<Met>& out) {
    out.clear();
    const ClusterList<T>& list = a_.lists[kind];
    const Cluster<T>& boxes = a_.lists[asking].clusters.data()[k];
    const Box whole =
        lane_of<float>(a_.lists[asking].groups.data()[k / cluster_size], k % cluster_size);
    for (const Index g : groups) {
      const Cluster<float>& group = list.groups.data()[g];
      ++tests_;
      for_each_bit(meeting_lanes(whole, group), [&](Index lane) {
        const Index cluster = g * cluster_size + lane;
        if (cluster < lowest) return;
        ++tests_;
        const std::uint32_t lanes = meeting_lanes(lane_of<T>(group, lane), boxes);
        if (lanes != 0) out.push_back({cluster, lanes});
      });
    }
  }

  /// Calls add(number) for each box of the collected clusters that box `lane` of `asking` meets.
  template <class Add>
  void for_each_box(ClusterKind kind, const std::vector<Met>& met, const BoxOf<T>& box, Index lane,
                    Add add) {
    const ClusterList<T>& list = a_.lists[kind];
    for (const Met& m : met) {
      if ((m.lanes >> lane & 1u) == 0) continue;
      ++tests_;
      const Index first = list.first + m.cluster * cluster_size;
      for_each_bit(meeting_lanes(box, list.clusters.data()[m.cluster]),
                   [&](Index k) { add(first + k); });
    }
  }

  /// Calls ask(k) for each cluster of group g.
  template <class Ask>
  void for_each_cluster(ClusterKind kind, Index g, Ask ask) {
    const Index end = std::min((g + 1) * cluster_size, a_.lists[kind].size());
    for (Index k = g * cluster_size; k < end; ++k) ask(k);
  }

  /// Calls ask(number, lane, box) for each primitive of cluster k.
  template <class Ask>
  void for_each_primitive(ClusterKind kind, Index k, Ask ask) {
    const ClusterList<T>& list = a_.lists[kind];
    const Index end = std::min(cluster_size, list.count - k * cluster_size);
    for (Index lane = 0; lane < end; ++lane)
      ask(list.first + k * cluster_size + lane, lane, lane_of<T>(list.clusters.data()[k], lane));
  }

  void ask_faces(ClusterKind kind, Index g) {
    const bool cloth = kind == cloth_vertices;
    const Box& hull = a_.lists[kind].hulls.data()[g];
    groups_cloth_.clear();
    groups_obstacle_.clear();
    if (!cloth || a_.self) collect_groups(cloth_faces, hull, 0, groups_cloth_);
    if (cloth) collect_groups(obstacle_faces, hull, 0, groups_obstacle_);
    for_each_cluster(kind, g, [&](Index k) {
      collect_clusters(cloth_faces, groups_cloth_, kind, k, 0, cloth_);
      collect_clusters(obstacle_faces, groups_obstacle_, kind, k, 0, obstacle_);
      for_each_primitive(kind, k, [&](Index v, Index lane, const BoxOf<T>& box) {
        for_each_box(cloth_faces, cloth_, box, lane, [&](Index f) {
          const Tri& t = a_.triangles.data()[f];
          if (t.v[0] != v && t.v[1] != v && t.v[2] != v) face_pairs_.add(v, f);
        });
        for_each_box(obstacle_faces, obstacle_, box, lane, [&](Index f) { face_pairs_.add(v, f); });
      });
    });
  }

  void ask_edges(Index g) {
    const Box& hull = a_.lists[cloth_edges].hulls.data()[g];
    groups_cloth_.clear();
    if (a_.self) collect_groups(cloth_edges, hull, g, groups_cloth_);
    collect_groups(obstacle_edges, hull, 0, groups_obstacle_);
    for_each_cluster(cloth_edges, g, [&](Index k) {
      collect_clusters(cloth_edges, groups_cloth_, cloth_edges, k, k, cloth_);
      collect_clusters(obstacle_edges, groups_obstacle_, cloth_edges, k, 0, obstacle_);
      for_each_primitive(cloth_edges, k, [&](Index e, Index lane, const BoxOf<T>& box) {
        const Edge& p = a_.edges.data()[e];
        for_each_box(cloth_edges, cloth_, box, lane, [&](Index f) {
          const Edge& q = a_.edges.data()[f];
          if (f > e && p.v[0] != q.v[0] && p.v[0] != q.v[1] && p.v[1] != q.v[0] && p.v[1] != q.v[1])
            edge_pairs_.add(e, f);
        });
        for_each_box(obstacle_edges, obstacle_, box, lane, [&](Index f) { edge_pairs_.add(e, f); });
      });
    });
  }

  const CollidePairs<T> a_;
  Appender face_pairs_;
  Appender edge_pairs_;
  Offset tests_ = 0;
  std::vector<Index> groups_cloth_;
  std::vector<Index> groups_obstacle_;
  std::vector<Met> cloth_;
  std::vector<Met> obstacle_;
};

}  // namespace

template <class T>
void run(OnHost, Queue& queue, const CollidePairs<T>& args) {
  submit_host(queue, [args] { PairFinder<T>(args).find(); });
}

template void run(OnHost, Queue&, const CollidePairs<float>&);
template void run(OnHost, Queue&, const CollidePairs<double>&);

}  // namespace weft
