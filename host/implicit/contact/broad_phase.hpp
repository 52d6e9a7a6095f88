#pragma once

#include <cstdint>
#include <vector>

#include "host/implicit/parallel/work_cuts.hpp"
#include "weft/exec/buffer.hpp"
#include "weft/exec/device.hpp"
#include "weft/kernels/collide/boxes.hpp"
#include "weft/kernels/collide/grid.hpp"
#include "weft/kernels/collide/pairs.hpp"

namespace weft {

/// Numbers of primitives. Cloth comes first, then obstacles; counts without "cloth" include both.
struct PrimitiveCounts {
  Index cloth_vertices = 0, vertices = 0;
  Index cloth_triangles = 0, triangles = 0;
  Index cloth_edges = 0, edges = 0;
};

/// Boxes, spatial hashes and workload tables of every rank, and the kernels that find pairs with
/// them (P-Cloth sections 4.2, 4.4). The caller owns the pairs.
template <class T>
class BroadPhase {
 public:
  /// @param self whether to find pairs of cloth with cloth
  BroadPhase(DeviceSet& devices, const PrimitiveCounts& counts, bool self);

  /// Submits to all ranks: boxes of the motion in `args`, and the hashes and tables built on them.
  /// @param args [ranks] all but lists, tables and flags, which are filled in here
  void launch_boxes(const std::vector<CollideBoxes<T>>& args);

  /// The arguments of rank r's box and pair kernels: `args`, with this object's buffers filled in.
  CollideBoxes<T> boxes_of(int r, CollideBoxes<T> args) const;
  CollidePairs<T> search_of(int r, CollidePairs<T> args) const;

  /// Whether later searches find pairs of cloth with cloth. Workload tables depend on it, boxes do
  /// not.
  void set_self(bool self) noexcept { self_ = self; }

  /// Submits to rank r: rebuild the workload tables from the present boxes.
  void launch_work(int r);

  /// Divides the queries of later searches among the ranks, by the work of the latest search. All
  /// ranks must search with the same division.
  /// @param of_faces, of_edges [ranks] work, >= 0
  void share_out(const std::vector<double>& of_faces, const std::vector<double>& of_edges);

  /// Submits to rank r: the pairs of its share.
  /// @param args primitives, pairs and counts; the rest is filled in here
  void launch_pairs(int r, CollidePairs<T> args);

  /// Swept AABBs of all vertices on rank r. Valid after launch_boxes().
  Span<const BoxOf<T>> swept_aabb(int r) const;
  /// [1] Whether rank r split the motion. Valid after launch_boxes().
  Span<const unsigned char> split(int r) const;

  /// Number of non-empty cells in rank r's hashes, of all kinds and sizes. Waits for the rank.
  std::int64_t cell_count(int r) const;

 private:
  struct GridBuffers {
    Buffer<GridEntry> entries;
    Buffer<Index> bucket_offset;
    Buffer<std::uint32_t> levels;
    Buffer<float> cell;
    Grid view() const { return {entries.span(), bucket_offset.span(), levels.span(), cell.span()}; }
  };
  struct Rank {
    Buffer<BoxOf<T>> swept_aabb;
    Buffer<Cluster<T>> clusters[cluster_kinds], ends[cluster_kinds];
    Buffer<Cluster<float>> groups[cluster_kinds], group_ends[cluster_kinds];
    Buffer<Box> hulls[cluster_kinds];
    Buffer<float> mean_extent;
    Buffer<unsigned char> split, obstacles_made, obstacles_moved;
    GridBuffers grid[cluster_kinds];  ///< vertices: not in use
    Buffer<Offset> face_work, edge_work;
    bool made = false;
  };

  Rank make_rank(int r) const;
  void launch_mean_extents(int r);
  void launch_grid(int r, std::size_t kind);
  ClusterList<T> empty_list(int kind) const;
  ClusterList<T> list(int r, int kind) const;
  /// The rank whose lists and hashes rank r reads.
  std::size_t owner(int r) const { return shared_ ? 0 : static_cast<std::size_t>(r); }

  DeviceSet& devices_;
  PrimitiveCounts counts_;
  bool self_;
  bool shared_;  ///< ranks read the lists and hashes of rank 0, and each of them makes a part
  WorkCuts face_cuts_, edge_cuts_;
  std::vector<Rank> ranks_;
};

}  // namespace weft
