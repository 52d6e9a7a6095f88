#include "weft/kernels/collide/pairs.hpp"

#include <algorithm>
#include <cmath>

#include "host/exec/host_device.hpp"
#include "weft/kernels/collide/boxes.hpp"

namespace weft {
namespace {

/// Calls visit(box number) once for each box of the grid that meets `box` and has a number above
/// `above`.
/// A pair of boxes may share several cells; it counts in the one that holds the lower corner of
/// their intersection.
template <class Visit>
void for_each_meeting(const Grid& grid, const Box& box, Index above, Offset& tests, Visit visit) {
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
          tests += grid.bucket_offset.data()[bucket + 1] - begin;
          for (Index e = grid.bucket_offset.data()[bucket + 1] - 1; e >= begin; --e) {
            const GridEntry& entry = grid.entries.data()[e];
            if (entry.number <= above) break;  // a bucket lists its boxes in ascending order
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

/// Appends to an array of fixed capacity, and counts what does not fit.
class Appender {
 public:
  explicit Appender(Span<Pair> out) : out_(out) {}
  void add(Index a, Index b) {
    if (count_ < out_.size()) out_.data()[count_] = {a, b};
    ++count_;
  }
  /// Sorts what has been added since the last call by its second number. Contacts then come in an
  /// order that knows nothing of the grids, so that it does not matter when pairs were searched.
  void end_run() {
    const std::size_t end = std::min(count_, out_.size());
    if (run_ < end)
      std::sort(out_.data() + run_, out_.data() + end,
                [](const Pair& p, const Pair& q) { return p.b < q.b; });
    run_ = end;
  }
  Index count() const { return static_cast<Index>(count_); }

 private:
  Span<Pair> out_;
  std::size_t count_ = 0;
  std::size_t run_ = 0;
};

void find_pairs(const CollidePairs& a) {
  CollideCounts counts{};
  Appender face_pairs(a.face_pairs);
  Appender edge_pairs(a.edge_pairs);
  for (Index v = a.vertex_begin; v < a.vertex_end; ++v) {
    const Box& box = a.vertex_box[static_cast<std::size_t>(v)];
    const auto add = [&](Index f) {
      const Tri& t = a.triangles.data()[f];
      if (t.v[0] != v && t.v[1] != v && t.v[2] != v) face_pairs.add(v, f);
    };
    const bool cloth = v < a.cloth_vertex_count;
    if (!cloth || a.self) for_each_meeting(a.cloth_triangles, box, -1, counts.tests, add);
    if (cloth) for_each_meeting(a.obstacle_triangles, box, -1, counts.tests, add);
    face_pairs.end_run();
  }
  for (Index e = a.edge_begin; e < a.edge_end; ++e) {
    const Box& box = a.edge_box[static_cast<std::size_t>(e)];
    const Edge& p = a.edges[static_cast<std::size_t>(e)];
    if (a.self)
      for_each_meeting(a.cloth_edges, box, e, counts.tests, [&](Index f) {
        const Edge& q = a.edges.data()[f];
        if (p.v[0] != q.v[0] && p.v[0] != q.v[1] && p.v[1] != q.v[0] && p.v[1] != q.v[1])
          edge_pairs.add(e, f);
      });
    for_each_meeting(a.obstacle_edges, box, -1, counts.tests,
                     [&](Index f) { edge_pairs.add(e, f); });
    edge_pairs.end_run();
  }
  counts.face_pairs = face_pairs.count();
  counts.edge_pairs = edge_pairs.count();
  a.counts[0] = counts;
}

}  // namespace

void run(OnHost, Queue& queue, const CollidePairs& args) {
  submit_host(queue, [args] { find_pairs(args); });
}

}  // namespace weft
