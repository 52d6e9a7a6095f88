#include "weft/kernels/collide/candidate_update.hpp"

#include "host/exec/host_device.hpp"

namespace weft {
namespace {

template <class T>
class CandidateUpdater {
 public:
  explicit CandidateUpdater(const CollideCandidateUpdate<T>& args)
      : a_(args), counts_(args.counts[0]) {}

  void run() {
    counts_ = {};
    find();
    if (!may_grow(a_)) return;
    for (Index n = 0; n < counts_.out_of_bounds; ++n) grow_swept_aabb(a_, n);
    if (a_.boxes.part > 0 && !a_.search) return;
    for (const int kind : {cloth_vertices, cloth_faces, cloth_edges}) touch(kind);
    if (!a_.search || static_cast<std::size_t>(counts_.dirty) > a_.dirty.size()) return;
    for (Index n = 0; n < counts_.dirty; ++n) ask(a_.dirty.data()[n]);
  }

 private:
  template <class Item>
  static void append(Span<Item> list, Index& count, const Item& item) {
    const auto place = static_cast<std::size_t>(count++);
    if (place < list.size()) list[place] = item;
  }

  void find() {
    for (std::size_t v = 0; v < a_.out_of_bounds_index.size(); ++v) {
      const auto vertex = static_cast<Index>(v);
      a_.out_of_bounds_index[v] = -1;
      if (!is_out_of_bounds(a_, vertex)) continue;
      if (vertex >= a_.boxes.cloth_vertex_count) ++counts_.obstacles;
      a_.out_of_bounds_index[v] = counts_.out_of_bounds;
      append(a_.out_of_bounds, counts_.out_of_bounds, {vertex, {}});
    }
  }

  void touch(int kind) {
    for (Index i = 0; i < a_.boxes.lists[kind].count; ++i) {
      if (!is_dirty(a_, kind, i)) continue;
      append(a_.dirty, counts_.dirty, {kind, i});
      if (a_.boxes.part == 0) grow_around(kind, i);
    }
  }

  /// The boxes around a primitive that has been dirty.
  void grow_around(int kind, Index i) {
    const ClusterList<T>& list = a_.boxes.lists[kind];
    const bool split = a_.boxes.split[0] != 0;
    const BoxOf<T> box = primitive_box(a_.boxes, kind, i);
    const Index cluster = i / cluster_size, group = cluster / cluster_size;
    set_lane((split ? list.ends : list.clusters).data()[cluster], i % cluster_size, box);
    Cluster<float>& whole = (split ? list.group_ends : list.groups).data()[group];
    const Index lane = cluster % cluster_size;
    set_lane(whole, lane, hull(lane_of<float>(whole, lane), around(box)));
    list.hulls.data()[group] = hull(list.hulls.data()[group], around(box));
  }

  void ask(const DirtyPrimitive& dirty) {
    const GrownBoxes<T> boxes = grown_boxes(a_, dirty.kind, dirty.number);
    const int partner = partner_kind(dirty.kind);
    for (int kind = a_.self ? partner : partner + 1; kind <= partner + 1; ++kind)
      for (Index g = 0; g < a_.boxes.lists[kind].group_count(); ++g)
        meet_group(a_, dirty, boxes, kind, g, [&](const Pair& pair) {
          if (partner == cloth_edges)
            append(a_.edge_pairs, counts_.edge_pairs, pair);
          else
            append(a_.face_pairs, counts_.face_pairs, pair);
        });
  }

  const CollideCandidateUpdate<T>& a_;
  CandidateUpdateCounts& counts_;
};

}  // namespace

template <class T>
void run(OnHost, Queue& queue, const CollideCandidateUpdate<T>& args) {
  submit_host(queue, [args] { CandidateUpdater<T>(args).run(); });
}

template void run(OnHost, Queue&, const CollideCandidateUpdate<float>&);
template void run(OnHost, Queue&, const CollideCandidateUpdate<double>&);

}  // namespace weft
