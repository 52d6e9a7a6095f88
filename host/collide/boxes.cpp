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
    const bool changed = make_motion_boxes();
    a_.obstacles_made.data()[0] = changed || a_.anew ? 1 : 0;
    for (int kind = 0; kind < cluster_kinds; ++kind)
      if (kind % 2 == cloth_vertices || changed || a_.anew) make_list(kind);
  }

 private:
  std::size_t cloth_end() const { return static_cast<std::size_t>(a_.cloth_vertex_count); }

  /// @return whether an obstacle's box is another one than before
  bool make_motion_boxes() const {
    T most = T(0);
    for (std::size_t v = 0; v < a_.positions_t0.size(); ++v)
      most = std::max(most, largest_motion(a_, v));
    const T margin = motion_margin(a_, most);
    bool changed = false;
    for (std::size_t v = 0; v < a_.positions_t0.size(); ++v) {
      const BoxOf<T> box = make_motion_box(a_, v, margin);
      if (v >= cloth_end() && differ(box, a_.motion_box.data()[v])) changed = true;
      a_.motion_box.data()[v] = box;
    }
    return changed;
  }

  void make_list(int kind) const {
    const ClusterList<T>& list = a_.lists[kind];
    double sum = 0;
    for (Index g = 0; g < list.group_count(); ++g) {
      Cluster<float>& group = list.groups.data()[g];
      Box whole = empty_box<float>();
      for (Index lane = 0; lane < cluster_size; ++lane) {
        Box box = empty_box<float>();
        const Index k = g * cluster_size + lane;
        if (k < list.size()) box = make_cluster(kind, k);
        whole = hull(whole, box);
        set_lane(group, lane, box);
      }
      list.hulls.data()[g] = whole;
      sum += static_cast<double>(extent(whole));
    }
    a_.mean_extent.data()[kind] =
        list.group_count() > 0 ? static_cast<float>(sum / list.group_count()) : 0.0f;
  }

  /// @return the box around cluster k
  Box make_cluster(int kind, Index k) const {
    const ClusterList<T>& list = a_.lists[kind];
    Cluster<T>& cluster = list.clusters.data()[k];
    BoxOf<T> whole = empty_box<T>();
    for (Index lane = 0; lane < cluster_size; ++lane) {
      const Index number = k * cluster_size + lane;
      BoxOf<T> box = empty_box<T>();
      if (number < list.count) box = primitive_box(a_, kind, list.first + number);
      whole = hull(whole, box);
      set_lane(cluster, lane, box);
    }
    return around(whole);
  }

  const CollideBoxes<T> a_;
};

}  // namespace

template <class T>
void run(OnHost, Queue& queue, const CollideBoxes<T>& args) {
  submit_host(queue, [args] { BoxMaker<T>(args).make(); });
}

template void run(OnHost, Queue&, const CollideBoxes<float>&);
template void run(OnHost, Queue&, const CollideBoxes<double>&);

}  // namespace weft
