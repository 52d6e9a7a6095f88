#include "weft/kernels/collide/proximity.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "host/collide/pair_lanes.hpp"
#include "host/exec/host_device.hpp"
#include "weft/elements/contact.hpp"
#include "weft/elements/distance.hpp"

namespace weft {
namespace {

/// Below half of the thickness repulsion grows as the inverse of the gap, up to this factor.
constexpr double stiffening_max = 8;
/// Share of their distance at rest at which neighbours start to repel.
constexpr double rest_share = 0.9;

template <class T>
class ProximityFinder {
 public:
  explicit ProximityFinder(const CollideProximity<T>& args) : a_(args) {}

  void find() {
    CollideCounts& counts = a_.counts[0];
    const auto face_pairs =
        std::min(static_cast<std::size_t>(counts.face_pairs), a_.face_pairs.size());
    const auto edge_pairs =
        std::min(static_cast<std::size_t>(counts.edge_pairs), a_.edge_pairs.size());
    PairLanes<T, 1> faces;
    for (std::size_t i = 0; i < face_pairs; ++i) {
      const Tri& t = a_.triangles.data()[a_.face_pairs[i].b];
      add(faces, {a_.face_pairs[i].a, t.v[0], t.v[1], t.v[2]}, i, a_.face_slack);
    }
    look(faces, a_.face_slack);
    counts.face_contacts = static_cast<Index>(count_);
    PairLanes<T, 2> edges;
    for (std::size_t i = 0; i < edge_pairs; ++i) {
      const Edge& p = a_.edges.data()[a_.edge_pairs[i].a];
      const Edge& q = a_.edges.data()[a_.edge_pairs[i].b];
      add(edges, {p.v[0], p.v[1], q.v[0], q.v[1]}, i, a_.edge_slack);
    }
    look(edges, a_.edge_slack);
    counts.contacts = static_cast<Index>(count_);
  }

 private:
  /// First: number of corners of the first primitive.
  template <int First>
  static Proximity<T> closest(const Vec3<T> x[4]) {
    if constexpr (First == 1) return vertex_triangle(x);
    return edge_edge(x);
  }
  template <int First>
  static bool farther(const Vec3<T> x[4], T d) {
    if constexpr (First == 1) return vertex_triangle_farther(x, d);
    return edge_edge_farther(x, d);
  }

  bool heavy(Index v) const { return v >= a_.cloth_vertex_count || a_.fixed.data()[v] != 0; }

  template <int First>
  void add(PairLanes<T, First>& lanes, const std::array<Index, 4>& v, std::size_t number,
           Span<float> slack) {
    lanes.add(v.data(), number, a_.positions_t0, a_.positions_t1);
    if (lanes.full()) look(lanes, slack);
  }

  /// Writes each pair's slack, appends contacts, and empties the lanes.
  template <int First>
  void look(PairLanes<T, First>& lanes, Span<float> slack) {
    constexpr int width = PairLanes<T, First>::width;
    T closing[width];
    T reach[width];
    T gap[width];
    bool apart[width];
    lanes.closing(closing);
    for (int k = 0; k < width; ++k) reach[k] = a_.thickness + T(1.01) * closing[k];
    lanes.box_gap(gap);
    lanes.plane_exceeds(reach, apart);
    for (int k = 0; k < lanes.count(); ++k) {
      float& out = slack.data()[lanes.number(k)];
      const std::size_t contacts_before = count_;
      const T distance =
          gap[k] > reach[k] || apart[k] ? reach[k] : measure<First>(lanes.corners(k), closing[k]);
      // Less by what rounding can have added to the distance and taken from the motion.
      out = static_cast<float>(T(0.9999) * distance - T(1.0001) * closing[k] -
                               T(8) * std::numeric_limits<T>::epsilon() * lanes.size(k));
      if (count_ > contacts_before) out = slack_of_contact;
    }
    lanes.clear();
  }

  /// @return [m] the pair's distance; appends a contact where there is one
  template <int First>
  T measure(const Index v[4], T closing) {
    Vec3<T> x[4];
    Vec3<T> u[4];
    for (int j = 0; j < 4; ++j) {
      x[j] = a_.positions_t0.data()[v[j]];
      u[j] = a_.positions_t1.data()[v[j]] - x[j];
    }
    const Proximity<T> p = closest<First>(x);
    const T distance = std::sqrt(p.distance_sq);
    if (distance - closing < a_.thickness && boxes_are_near<First>(v))
      consider<First>(v, u, p, distance);
    return distance;
  }

  /// Whether the swept boxes come closer than the thickness. Only such pairs does every search
  /// find, whatever its margins were; the others must not become contacts by chance.
  template <int First>
  bool boxes_are_near(const Index v[4]) const {
    for (int c = 0; c < 3; ++c) {
      T lo[2];
      T hi[2];
      for (int j = 0; j < 4; ++j) {
        const int side = j < First ? 0 : 1;
        const T p = a_.positions_t0.data()[v[j]][c];
        const T q = a_.positions_t1.data()[v[j]][c];
        const bool first = j == 0 || j == First;
        lo[side] = first ? std::min(p, q) : std::min({lo[side], p, q});
        hi[side] = first ? std::max(p, q) : std::max({hi[side], p, q});
      }
      if (lo[0] - hi[1] > a_.thickness || lo[1] - hi[0] > a_.thickness) return false;
    }
    return true;
  }

  /// Whether a seam ties a corner of the first primitive to one of the second.
  template <int First>
  bool are_tied(const Index v[4]) const {
    if (a_.tied.empty()) return false;
    for (int i = 0; i < First; ++i)
      for (int j = First; j < 4; ++j)
        if (v[i] < a_.cloth_vertex_count && v[j] < a_.cloth_vertex_count &&
            a_.tied.data()[v[i]] == a_.tied.data()[v[j]])
          return true;
    return false;
  }

  template <int First>
  void consider(const Index v[4], const Vec3<T> u[4], const Proximity<T>& p, T distance) {
    // Touching is left to the continuous test.
    if (!(distance > T(0)) || are_tied<First>(v)) return;
    Contact<T> c;
    c.n = (T(1) / distance) * p.difference;
    T inverse_mass = T(0);
    Vec3<T> slip{};
    T friction = T(0);
    bool obstacle = false;
    for (int j = 0; j < 4; ++j) {
      c.v[j] = v[j];
      c.w[j] = p.w[j];
      slip += p.w[j] * u[j];
      if (!heavy(v[j])) inverse_mass += p.w[j] * p.w[j] / a_.mass.data()[v[j]];
      if (v[j] >= a_.cloth_vertex_count) obstacle = true;
      if (j == 0 || v[j] >= a_.cloth_vertex_count) friction = a_.friction_of_vertex.data()[v[j]];
    }
    if (!(inverse_mass > T(0))) return;
    const T predicted = distance + dot(c.n, slip);
    if (predicted >= a_.thickness) return;
    c.thickness = obstacle ? a_.thickness : std::min(a_.thickness, rest_limit<First>(v));
    if (predicted >= c.thickness) return;

    T ratio = a_.stiffness;
    if (distance < c.thickness / 2)
      ratio *= std::min(static_cast<T>(stiffening_max), c.thickness / (2 * distance));
    // A penalty leaves about 1 / ratio of what it meets: a fast approach needs a larger one, or it
    // ends beyond the thickness.
    ratio *= std::max(T(1), (c.thickness - predicted) / (2 * c.thickness));
    c.stiffness = ratio / (inverse_mass * a_.step * a_.step);
    // What the contact bears at rest, plus what stopping the approach will take after the solve has
    // shared it with the masses.
    const T normal_force =
        c.stiffness *
        (std::max(T(0), c.thickness - distance) +
         std::max(T(0), std::min(distance, c.thickness) - predicted) / (T(1) + ratio));
    c.friction = friction * normal_force;
    c.slip_inv = friction_scale(length(tangential(slip, c.n)), a_.slip_smoothing);
    if (count_ < a_.contacts.size()) a_.contacts[count_] = c;
    ++count_;
  }

  /// How close neighbours of one cloth may be without repelling each other at rest.
  template <int First>
  T rest_limit(const Index v[4]) const {
    const Index cloth = a_.cloth_of_vertex.data()[v[0]];
    Vec3<T> rest[4];
    for (int j = 0; j < 4; ++j) {
      if (a_.cloth_of_vertex.data()[v[j]] != cloth) return a_.thickness;
      const Vec2<T>& m = a_.material_points.data()[v[j]];
      rest[j] = {m[0], m[1], T(0)};
    }
    const T limit = a_.thickness / static_cast<T>(rest_share);
    if (farther<First>(rest, limit)) return a_.thickness;
    return static_cast<T>(rest_share) * std::sqrt(closest<First>(rest).distance_sq);
  }

  const CollideProximity<T> a_;
  std::size_t count_ = 0;
};

}  // namespace

template <class T>
void run(OnHost, Queue& queue, const CollideProximity<T>& args) {
  submit_host(queue, [args] { ProximityFinder<T>(args).find(); });
}

template void run(OnHost, Queue&, const CollideProximity<float>&);
template void run(OnHost, Queue&, const CollideProximity<double>&);

}  // namespace weft
