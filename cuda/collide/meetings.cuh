#pragma once

#include <cstdint>

#include "cuda/collide/grid_scan.cuh"
#include "cuda/collide/walk.cuh"
#include "cuda/exec/sums.cuh"
#include "weft/kernels/collide/pairs.hpp"

namespace weft {

/// Hulls that are compared while a cell is looked up: who covers more cells had better compare all.
inline constexpr double boxes_a_cell = 64;
/// Primitives of a group.
inline constexpr Index group_size = cluster_size * cluster_size;
/// Meetings that a warp holds before it writes them.
inline constexpr int meetings_held = 64;
/// Words of the mask of met groups at most: more groups are asked a window at a time.
inline constexpr int mask_words_max = 1216;

/// A cluster that asks, one that is asked, and which of their boxes meet: bit 8 j + k of both
/// words, in order, that asking box j meets box k. `clusters` is eight times the number of the
/// asked one and the asking one's number in its group; groups of the cloth and then of the obstacle
/// count through, and clusters with them, eight to a group. Meetings stand in segments behind a
/// head, whose `clusters` is how many follow and whose rows say where the next segment of the same
/// item begins. Those of one asking cluster come in the order of the clusters that it asks.
struct Meeting {
  std::uint32_t clusters;
  std::uint32_t rows[2];
};
inline constexpr Offset no_segment = -1;

/// What the stages hand on, in the queue's scratch memory. Asking groups count vertices, cloth then
/// obstacle, then edges. Each has a list of the groups that its hull meets, if there is room, and
/// an item is a part of these. Counts stand by group, then by primitive, then by item, so that
/// their sums are places in the lists.
struct PairWork {
  Index group_count;  ///< asking
  Index face_groups;  ///< of them, those of vertices
  Index* next_group;  ///< [1] that no warp has begun with
  Index* met_count;   ///< [groups] of groups that are met
  Offset* met_begin;  ///< [groups] where they are listed, ascending; -1: there was no room
  Index* met;         ///< [met_capacity]
  Offset met_capacity;
  unsigned long long* met_total;  ///< [1] sum of the counts; may exceed the capacity
  Index* first_item;              ///< [groups + 1]
  Index* item_group;              ///< [items]
  Index* next_item;               ///< [1] that no warp has begun with
  Index* count;                   ///< [group_size items] pairs
  Offset* place;                  ///< [group_size items + 1]
  Offset* segment;                ///< [items] first segment of an item's meetings
  Meeting* meeting;               ///< [meeting_capacity]
  Offset meeting_capacity;
  unsigned long long* meeting_count;  ///< [1] may exceed the capacity, as some list then does
  Offset* block_sum;                  ///< [scan_blocks]
  int mask_words;                     ///< of what lists groups
  int ask_mask_words;                 ///< of what compares without a list
};

/// What an item asks: items, groups and lists by number.
struct Question {
  Index item, chunk, chunks;  ///< chunk of how many that the group is cut into
  ClusterKind asking;
  Index group;  ///< number in the asking list
  ClusterKind cloth, obstacle;
  bool asks_cloth, asks_obstacle;
  Index cloth_groups, groups;  ///< those that can be asked, obstacle behind cloth
  Index met_count;             ///< see PairWork
  Offset met_begin;

  __device__ bool edges() const { return asking == cloth_edges; }
  /// The first group that it may ask: of edges, each pair is met once.
  __device__ Index first_group() const { return !asks_cloth ? cloth_groups : edges() ? group : 0; }
};

/// @param group number among those that ask
template <class T>
__device__ Question question_of_group(const CollidePairs<T>& a, const PairWork& work, Index group) {
  Question q{};
  const bool edges = group >= work.face_groups;
  const Index cloth = a.lists[cloth_vertices].group_count();
  const bool obstacle = !edges && group >= cloth;
  q.asking = edges ? cloth_edges : obstacle ? obstacle_vertices : cloth_vertices;
  q.group = edges ? group - work.face_groups : obstacle ? group - cloth : group;
  q.cloth = edges ? cloth_edges : cloth_faces;
  q.obstacle = edges ? obstacle_edges : obstacle_faces;
  q.asks_cloth = obstacle || a.self;
  q.asks_obstacle = !obstacle;
  q.cloth_groups = a.lists[q.cloth].group_count();
  q.groups = q.cloth_groups + (obstacle ? 0 : a.lists[q.obstacle].group_count());
  return q;
}

template <class T>
__device__ Question question_of(const CollidePairs<T>& a, const PairWork& work, Index item) {
  const Index group = work.item_group[item];
  Question q = question_of_group(a, work, group);
  q.item = item;
  q.chunk = item - work.first_item[group];
  q.chunks = work.first_item[group + 1] - work.first_item[group];
  q.met_count = work.met_count[group];
  q.met_begin = work.met_begin[group];
  return q;
}

/// Marks the groups of one grid that the hull `box` meets, those in a window of the mask. All lanes
/// of a warp.
/// @param hulls  the boxes that the grid was built over
/// @param lowest number of the first that counts
/// @param shift  number of the first in the mask
__device__ inline void mark_meeting(const Grid& grid, Span<const Box> hulls, const Box& box,
                                    Index lowest, Index shift, std::uint32_t* mask, int words) {
  const auto mark = [&](Index number) {
    const Index bit = number + shift;
    if (bit >= 0 && bit < 32 * words) atomicOr(&mask[bit / 32], 1u << bit % 32);
  };
  const auto lane = static_cast<int>(threadIdx.x % 32);
  constexpr int together = 4;  // loads under way
  const CoveredCells cells(grid, box);
  if (cells.too_many(hulls.size(), boxes_a_cell)) {
    const auto count = static_cast<Index>(hulls.size());
    for (Index i = lowest + lane; i < count; i += 32 * together) {
      Box other[together];
#pragma unroll
      for (int k = 0; k < together; ++k)
        other[k] = i + 32 * k < count ? hulls.data()[i + 32 * k] : empty_box<float>();
#pragma unroll
      for (int k = 0; k < together; ++k)
        if (boxes_meet(box, other[k])) mark(i + 32 * k);
    }
    return;
  }
  // A lane a cell, then a lane an entry of all these cells.
  for (std::int32_t n = 0; n < cells.count(); n += 32) {
    const CoveredCells::Cell cell = cells(n + lane);
    Index begin = 0, count = 0;
    if (cell.is_one) {
      begin = grid.bucket_offset.data()[cell.bucket];
      count = grid.bucket_offset.data()[cell.bucket + 1] - begin;
    }
    const Index sum = cuda::sum_up_to_lane(count);
    const Index total = __shfl_sync(cuda::whole_warp, sum, 31);
    for (Index first = 0; first < total; first += 32 * together) {
      GridEntry entry[together];
      bool is_one[together];
      std::uint32_t tag[together];
#pragma unroll
      for (int k = 0; k < together; ++k) {
        const Index e = first + 32 * k + lane;
        const int of = lane_that_has(sum - count, e);
        const Index place = __shfl_sync(cuda::whole_warp, begin - (sum - count), of) + e;
        tag[k] = __shfl_sync(cuda::whole_warp, cell.tag, of);
        is_one[k] = e < total;
        if (is_one[k]) entry[k] = grid.entries.data()[place];
      }
#pragma unroll
      for (int k = 0; k < together; ++k)
        if (is_one[k] && entry[k].tag == tag[k] && entry[k].number >= lowest &&
            boxes_meet(box, entry[k].box))
          mark(entry[k].number);
    }
  }
}

/// Groups that a question's meets, as a mask, which is in order and names each once. All lanes of a
/// warp call everything together.
template <class T>
class MeetingMask {
 public:
  /// @param mask [words] of the warp alone
  __device__ MeetingMask(const CollidePairs<T>& a, std::uint32_t* mask, int words)
      : a_(a), mask_(mask), words_max_(words), lane_(static_cast<int>(threadIdx.x) % 32) {}

  /// Groups that one window holds, and where the first window begins.
  __device__ Index window() const { return 32 * words_max_; }
  __device__ static Index origin(const Question& q) { return q.first_group() / 32 * 32; }

  /// Words in use of the window that begins with group `first`.
  __device__ int words_from(const Question& q, Index first) const {
    return min(words_max_, (q.groups - first + 31) / 32);
  }

  /// Marks the groups of the window.
  __device__ void mark(const Question& q, Index first) {
    const int words = words_from(q, first);
    __syncwarp();
    for (int w = lane_; w < words; w += 32) mask_[w] = 0;
    __syncwarp();
    const Box box = a_.lists[q.asking].hulls.data()[q.group];
#pragma unroll 1
    for (int side = q.asks_cloth ? 0 : 1; side < (q.asks_obstacle ? 2 : 1); ++side) {
      const ClusterKind kind = side == 0 ? q.cloth : q.obstacle;
      mark_meeting(a_.grids[kind], a_.lists[kind].hulls, box, side == 0 && q.edges() ? q.group : 0,
                   side == 0 ? -first : q.cloth_groups - first, mask_, words);
    }
    __syncwarp();
  }

  __device__ Index count(const Question& q, Index first) const {
    const int words = words_from(q, first);
    Index own = 0;
    for (int w = lane_; w < words; w += 32) own += __popc(mask_[w]);
    return cuda::sum_lanes(own);
  }

  /// 32 groups from word `w` of the window on.
  __device__ std::uint32_t word(int w) const {
    return mask_[w];
  }

 private:
  const CollidePairs<T>& a_;
  std::uint32_t* mask_;
  int words_max_;
  int lane_;
};

/// Lists the groups that each asking group of this rank's share meets.
template <class T>
class HullAsker {
 public:
  __device__ HullAsker(const CollidePairs<T>& a, const PairWork& work, std::uint32_t* mask)
      : a_(a),
        work_(work),
        mask_(a, mask, work.mask_words),
        lane_(static_cast<int>(threadIdx.x) % 32) {}

  __device__ void ask(Index group) {
    const Question q = question_of_group(a_, work_, group);
    const Index origin = mask_.origin(q);
    Index all = 0;
    for (Index first = origin; first < q.groups; first += mask_.window()) {
      mask_.mark(q, first);
      all += mask_.count(q, first);
    }
    unsigned long long at = 0;
    if (lane_ == 0 && all > 0)
      at = atomicAdd(work_.met_total, static_cast<unsigned long long>(all));
    auto begin = static_cast<Offset>(__shfl_sync(cuda::whole_warp, at, 0));
    if (begin + all > work_.met_capacity) begin = -1;
    if (lane_ == 0) {
      work_.met_count[group] = all;
      work_.met_begin[group] = begin;
    }
    if (begin < 0 || all == 0) return;
    const bool stands = q.groups - origin <= mask_.window();
    for (Index first = origin; first < q.groups; first += mask_.window()) {
      if (!stands) mask_.mark(q, first);
      begin = write(first, mask_.words_from(q, first), begin);
    }
  }

 private:
  /// @return where the next window's groups go
  __device__ Offset write(Index first, int words, Offset begin) const {
#pragma unroll 1
    for (int block = 0; block < words; block += 32) {
      std::uint32_t bits = block + lane_ < words ? mask_.word(block + lane_) : 0;
      const int own = __popc(bits);
      if (!__any_sync(cuda::whole_warp, own > 0)) continue;
      const int sum = cuda::sum_up_to_lane(own);
      Index* out = work_.met + begin + (sum - own);
      for (; bits != 0; bits &= bits - 1) *out++ = first + 32 * (block + lane_) + lowest_bit(bits);
      begin += __shfl_sync(cuda::whole_warp, sum, 31);
    }
    return begin;
  }

  const CollidePairs<T>& a_;
  const PairWork& work_;
  MeetingMask<T> mask_;
  int lane_;
};

}  // namespace weft
