#pragma once

#include <cstdint>

#include "cuda/collide/grid_scan.cuh"
#include "cuda/collide/walk.cuh"
#include "weft/kernels/collide/pairs.hpp"

namespace weft {

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

/// What the stages hand on, in the queue's scratch memory. An item is a part of what a group asks:
/// asking groups count vertices, cloth then obstacle, then edges; a group with much work has many
/// items, none has none. Counts stand by group, then by primitive, then by item, so that their sums
/// are places in the lists.
struct PairWork {
  Index group_count;  ///< asking
  Index face_groups;  ///< of them, those of vertices
  Index* first_item;  ///< [groups + 1]
  Index* item_group;  ///< [items]
  Index* next_item;   ///< [1] that no warp has begun with
  Index* count;       ///< [group_size items] pairs
  Offset* place;      ///< [group_size items + 1]
  Offset* segment;    ///< [items] first segment of an item's meetings
  Meeting* meeting;   ///< [meeting_capacity]
  Offset meeting_capacity;
  unsigned long long* meeting_count;  ///< [1] may exceed the capacity, as some list then does
  Offset* block_sum;                  ///< [scan_blocks]
  int mask_words;
};

/// What an item asks: items, groups and lists by number.
struct Question {
  Index item, chunk, chunks;  ///< chunk of how many that the group is cut into
  ClusterKind asking;
  Index group;  ///< number in the asking list
  ClusterKind cloth, obstacle;
  bool asks_cloth, asks_obstacle;
  Index cloth_groups, groups;  ///< those that can be asked, obstacle behind cloth

  __device__ bool edges() const { return asking == cloth_edges; }
  /// The first group that it may ask: of edges, each pair is met once.
  __device__ Index first_group() const { return !asks_cloth ? cloth_groups : edges() ? group : 0; }
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
  if (covers_too_many(grid, hulls.size(), box)) {
    for (Index i = lowest + lane; i < static_cast<Index>(hulls.size()); i += 32)
      if (boxes_meet(box, hulls.data()[i])) mark(i);
    return;
  }
  constexpr int lanes = 8;  // that share a cell, which seldom holds more
  for_each_cell(grid, box, lane / lanes, 32 / lanes, [&](std::uint32_t bucket, std::uint32_t tag) {
    const Index end = grid.bucket_offset.data()[bucket + 1];
    for (Index e = grid.bucket_offset.data()[bucket] + lane % lanes; e < end; e += lanes) {
      const GridEntry& entry = grid.entries.data()[e];
      if (entry.tag == tag && entry.number >= lowest && boxes_meet(box, entry.box))
        mark(entry.number);
    }
  });
}

}  // namespace weft
