#include "weft/kernels/collide/boxes.hpp"

#include <algorithm>

#include "host/exec/host_device.hpp"

namespace weft {
namespace {

/// hull() and grown() of eight boxes at once, written so that compilers keep them in vector
/// registers.
template <class T>
void add_to_hull(const Cluster<T>& more, Cluster<T>& whole) {
  for (int c = 0; c < 3; ++c)
    for (Index k = 0; k < cluster_size; ++k) {
      whole.lo[c][k] = whole.lo[c][k] < more.lo[c][k] ? whole.lo[c][k] : more.lo[c][k];
      whole.hi[c][k] = whole.hi[c][k] > more.hi[c][k] ? whole.hi[c][k] : more.hi[c][k];
    }
}
template <class T>
void grow(T by, Cluster<T>& boxes) {
  for (int c = 0; c < 3; ++c)
    for (Index k = 0; k < cluster_size; ++k) {
      const BoxOf<T> box = grown(BoxOf<T>{{boxes.lo[c][k], 0, 0}, {boxes.hi[c][k], 0, 0}}, by);
      boxes.lo[c][k] = box.lo[0];
      boxes.hi[c][k] = box.hi[0];
    }
}
template <class T>
BoxOf<T> hull_of(const Cluster<T>& boxes) {
  BoxOf<T> whole = lane_of<T>(boxes, 0);
  for (Index k = 1; k < cluster_size; ++k) whole = hull(whole, lane_of<T>(boxes, k));
  return whole;
}

template <class T>
class BoxMaker {
 public:
  explicit BoxMaker(const CollideBoxes<T>& args) : a_(args) {}

  void make() {
    const bool obstacles = make_swept_aabbs();
    a_.obstacles_made.data()[0] = obstacles ? 1 : 0;
    a_.split.data()[0] = split_ ? 1 : 0;
    for (int kind = 0; kind < cluster_kinds; ++kind)
      if (kind % 2 == cloth_vertices || obstacles) make_list(kind);
  }

 private:
  std::size_t cloth_end() const { return static_cast<std::size_t>(a_.cloth_vertex_count); }

  /// @return whether boxes of obstacles have to be made
  bool make_swept_aabbs() {
    T most = T(0);
    for (std::size_t v = 0; v < a_.positions_t0.size(); ++v)
      most = std::max(most, largest_motion(a_, v));
    const T margin = motion_margin(a_, most);
    split_ = most > a_.split_motion;
    bool changed = a_.make_obstacles || a_.obstacles_moved.data()[0] != 0;
    bool moved = false;
    for (std::size_t v = 0; v < a_.positions_t0.size(); ++v) {
      const BoxOf<T> box = make_swept_aabb(a_, v, margin, split_);
      if (v >= cloth_end()) {
        changed = changed || differ(box, a_.swept_aabb.data()[v]);
        moved = moved || (split_ && !stands_still(a_, v));
      }
      a_.swept_aabb.data()[v] = box;
    }
    a_.obstacles_moved.data()[0] = moved ? 1 : 0;
    return changed || moved;
  }

  void make_list(int kind) const {
    const ClusterList<T>& list = a_.lists[kind];
    const Offset groups = list.group_count();
    const auto begin = static_cast<Index>(groups * a_.part / a_.parts);
    const auto end = static_cast<Index>(groups * (a_.part + 1) / a_.parts);
    for (Index g = begin; g < end; ++g) {
      Box whole = empty_box<float>();
      for (Index lane = 0; lane < cluster_size; ++lane) {
        SplitBox<float> box{empty_box<float>(), empty_box<float>()};
        const Index k = g * cluster_size + lane;
        if (k < list.size()) box = make_cluster(kind, k);
        whole = hull(whole, hull(box.start, box.end));
        set_lane(list.groups.data()[g], lane, box.start);
        if (ends_wanted(kind)) set_lane(list.group_ends.data()[g], lane, box.end);
      }
      list.hulls.data()[g] = whole;
    }
    if (a_.parts == 1)
      a_.mean_extent.data()[kind] = mean_extent(list.hulls.subspan(0, list.group_count()));
  }

  /// Those of obstacles may serve when a later motion is split.
  bool ends_wanted(int kind) const { return split_ || kind % 2 == obstacle_vertices; }

  /// @return the boxes around cluster k, which are the same unless the motion is split
  SplitBox<float> make_cluster(int kind, Index k) const {
    const ClusterList<T>& list = a_.lists[kind];
    Cluster<T>& starts = list.clusters.data()[k];
    Cluster<T> ends;
    make_boxes(
        kind, k, [this](Index v) { return a_.swept_aabb.data()[v]; }, ends);
    if (split_)
      make_boxes(
          kind, k, [this](Index v) { return start_of(v); }, starts);
    else
      starts = ends;
    if (ends_wanted(kind)) list.ends.data()[k] = ends;
    return {around(hull_of(starts)), around(hull_of(ends))};
  }

  /// Boxes of cluster k, with reach, around box_of(v) of their corners.
  template <class BoxOfVertex>
  void make_boxes(int kind, Index k, BoxOfVertex box_of, Cluster<T>& out) const {
    const ClusterList<T>& list = a_.lists[kind];
    const Index first = list.first + k * cluster_size;
    const Index count = std::min(cluster_size, list.count - k * cluster_size);
    const auto of_corner = [&](auto corner, Cluster<T>& boxes) {
      for (Index lane = 0; lane < cluster_size; ++lane)
        set_lane(boxes, lane, box_of(corner(first + std::min(lane, count - 1))));
    };
    Cluster<T> more;
    const auto add_corner = [&](auto corner) {
      of_corner(corner, more);
      add_to_hull(more, out);
    };
    if (kind < cloth_faces) {
      of_corner([](Index i) { return i; }, out);
    } else if (kind < cloth_edges) {
      const Tri* t = a_.triangles.data();
      of_corner([t](Index i) { return t[i].v[0]; }, out);
      add_corner([t](Index i) { return t[i].v[1]; });
      add_corner([t](Index i) { return t[i].v[2]; });
    } else {
      const Edge* e = a_.edges.data();
      of_corner([e](Index i) { return e[i].v[0]; }, out);
      add_corner([e](Index i) { return e[i].v[1]; });
    }
    grow(a_.reach, out);
    for (Index lane = count; lane < cluster_size; ++lane) set_lane(out, lane, empty_box<T>());
  }

  BoxOf<T> start_of(Index v) const {
    const Vec3<T>& p = a_.positions_t0.data()[v];
    return grown(BoxOf<T>{{p[0], p[1], p[2]}, {p[0], p[1], p[2]}}, T(0));
  }

  const CollideBoxes<T> a_;
  bool split_ = false;
};

}  // namespace

template <class T>
void run(OnHost, Queue& queue, const CollideBoxes<T>& args) {
  submit_host(queue, [args] { BoxMaker<T>(args).make(); });
}

template void run(OnHost, Queue&, const CollideBoxes<float>&);
template void run(OnHost, Queue&, const CollideBoxes<double>&);

}  // namespace weft
