#pragma once

#include <cstdint>

#include "cuda/collide/grid_scan.cuh"
#include "cuda/collide/walk.cuh"
#include "weft/kernels/collide/pairs.hpp"

namespace weft {

/// A warp an asking cluster, a block an asking group.
inline constexpr int ask_warps = cluster_size;
inline constexpr int ask_threads = 32 * ask_warps;
/// Blocks of them that a processor holds at least.
template <class T>
inline constexpr int ask_blocks = sizeof(T) == sizeof(float) ? 3 : 2;
/// Primitives of a group.
inline constexpr Index group_size = cluster_size * cluster_size;
/// Met groups that a block looks at before it collects more, and meetings that a warp holds before
/// it writes them.
inline constexpr Index list_length = 512;
inline constexpr int meetings_held = 64;
/// Words of the mask of met groups at most: more groups are asked a window at a time.
inline constexpr int mask_words_max = 4096;

/// An asked cluster and which of its boxes the asking cluster's meet: bit 8 j + k of both words, in
/// order, that asking box j meets box k. Groups of the cloth and then of the obstacle count
/// through, and clusters with them, eight to a group. Meetings stand in segments behind a head,
/// whose `cluster` is how many follow and whose rows say where the next segment of the same asking
/// cluster begins.
struct Meeting {
  Index cluster;
  std::uint32_t rows[2];
};
inline constexpr Offset no_segment = -1;

/// What the stages hand on, in the queue's scratch memory. An item is a part of what a group asks:
/// asking groups count vertices, cloth then obstacle, then edges; a group with much work has many
/// items, none has none. Counts stand by group, then by primitive, then by item, so that their sums
/// are places in the lists.
struct PairWork {
  Index group_count;  ///< asking
  Index face_groups;  ///< of them, those of vertices
  Index* first_item;  ///< [groups + 1]
  Index* item_group;  ///< [items]
  Index* count;       ///< [group_size items] pairs
  Offset* place;      ///< [group_size items + 1]
  Offset* segment;    ///< [cluster_size items] first segment of an asking cluster's meetings
  Meeting* meeting;   ///< [meeting_capacity]
  Offset meeting_capacity;
  unsigned long long* meeting_count;  ///< [1] may exceed the capacity, as some list then does
  Offset* block_sum;                  ///< [scan_blocks]
  int mask_words;
};

/// What a block asks: items, groups and lists by number.
struct Question {
  Index item, chunk, chunks;  ///< chunk of how many that the group is cut into
  ClusterKind asking;
  Index group;  ///< number in the asking list
  ClusterKind cloth, obstacle;
  bool asks_cloth, asks_obstacle;
  Index cloth_groups, groups;  ///< those that can be asked, obstacle behind cloth
};

template <class T>
__device__ Question question_of(const CollidePairs<T>& a, const PairWork& work, Index item) {
  Question q;
  q.item = item;
  const Index group = work.item_group[item];
  q.chunk = item - work.first_item[group];
  q.chunks = work.first_item[group + 1] - work.first_item[group];
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

/// Shared memory of a block, besides the mask.
template <class T>
struct AskMemory {
  /// An asking box and the corners of its primitive; first corner -1: there is none. The box is of
  /// the start, and `end` in use, where the motion is split.
  struct alignas(16) AskingBox {
    BoxOf<T> box;
    Index corner[2];
    BoxOf<T> end;
  };
  Question question;
  AskingBox asker[ask_warps][cluster_size];
  Meeting held[ask_warps][meetings_held];
  Index queue[ask_warps][64];
  Index list[list_length];
  Index warp_sum[ask_warps];
  int held_count[ask_warps];
  Box whole[ask_warps];             ///< around the asking cluster
  Box whole_end[ask_warps];         ///< likewise, of the end
  Offset first_segment[ask_warps];  ///< of the warp's, and the latest
  Offset last_segment[ask_warps];
  Offset tests[ask_warps];
  unsigned long long begin;
};

/// Finds what the cluster of one warp meets. All lanes of the warp call everything together.
template <class T>
class Asker {
 public:
  __device__ Asker(const CollidePairs<T>& a, const PairWork& work, AskMemory<T>& memory)
      : a_(a),
        work_(work),
        q_(memory.question),
        memory_(memory),
        warp_(static_cast<int>(threadIdx.x) / 32),
        lane_(static_cast<int>(threadIdx.x) % 32),
        cluster_(memory.question.group * cluster_size + warp_),
        split_(!a.split.empty() && a.split.data()[0] != 0) {
    const ClusterList<T>& list = a.lists[q_.asking];
    active_ = cluster_ < list.size();
    if (lane_ == 0) memory.first_segment[warp_] = memory.last_segment[warp_] = no_segment;
    if (!active_) return;
    if (lane_ == 0) {
      memory.whole[warp_] = lane_of<float>(list.groups.data()[q_.group], warp_);
      if (split_) memory.whole_end[warp_] = lane_of<float>(list.group_ends.data()[q_.group], warp_);
    }
    if (lane_ < cluster_size) {
      auto& asker = memory.asker[warp_][lane_];
      asker.box = lane_of<T>(list.clusters.data()[cluster_], lane_);
      if (split_) asker.end = lane_of<T>(list.ends.data()[cluster_], lane_);
      const Index n = cluster_ * cluster_size + lane_;
      asker.corner[0] = -1;
      if (n < list.count) {
        const Index number = list.first + n;
        if (q_.asking == cloth_edges) {
          asker.corner[0] = a.edges.data()[number].v[0];
          asker.corner[1] = a.edges.data()[number].v[1];
        } else {
          asker.corner[0] = number;
        }
      }
    }
    __syncwarp();
  }

  /// Compares with the clusters of `count` groups in the block's list.
  __device__ void meet_groups(Index count) {
    if (!active_) return;
    for (Index i = 0; i < count; i += 32 / cluster_size) {
      const Index place = i + lane_ / cluster_size;
      Index cluster = 0;
      const bool meets = place < count && meets_cluster(memory_.list[place], cluster);
      const unsigned bits = __ballot_sync(all_lanes, meets);
      if (meets) memory_.queue[warp_][(tail_ + __popc(bits & before())) % 64] = cluster;
      tail_ += __popc(bits);
      __syncwarp();
      meet_queue((tail_ - head_) / 4 * 4);
    }
    tests_ += Offset{cluster_size} * count;
  }

  /// What is left over, then everything to memory. All warps of the block call it together.
  __device__ void finish() {
    meet_queue(tail_ - head_);
    if (lane_ == 0) {
      memory_.held_count[warp_] = held_;
      memory_.tests[warp_] = tests_ + Offset{group_size} * tail_;
    }
    __syncthreads();
    if (threadIdx.x == 0) reserve();
    __syncthreads();
    auto begin = static_cast<Offset>(memory_.begin);
    for (int w = 0; w < warp_; ++w) begin += segment_length(memory_.held_count[w]);
    if (held_ > 0) store(begin);
    const Offset clusters = Offset{cluster_size} * q_.item + warp_;
    if (lane_ == 0) work_.segment[clusters] = memory_.first_segment[warp_];
    if (lane_ >= cluster_size) return;
    const Offset primitive = Offset{cluster_size} * warp_ + lane_;
    work_.count[Offset{group_size} * (q_.item - q_.chunk) + primitive * q_.chunks + q_.chunk] =
        count_;
  }

 private:
  static constexpr unsigned all_lanes = 0xffffffffu;

  __device__ unsigned before() const { return (1u << lane_) - 1u; }
  __device__ static Offset segment_length(int held) { return held > 0 ? held + 1 : 0; }

  /// Whether the asking cluster meets the cluster of group g that is this lane's, and which it is.
  __device__ bool meets_cluster(Index g, Index& cluster) const {
    const Index k = lane_ % cluster_size;
    const bool cloth = g < q_.cloth_groups;
    const ClusterList<T>& list = a_.lists[cloth ? q_.cloth : q_.obstacle];
    const Index group = cloth ? g : g - q_.cloth_groups;
    cluster = g * cluster_size + k;
    const Index own = group * cluster_size + k;
    if (own >= list.size() || (q_.asking == cloth_edges && cloth && own < cluster_)) return false;
    const Box whole = memory_.whole[warp_];
    const Box other = lane_of<float>(list.groups.data()[group], k);
    if (!split_) return boxes_meet(whole, other);
    return may_meet(SplitBox<float>{whole, memory_.whole_end[warp_]},
                    SplitBox<float>{other, lane_of<float>(list.group_ends.data()[group], k)});
  }

  /// A box that is asked.
  struct Asked {
    Index number;     ///< of the primitive; -1: there is none
    SplitBox<T> box;  ///< the end is in use where the motion is split
  };

  /// This lane's box of the four clusters from place `at` of the queue on.
  /// @param end of the queue
  __device__ Asked asked_box(int at, int end) const {
    Asked asked{-1, {empty_box<T>(), empty_box<T>()}};
    at += lane_ / cluster_size;
    if (at >= end) return asked;
    const Index cluster = memory_.queue[warp_][at % 64];
    const bool cloth = cluster < q_.cloth_groups * cluster_size;
    const ClusterList<T>& list = a_.lists[cloth ? q_.cloth : q_.obstacle];
    const Index own = cloth ? cluster : cluster - q_.cloth_groups * cluster_size;
    const Index n = own * cluster_size + lane_ % cluster_size;
    asked.box.start = lane_of<T>(list.clusters.data()[own], lane_ % cluster_size);
    if (split_) asked.box.end = lane_of<T>(list.ends.data()[own], lane_ % cluster_size);
    if (n < list.count) asked.number = list.first + n;
    return asked;
  }

  /// Compares with the next `count` clusters of the queue, four at a time; the boxes of the four
  /// after these are under way meanwhile.
  __device__ void meet_queue(int count) {
    const int end = head_ + count;
    Asked next = asked_box(head_, end);
    for (; head_ < end; head_ += 4) {
      const Asked asked = next;
      next = asked_box(head_ + 4, end);
      meet_clusters(asked);
    }
    head_ = end;
  }

  /// Whether asking primitive and asked one are a pair, if their boxes meet.
  __device__ bool is_pair(const typename AskMemory<T>::AskingBox& asker, Index number,
                          const Tri& corners) const {
    if (asker.corner[0] < 0) return false;
    if (q_.asking != cloth_edges) return shares_no_vertex(asker.corner[0], corners);
    return shares_no_vertex(Edge{{asker.corner[0], asker.corner[1]}},
                            Edge{{corners.v[0], corners.v[1]}});
  }

  /// Compares all boxes of the asking cluster with one box a lane.
  __device__ void meet_clusters(const Asked& asked) {
    __syncwarp();  // keeps the asking boxes in shared memory, and out of 48 registers
    unsigned row[cluster_size];
    unsigned any = 0;
#pragma unroll
    for (int j = 0; j < cluster_size; ++j) {
      const auto& asker = memory_.asker[warp_][j];
      const bool meets = split_ ? may_meet(SplitBox<T>{asker.box, asker.end}, asked.box)
                                : boxes_meet(asker.box, asked.box.start);
      row[j] = __ballot_sync(all_lanes, meets);
      any |= row[j];
    }
    if (any != 0) keep_pairs(asked.number, row);
  }

  /// Of the meetings in `row`, one for each asking box, keeps those that are pairs.
  __device__ void keep_pairs(Index number, unsigned (&row)[cluster_size]) {
    Tri corners{};
    if (number >= 0) {
      if (q_.asking == cloth_edges) {
        const Edge edge = a_.edges.data()[number];
        corners = {{edge.v[0], edge.v[1], -1}};
      } else {
        corners = a_.triangles.data()[number];
      }
    }
    // Within one cluster, and in no other, some edges that are asked come before the asking one.
    const Index first = a_.lists[q_.asking].first + cluster_ * cluster_size;
    unsigned any = 0;
    unsigned own = 0;
#pragma unroll
    for (int j = 0; j < cluster_size; ++j) {
      if (row[j] == 0) continue;
      const bool keep = (row[j] >> lane_ & 1u) != 0 && number >= 0 &&
                        (q_.asking != cloth_edges || number > first + j) &&
                        is_pair(memory_.asker[warp_][j], number, corners);
      row[j] = __ballot_sync(all_lanes, keep);
      any |= row[j];
      if (lane_ == j) own = row[j];
    }
    count_ += __popc(own);
    if (any != 0) hold(row);
  }

  /// Appends the meetings of up to four asked clusters, one to a lane.
  __device__ void hold(const unsigned (&row)[cluster_size]) {
    // Byte `lane` of each row, four rows to a word.
    const unsigned two = static_cast<unsigned>(lane_ % 4) * 0x11u + 0x40u;
    Meeting meeting;
#pragma unroll
    for (int half = 0; half < 2; ++half)
      meeting.rows[half] =
          __byte_perm(__byte_perm(row[4 * half], row[4 * half + 1], two),
                      __byte_perm(row[4 * half + 2], row[4 * half + 3], two), 0x5410);
    meeting.cluster = memory_.queue[warp_][(head_ + lane_ % 4) % 64];
    const bool wanted = lane_ < 4 && (meeting.rows[0] | meeting.rows[1]) != 0;
    const unsigned bits = __ballot_sync(all_lanes, wanted);
    if (wanted) memory_.held[warp_][held_ + __popc(bits & before())] = meeting;
    held_ += __popc(bits);
    __syncwarp();
    if (held_ + 4 > meetings_held) flush();
  }

  /// Writes a full segment.
  __device__ void flush() {
    unsigned long long begin = 0;
    if (lane_ == 0)
      begin =
          atomicAdd(work_.meeting_count, static_cast<unsigned long long>(segment_length(held_)));
    store(static_cast<Offset>(__shfl_sync(all_lanes, begin, 0)));
    __syncwarp();
  }

  /// Room for the last segments of all warps in one go, and the block's tests.
  __device__ void reserve() {
    Offset length = 0;
    Offset tests = 0;
    for (int w = 0; w < ask_warps; ++w) {
      length += segment_length(memory_.held_count[w]);
      tests += memory_.tests[w];
    }
    if (length > 0)
      memory_.begin = atomicAdd(work_.meeting_count, static_cast<unsigned long long>(length));
    atomicAdd(reinterpret_cast<unsigned long long*>(&a_.counts.data()->tests),
              static_cast<unsigned long long>(tests));
  }

  /// Writes what is held as a segment, if there is room, and links it to the one before.
  __device__ void store(Offset begin) {
    if (begin + segment_length(held_) <= work_.meeting_capacity) {
      if (lane_ == 0) {
        work_.meeting[begin] = {held_, {~0u, ~0u}};
        const Offset last = memory_.last_segment[warp_];
        if (last == no_segment) {
          memory_.first_segment[warp_] = begin;
        } else {
          work_.meeting[last].rows[0] = static_cast<std::uint32_t>(begin);
          work_.meeting[last].rows[1] = static_cast<std::uint32_t>(begin >> 32);
        }
        memory_.last_segment[warp_] = begin;
      }
      for (int n = lane_; n < held_; n += 32) work_.meeting[begin + 1 + n] = memory_.held[warp_][n];
    }
    held_ = 0;
  }

  const CollidePairs<T>& a_;
  const PairWork& work_;
  const Question& q_;
  AskMemory<T>& memory_;
  int warp_, lane_;
  Index cluster_;
  bool split_;
  bool active_;
  int head_ = 0;      ///< of the queue
  int tail_ = 0;      ///< how many clusters were met
  int held_ = 0;      ///< meetings not written yet
  Index count_ = 0;   ///< pairs of asking primitive number `lane`
  Offset tests_ = 0;  ///< with the boxes around clusters
};

/// Marks the groups of one grid that the hull `box` meets, those in a window of the mask.
/// @param hulls  the boxes that the grid was built over
/// @param lowest number of the first that counts
/// @param shift  number of the first in the mask
__device__ inline void mark_meeting(const Grid& grid, Span<const Box> hulls, const Box& box,
                                    Index lowest, Index shift, std::uint32_t* mask, int words) {
  const auto mark = [&](Index number) {
    const Index bit = number + shift;
    if (bit >= 0 && bit < 32 * words) atomicOr(&mask[bit / 32], 1u << bit % 32);
  };
  const auto thread = static_cast<int>(threadIdx.x);
  if (covers_too_many(grid, hulls.size(), box)) {
    for (Index i = lowest + thread; i < static_cast<Index>(hulls.size()); i += ask_threads)
      if (boxes_meet(box, hulls.data()[i])) mark(i);
    return;
  }
  constexpr int lanes = 8;  // that share a cell, which seldom holds more
  for_each_cell(
      grid, box, thread / lanes, ask_threads / lanes, [&](std::uint32_t bucket, std::uint32_t tag) {
        const Index end = grid.bucket_offset.data()[bucket + 1];
        for (Index e = grid.bucket_offset.data()[bucket] + thread % lanes; e < end; e += lanes) {
          const GridEntry& entry = grid.entries.data()[e];
          if (entry.tag == tag && entry.number >= lowest && boxes_meet(box, entry.box))
            mark(entry.number);
        }
      });
}

/// Marks the groups that the question's meets, from number `first` on. All threads of the block.
template <class T>
__device__ void mark_groups(const CollidePairs<T>& a, const Question& q, Index first,
                            std::uint32_t* mask, int words) {
  __syncthreads();
  for (int w = static_cast<int>(threadIdx.x); w < words; w += ask_threads) mask[w] = 0;
  __syncthreads();
  const Box box = a.lists[q.asking].hulls.data()[q.group];
  const Index lowest = q.asking == cloth_edges ? q.group : 0;
#pragma unroll 1
  for (int side = q.asks_cloth ? 0 : 1; side < (q.asks_obstacle ? 2 : 1); ++side) {
    const ClusterKind kind = side == 0 ? q.cloth : q.obstacle;
    mark_meeting(a.grids[kind], a.lists[kind].hulls, box, side == 0 ? lowest : 0,
                 side == 0 ? -first : q.cloth_groups - first, mask, words);
  }
  __syncthreads();
}

/// Marks of the mask before those of this thread's words, and all of them in `total`.
__device__ inline Index marks_before(const std::uint32_t* mask, int words, Index* warp_sum,
                                     Index& total) {
  const int run = (words + ask_threads - 1) / ask_threads;
  const int begin = run * static_cast<int>(threadIdx.x);
  Index own = 0;
  for (int w = begin; w < min(words, begin + run); ++w) own += __popc(mask[w]);
  return sum_before<ask_threads>(own, warp_sum, total);
}

/// Writes marks number `begin` to `end` of the mask, ascending, to `list`.
/// @param number of the mark before this thread's first
/// @param first  group of the mask's first bit
__device__ inline void list_marks(const std::uint32_t* mask, int words, Index number, Index begin,
                                  Index end, Index first, Index* list) {
  const int run = (words + ask_threads - 1) / ask_threads;
  const int from = run * static_cast<int>(threadIdx.x);
  for (int w = from; w < min(words, from + run); ++w)
    for (std::uint32_t bits = mask[w]; bits != 0; bits &= bits - 1, ++number)
      if (number >= begin && number < end) list[number - begin] = first + 32 * w + lowest_bit(bits);
}

/// A block an item: the groups that the asking group's hull meets, as a mask, which is in order and
/// names each once; then, a warp an asking cluster, their clusters; then box by box.
template <class T>
__global__ void __launch_bounds__(ask_threads, ask_blocks<T>)
    find_meetings(const __grid_constant__ CollidePairs<T> a,
                  const __grid_constant__ PairWork work) {
  extern __shared__ std::uint32_t mask[];
  __shared__ AskMemory<T> memory;
  const auto item = static_cast<Index>(blockIdx.x);
  if (item >= work.first_item[work.group_count]) return;
  if (threadIdx.x == 0) memory.question = question_of(a, work, item);
  __syncthreads();
  const Question& q = memory.question;
  Asker<T> asker(a, work, memory);
  const int words = work.mask_words;
  const Index window = 32 * words;
  // A chunk has to know first how many groups there are for all chunks. With one window, the mask
  // then stands already.
  Index all = 0;
  for (int pass = q.chunks > 1 ? 0 : 1; pass < 2; ++pass) {
    const Index begin = static_cast<Index>(Offset{all} * q.chunk / q.chunks);
    const Index end =
        q.chunks > 1 ? static_cast<Index>(Offset{all} * (q.chunk + 1) / q.chunks) : q.groups;
    Index seen = 0;
    for (Index first = 0; first < q.groups; first += window) {
      if (pass == 0 || q.chunks == 1 || q.groups > window) mark_groups(a, q, first, mask, words);
      Index total;
      const Index before = seen + marks_before(mask, words, memory.warp_sum, total);
      const Index last = min(end, seen + total);
      for (Index at = max(begin, seen); at < last; at += list_length) {
        const Index batch = min(last, at + list_length);
        __syncthreads();
        list_marks(mask, words, before, at, batch, first, memory.list);
        __syncthreads();
        asker.meet_groups(batch - at);
      }
      seen += total;
    }
    all = seen;
  }
  asker.finish();
}

}  // namespace weft
