#include "weft/kernels/collide/boxes.hpp"

#include "host/exec/host_device.hpp"

namespace weft {
namespace {

template <class T>
void make_vertex_boxes(const CollideBoxes<T>& a) {
  const auto reach = static_cast<float>(a.reach);
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
    a.vertex_box[i] = grown(a.motion_box[i], reach);
  }
}

float extent(const Box& box) {
  return (box.hi[0] - box.lo[0] + box.hi[1] - box.lo[1] + box.hi[2] - box.lo[2]) / 3;
}

/// Mean extent of boxes first to last - 1.
float mean_extent(Span<const Box> boxes, std::size_t first, std::size_t last) {
  double sum = 0;
  for (std::size_t i = first; i < last; ++i) sum += static_cast<double>(extent(boxes[i]));
  return last > first ? static_cast<float>(sum / static_cast<double>(last - first)) : 0.0f;
}

template <class T>
void make_boxes(const CollideBoxes<T>& a) {
  make_vertex_boxes(a);
  for (std::size_t i = 0; i < a.edges.size(); ++i) {
    const Edge& e = a.edges[i];
    a.edge_box[i] = hull(a.vertex_box[static_cast<std::size_t>(e.v[0])],
                         a.vertex_box[static_cast<std::size_t>(e.v[1])]);
  }
  for (std::size_t i = 0; i < a.triangles.size(); ++i) {
    const Tri& t = a.triangles[i];
    a.triangle_box[i] = hull(hull(a.vertex_box[static_cast<std::size_t>(t.v[0])],
                                  a.vertex_box[static_cast<std::size_t>(t.v[1])]),
                             a.vertex_box[static_cast<std::size_t>(t.v[2])]);
  }
  const auto cloth_triangles = static_cast<std::size_t>(a.cloth_triangle_count);
  const auto cloth_edges = static_cast<std::size_t>(a.cloth_edge_count);
  a.mean_extent[0] = mean_extent(a.triangle_box, 0, cloth_triangles);
  a.mean_extent[1] = mean_extent(a.triangle_box, cloth_triangles, a.triangles.size());
  a.mean_extent[2] = mean_extent(a.edge_box, 0, cloth_edges);
  a.mean_extent[3] = mean_extent(a.edge_box, cloth_edges, a.edges.size());
}

}  // namespace

template <class T>
void run(OnHost, Queue& queue, const CollideBoxes<T>& args) {
  submit_host(queue, [args] { make_boxes(args); });
}

template void run(OnHost, Queue&, const CollideBoxes<float>&);
template void run(OnHost, Queue&, const CollideBoxes<double>&);

}  // namespace weft
