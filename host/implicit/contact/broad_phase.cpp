#include "host/implicit/contact/broad_phase.hpp"

#include <algorithm>
#include <bit>
#include <set>

#include "host/exec/host_device.hpp"
#include "host/implicit/parallel/exchange.hpp"
#include "host/state/store.hpp"
#include "weft/kernels/collide/work.hpp"

namespace weft {

template <class T>
BroadPhase<T>::BroadPhase(DeviceSet& devices, const PrimitiveCounts& counts, bool self)
    : devices_(devices),
      counts_(counts),
      self_(self),
      shared_(devices.size() > 1 && share_memory(devices)),
      face_cuts_(devices.size()),
      edge_cuts_(devices.size()) {
  for (int r = 0; r < devices.size(); ++r) ranks_.push_back(make_rank(r));
}

template <class T>
ClusterList<T> BroadPhase<T>::empty_list(int kind) const {
  const Index bounds[3][3] = {{0, counts_.cloth_vertices, counts_.vertices},
                              {0, counts_.cloth_triangles, counts_.triangles},
                              {0, counts_.cloth_edges, counts_.edges}};
  const Index* of = bounds[kind / 2] + kind % 2;
  ClusterList<T> list;
  list.first = of[0];
  list.count = of[1] - of[0];
  return list;
}

template <class T>
ClusterList<T> BroadPhase<T>::list(int r, int kind) const {
  const Rank& rank = ranks_[owner(r)];
  ClusterList<T> list = empty_list(kind);
  list.clusters = rank.clusters[kind].span();
  list.groups = rank.groups[kind].span();
  list.hulls = rank.hulls[kind].span();
  list.ends = rank.ends[kind].span();
  list.group_ends = rank.group_ends[kind].span();
  return list;
}

template <class T>
typename BroadPhase<T>::Rank BroadPhase<T>::make_rank(int r) const {
  Device& device = devices_[r];
  Rank rank;
  const MemoryName name("boxes");
  rank.swept_aabb = Buffer<BoxOf<T>>(device, static_cast<std::size_t>(counts_.vertices));
  rank.mean_extent = Buffer<float>(device, cluster_kinds);
  for (auto* flag : {&rank.split, &rank.obstacles_made, &rank.obstacles_moved})
    *flag = Buffer<unsigned char>(device, 1);
  for (int kind = 0; kind < cluster_kinds; ++kind) {
    if (owner(r) != static_cast<std::size_t>(r)) break;
    const ClusterList<T> list = empty_list(kind);
    const auto groups = static_cast<std::size_t>(list.group_count());
    for (auto* clusters : {&rank.clusters[kind], &rank.ends[kind]})
      *clusters = Buffer<Cluster<T>>(device, static_cast<std::size_t>(list.size()));
    for (auto* around : {&rank.groups[kind], &rank.group_ends[kind]})
      *around = Buffer<Cluster<float>>(device, groups);
    rank.hulls[kind] = Buffer<Box>(device, groups);
    if (kind < cloth_faces) continue;
    const MemoryName of_grids("hash");
    const std::size_t buckets = std::bit_ceil(std::max<std::size_t>(4 * groups, 16));
    rank.grid[kind] =
        GridBuffers{Buffer<GridEntry>(device, 8 * groups), Buffer<Index>(device, buckets + 1),
                    Buffer<std::uint32_t>(device, 1), Buffer<float>(device, 1)};
  }
  const MemoryName of_tables("hash");
  const auto table = [&](std::size_t count) { return Buffer<Offset>(device, count + 1); };
  const auto groups = [this](int kind) {
    return static_cast<std::size_t>(empty_list(kind).group_count());
  };
  rank.face_work = table(groups(cloth_vertices) + groups(obstacle_vertices));
  rank.edge_work = table(groups(cloth_edges));
  return rank;
}

template <class T>
CollideBoxes<T> BroadPhase<T>::boxes_of(int r, CollideBoxes<T> args) const {
  const Rank& rank = ranks_[static_cast<std::size_t>(r)];
  args.cloth_vertex_count = counts_.cloth_vertices;
  args.make_obstacles = !rank.made;
  args.swept_aabb = rank.swept_aabb.span();
  for (int kind = 0; kind < cluster_kinds; ++kind) args.lists[kind] = list(r, kind);
  if (shared_) {
    args.part = r;
    args.parts = devices_.size();
  }
  args.mean_extent = rank.mean_extent.span();
  args.split = rank.split.span();
  args.obstacles_made = rank.obstacles_made.span();
  args.obstacles_moved = rank.obstacles_moved.span();
  return args;
}

template <class T>
void BroadPhase<T>::launch_boxes(const std::vector<CollideBoxes<T>>& args) {
  // Of lists that ranks share, all parts are made between two joins.
  if (shared_) join_ranks(devices_);
  for (int r = 0; r < devices_.size(); ++r) {
    const auto n = static_cast<std::size_t>(r);
    launch(devices_[r].compute(), boxes_of(r, args[n]));
    ranks_[n].made = true;
  }
  if (shared_) join_ranks(devices_);
  for (int r = 0; r < devices_.size(); ++r) {
    if (shared_) launch_mean_extents(r);
    for (std::size_t kind = cloth_faces; kind < cluster_kinds; ++kind)
      if (!shared_ || static_cast<int>(kind) % devices_.size() == r) launch_grid(r, kind);
  }
  if (shared_) join_ranks(devices_);
  for (int r = 0; r < devices_.size(); ++r) launch_work(r);
}

/// Of lists that ranks share.
template <class T>
void BroadPhase<T>::launch_mean_extents(int r) {
  const Rank& rank = ranks_[static_cast<std::size_t>(r)];
  submit_host(devices_[r].compute(), [this, &rank] {
    for (int kind = 0; kind < cluster_kinds; ++kind)
      if (kind % 2 == cloth_vertices || rank.obstacles_made.data()[0] != 0)
        rank.mean_extent.data()[kind] = mean_extent(ranks_[0].hulls[kind].span());
  });
}

/// Cells are as the cloth that asks wants them. Obstacles ask as well, but with few boxes: cells as
/// large as a floor would make every component of cloth look at all the others.
template <class T>
void BroadPhase<T>::launch_grid(int r, std::size_t kind) {
  const Rank& own = ranks_[static_cast<std::size_t>(r)];
  const Rank& rank = ranks_[owner(r)];
  Span<const unsigned char> wanted;
  if (kind % 2 == 1) wanted = own.obstacles_made.span();
  const std::size_t asking = kind < cloth_edges ? cloth_vertices : cloth_edges;
  launch(devices_[r].compute(),
         CollideGrid{rank.hulls[kind].span(), own.mean_extent.span().subspan(kind, 1),
                     own.mean_extent.span().subspan(asking, 1), wanted,
                     rank.grid[kind].entries.span(), rank.grid[kind].bucket_offset.span(),
                     rank.grid[kind].levels.span(), rank.grid[kind].cell.span()});
}

template <class T>
void BroadPhase<T>::launch_work(int r) {
  const Rank& rank = ranks_[static_cast<std::size_t>(r)];
  CollideWork<T> work;
  for (int kind = 0; kind < cluster_kinds; ++kind) {
    work.lists[kind] = list(r, kind);
    work.grids[kind] = ranks_[owner(r)].grid[kind].view();
  }
  work.self = self_;
  work.face_work = rank.face_work.span();
  work.edge_work = rank.edge_work.span();
  launch(devices_[r].compute(), work);
}

template <class T>
CollidePairs<T> BroadPhase<T>::search_of(int r, CollidePairs<T> args) const {
  const Rank& rank = ranks_[static_cast<std::size_t>(r)];
  for (int kind = 0; kind < cluster_kinds; ++kind) {
    args.lists[kind] = list(r, kind);
    args.grids[kind] = ranks_[owner(r)].grid[kind].view();
  }
  args.self = self_;
  args.split = rank.split.span();
  args.face_work = rank.face_work.span();
  args.edge_work = rank.edge_work.span();
  args.face_share = face_cuts_.share(r);
  args.edge_share = edge_cuts_.share(r);
  return args;
}

template <class T>
void BroadPhase<T>::share_out(const std::vector<double>& of_faces,
                              const std::vector<double>& of_edges) {
  face_cuts_.balance(of_faces);
  edge_cuts_.balance(of_edges);
}

template <class T>
void BroadPhase<T>::launch_pairs(int r, CollidePairs<T> args) {
  launch(devices_[r].compute(), search_of(r, args));
}

template <class T>
Span<const BoxOf<T>> BroadPhase<T>::swept_aabb(int r) const {
  return ranks_[static_cast<std::size_t>(r)].swept_aabb.span();
}

template <class T>
Span<const unsigned char> BroadPhase<T>::split(int r) const {
  return ranks_[static_cast<std::size_t>(r)].split.span();
}

template <class T>
std::int64_t BroadPhase<T>::cell_count(int r) const {
  Queue& queue = devices_[r].compute();
  std::int64_t count = 0;
  for (int kind = cloth_faces; kind < cluster_kinds; ++kind) {
    const GridBuffers& grid = ranks_[owner(r)].grid[kind];
    std::vector<GridEntry> entries = download(queue, grid.entries);
    const std::vector<Index> offset = download(queue, grid.bucket_offset);
    for (std::size_t b = 0; b + 1 < offset.size(); ++b) {
      // The cells of one bucket, but for the odd two that also share a tag.
      std::set<std::uint32_t> tags;
      for (Index e = offset[b]; e < offset[b + 1]; ++e)
        tags.insert(entries[static_cast<std::size_t>(e)].tag);
      count += static_cast<std::int64_t>(tags.size());
    }
  }
  return count;
}

template class BroadPhase<float>;
template class BroadPhase<double>;

}  // namespace weft
