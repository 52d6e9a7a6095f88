#include <algorithm>
#include <limits>
#include <utility>

#include "host/exec/host_device.hpp"
#include "host/implicit/contact/contact_detection.hpp"
#include "host/implicit/parallel/exchange.hpp"
#include "weft/kernels/collide/candidate_update.hpp"

namespace weft {
namespace {

/// Most vertices out of bounds at a time, on the host and on GPUs, and the same as a share of all:
/// each of them is compared with all the rest. What they touch at most, and the most pairs
/// that they make.
constexpr std::size_t host_out_of_bounds_max = 256;
constexpr std::size_t gpu_out_of_bounds_max = 1024;
constexpr std::size_t out_of_bounds_share = 16;
constexpr std::size_t dirty_per_vertex = 16;
constexpr std::size_t update_pairs_max = 1 << 16;

/// Bounds of pairs that nobody has measured. It must not be separation_bound_of_contact.
constexpr float bound_unknown = -std::numeric_limits<float>::max();

bool comes_before(const Pair& p, const Pair& q) {
  return p.a != q.a ? p.a < q.a : p.b < q.b;
}

void sort_once(std::vector<Pair>& pairs) {
  std::sort(pairs.begin(), pairs.end(), comes_before);
  const auto same = [](const Pair& p, const Pair& q) { return p.a == q.a && p.b == q.b; };
  pairs.erase(std::unique(pairs.begin(), pairs.end(), same), pairs.end());
}

/// Lets a host's list of `count` items have `more`.
template <class Item>
void make_room(Buffer<Item>& list, std::size_t count, std::size_t more) {
  if (list.size() >= count + more) return;
  Buffer<Item> longer(list.device(), count + more + (count + more) / 4);
  std::copy_n(list.data(), count, longer.data());
  list = std::move(longer);
}

/// Merges pairs into those of a host's list that is ordered and has room for them.
void merge(Buffer<Pair>& pairs, Buffer<float>& separation_bound, Buffer<float>& distance,
           std::size_t count, const std::vector<Pair>& more) {
  for (std::size_t left = more.size(); left > 0;) {
    const std::size_t to = count + left - 1;
    if (count > 0 && comes_before(more[left - 1], pairs.data()[count - 1])) {
      --count;
      pairs.data()[to] = pairs.data()[count];
      separation_bound.data()[to] = separation_bound.data()[count];
      distance.data()[to] = distance.data()[count];
    } else {
      --left;
      pairs.data()[to] = more[left];
      separation_bound.data()[to] = bound_unknown;
      distance.data()[to] = bound_unknown;
    }
  }
}

}  // namespace

/// Adds the pairs of those vertices that have left their swept AABBs, where these are few. There
/// are no contacts among them: these stand along the motion that all boxes were made around.
/// @return false where a whole search is called for
template <class T>
bool ContactDetection<T>::update_candidates(double dt) {
  // Lists that lack the pairs of cloth with cloth may be completed over the boxes of the search.
  if (!self_listed_ || !find_out_of_bounds(dt)) return false;
  for (std::size_t n = 0; n < ranks_.size(); ++n) {
    CollideCounts& counts = counts_[n];
    counts.face_pairs += static_cast<Index>(added_[n].face_pairs.size());
    counts.edge_pairs += static_cast<Index>(added_[n].edge_pairs.size());
  }
  for (int r = 0; r < store_.devices().size(); ++r) launch_added(r);
  sync_ranks(store_.devices());
  return true;
}

/// Grows the boxes of all ranks, and shares out the pairs that this takes.
template <class T>
bool ContactDetection<T>::find_out_of_bounds(double dt) {
  DeviceSet& devices = store_.devices();
  Offset out_of_bounds = 0;
  for (const CollideCounts& c : counts_) out_of_bounds += c.out_of_bounds;
  const auto vertices = static_cast<std::size_t>(store_.model().vertex_count);
  const bool on_host = devices.backend() == Backend::host;
  const std::size_t most = std::min(on_host ? host_out_of_bounds_max : gpu_out_of_bounds_max,
                                    vertices / out_of_bounds_share);
  const std::size_t dirty_max = dirty_per_vertex * most;
  if (out_of_bounds > static_cast<Offset>(most)) return false;
  for (int r = 0; r < devices.size(); ++r) {
    const auto n = static_cast<std::size_t>(r);
    CandidateUpdateBuffers& own = candidate_updates_[n];
    own.out_of_bounds_index.resize(vertices);
    own.out_of_bounds.resize(most);
    own.dirty.resize(dirty_max);
    // The ranks have the same positions and boxes: what one finds is what all would.
    if (r == 0) own.face_pairs.resize(update_pairs_max);
    if (r == 0) own.edge_pairs.resize(update_pairs_max);
    launch(devices[r].compute(),
           CollideCandidateUpdate<T>{
               broad_phase_.boxes_of(r, boxes_of(r, dt, update_margin_factor_)),
               broad_phase_.search_of(r, search_of(r)).self, r == 0, own.out_of_bounds_index.span(),
               own.out_of_bounds.span(), own.dirty.span(), own.face_pairs.span(),
               own.edge_pairs.span(), own.counts.span()});
  }
  CandidateUpdateBuffers& first = candidate_updates_.front();
  Queue& queue = devices[0].compute();
  CandidateUpdateCounts found;
  queue.copy(&found, first.counts.data(), sizeof found);
  sync_ranks(devices);
  const auto fits = [](Index count, std::size_t room) {
    return static_cast<std::size_t>(count) <= room;
  };
  if (found.obstacles > 0 || !fits(found.out_of_bounds, most) || !fits(found.dirty, dirty_max) ||
      !fits(found.face_pairs, update_pairs_max) || !fits(found.edge_pairs, update_pairs_max))
    return false;
  std::vector<Pair> faces(static_cast<std::size_t>(found.face_pairs));
  std::vector<Pair> edges(static_cast<std::size_t>(found.edge_pairs));
  queue.copy(faces.data(), first.face_pairs.data(), faces.size() * sizeof(Pair));
  queue.copy(edges.data(), first.edge_pairs.data(), edges.size() * sizeof(Pair));
  queue.sync();
  sort_once(faces);
  sort_once(edges);
  return share_candidate_update(faces, edges);
}

/// To the rank that asks for them, in the order of its list; on GPUs in even parts.
/// @return false where the lists cannot take them
template <class T>
bool ContactDetection<T>::share_candidate_update(const std::vector<Pair>& faces,
                                                 const std::vector<Pair>& edges) {
  constexpr auto index_max = static_cast<std::size_t>(std::numeric_limits<Index>::max());
  const bool on_host = store_.devices().backend() == Backend::host;
  const auto ranks = static_cast<int>(ranks_.size());
  const CollidePairs<T> search = broad_phase_.search_of(0, search_of(0));
  const ClusterList<T>& cloth = search.lists[cloth_vertices];
  constexpr Index group = cluster_size * cluster_size;
  const auto face_group = [&](const Pair& pair) {
    return pair.a < cloth.count ? pair.a / group
                                : cloth.group_count() + (pair.a - cloth.count) / group;
  };
  const auto edge_group = [](const Pair& pair) { return pair.a / group; };
  const auto share = [&](const std::vector<Pair>& all, Span<const Offset> work,
                         const WorkShare& of_rank, int r, const auto& group_of,
                         std::vector<Pair>& own) {
    own.clear();
    if (!on_host) {
      const auto size = static_cast<Offset>(all.size());
      own.assign(all.begin() + size * r / ranks, all.begin() + size * (r + 1) / ranks);
      return;
    }
    const Index begin = share_begin(work, of_rank.begin), end = share_begin(work, of_rank.end);
    for (const Pair& pair : all)
      if (group_of(pair) >= begin && group_of(pair) < end) own.push_back(pair);
  };
  bool fit = true;
  for (int r = 0; r < ranks; ++r) {
    const auto n = static_cast<std::size_t>(r);
    const CollidePairs<T> asked = broad_phase_.search_of(r, search_of(r));
    share(faces, search.face_work, asked.face_share, r, face_group, added_[n].face_pairs);
    share(edges, search.edge_work, asked.edge_share, r, edge_group, added_[n].edge_pairs);
    const auto fits = [&](Index count, std::size_t more, std::size_t room) {
      return static_cast<std::size_t>(count) + more <= (on_host ? index_max : room);
    };
    fit = fit &&
          fits(counts_[n].face_pairs, added_[n].face_pairs.size(), ranks_[n].face_pairs.size()) &&
          fits(counts_[n].edge_pairs, added_[n].edge_pairs.size(), ranks_[n].edge_pairs.size());
  }
  return fit;
}

/// Submits to rank r: its share of what has been found to its lists, whose counts include it.
template <class T>
void ContactDetection<T>::launch_added(int r) {
  const auto n = static_cast<std::size_t>(r);
  Rank& rank = ranks_[n];
  Added& added = added_[n];
  Queue& queue = store_.devices()[r].compute();
  const auto old_count = [](Index count, const std::vector<Pair>& more) {
    return static_cast<std::size_t>(count) - more.size();
  };
  const std::size_t old_faces = old_count(counts_[n].face_pairs, added.face_pairs);
  const std::size_t old_edges = old_count(counts_[n].edge_pairs, added.edge_pairs);
  queue.copy(rank.counts.data(), &counts_[n], sizeof counts_[n]);
  if (queue.backend() == Backend::host) {
    const MemoryName name("pairs");
    make_room(rank.face_pairs, old_faces, added.face_pairs.size());
    make_room(rank.face_separation_bound, old_faces, added.face_pairs.size());
    make_room(rank.face_distance, old_faces, added.face_pairs.size());
    make_room(rank.edge_pairs, old_edges, added.edge_pairs.size());
    make_room(rank.edge_separation_bound, old_edges, added.edge_pairs.size());
    make_room(rank.edge_distance, old_edges, added.edge_pairs.size());
    submit_host(queue, [&rank, &added, old_faces, old_edges] {
      merge(rank.face_pairs, rank.face_separation_bound, rank.face_distance, old_faces,
            added.face_pairs);
      merge(rank.edge_pairs, rank.edge_separation_bound, rank.edge_distance, old_edges,
            added.edge_pairs);
    });
    return;
  }
  // At the end of the lists: their order decides that of contacts, which are no more taken from
  // these lists.
  unordered_ = true;
  added.separation_bound.assign(std::max(added.face_pairs.size(), added.edge_pairs.size()),
                                bound_unknown);
  const auto append = [&](Buffer<Pair>& pairs, Buffer<float>& separation_bound, std::size_t at,
                          const std::vector<Pair>& more) {
    queue.copy(pairs.data() + at, more.data(), more.size() * sizeof(Pair));
    queue.copy(separation_bound.data() + at, added.separation_bound.data(),
               more.size() * sizeof(float));
  };
  append(rank.face_pairs, rank.face_separation_bound, old_faces, added.face_pairs);
  append(rank.edge_pairs, rank.edge_separation_bound, old_edges, added.edge_pairs);
}

template bool ContactDetection<float>::update_candidates(double);
template bool ContactDetection<double>::update_candidates(double);

}  // namespace weft
