#include "host/implicit/stray_pairs.hpp"

#include <algorithm>
#include <cstddef>
#include <iterator>
#include <utility>

#include "host/collide/grid_walk.hpp"
#include "weft/kernels/collide/stray.hpp"

namespace weft {
namespace {

/// Most vertices that may stray: a share of all, and what has strayed is compared one by one.
constexpr std::size_t stray_share = 16;
constexpr std::size_t strays_max = 256;

std::size_t at(Index i) {
  return static_cast<std::size_t>(i);
}

/// What stands in the boxes of a search.
template <class T>
class ListedBoxes {
 public:
  ListedBoxes(const CollidePairs<T>& search, bool split) : s_(search), split_(split) {}

  /// Calls visit(number, box) for each primitive of a kind that may meet `box`.
  template <class Visit>
  void for_each_near(int kind, const SplitBox<T>& box, Visit visit) const {
    const ClusterList<T>& list = s_.lists[kind];
    const SplitBox<float> outer{around(box.start), around(box.end)};
    const Box whole = hull(outer.start, outer.end);
    const auto look = [&](Index group) { in_group(list, group, outer, box, visit); };
    if (kind >= cloth_faces) {
      for_each_meeting(s_.grids[kind], list.hulls, whole, 0, look);
      return;
    }
    for (Index g = 0; g < list.group_count(); ++g)  // there is no grid of vertices
      if (boxes_meet(whole, list.hulls.data()[g])) look(g);
  }

 private:
  template <class Visit>
  void in_group(const ClusterList<T>& list, Index g, const SplitBox<float>& outer,
                const SplitBox<T>& box, Visit visit) const {
    const Index end = std::min((g + 1) * cluster_size, list.size());
    for (Index k = g * cluster_size; k < end; ++k) {
      if (!may_meet(outer, lanes(list.groups, list.group_ends, k))) continue;
      const Index last = std::min((k + 1) * cluster_size, list.count);
      for (Index i = k * cluster_size; i < last; ++i) {
        const SplitBox<T> other = lanes(list.clusters, list.ends, i);
        if (may_meet(box, other)) visit(list.first + i, other);
      }
    }
  }

  template <class S>
  SplitBox<S> lanes(Span<Cluster<S>> starts, Span<Cluster<S>> ends, Index i) const {
    const Index cluster = i / cluster_size, lane = i % cluster_size;
    const BoxOf<S> start = lane_of<S>(starts.data()[cluster], lane);
    return {start, split_ ? lane_of<S>(ends.data()[cluster], lane) : start};
  }

  const CollidePairs<T>& s_;
  bool split_;
};

/// Groups that this rank asks for.
std::pair<Index, Index> groups_of(Span<const Offset> work, const WorkShare& share) {
  return {share_begin(work, share.begin), share_begin(work, share.end)};
}

void sort_once(std::vector<Pair>& pairs) {
  const auto key = [](const Pair& p) { return std::pair(p.a, p.b); };
  std::sort(pairs.begin(), pairs.end(),
            [&](const Pair& p, const Pair& q) { return key(p) < key(q); });
  pairs.erase(std::unique(pairs.begin(), pairs.end(),
                          [&](const Pair& p, const Pair& q) { return key(p) == key(q); }),
              pairs.end());
}

}  // namespace

/// Finds the vertices that have strayed and grows their boxes.
template <class T>
bool StrayPairs<T>::gather(const CollideBoxes<T>& a) {
  const auto count = a.motion_box.size();
  strays_.clear();
  for (std::size_t v = 0; v < count; ++v)
    if (!keeps_to(a.motion_box.data()[v], a.positions_t1.data()[v])) {
      strays_.push_back(static_cast<Index>(v));
      if (strays_.size() > strays_max) return false;
    }
  std::vector<Index> grown;
  std::set_union(grown_.begin(), grown_.end(), strays_.begin(), strays_.end(),
                 std::back_inserter(grown));
  if (grown.size() > std::min(strays_max, count / stray_share) ||
      (!strays_.empty() && strays_.back() >= a.cloth_vertex_count))
    return false;
  stray_of_.assign(count, -1);
  has_grown_.assign(count, 0);
  boxes_before_.clear();
  grown_ = std::move(grown);
  for (const Index v : grown_) has_grown_[at(v)] = 1;
  for (const Index v : strays_) {
    BoxOf<T>& box = a.motion_box.data()[v];
    stray_of_[at(v)] = static_cast<Index>(boxes_before_.size());
    boxes_before_.push_back(box);
    box = hull(box, make_motion_box(a, at(v), a.margin, split_));
  }
  return true;
}

template <class T>
SplitBox<T> StrayPairs<T>::split_box(const CollideBoxes<T>& a, int kind, Index i) const {
  const BoxOf<T> end = primitive_box(a, kind, i);
  return {split_ ? start_box(a, kind, i) : end, end};
}

template <class T>
SplitBox<T> StrayPairs<T>::box_before(const CollideBoxes<T>& a, int kind, Index i) const {
  const BoxOf<T> end = box_around_corners(a, kind, i, [&](Index v) {
    const Index stray = stray_of_[at(v)];
    return stray < 0 ? a.motion_box.data()[v] : boxes_before_[at(stray)];
  });
  return {split_ ? start_box(a, kind, i) : end, end};
}

/// Of the cloth's primitives of a kind, those with a corner whose box has grown.
template <class T>
std::vector<typename StrayPairs<T>::Touched> StrayPairs<T>::touched(const CollideBoxes<T>& a,
                                                                    int kind) const {
  std::vector<Touched> result;
  const auto add = [&](Index i, const Index* v, int corners) {
    bool any = false, now = false;
    for (int j = 0; j < corners; ++j) {
      any = any || has_grown_[at(v[j])] != 0;
      now = now || stray_of_[at(v[j])] >= 0;
    }
    if (any) result.push_back({i, now, split_box(a, kind, i), box_before(a, kind, i)});
  };
  const Index count = a.lists[kind].count;
  if (kind == cloth_vertices)
    for (const Index v : grown_) add(v, &v, 1);
  if (kind == cloth_faces)
    for (Index i = 0; i < count; ++i) add(i, a.triangles.data()[i].v, 3);
  if (kind == cloth_edges)
    for (Index i = 0; i < count; ++i) add(i, a.edges.data()[i].v, 2);
  return result;
}

template <class T>
bool StrayPairs<T>::find(const CollideBoxes<T>& a, const CollidePairs<T>& search) {
  split_ = !search.split.empty() && search.split.data()[0] != 0;
  face_pairs_.clear();
  edge_pairs_.clear();
  if (!gather(a)) return false;
  const std::vector<Touched> vertices = touched(a, cloth_vertices);
  const std::vector<Touched> faces = touched(a, cloth_faces);
  const std::vector<Touched> edges = touched(a, cloth_edges);
  const ListedBoxes<T> listed(search, split_);
  const auto has_grown = [&](const Index* v, int corners) {
    return std::any_of(v, v + corners, [&](Index i) { return has_grown_[at(i)] != 0; });
  };
  const auto [faces_begin, faces_end] = groups_of(search.face_work, search.face_share);
  const auto [edges_begin, edges_end] = groups_of(search.edge_work, search.edge_share);
  constexpr Index group = cluster_size * cluster_size;
  const ClusterList<T>& cloth = search.lists[cloth_vertices];
  const auto add_face = [&, first = faces_begin, last = faces_end](Index v, Index f) {
    const Index asking =
        v < cloth.count ? v / group : cloth.group_count() + (v - cloth.count) / group;
    if (asking >= first && asking < last && shares_no_vertex(v, a.triangles.data()[f]))
      face_pairs_.push_back({v, f});
  };
  const auto add_edge = [&, first = edges_begin, last = edges_end](Index e, Index f) {
    const Index low = std::min(e, f), high = std::max(e, f);
    if (low / group >= first && low / group < last &&
        shares_no_vertex(a.edges.data()[low], a.edges.data()[high]))
      edge_pairs_.push_back({low, high});
  };
  // Whether a pair meets that did not: all others that meet are listed.
  const auto meets_now = [](const Touched& x, const SplitBox<T>& other,
                            const SplitBox<T>& other_before) {
    return may_meet(x.box, other) && !may_meet(x.before, other_before);
  };

  // Against what has not grown, whose boxes stand in the lists.
  for (const int kind : {cloth_faces, obstacle_faces})
    for (const Touched& x : vertices)
      if (x.now && (kind != cloth_faces || search.self))
        listed.for_each_near(kind, x.box, [&](Index f, const SplitBox<T>& box) {
          if (!has_grown(a.triangles.data()[f].v, 3) && meets_now(x, box, box))
            add_face(x.number, f);
        });
  for (const int kind : {cloth_vertices, obstacle_vertices})
    for (const Touched& x : faces)
      if (x.now && (kind != cloth_vertices || search.self))
        listed.for_each_near(kind, x.box, [&](Index v, const SplitBox<T>& box) {
          if (!has_grown(&v, 1) && meets_now(x, box, box)) add_face(v, x.number);
        });
  for (const int kind : {cloth_edges, obstacle_edges})
    for (const Touched& x : edges)
      if (x.now && (kind != cloth_edges || search.self))
        listed.for_each_near(kind, x.box, [&](Index e, const SplitBox<T>& box) {
          if (!has_grown(a.edges.data()[e].v, 2) && meets_now(x, box, box)) add_edge(x.number, e);
        });
  // Among what has grown, whose boxes do not.
  if (search.self) {
    for (const Touched& x : vertices)
      for (const Touched& y : faces)
        if ((x.now || y.now) && meets_now(x, y.box, y.before)) add_face(x.number, y.number);
    for (std::size_t i = 0; i < edges.size(); ++i)
      for (std::size_t j = i + 1; j < edges.size(); ++j)
        if ((edges[i].now || edges[j].now) && meets_now(edges[i], edges[j].box, edges[j].before))
          add_edge(edges[i].number, edges[j].number);
  }
  sort_once(face_pairs_);
  sort_once(edge_pairs_);
  return true;
}

template class StrayPairs<float>;
template class StrayPairs<double>;

}  // namespace weft
