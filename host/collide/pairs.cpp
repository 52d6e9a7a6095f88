#include "weft/kernels/collide/pairs.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <vector>

#include "host/exec/host_device.hpp"

namespace weft {
namespace {

/// Calls visit(number) once for each box of the grid that meets `box` and has a number of at least
/// `lowest`. A pair of boxes may share several cells; it counts in the one that holds the lower
/// corner of their intersection.
template <class Visit>
void for_each_meeting(const Grid& grid, const Box& box, Index lowest, Visit visit) {
  if (grid.entries.empty()) return;
  const auto buckets = static_cast<std::uint32_t>(grid.bucket_offset.size() - 1);
  for (int level = 0; level < grid_levels; ++level) {
    if ((grid.levels[0] >> level & 1u) == 0) continue;
    const float cell = std::ldexp(grid.cell[0], level);
    const float inv = 1.0f / cell;
    const CellRange r = cells_of(box, cell);
    for (std::int32_t z = r.lo[2]; z <= r.hi[2]; ++z)
      for (std::int32_t y = r.lo[1]; y <= r.hi[1]; ++y)
        for (std::int32_t x = r.lo[0]; x <= r.hi[0]; ++x) {
          const std::uint32_t bucket = cell_bucket(x, y, z, level, buckets);
          const std::uint32_t tag = cell_tag(x, y, z, level);
          const Index begin = grid.bucket_offset.data()[bucket];
          for (Index e = grid.bucket_offset.data()[bucket + 1] - 1; e >= begin; --e) {
            const GridEntry& entry = grid.entries.data()[e];
            if (entry.number < lowest) break;  // a bucket lists its boxes in ascending order
            const Box& other = entry.box;
            if ((static_cast<int>(entry.tag == tag) & static_cast<int>(boxes_meet(box, other))) ==
                0)
              continue;
            if (cell_coordinate(std::max(box.lo[0], other.lo[0]), inv) != x ||
                cell_coordinate(std::max(box.lo[1], other.lo[1]), inv) != y ||
                cell_coordinate(std::max(box.lo[2], other.lo[2]), inv) != z)
              continue;
            visit(entry.number);
          }
        }
  }
}

/// Bit k: box `lane` of `a` meets box k of `b`. Written so that compilers use vector registers.
std::uint32_t meeting_lanes(const Cluster& a, Index lane, const Cluster& b) {
  std::uint32_t hit[cluster_size];
  for (Index k = 0; k < cluster_size; ++k) {
    float gap = a.lo[0][lane] - b.hi[0][k];
    gap = std::max(gap, b.lo[0][k] - a.hi[0][lane]);
    gap = std::max(gap, a.lo[1][lane] - b.hi[1][k]);
    gap = std::max(gap, b.lo[1][k] - a.hi[1][lane]);
    gap = std::max(gap, a.lo[2][lane] - b.hi[2][k]);
    gap = std::max(gap, b.lo[2][k] - a.hi[2][lane]);
    hit[k] = gap <= 0 ? 1u << k : 0u;
  }
  std::uint32_t bits = 0;
  for (Index k = 0; k < cluster_size; ++k) bits |= hit[k];
  return bits;
}

/// Appends to an array of fixed capacity, and counts what does not fit.
class Appender {
 public:
  explicit Appender(Span<Pair> out) : out_(out) {}
  void add(Index a, Index b) {
    if (count_ < out_.size()) out_.data()[count_] = {a, b};
    ++count_;
  }
  Index count() const { return static_cast<Index>(count_); }

 private:
  Span<Pair> out_;
  std::size_t count_ = 0;
};

class PairFinder {
 public:
  explicit PairFinder(const CollidePairs& args)
      : a_(args), face_pairs_(args.face_pairs), edge_pairs_(args.edge_pairs) {}

  void find() {
    const Index cloth = a_.lists[cloth_vertices].size();
    for (Index k = a_.vertex_begin; k < a_.vertex_end; ++k)
      k < cloth ? ask_faces(cloth_vertices, k) : ask_faces(obstacle_vertices, k - cloth);
    for (Index k = a_.edge_begin; k < a_.edge_end; ++k) ask_edges(k);
    CollideCounts counts{};
    counts.face_pairs = face_pairs_.count();
    counts.edge_pairs = edge_pairs_.count();
    a_.counts[0] = counts;
  }

 private:
  /// Clusters of `kind` that the hull `box` meets, in ascending order: pairs then come in an order
  /// that knows nothing of the grids, so that it does not matter when they were searched.
  void collect(ClusterKind kind, const Box& box, Index lowest, std::vector<Index>& out) {
    out.clear();
    for_each_meeting(a_.grids[kind], box, lowest, [&](Index number) { out.push_back(number); });
    std::sort(out.begin(), out.end());
  }

  /// Calls add(number) for each box of the collected clusters that meets box `lane` of `asking`.
  template <class Add>
  void for_each_box(ClusterKind kind, const std::vector<Index>& met, const Cluster& asking,
                    Index lane, Add add) const {
    const ClusterList& list = a_.lists[kind];
    for (const Index k : met) {
      const Index first = list.first + k * cluster_size;
      for (std::uint32_t bits = meeting_lanes(asking, lane, list.clusters.data()[k]); bits != 0;
           bits &= bits - 1)
        add(first + static_cast<Index>(std::countr_zero(bits)));
    }
  }

  void ask_faces(ClusterKind kind, Index k) {
    const ClusterList& list = a_.lists[kind];
    const bool cloth = kind == cloth_vertices;
    met_self_.clear();
    met_obstacle_.clear();
    const Box& hull = list.hulls.data()[k];
    if (!cloth || a_.self) collect(cloth_faces, hull, 0, met_self_);
    if (cloth) collect(obstacle_faces, hull, 0, met_obstacle_);
    const Cluster& asking = list.clusters.data()[k];
    const Index end = std::min(cluster_size, list.count - k * cluster_size);
    for (Index lane = 0; lane < end; ++lane) {
      const Index v = list.first + k * cluster_size + lane;
      for_each_box(cloth_faces, met_self_, asking, lane, [&](Index f) {
        const Tri& t = a_.triangles.data()[f];
        if (t.v[0] != v && t.v[1] != v && t.v[2] != v) face_pairs_.add(v, f);
      });
      for_each_box(obstacle_faces, met_obstacle_, asking, lane,
                   [&](Index f) { face_pairs_.add(v, f); });
    }
  }

  void ask_edges(Index k) {
    const ClusterList& list = a_.lists[cloth_edges];
    const Box& hull = list.hulls.data()[k];
    met_self_.clear();
    if (a_.self) collect(cloth_edges, hull, k, met_self_);
    collect(obstacle_edges, hull, 0, met_obstacle_);
    const Cluster& asking = list.clusters.data()[k];
    const Index end = std::min(cluster_size, list.count - k * cluster_size);
    for (Index lane = 0; lane < end; ++lane) {
      const Index e = list.first + k * cluster_size + lane;
      const Edge& p = a_.edges.data()[e];
      for_each_box(cloth_edges, met_self_, asking, lane, [&](Index f) {
        const Edge& q = a_.edges.data()[f];
        if (f > e && p.v[0] != q.v[0] && p.v[0] != q.v[1] && p.v[1] != q.v[0] && p.v[1] != q.v[1])
          edge_pairs_.add(e, f);
      });
      for_each_box(obstacle_edges, met_obstacle_, asking, lane,
                   [&](Index f) { edge_pairs_.add(e, f); });
    }
  }

  const CollidePairs a_;
  Appender face_pairs_;
  Appender edge_pairs_;
  std::vector<Index> met_self_;
  std::vector<Index> met_obstacle_;
};

}  // namespace

void run(OnHost, Queue& queue, const CollidePairs& args) {
  submit_host(queue, [args] { PairFinder(args).find(); });
}

}  // namespace weft
