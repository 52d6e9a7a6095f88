#include <algorithm>
#include <limits>
#include <utility>

#include "host/exec/host_device.hpp"
#include "host/implicit/contact_search.hpp"
#include "host/implicit/exchange.hpp"

namespace weft {
namespace {

/// Lets a host's list of `count` items have `more`.
template <class Item>
void make_room(Buffer<Item>& list, std::size_t count, std::size_t more) {
  if (list.size() >= count + more) return;
  Buffer<Item> longer(list.device(), count + more + (count + more) / 4);
  std::copy_n(list.data(), count, longer.data());
  list = std::move(longer);
}

/// Whether the lists with what is to be added can still be counted.
template <class T>
bool fits(const StrayPairs<T>& added, const CollideCounts& counts) {
  constexpr auto max = static_cast<std::size_t>(std::numeric_limits<Index>::max());
  return added.face_pairs().size() <= max - static_cast<std::size_t>(counts.face_pairs) &&
         added.edge_pairs().size() <= max - static_cast<std::size_t>(counts.edge_pairs);
}

/// Merges pairs and their slacks into those of a list that is ordered and has room for them.
void merge(Buffer<Pair>& pairs, Buffer<float>& slack, std::size_t count,
           const std::vector<Pair>& more, const std::vector<float>& more_slack) {
  const auto comes_before = [](const Pair& p, const Pair& q) {
    return p.a != q.a ? p.a < q.a : p.b < q.b;
  };
  for (std::size_t left = more.size(); left > 0;) {
    const std::size_t to = count + left - 1;
    if (count > 0 && comes_before(more[left - 1], pairs.data()[count - 1])) {
      --count;
      pairs.data()[to] = pairs.data()[count];
      slack.data()[to] = slack.data()[count];
    } else {
      --left;
      pairs.data()[to] = more[left];
      slack.data()[to] = more_slack[left];
    }
  }
}

}  // namespace

/// Adds the pairs of those vertices that have left their motion boxes, and their slacks. There are
/// no contacts among them: these stand along the motion that all boxes were made around.
/// @return false where a whole search is called for
template <class T>
bool ContactSearch<T>::add_strays(double dt) {
  DeviceSet& devices = store_.devices();
  // Lists that lack the pairs of cloth with cloth may be completed over the boxes of the search.
  if (devices.backend() != Backend::host || !self_listed_) return false;
  for (int r = 0; r < devices.size(); ++r)
    submit_host(devices[r].compute(), [this, r, dt] {
      Added& added = added_[static_cast<std::size_t>(r)];
      added.found = added.pairs.find(broad_phase_.boxes_of(r, boxes_of(r, dt, stray_room_)),
                                     broad_phase_.search_of(r, search_of(r)));
    });
  sync_ranks(devices);
  // The ranks have the same positions and boxes, and find the same.
  if (!added_.front().found) return false;
  for (int r = 0; r < devices.size(); ++r)
    if (!fits(added_[static_cast<std::size_t>(r)].pairs, counts_[static_cast<std::size_t>(r)]))
      return false;
  for (int r = 0; r < devices.size(); ++r) launch_added(r);
  sync_ranks(devices);
  return true;
}

/// Submits to rank r: the slacks of what add_strays() has found, and both to their places.
template <class T>
void ContactSearch<T>::launch_added(int r) {
  const auto n = static_cast<std::size_t>(r);
  Rank& rank = ranks_[n];
  Added& added = added_[n];
  CollideCounts& counts = counts_[n];
  const std::vector<Pair>& faces = added.pairs.face_pairs();
  const std::vector<Pair>& edges = added.pairs.edge_pairs();
  added.face_slack.resize(faces.size());
  added.edge_slack.resize(edges.size());
  const auto old_faces = static_cast<std::size_t>(counts.face_pairs);
  const auto old_edges = static_cast<std::size_t>(counts.edge_pairs);
  const MemoryName name("pairs");
  make_room(rank.face_pairs, old_faces, faces.size());
  make_room(rank.face_slack, old_faces, faces.size());
  make_room(rank.edge_pairs, old_edges, edges.size());
  make_room(rank.edge_slack, old_edges, edges.size());
  added.counts = {};
  added.counts.face_pairs = static_cast<Index>(faces.size());
  added.counts.edge_pairs = static_cast<Index>(edges.size());
  counts.face_pairs += added.counts.face_pairs;
  counts.edge_pairs += added.counts.edge_pairs;
  CollideProximity<T> proximity = proximity_of(r);
  proximity.face_pairs = {faces.data(), faces.size()};
  proximity.edge_pairs = {edges.data(), edges.size()};
  proximity.face_slack = {added.face_slack.data(), faces.size()};
  proximity.edge_slack = {added.edge_slack.data(), edges.size()};
  Queue& queue = store_.devices()[r].compute();
  queue.copy(rank.counts.data(), &added.counts, sizeof added.counts);
  launch(queue, proximity);
  queue.copy(rank.counts.data(), &counts, sizeof counts);
  submit_host(queue, [&rank, &added, old_faces, old_edges] {
    merge(rank.face_pairs, rank.face_slack, old_faces, added.pairs.face_pairs(), added.face_slack);
    merge(rank.edge_pairs, rank.edge_slack, old_edges, added.pairs.edge_pairs(), added.edge_slack);
  });
}

template bool ContactSearch<float>::add_strays(double);
template bool ContactSearch<double>::add_strays(double);

}  // namespace weft
