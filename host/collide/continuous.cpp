#include "weft/kernels/collide/continuous.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "host/exec/host_device.hpp"
#include "weft/elements/ccd.hpp"
#include "weft/elements/contact.hpp"
#include "weft/kernels/collide/stray.hpp"

namespace weft {
namespace {

template <class T>
class ContinuousFinder {
 public:
  explicit ContinuousFinder(const CollideContinuous<T>& args) : a_(args) {}

  void find() {
    CollideCounts& counts = a_.counts[0];
    counts.escaped = 0;
    counts.not_finite = 0;
    check_own_rows(counts);
    const auto face_pairs =
        std::min(static_cast<std::size_t>(counts.face_pairs), a_.face_pairs.size());
    const auto edge_pairs =
        std::min(static_cast<std::size_t>(counts.edge_pairs), a_.edge_pairs.size());
    for (std::size_t i = 0; i < face_pairs; ++i) {
      const Tri& t = a_.triangles.data()[a_.face_pairs[i].b];
      const Index v[4] = {a_.face_pairs[i].a, t.v[0], t.v[1], t.v[2]};
      look<1>(v, a_.face_distance[i]);
    }
    counts.face_collisions = static_cast<Index>(count_);
    for (std::size_t i = 0; i < edge_pairs; ++i) {
      const Edge& p = a_.edges.data()[a_.edge_pairs[i].a];
      const Edge& q = a_.edges.data()[a_.edge_pairs[i].b];
      const Index v[4] = {p.v[0], p.v[1], q.v[0], q.v[1]};
      look<2>(v, a_.edge_distance[i]);
    }
    counts.collisions = static_cast<Index>(count_);
    counts.ccd_tests = tests_;
  }

 private:
  void check_own_rows(CollideCounts& counts) const {
    for (Index v = a_.row_begin; v < a_.row_end; ++v) {
      const Vec3<T>& x = a_.positions_t1.data()[v];
      for (int c = 0; c < 3; ++c)
        if (!std::isfinite(x[c])) ++counts.not_finite;
      if (!keeps_to(a_.motion_box.data()[v], x)) ++counts.escaped;
    }
  }

  /// First: number of corners of the first primitive.
  template <int First>
  void look(const Index v[4], float distance) {
    if (!a_.moved.empty() && (a_.moved.data()[v[0]] | a_.moved.data()[v[1]] |
                              a_.moved.data()[v[2]] | a_.moved.data()[v[3]]) == 0)
      return;
    Vec3<T> u[4];
    for (int j = 0; j < 4; ++j) u[j] = a_.positions_t1.data()[v[j]] - a_.positions_t0.data()[v[j]];
    const Vec3<T> mean = T(0.25) * (u[0] + u[1] + u[2] + u[3]);
    T most[2] = {T(0), T(0)};
    for (int j = 0; j < 4; ++j) {
      T& m = most[j < First ? 0 : 1];
      m = std::max(m, length_sq(u[j] - mean));
    }
    // Displacements round at the size of the coordinates; a part in 1e5 on top covers the rest.
    T size = T(0);
    for (int c = 0; c < 3; ++c) size = std::max(size, std::fabs(a_.positions_t1.data()[v[0]][c]));
    const double closing = 1.00001 * (std::sqrt(static_cast<double>(most[0])) +
                                      std::sqrt(static_cast<double>(most[1]))) +
                           8.0 * static_cast<double>(std::numeric_limits<T>::epsilon() * size);
    if (static_cast<double>(distance) - a_.separation > closing) return;
    ++tests_;
    detect<First>(v);
  }

  template <int First>
  void detect(const Index v[4]) {
    Vec3<double> x_t0[4];
    Vec3<double> x_t1[4];
    for (int j = 0; j < 4; ++j) {
      x_t0[j] = vec_cast<double>(a_.positions_t0.data()[v[j]]);
      x_t1[j] = vec_cast<double>(a_.positions_t1.data()[v[j]]);
    }
    const Proximity<double> start = First == 1 ? vertex_triangle(x_t0) : edge_edge(x_t0);
    const double distance = std::sqrt(start.distance_sq);
    const double separation = std::min(a_.separation, 0.5 * distance);
    const Impact impact = First == 1 ? ccd_vertex_triangle(x_t0, x_t1, separation)
                                     : ccd_edge_edge(x_t0, x_t1, separation);
    if (!impact.hit) return;
    Collision c;
    const Vec3<double> at_start =
        distance > 0 ? (1 / distance) * start.difference : Vec3<double>{0, 0, 1};
    c.n = contact_normal(impact.at.difference, at_start);
    for (int j = 0; j < 4; ++j) {
      c.v[j] = v[j];
      c.w[j] = impact.at.w[j];
    }
    c.offset = std::min(a_.offset, 0.9 * distance);
    c.toi = impact.toi;
    if (count_ < a_.collisions.size()) a_.collisions[count_] = c;
    ++count_;
  }

  const CollideContinuous<T> a_;
  std::size_t count_ = 0;
  Offset tests_ = 0;
};

}  // namespace

template <class T>
void run(OnHost, Queue& queue, const CollideContinuous<T>& args) {
  submit_host(queue, [args] { ContinuousFinder<T>(args).find(); });
}

template void run(OnHost, Queue&, const CollideContinuous<float>&);
template void run(OnHost, Queue&, const CollideContinuous<double>&);

}  // namespace weft
