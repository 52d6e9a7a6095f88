#include "weft/kernels/collide/continuous.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "host/collide/pair_lanes.hpp"
#include "host/exec/host_device.hpp"
#include "weft/elements/ccd.hpp"
#include "weft/elements/contact.hpp"
#include "weft/kernels/collide/proximity.hpp"
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
    counts.face_collisions = 0;
    check_vertices(counts);
    if (counts.escaped == 0) find_collisions(counts);
    counts.collisions = static_cast<Index>(count_);
    counts.missed = missed_;
    counts.ccd_tests = tests_;
  }

 private:
  void find_collisions(CollideCounts& counts) {
    measure_deviations();
    const auto face_pairs =
        std::min(static_cast<std::size_t>(counts.face_pairs), a_.face_pairs.size());
    const auto edge_pairs =
        std::min(static_cast<std::size_t>(counts.edge_pairs), a_.edge_pairs.size());
    PairLanes<T, 1> faces;
    for (std::size_t i = 0; i < face_pairs && !done(); ++i) {
      const Tri& t = a_.triangles.data()[a_.face_pairs[i].b];
      add(faces, {a_.face_pairs[i].a, t.v[0], t.v[1], t.v[2]}, i, a_.face_slack);
    }
    look(faces, a_.face_slack);
    counts.face_collisions = static_cast<Index>(count_);
    PairLanes<T, 2> edges;
    for (std::size_t i = 0; i < edge_pairs && !done(); ++i) {
      const Edge& p = a_.edges.data()[a_.edge_pairs[i].a];
      const Edge& q = a_.edges.data()[a_.edge_pairs[i].b];
      add(edges, {p.v[0], p.v[1], q.v[0], q.v[1]}, i, a_.edge_slack);
    }
    look(edges, a_.edge_slack);
  }

  bool done() const { return a_.stop_at_missed && missed_ > 0; }

  void check_vertices(CollideCounts& counts) const {
    for (Index v = a_.vertex_begin; v < a_.vertex_end; ++v) {
      const Vec3<T>& x = a_.positions_t1.data()[v];
      for (int c = 0; c < 3; ++c)
        if (!std::isfinite(x[c])) ++counts.not_finite;
      if (!keeps_to(a_.motion_box.data()[v], x)) ++counts.escaped;
    }
  }

  /// How far each vertex ends from where it was predicted, rounding included.
  void measure_deviations() const {
    constexpr T epsilon = std::numeric_limits<T>::epsilon();
    for (std::size_t v = 0; v < a_.deviation.size(); ++v) {
      const Vec3<T>& x = a_.positions_t1[v];
      const T size = std::max({std::fabs(x[0]), std::fabs(x[1]), std::fabs(x[2])});
      a_.deviation[v] =
          static_cast<float>(T(1.0001) * length(x - a_.predicted[v]) + T(8) * epsilon * size);
    }
  }

  /// Keeps for the lanes what the prediction's slack does not keep apart.
  template <int First>
  void add(PairLanes<T, First>& lanes, const std::array<Index, 4>& v, std::size_t number,
           Span<const float> slack) {
    const float* d = a_.deviation.data();
    const float strayed = First == 1 ? d[v[0]] + std::max({d[v[1]], d[v[2]], d[v[3]]})
                                     : std::max(d[v[0]], d[v[1]]) + std::max(d[v[2]], d[v[3]]);
    // Not "<=": where something is not a number the pair has to be looked at.
    if (slack.data()[number] - 1.0001f * strayed > static_cast<float>(a_.separation) * 1.0001f)
      return;
    const unsigned char* moved = a_.moved.data();
    if (!a_.moved.empty() && (moved[v[0]] | moved[v[1]] | moved[v[2]] | moved[v[3]]) == 0) return;
    lanes.add(v.data(), number, a_.positions_t0, a_.positions_t1);
    if (lanes.full()) look(lanes, slack);
  }

  /// Whether the distance at the start is larger than `reach`, rounding included.
  template <int First>
  bool farther(const Index v[4], T reach) const {
    Vec3<T> x[4];
    for (int j = 0; j < 4; ++j) x[j] = a_.positions_t0.data()[v[j]];
    const Proximity<T> p = First == 1 ? vertex_triangle(x) : edge_edge(x);
    return T(0.9999) * std::sqrt(p.distance_sq) > reach;
  }

  /// Tests what boxes and planes at the start do not keep apart either, and empties the lanes.
  template <int First>
  void look(PairLanes<T, First>& lanes, Span<const float> slack) {
    constexpr int width = PairLanes<T, First>::width;
    T closing[width];
    T reach[width];
    T gap[width];
    bool apart[width];
    lanes.closing(closing);
    // Displacements round at the size of the coordinates; a hundredth on top covers the rest.
    for (int k = 0; k < width; ++k)
      reach[k] = T(1.0001) * static_cast<T>(a_.separation) + T(1.01) * closing[k] +
                 T(8) * std::numeric_limits<T>::epsilon() * lanes.size(k);
    lanes.box_gap(gap);
    lanes.plane_exceeds(reach, apart);
    for (int k = 0; k < lanes.count(); ++k) {
      if (gap[k] > reach[k] || apart[k] || farther<First>(lanes.corners(k), reach[k])) continue;
      ++tests_;
      if (detect<First>(lanes.corners(k)) && slack.data()[lanes.number(k)] != slack_of_contact)
        ++missed_;
    }
    lanes.clear();
  }

  /// @return whether the pair collides; appends the collision
  template <int First>
  bool detect(const Index v[4]) {
    Vec3<double> x_t0[4];
    Vec3<double> x_t1[4];
    for (int j = 0; j < 4; ++j) {
      x_t0[j] = vec_cast<double>(a_.positions_t0.data()[v[j]]);
      x_t1[j] = vec_cast<double>(a_.positions_t1.data()[v[j]]);
    }
    const Proximity<double> start = First == 1 ? vertex_triangle(x_t0) : edge_edge(x_t0);
    const double distance = std::sqrt(start.distance_sq);
    const double separation = std::min(a_.separation, 0.5 * distance);
    const Impact<double> impact = First == 1 ? ccd_vertex_triangle(x_t0, x_t1, separation)
                                             : ccd_edge_edge(x_t0, x_t1, separation);
    if (!impact.hit) return false;
    Collision c;
    const Vec3<double> at_start =
        distance > 0 ? (1 / distance) * start.difference : Vec3<double>{0, 0, 1};
    c.n = contact_normal(impact.at.difference, at_start);
    for (int j = 0; j < 4; ++j) {
      c.v[j] = v[j];
      c.w[j] = impact.at.w[j];
    }
    // Less than there was, or zones would have to make room that there may not be; but layers that
    // are squeezed step after step must not come as close as rounding, where nothing parts them.
    c.offset = std::min(a_.offset, std::max(0.9 * distance, 0.05 * a_.offset));
    c.toi = impact.toi;
    if (count_ < a_.collisions.size()) a_.collisions[count_] = c;
    ++count_;
    return true;
  }

  const CollideContinuous<T> a_;
  std::size_t count_ = 0;
  Index missed_ = 0;
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
