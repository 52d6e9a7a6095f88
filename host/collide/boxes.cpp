#include "weft/kernels/collide/boxes.hpp"

#include <algorithm>
#include <limits>

#include "host/exec/host_device.hpp"

namespace weft {
namespace {

template <class T>
void make_motion_boxes(const CollideBoxes<T>& a) {
  for (std::size_t i = 0; i < a.positions_t0.size(); ++i) {
    Box box;
    for (int c = 0; c < 3; ++c) {
      const auto p = static_cast<float>(a.positions_t0[i][c]);
      const auto q = static_cast<float>(a.positions_t1[i][c]);
      box.lo[c] = p < q ? p : q;
      box.hi[c] = p < q ? q : p;
    }
    T margin = a.margin;
    if (static_cast<Index>(i) < a.cloth_vertex_count)
      margin += a.change_time * length(a.velocities[i] - a.previous_velocities[i]);
    a.motion_box[i] = grown(box, static_cast<float>(margin));
  }
}

float extent(const Box& box) {
  return (box.hi[0] - box.lo[0] + box.hi[1] - box.lo[1] + box.hi[2] - box.lo[2]) / 3;
}

/// Fills one list from `box_of(number)`.
/// @return mean extent of the hulls
template <class BoxOf>
float make_clusters(const ClusterList& list, float reach, BoxOf box_of) {
  constexpr float infinity = std::numeric_limits<float>::infinity();
  double sum = 0;
  for (Index k = 0; k < list.size(); ++k) {
    Cluster& cluster = list.clusters.data()[k];
    Box around{{infinity, infinity, infinity}, {-infinity, -infinity, -infinity}};
    for (Index lane = 0; lane < cluster_size; ++lane) {
      const Index number = k * cluster_size + lane;
      Box box{{infinity, infinity, infinity}, {-infinity, -infinity, -infinity}};
      if (number < list.count) {
        box = grown(box_of(list.first + number), reach);
        around = hull(around, box);
      }
      for (int c = 0; c < 3; ++c) {
        cluster.lo[c][lane] = box.lo[c];
        cluster.hi[c][lane] = box.hi[c];
      }
    }
    list.hulls.data()[k] = around;
    sum += static_cast<double>(extent(around));
  }
  return list.size() > 0 ? static_cast<float>(sum / list.size()) : 0.0f;
}

template <class T>
void make_boxes(const CollideBoxes<T>& a) {
  make_motion_boxes(a);
  const Box* motion = a.motion_box.data();
  const auto reach = static_cast<float>(a.reach);
  const auto fill = [&](int kind, auto box_of) {
    a.mean_extent.data()[kind] = make_clusters(a.lists[kind], reach, box_of);
  };
  const auto vertex = [motion](Index i) { return motion[i]; };
  const auto face = [&a, motion](Index i) {
    const Tri& t = a.triangles.data()[i];
    return hull(hull(motion[t.v[0]], motion[t.v[1]]), motion[t.v[2]]);
  };
  const auto edge = [&a, motion](Index i) {
    const Edge& e = a.edges.data()[i];
    return hull(motion[e.v[0]], motion[e.v[1]]);
  };
  fill(cloth_vertices, vertex);
  fill(obstacle_vertices, vertex);
  fill(cloth_faces, face);
  fill(obstacle_faces, face);
  fill(cloth_edges, edge);
  fill(obstacle_edges, edge);
}

}  // namespace

template <class T>
void run(OnHost, Queue& queue, const CollideBoxes<T>& args) {
  submit_host(queue, [args] { make_boxes(args); });
}

template void run(OnHost, Queue&, const CollideBoxes<float>&);
template void run(OnHost, Queue&, const CollideBoxes<double>&);

}  // namespace weft
