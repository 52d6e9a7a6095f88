#include "weft/kernels/collide/boxes.hpp"

#include <algorithm>

#include "host/exec/host_device.hpp"

namespace weft {
namespace {

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
    double sum = 0;
    for (Index g = 0; g < list.group_count(); ++g) {
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
      sum += static_cast<double>(extent(whole));
    }
    a_.mean_extent.data()[kind] =
        list.group_count() > 0 ? static_cast<float>(sum / list.group_count()) : 0.0f;
  }

  /// Those of obstacles may serve when a later motion is split.
  bool ends_wanted(int kind) const { return split_ || kind % 2 == obstacle_vertices; }

  /// @return the boxes around cluster k, which are the same unless the motion is split
  SplitBox<float> make_cluster(int kind, Index k) const {
    const ClusterList<T>& list = a_.lists[kind];
    SplitBox<T> whole{empty_box<T>(), empty_box<T>()};
    for (Index lane = 0; lane < cluster_size; ++lane) {
      const Index number = k * cluster_size + lane;
      SplitBox<T> box{empty_box<T>(), empty_box<T>()};
      if (number < list.count) {
        box.end = primitive_box(a_, kind, list.first + number);
        box.start = split_ ? start_box(a_, kind, list.first + number) : box.end;
      }
      whole = {hull(whole.start, box.start), hull(whole.end, box.end)};
      set_lane(list.clusters.data()[k], lane, box.start);
      if (ends_wanted(kind)) set_lane(list.ends.data()[k], lane, box.end);
    }
    return {around(whole.start), around(whole.end)};
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
