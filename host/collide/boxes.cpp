#include "weft/kernels/collide/boxes.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "host/exec/host_device.hpp"

namespace weft {
namespace {

template <class T>
constexpr BoxOf<T> empty_box() {
  constexpr T infinity = std::numeric_limits<T>::infinity();
  return {{infinity, infinity, infinity}, {-infinity, -infinity, -infinity}};
}

/// To float, outwards.
Box around(const Box& box) {
  return box;
}
Box around(const BoxOf<double>& box) {
  Box r;
  for (int c = 0; c < 3; ++c) {
    r.lo[c] = static_cast<float>(box.lo[c]);
    r.hi[c] = static_cast<float>(box.hi[c]);
  }
  return grown(r, 0.0f);
}

template <class T>
void set_lane(Cluster<T>& cluster, Index lane, const BoxOf<T>& box) {
  for (int c = 0; c < 3; ++c) {
    cluster.lo[c][lane] = box.lo[c];
    cluster.hi[c][lane] = box.hi[c];
  }
}

template <class T>
bool differ(const BoxOf<T>& a, const BoxOf<T>& b) {
  for (int c = 0; c < 3; ++c)
    if (a.lo[c] != b.lo[c] || a.hi[c] != b.hi[c]) return true;
  return false;
}

float extent(const Box& box) {
  return (box.hi[0] - box.lo[0] + box.hi[1] - box.lo[1] + box.hi[2] - box.lo[2]) / 3;
}

template <class T>
class BoxMaker {
 public:
  explicit BoxMaker(const CollideBoxes<T>& args) : a_(args) {}

  void make() {
    const bool changed = make_motion_boxes();
    a_.obstacles_made.data()[0] = changed || a_.anew ? 1 : 0;
    make_kinds(cloth_vertices, cloth_faces, cloth_edges);
    if (changed || a_.anew) make_kinds(obstacle_vertices, obstacle_faces, obstacle_edges);
  }

 private:
  std::size_t cloth_end() const { return static_cast<std::size_t>(a_.cloth_vertex_count); }

  /// Largest displacement along an axis. [m]
  T largest_motion() const {
    T most = T(0);
    for (std::size_t v = 0; v < a_.positions_t0.size(); ++v)
      for (int c = 0; c < 3; ++c)
        most =
            std::max(most, std::fabs(a_.positions_t1.data()[v][c] - a_.positions_t0.data()[v][c]));
    return most;
  }

  /// @return whether an obstacle's box is another one than before
  bool make_motion_boxes() const {
    const T margin = largest_motion() < a_.margin_at_rest / 2 ? a_.margin_at_rest : a_.margin;
    bool changed = false;
    for (std::size_t v = 0; v < a_.positions_t0.size(); ++v) {
      const Vec3<T>& p = a_.positions_t0.data()[v];
      const Vec3<T>& q = a_.positions_t1.data()[v];
      BoxOf<T> box;
      for (int c = 0; c < 3; ++c) {
        box.lo[c] = p[c] < q[c] ? p[c] : q[c];
        box.hi[c] = p[c] < q[c] ? q[c] : p[c];
      }
      T room = margin;
      if (v >= cloth_end() && p[0] == q[0] && p[1] == q[1] && p[2] == q[2]) room = T(0);
      if (v < cloth_end() && a_.change_time > T(0))
        room += a_.change_time * length(a_.velocities.data()[v] - a_.previous_velocities.data()[v]);
      box = grown(box, room);
      if (v >= cloth_end() && differ(box, a_.motion_box.data()[v])) changed = true;
      a_.motion_box.data()[v] = box;
    }
    return changed;
  }

  void make_kinds(int vertices, int faces, int edges) const {
    const BoxOf<T>* motion = a_.motion_box.data();
    make_list(vertices, [motion](Index i) { return motion[i]; });
    make_list(faces, [this, motion](Index i) {
      const Tri& t = a_.triangles.data()[i];
      return hull(hull(motion[t.v[0]], motion[t.v[1]]), motion[t.v[2]]);
    });
    make_list(edges, [this, motion](Index i) {
      const Edge& e = a_.edges.data()[i];
      return hull(motion[e.v[0]], motion[e.v[1]]);
    });
  }

  template <class BoxOfPrimitive>
  void make_list(int kind, BoxOfPrimitive box_of) const {
    const ClusterList<T>& list = a_.lists[kind];
    double sum = 0;
    for (Index g = 0; g < list.group_count(); ++g) {
      Cluster<float>& group = list.groups.data()[g];
      Box whole = empty_box<float>();
      for (Index lane = 0; lane < cluster_size; ++lane) {
        Box box = empty_box<float>();
        const Index k = g * cluster_size + lane;
        if (k < list.size()) box = make_cluster(list, k, box_of);
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
  template <class BoxOfPrimitive>
  Box make_cluster(const ClusterList<T>& list, Index k, BoxOfPrimitive box_of) const {
    Cluster<T>& cluster = list.clusters.data()[k];
    BoxOf<T> whole = empty_box<T>();
    for (Index lane = 0; lane < cluster_size; ++lane) {
      const Index number = k * cluster_size + lane;
      BoxOf<T> box = empty_box<T>();
      if (number < list.count) box = grown(box_of(list.first + number), a_.reach);
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
