#include "weft/kernels/collide/proximity.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "host/collide/pair_lanes.hpp"
#include "host/exec/host_device.hpp"
#include "weft/elements/contact.hpp"
#include "weft/elements/distance.hpp"
#include "weft/elements/normal_cone.hpp"

namespace weft {
namespace {

/// Below half of the thickness repulsion grows as the inverse of the gap, up to this factor.
constexpr double stiffening_max = 8;
/// Share of their distance at rest at which neighbours start to repel.
constexpr double rest_share = 0.9;
/// Cosine that counts as a right angle, so that flat cloth on a flat floor is not a matter of
/// rounding.
constexpr double flat = 1e-3;
/// Edges count as closest up to this slant (cosine) of the faces beside them.
constexpr double edge_slant = 0.5;
/// Contacts of the last step speak for a new one of the same vertex or edge from this cosine on.
constexpr double likeness = 0.7;

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
      const Edge& p = a_.surface.edges.data()[a_.edge_pairs[i].a];
      const Edge& q = a_.surface.edges.data()[a_.edge_pairs[i].b];
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
      known_ = false;
      const T distance = gap[k] > reach[k] || apart[k]
                             ? reach[k]
                             : measure<First>(pairs<First>().data()[lanes.number(k)],
                                              lanes.corners(k), closing[k]);
      // Less by what rounding can have added to the distance and taken from the motion.
      out = static_cast<float>(T(0.9999) * distance - T(1.0001) * closing[k] -
                               T(8) * std::numeric_limits<T>::epsilon() * lanes.size(k));
      if (known_) out = slack_of_contact;
    }
    lanes.clear();
  }

  /// @return [m] the pair's distance; appends a contact where there is one
  template <int First>
  T measure(const Pair& pair, const Index v[4], T closing) {
    Vec3<T> x[4];
    Vec3<T> u[4];
    for (int j = 0; j < 4; ++j) {
      x[j] = a_.positions_t0.data()[v[j]];
      u[j] = a_.positions_t1.data()[v[j]] - x[j];
    }
    const Proximity<T> p = closest<First>(x);
    const T distance = std::sqrt(p.distance_sq);
    if (distance - closing < a_.thickness && boxes_are_near<First>(v))
      consider<First>(pair, v, u, p, distance);
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
  Span<const Pair> pairs() const {
    return First == 1 ? a_.face_pairs : a_.edge_pairs;
  }

  /// What the pair's contact of the last step left, if it bore anything. A vertex or edge that has
  /// moved on to another face or edge goes on with the contact of its own that lay most alike.
  template <int First>
  const ContactMemory<T>* recall(const Pair& pair, const Vec3<T>& n) const {
    const Span<const ContactMemory<T>> memory = First == 1 ? a_.face_memory : a_.edge_memory;
    const auto* m = std::lower_bound(
        memory.begin(), memory.end(), pair.a,
        [](const ContactMemory<T>& one, Index first) { return one.pair.a < first; });
    const ContactMemory<T>* best = nullptr;
    T best_likeness = static_cast<T>(likeness);
    for (; m != memory.end() && m->pair.a == pair.a; ++m) {
      if (!(m->normal_force > T(0))) continue;
      if (m->pair.b == pair.b) return m;
      if (dot(m->n, n) <= best_likeness) continue;
      best = m;
      best_likeness = dot(m->n, n);
    }
    return best;
  }

  /// Whose the closest points of a pair are.
  enum class Owner {
    pair,
    neighbour,  ///< another pair has the same points
    nobody,     ///< the surfaces are closer elsewhere
  };

  bool vertex_faces(Index v, const Vec3<T>& away, T slack) const {
    const Offset* offset = a_.surface.ring_offset.data() + v;
    return in_vertex_cone(a_.surface.ring.subspan(static_cast<std::size_t>(offset[0]),
                                                  static_cast<std::size_t>(offset[1] - offset[0])),
                          a_.positions_t0, v, away, slack);
  }
  bool edge_faces(Index e, const Vec3<T>& away, T slack) const {
    return in_edge_cone(a_.surface.edges.data()[e], a_.surface.wings.data()[e].v, a_.positions_t0,
                        away, slack);
  }

  Owner owner_of_face_point(const Pair& pair, const Vec3<T>& n, T slack, unsigned corners) const {
    if (corners == 0b1111) return Owner::pair;
    const Surface& surface = a_.surface;
    if (!vertex_faces(pair.a, -n, slack)) return Owner::nobody;
    const Tri& face = a_.triangles.data()[pair.b];
    for (int k = 0; k < 3; ++k) {
      const Index e = surface.edges_of_face.data()[pair.b].v[k];
      if (corners == (0b1111u & ~(2u << k))) {
        if (!edge_faces(e, n, slack)) return Owner::nobody;
        return surface.wings.data()[e].first_face == pair.b ? Owner::pair : Owner::neighbour;
      }
      if (corners == (1u | 2u << k)) {
        const Index v = face.v[k];
        if (!vertex_faces(v, n, slack)) return Owner::nobody;
        // Of two vertices the lower one asks.
        return pair.a < v && surface.face_of_vertex.data()[v] == pair.b ? Owner::pair
                                                                        : Owner::neighbour;
      }
    }
    return Owner::pair;
  }

  /// The normal of two edges is at right angles to both, so that it slants only where their
  /// surfaces do; in folds that is everywhere, and such edges have to be held apart.
  Owner owner_of_edge_points(const Pair& pair, const Vec3<T>& n, unsigned corners) const {
    if (corners != 0b1111) return Owner::neighbour;  // a vertex has a pair with a face there
    const T slack = static_cast<T>(edge_slant);
    return edge_faces(pair.a, -n, slack) && edge_faces(pair.b, n, slack) ? Owner::pair
                                                                         : Owner::nobody;
  }

  /// How a pair meets.
  struct Meeting {
    T w[4];
    Vec3<T> n;
    T distance;   ///< [m] along n, at the start
    T predicted;  ///< [m] likewise, at the predicted end
  };

  template <int First>
  Owner owner(const Pair& pair, const Index v[4], const Proximity<T>& p, const Meeting& m) const {
    T size = T(0);
    for (int i = 0; i < 3; ++i) size = std::max(size, std::abs(a_.positions_t0.data()[v[0]][i]));
    // With what rounding of the positions does to the direction of their difference.
    const T slack =
        static_cast<T>(flat) + T(8) * std::numeric_limits<T>::epsilon() * size / m.distance;
    const unsigned corners = active_corners(p);
    return First == 1 ? owner_of_face_point(pair, m.n, slack, corners)
                      : owner_of_edge_points(pair, m.n, corners);
  }

  /// A pair whose neighbour is closer now may be the one that meets in the end: then its plane
  /// there counts.
  template <int First>
  bool meets_at_end(const Index v[4], const Vec3<T> u[4], Meeting& m) const {
    Vec3<T> x[4];
    for (int j = 0; j < 4; ++j) x[j] = a_.positions_t1.data()[v[j]];
    const Proximity<T> p = closest<First>(x);
    if (active_corners(p) != 0b1111) return false;
    const Vec3<T> across =
        First == 1 ? cross(x[2] - x[1], x[3] - x[1]) : cross(x[1] - x[0], x[3] - x[2]);
    const T size = length(across);
    if (!(size > T(0))) return false;
    m.n = across * (T(1) / size);
    Vec3<T> before = p.difference;
    for (int j = 0; j < 4; ++j) before -= p.w[j] * u[j];
    if (dot(m.n, before) < T(0)) m.n = -m.n;
    m.distance = dot(m.n, before);
    m.predicted = dot(m.n, p.difference);
    for (int j = 0; j < 4; ++j) m.w[j] = p.w[j];
    // Edges lie slanting to each other everywhere in folds: only those that would cross matter.
    return m.distance > T(0) && (First == 1 || m.predicted < T(0));
  }

  template <int First>
  void consider(const Pair& pair, const Index v[4], const Vec3<T> u[4], const Proximity<T>& p,
                T distance) {
    // Touching is left to the continuous test.
    if (!(distance > T(0)) || are_tied<First>(v)) return;
    Meeting m{
        {p.w[0], p.w[1], p.w[2], p.w[3]}, (T(1) / distance) * p.difference, distance, distance};
    for (int j = 0; j < 4; ++j) m.predicted += p.w[j] * dot(m.n, u[j]);
    if (m.predicted >= a_.thickness && distance >= a_.thickness) return;
    const bool obstacle =
        std::any_of(v, v + 4, [&](Index k) { return k >= a_.cloth_vertex_count; });
    const T thickness = obstacle ? a_.thickness : std::min(a_.thickness, rest_limit<First>(v));
    const Owner whose = owner<First>(pair, v, p, m);
    if (whose == Owner::nobody && !meets_at_end<First>(v, u, m)) return;
    const ContactMemory<T>* memory = recall<First>(pair, m.n);
    const bool bearing = memory != nullptr && m.distance < thickness;
    if (m.predicted >= thickness && !bearing) return;
    known_ = true;
    if (whose != Owner::neighbour) add_contact(pair, v, u, m, thickness, memory);
  }

  void add_contact(const Pair& pair, const Index v[4], const Vec3<T> u[4], const Meeting& m,
                   T thickness, const ContactMemory<T>* memory) {
    Contact<T> c;
    c.pair = pair;
    c.n = m.n;
    c.thickness = thickness;
    T inverse_mass = T(0);
    Vec3<T> slip{};
    for (int j = 0; j < 4; ++j) {
      c.v[j] = v[j];
      c.w[j] = m.w[j];
      slip += m.w[j] * u[j];
      if (!heavy(v[j])) inverse_mass += m.w[j] * m.w[j] / a_.mass.data()[v[j]];
      if (j == 0 || v[j] >= a_.cloth_vertex_count) c.friction = a_.friction_of_vertex.data()[v[j]];
    }
    if (!(inverse_mass > T(0))) return;
    T ratio = a_.stiffness;
    if (m.distance < thickness / 2)
      ratio *= std::min(static_cast<T>(stiffening_max), thickness / (2 * m.distance));
    // A penalty leaves about 1 / ratio of what it meets: a fast approach needs a larger one, or it
    // ends beyond the thickness.
    ratio *= std::max(T(1), (thickness - m.predicted) / (2 * thickness));
    c.stiffness = ratio / (inverse_mass * a_.step * a_.step);
    c.push = c.stiffness;
    FrictionTangent<T> drag;
    if (memory != nullptr) {
      c.anchor = turned_anchor(memory->anchor, memory->n, c.n);
      const T held = length(c.anchor);
      drag = friction_tangent(c.stiffness, c.friction * memory->normal_force,
                              held > T(0) ? c.anchor * (memory->displacement / held) : c.anchor);
    } else {
      c.anchor = {};
      // What stopping the approach will take after the solve has shared it with the masses.
      const T normal_force =
          c.stiffness *
          (std::max(T(0), thickness - m.distance) +
           std::max(T(0), std::min(m.distance, thickness) - m.predicted) / (T(1) + ratio));
      drag = friction_tangent(c.stiffness, c.friction * normal_force, tangential(slip, c.n));
    }
    c.drag = drag.stiffness;
    c.drag_limit = drag.limit;
    c.slide = drag.slide;
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
  bool known_ = false;  ///< the pair at hand is a contact, or another one stands for it
};

}  // namespace

template <class T>
void run(OnHost, Queue& queue, const CollideProximity<T>& args) {
  submit_host(queue, [args] { ProximityFinder<T>(args).find(); });
}

template void run(OnHost, Queue&, const CollideProximity<float>&);
template void run(OnHost, Queue&, const CollideProximity<double>&);

}  // namespace weft
