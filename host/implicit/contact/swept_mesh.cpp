#include "host/implicit/contact/swept_mesh.hpp"

#include <algorithm>
#include <utility>

#include "host/geometry/morton.hpp"
#include "host/implicit/parallel/exchange.hpp"
#include "host/state/store.hpp"

namespace weft {
namespace {

Index lowest(const Tri& t) {
  return std::min({t.v[0], t.v[1], t.v[2]});
}

std::vector<Edge> edges_of(const std::vector<Tri>& triangles) {
  std::vector<std::pair<Index, Index>> sides;
  sides.reserve(3 * triangles.size());
  for (const Tri& t : triangles)
    for (int j = 0; j < 3; ++j) {
      const Index a = t.v[j];
      const Index b = t.v[(j + 1) % 3];
      sides.emplace_back(std::min(a, b), std::max(a, b));
    }
  std::sort(sides.begin(), sides.end());
  sides.erase(std::unique(sides.begin(), sides.end()), sides.end());
  std::vector<Edge> edges;
  edges.reserve(sides.size());
  for (const auto& [a, b] : sides) edges.push_back({{a, b}});
  return edges;
}

}  // namespace

SweptMesh make_swept_mesh(const std::vector<Vec3<double>>& positions_t0,
                          const std::vector<Vec3<double>>& positions_t1,
                          const std::vector<Tri>& triangles) {
  SweptMesh mesh;
  std::vector<Index> place(positions_t0.size());
  for (const Index input : morton_order(positions_t0)) {
    const auto i = static_cast<std::size_t>(input);
    place[i] = static_cast<Index>(mesh.positions_t0.size());
    mesh.positions_t0.push_back(positions_t0[i]);
    mesh.positions_t1.push_back(positions_t1[i]);
  }
  mesh.triangles = triangles;
  for (Tri& t : mesh.triangles)
    for (Index& v : t.v) v = place[static_cast<std::size_t>(v)];
  std::stable_sort(mesh.triangles.begin(), mesh.triangles.end(),
                   [](const Tri& a, const Tri& b) { return lowest(a) < lowest(b); });
  mesh.edges = edges_of(mesh.triangles);
  const auto vertices = static_cast<Index>(mesh.positions_t0.size());
  const auto faces = static_cast<Index>(mesh.triangles.size());
  const auto edges = static_cast<Index>(mesh.edges.size());
  mesh.counts = {vertices, vertices, faces, faces, edges, edges};
  return mesh;
}

template <class T>
SweptSearch<T>::SweptSearch(DeviceSet& devices, const SweptMesh& mesh, double inflate,
                            double margin, double split_motion)
    : devices_(devices),
      inflate_(static_cast<T>(inflate)),
      margin_(static_cast<T>(margin)),
      split_motion_(static_cast<T>(split_motion)),
      broad_phase_(devices, mesh.counts, true),
      counts_(static_cast<std::size_t>(devices.size())) {
  const std::size_t pairs =
      4 * mesh.edges.size() / static_cast<std::size_t>(devices.size()) + cluster_size;
  for (int r = 0; r < devices.size(); ++r) {
    Device& device = devices[r];
    Queue& queue = device.compute();
    Rank rank{Buffer<Vec3<T>>(device),
              Buffer<Vec3<T>>(device),
              Buffer<Tri>(device),
              Buffer<Edge>(device),
              Buffer<Pair>(device, pairs),
              Buffer<Pair>(device, pairs),
              Buffer<CollideCounts>(device, 1)};
    upload(queue, rank.triangles, mesh.triangles);
    upload(queue, rank.edges, mesh.edges);
    ranks_.push_back(std::move(rank));
  }
  move(mesh.positions_t0, mesh.positions_t1);
}

template <class T>
void SweptSearch<T>::move(const std::vector<Vec3<double>>& positions_t0,
                          const std::vector<Vec3<double>>& positions_t1) {
  for (int r = 0; r < devices_.size(); ++r) {
    Rank& rank = ranks_[static_cast<std::size_t>(r)];
    upload(devices_[r].compute(), rank.positions_t0, cast_all<T>(positions_t0));
    upload(devices_[r].compute(), rank.positions_t1, cast_all<T>(positions_t1));
  }
}

template <class T>
void SweptSearch<T>::run() {
  std::vector<CollideBoxes<T>> of_ranks;
  for (const Rank& rank : ranks_) {
    CollideBoxes<T> boxes{};
    boxes.positions_t0 = rank.positions_t0.span();
    boxes.positions_t1 = rank.positions_t1.span();
    boxes.edges = rank.edges.span();
    boxes.triangles = rank.triangles.span();
    boxes.margin = margin_;
    boxes.margin_at_rest = margin_;
    boxes.reach = inflate_;
    boxes.split_motion = split_motion_;
    of_ranks.push_back(boxes);
  }
  broad_phase_.launch_boxes(of_ranks);
  do {
    for (int r = 0; r < devices_.size(); ++r) launch_pairs(r);
    read_counts();
  } while (grow_where_full());
}

template <class T>
void SweptSearch<T>::launch_pairs(int r) {
  const Rank& rank = ranks_[static_cast<std::size_t>(r)];
  CollidePairs<T> pairs{};
  pairs.edges = rank.edges.span();
  pairs.triangles = rank.triangles.span();
  pairs.face_pairs = rank.face_pairs.span();
  pairs.edge_pairs = rank.edge_pairs.span();
  pairs.counts = rank.counts.span();
  broad_phase_.launch_pairs(r, pairs);
}

template <class T>
void SweptSearch<T>::read_counts() {
  for (int r = 0; r < devices_.size(); ++r)
    devices_[r].compute().copy(&counts_[static_cast<std::size_t>(r)],
                               ranks_[static_cast<std::size_t>(r)].counts.data(),
                               sizeof(CollideCounts));
  sync_ranks(devices_);
}

template <class T>
bool SweptSearch<T>::grow_where_full() {
  bool full = false;
  for (std::size_t n = 0; n < ranks_.size(); ++n) {
    const auto grow = [&](Buffer<Pair>& list, Index count) {
      if (static_cast<std::size_t>(count) <= list.size()) return;
      list.grow(static_cast<std::size_t>(count));
      full = true;
    };
    grow(ranks_[n].face_pairs, counts_[n].face_pairs);
    grow(ranks_[n].edge_pairs, counts_[n].edge_pairs);
  }
  return full;
}

template <class T>
std::vector<Pair> SweptSearch<T>::joined(Buffer<Pair> Rank::*list,
                                         Index CollideCounts::*count) const {
  std::vector<Pair> all;
  for (std::size_t n = 0; n < ranks_.size(); ++n) {
    const std::vector<Pair> own =
        download(devices_[static_cast<int>(n)].compute(), ranks_[n].*list);
    all.insert(all.end(), own.begin(), own.begin() + counts_[n].*count);
  }
  return all;
}

template <class T>
std::vector<Pair> SweptSearch<T>::face_pairs() const {
  return joined(&Rank::face_pairs, &CollideCounts::face_pairs);
}

template <class T>
std::vector<Pair> SweptSearch<T>::edge_pairs() const {
  return joined(&Rank::edge_pairs, &CollideCounts::edge_pairs);
}

template <class T>
std::int64_t SweptSearch<T>::face_pair_count() const {
  std::int64_t sum = 0;
  for (const CollideCounts& c : counts_) sum += c.face_pairs;
  return sum;
}

template <class T>
std::int64_t SweptSearch<T>::edge_pair_count() const {
  std::int64_t sum = 0;
  for (const CollideCounts& c : counts_) sum += c.edge_pairs;
  return sum;
}

template <class T>
std::int64_t SweptSearch<T>::cell_count() const {
  return broad_phase_.cell_count(0);
}

template <class T>
std::vector<std::int64_t> SweptSearch<T>::tests() const {
  std::vector<std::int64_t> all;
  for (const CollideCounts& c : counts_) all.push_back(c.tests);
  return all;
}

template class SweptSearch<float>;
template class SweptSearch<double>;

}  // namespace weft
