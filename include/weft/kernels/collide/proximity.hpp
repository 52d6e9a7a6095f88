#pragma once

#include <cmath>
#include <cstdint>
#include <limits>

#include "weft/core/hd.hpp"
#include "weft/core/ids.hpp"
#include "weft/core/marks.hpp"
#include "weft/core/span.hpp"
#include "weft/elements/contact.hpp"
#include "weft/elements/distance.hpp"
#include "weft/elements/normal_cone.hpp"
#include "weft/elements/pair_lanes.hpp"
#include "weft/elements/rest_distance.hpp"
#include "weft/elements/scalar.hpp"
#include "weft/exec/launch.hpp"
#include "weft/kernels/collide/pairs.hpp"
#include "weft/state/contact.hpp"
#include "weft/state/known_distances.hpp"
#include "weft/state/surface.hpp"
#include "weft/state/touched.hpp"

namespace weft {

/// Stands in place of a pair's separation bound if the pair is a contact, or another one stands for
/// it: continuous detection then looks at it at any distance, and knows that the system has heard
/// of it.
constexpr float separation_bound_of_contact = -std::numeric_limits<float>::infinity();

/// CollideProximity::closed_share. With a half, what slides on one layer of thin cloth would touch
/// the floor below it as well. While seams are open it is a half: stiffer layers would not let them
/// close.
inline constexpr double closed_share_of_loads = 0.2;
inline constexpr double closed_share_while_sewn = 0.5;

/// Contacts that the implicit system has to know of: pairs that are closer than the thickness now,
/// or that would be at the end of the step if nothing but gravity changed any velocity, and pairs
/// that bore something in the last step and still are that close. Only pairs whose closest points
/// are where the two surfaces are closest as well (see elements/normal_cone.hpp), and each pair of
/// features once: of the faces around a vertex or an edge the first one stands for it, and edges
/// meet edges within both. The repulsion of a pair is stiffness * m / dt^2 with m its effective
/// mass; below half of the thickness it grows as the inverse of the gap, up to eightfold, it grows
/// with the depth that the prediction reaches, so that what is left of it stays below the
/// thickness, and up to a limit it is enough for loads to close no more than a share of the
/// thickness: in a contact at rest, that hardly slides in this step, a small share by the mean load
/// and half by the force of the last step; in others `closed_share` by that force. A
/// contact at rest also remains one where others of its vertex or edge would take its place, see
/// stays(). A contact of the last step goes on from its force, see go_on(); one that another
/// contact of its vertex or edge hands its load to has the force that it would have without. Where
/// impact zones keep moving vertices it hardens, see harden(). Cloth that is closer than the
/// thickness at rest (a fine mesh) repels at nine tenths of its distance at rest only, not at all
/// if that is below a hundredth of the thickness. Cloth with a thickness of its own from its start
/// (`start_thickness`) repels at that. Two primitives with corners that a seam ties to each other
/// do not repel (P-Cloth section 5.1). The initial guess at friction is that of the last step, and
/// contacts that hang above the thickness are not taken to push, see hovers(). Reads: pairs,
/// positions, memory. Writes: contacts, separation bounds, counts, with the largest slide() of the
/// contacts. Order: face pairs, then edge pairs, each in their order. Ghosts: all vertices. Flags:
/// counts above capacity. Where there are more pairs than there is room for, or a vertex is out of
/// bounds, the pairs are not all and none is looked at, so that it can be launched before anyone
/// has read how many pairs there are.
template <class T>
struct CollideProximity {
  Span<const Pair> face_pairs;  ///< capacity; the number stands in counts
  Span<const Pair> edge_pairs;
  Surface surface;
  Span<const Tri> triangles;
  Span<const Vec3<T>> positions_t0;     ///< [vertices] [m]
  Span<const Vec3<T>> positions_t1;     ///< [vertices] [m] prediction; obstacle: end of the step
  Span<const T> mass;                   ///< [cloth vertices] [kg]
  Span<const unsigned char> fixed;      ///< [cloth vertices]
  Span<const Vec2<T>> material_points;  ///< [cloth vertices] [m]
  Span<const Index> cloth_of_vertex;    ///< [cloth vertices]
  Span<const Index> tied;               ///< [cloth vertices] see Model; empty: no two are
  Span<const T> friction_of_vertex;     ///< [vertices] cloth: cloth on cloth; obstacle: its own
  Index cloth_vertex_count = 0;
  T thickness;                               ///< [m]
  T stiffness;                               ///< in units of m / dt^2
  T step;                                    ///< [s] nominal time step, sets the stiffness
  Span<const ContactMemory<T>> face_memory;  ///< of the last step, in the order of its pairs
  Span<const ContactMemory<T>> edge_memory;
  Span<float> face_separation_bound;  ///< [capacity] [m] lower bound of the pair's gap during the
                                      ///< prediction
  Span<float> edge_separation_bound;
  Span<Contact<T>> contacts;    ///< capacity
  Span<CollideCounts> counts;   ///< [1]
  Span<std::uint32_t> scratch;  ///< [proximity_scratch_size] in CUDA; not in use on the host
  /// Contacts start from the normal force that they had last, as their multiplier (augmented
  /// Lagrangian). Their stiffness grows with nothing but a small gap then.
  bool hold_normal_forces = false;
  /// [cloth vertices] [m] see Model::start_thickness; empty: `thickness` everywhere
  Span<const T> start_thickness = {};
  T fall = T(0);  ///< [m] what gravity adds to the prediction; 0: positions_t1 have been solved for
  Span<const unsigned char> touched = {};  ///< [>= cloth vertices] see state/touched.hpp
  /// Share of the thickness that the force of the last step may close in contacts that slide.
  T closed_share = static_cast<T>(closed_share_of_loads);
  /// Whether any contact counts as at rest. While seams are open none does: stiff contacts that
  /// last would not let them close.
  bool may_rest = true;
  T gravity = T(0);                    ///< [m/s^2] size; 0: no contact counts as heavily loaded
  Span<const unsigned char> cut = {};  ///< [cloth edges] see Model::cut; empty: none is
  KnownDistances<T> known = {};        ///< on the host: from the call before, and for the next one
};

/// Numbers of scratch that CollideProximity takes in CUDA.
/// @param face_pairs, edge_pairs capacities
constexpr std::size_t proximity_scratch_size(std::size_t face_pairs,
                                             std::size_t edge_pairs) noexcept {
  return 2 * marks_size(face_pairs + edge_pairs + 2 * Marks::word_items);
}

template <class T>
void run(OnHost, Queue& queue, const CollideProximity<T>& args);
template <class T>
void run(OnCuda, Queue& queue, const CollideProximity<T>& args);

/// Whether the lists hold all pairs that there are.
template <class T>
WEFT_HD bool has_all_pairs(const CollideProximity<T>& a) noexcept {
  const CollideCounts& counts = a.counts.data()[0];
  return counts.out_of_bounds == 0 &&
         static_cast<std::size_t>(counts.face_pairs) <= a.face_pairs.size() &&
         static_cast<std::size_t>(counts.edge_pairs) <= a.edge_pairs.size();
}

/// What a pair is to the system.
enum class PairRole {
  apart,
  known,  ///< the system knows of it: another contact stands for it, or nothing of it can move
  contact
};

/// How the two primitives of a pair stand.
template <class T>
struct PairApproach {
  Proximity<T> closest;  ///< at the start
  Vec3<T> u[4];          ///< [m] displacements of the corners
  T distance;            ///< [m] at the start
};

/// The decisions of CollideProximity, a pair at a time.
/// @tparam First corners of the first primitive: 1 vertex and face, 2 two edges
template <class T>
class ProximityRule {
 public:
  WEFT_HD explicit ProximityRule(const CollideProximity<T>& args) noexcept : a_(args) {}

  template <int First>
  WEFT_HD const Pair* all_pairs() const noexcept {
    return (First == 1 ? a_.face_pairs : a_.edge_pairs).data();
  }
  template <int First>
  WEFT_HD const Pair& pair(std::size_t number) const noexcept {
    return all_pairs<First>()[number];
  }
  template <int First>
  WEFT_HD float& separation_bound(std::size_t number) const noexcept {
    return (First == 1 ? a_.face_separation_bound : a_.edge_separation_bound).data()[number];
  }

  template <int First>
  WEFT_HD void corners(std::size_t number, Index v[4]) const noexcept {
    const Pair& p = pair<First>(number);
    if constexpr (First == 1) {
      v[0] = p.a;
      for (int j = 0; j < 3; ++j) v[j + 1] = a_.triangles.data()[p.b].v[j];
    } else {
      for (int j = 0; j < 2; ++j) {
        v[j] = a_.surface.edges.data()[p.a].v[j];
        v[j + 2] = a_.surface.edges.data()[p.b].v[j];
      }
    }
  }

  /// Makes the pair one of the lanes.
  template <int First, int Width>
  WEFT_HD void add(PairLanes<T, First, Width>& lanes, std::size_t number) const noexcept {
    Index v[4];
    corners<First>(number, v);
    lanes.add(v, number, a_.positions_t0, a_.positions_t1);
  }

  /// Of each lane: the most that it can close by, how far apart it must be to be left alone, and a
  /// lower bound of its distance at the start. [m]
  template <int First, int Width>
  WEFT_HD void look(const PairLanes<T, First, Width>& lanes, T closing[Width], T reach[Width],
                    T gap[Width]) const noexcept {
    T plane_gap[Width];
    lanes.closing(closing);
    for (int k = 0; k < Width; ++k) reach[k] = a_.thickness + T(1.01) * closing[k];
    lanes.box_gap(gap);
    lanes.plane_gap(plane_gap);
    for (int k = 0; k < Width; ++k) gap[k] = greater(plane_gap[k], gap[k]);
  }

  template <int First>
  WEFT_HD PairApproach<T> approach(const Index v[4]) const noexcept {
    using std::sqrt;
    PairApproach<T> p;
    Vec3<T> x[4];
    for (int j = 0; j < 4; ++j) {
      x[j] = a_.positions_t0.data()[v[j]];
      p.u[j] = a_.positions_t1.data()[v[j]] - x[j];
    }
    p.closest = closest_points<First>(x);
    p.distance = sqrt(p.closest.distance_sq);
    return p;
  }

  /// Whether a pair may be a contact. Only pairs that every search finds, whatever its margins were
  /// and whether it split the motion: their boxes come closer than the thickness as may_meet() has
  /// it. The others must not become contacts by chance.
  template <int First>
  WEFT_HD bool is_near(const Index v[4], T distance, T closing) const noexcept {
    return distance - closing < a_.thickness && boxes_are_near<First>(v);
  }

  /// Lower bound of the gap during the prediction: less by what rounding can have added to the
  /// distance and taken from the motion. [m]
  /// @param size [m] of the coordinates
  WEFT_HD static float separation_bound_of(T distance, T closing, T size) noexcept {
    return static_cast<float>(T(0.9999) * distance - T(1.0001) * closing -
                              T(8) * epsilon<T> * size);
  }

  /// By how many of its edges a contact between cloths slides during the prediction while it bears
  /// far more than the weight of its vertices; 0 for other contacts.
  /// @tparam First as in role()
  template <int First>
  WEFT_HD float slide(const Contact<T>& c) const noexcept {
    using std::sqrt;
    if (!(c.load > T(0)) || !(a_.gravity > T(0))) return 0;
    T inverse_mass = T(0);
    Vec3<T> slip{};
    Vec3<T> x[4];
    for (int j = 0; j < 4; ++j) {
      const Index v = c.v[j];
      if (v >= a_.cloth_vertex_count) return 0;
      if (!heavy(v)) inverse_mass += c.w[j] * c.w[j] / a_.mass.data()[v];
      x[j] = a_.positions_t0.data()[v];
      slip += c.w[j] * (a_.positions_t1.data()[v] - x[j]);
    }
    if (!(c.load * inverse_mass > static_cast<T>(heavy_load) * a_.gravity)) return 0;
    const T edge_sq = First == 1 ? greater(length_sq(x[2] - x[1]),
                                           greater(length_sq(x[3] - x[2]), length_sq(x[1] - x[3])))
                                 : greater(length_sq(x[1] - x[0]), length_sq(x[3] - x[2]));
    return static_cast<float>(length(tangential(slip, c.n)) / sqrt(edge_sq));
  }

  /// @param out written where the pair is a contact
  template <int First>
  WEFT_HD PairRole role(const Pair& pair, const Index v[4], const PairApproach<T>& p,
                        Contact<T>& out) const noexcept {
    // Touching is left to the continuous test.
    if (!(p.distance > T(0)) || are_tied<First>(v)) return PairRole::apart;
    const Proximity<T>& at = p.closest;
    Meeting m{{at.w[0], at.w[1], at.w[2], at.w[3]},
              (T(1) / p.distance) * at.difference,
              p.distance,
              p.distance};
    for (int j = 0; j < 4; ++j) m.predicted += at.w[j] * dot(m.n, p.u[j]);
    if (m.predicted >= a_.thickness && p.distance >= a_.thickness) return PairRole::apart;
    bool obstacle = false;
    for (int j = 0; j < 4; ++j) obstacle = obstacle || v[j] >= a_.cloth_vertex_count;
    const T thickness =
        lesser(obstacle ? a_.thickness : lesser(rest_limit<First>(pair, v), a_.thickness),
               start_limit<First>(v, at));
    Owner whose = owner<First>(pair, v, at, m);
    Recalled memory = recall<First>(pair, m.n);
    if (whose != Owner::pair && rests(memory, p.u, m) && stays<First>(pair, v, at, m))
      whose = Owner::pair;
    if (whose == Owner::nobody) {
      if (!meets_at_end<First>(v, p.u, m)) return PairRole::apart;
      memory = recall<First>(pair, m.n);
    }
    const bool bearing = memory.bearing != nullptr && m.distance < thickness;
    if (m.predicted >= thickness && !bearing) return PairRole::apart;
    // Neighbours whose rest is unknown or next to nothing.
    const bool at_rest_together = thickness < static_cast<T>(rest_least) * a_.thickness;
    if (whose == Owner::neighbour || at_rest_together) return PairRole::known;
    return make_contact(pair, v, p.u, m, thickness, memory, out) ? PairRole::contact
                                                                 : PairRole::known;
  }

 private:
  /// Below half of the thickness repulsion grows as the inverse of the gap, up to this factor.
  static constexpr double stiffening_max = 8;
  /// Sum of the squared weights of free vertices that the stiffness of a contact is at least made
  /// for. Faces and edges without held vertices have a third or more.
  static constexpr double free_weight_sq_least = 0.1;
  /// Share of the way to its settled force that a contact goes in a step, and how many times as
  /// stiff as within a step it is when settled, sliding and at rest. See
  /// docs/decisions/002-contacts.md.
  static constexpr double settling_share = 0.2;
  static constexpr double settled_stiffness = 1.5;
  static constexpr double settled_stiffness_at_rest = 1.2;
  /// Loads beyond so many times what closes a contact without load are not stiffened for.
  static constexpr double stiffened_load_max = 15;
  /// Shares of the thickness that the mean load and the force of the last step close in a contact
  /// at rest.
  static constexpr double closed_at_rest = 0.04;
  static constexpr double closed_at_once = 0.5;
  /// How many times as far as gravity takes it a contact may close that is not taken to push.
  static constexpr double hovering_falls = 1.5;
  /// Cosine that counts as a right angle, so that flat cloth on a flat floor is not a matter of
  /// rounding.
  static constexpr double flat = 1e-3;
  /// Edges with so small a sine between them are parallel.
  static constexpr double parallel = 0.02;
  /// [distances of the two sides] by which a contact at rest slides in a step at most.
  static constexpr double resting_slip = 0.05;
  /// Weights of its vertices beyond which a contact is heavily loaded. Layers of garments stay
  /// below.
  static constexpr double heavy_load = 20;
  /// Edges count as closest up to this slant (cosine) of the faces beside them.
  static constexpr double edge_slant = 0.5;
  /// Contacts of the last step speak for a new one of the same vertex or edge from this cosine on.
  static constexpr double likeness = 0.7;

  template <int First>
  WEFT_HD static bool farther(const Vec3<T> x[4], T d) noexcept {
    if constexpr (First == 1) return vertex_triangle_farther(x, d);
    return edge_edge_farther(x, d);
  }

  WEFT_HD bool heavy(Index v) const noexcept {
    return v >= a_.cloth_vertex_count || a_.fixed.data()[v] != 0;
  }

  template <int First>
  WEFT_HD bool boxes_are_near(const Index v[4]) const noexcept {
    for (int c = 0; c < 3; ++c) {
      bool below = true;  // the second one below the first, at the start and at the end
      bool above = true;
      for (const Vec3<T>* x : {a_.positions_t0.data(), a_.positions_t1.data()}) {
        T lo[2] = {};
        T hi[2] = {};
        for (int j = 0; j < 4; ++j) {
          const int side = j < First ? 0 : 1;
          const bool first = j == 0 || j == First;
          const T at = x[v[j]][c];
          lo[side] = first ? at : lesser(at, lo[side]);
          hi[side] = first ? at : greater(at, hi[side]);
        }
        below = below && lo[0] - hi[1] > a_.thickness;
        above = above && lo[1] - hi[0] > a_.thickness;
      }
      if (below || above) return false;
    }
    return true;
  }

  /// Whether a seam ties a corner of the first primitive to one of the second.
  template <int First>
  WEFT_HD bool are_tied(const Index v[4]) const noexcept {
    if (a_.tied.empty()) return false;
    for (int i = 0; i < First; ++i)
      for (int j = First; j < 4; ++j)
        if (v[i] < a_.cloth_vertex_count && v[j] < a_.cloth_vertex_count &&
            a_.tied.data()[v[i]] == a_.tied.data()[v[j]])
          return true;
    return false;
  }

  /// Contacts of the last step that a pair goes on from; nullptr: none.
  struct Recalled {
    const ContactMemory<T>* own = nullptr;  ///< its own, also if that bore nothing
    /// Its own if that bore anything; else, as a vertex or edge may have moved on to another face
    /// or edge, the one of this vertex or edge that bore something and lay most alike.
    const ContactMemory<T>* bearing = nullptr;
  };

  template <int First>
  WEFT_HD Recalled recall(const Pair& pair, const Vec3<T>& n) const noexcept {
    const Span<const ContactMemory<T>>& memory = First == 1 ? a_.face_memory : a_.edge_memory;
    std::size_t low = 0;
    std::size_t high = memory.size();
    while (low < high) {
      const std::size_t middle = low + (high - low) / 2;
      if (memory.data()[middle].pair.a < pair.a)
        low = middle + 1;
      else
        high = middle;
    }
    Recalled recalled;
    T best_likeness = static_cast<T>(likeness);
    for (const auto* m = memory.data() + low; m != memory.end() && m->pair.a == pair.a; ++m) {
      const bool own = m->pair.b == pair.b;
      if (own) recalled.own = m;
      if (!(m->normal_force > T(0))) continue;
      const T alike = own ? std::numeric_limits<T>::infinity() : dot(m->n, n);
      if (alike <= best_likeness) continue;
      recalled.bearing = m;
      best_likeness = alike;
    }
    return recalled;
  }

  /// Whose the closest points of a pair are.
  enum class Owner {
    pair,
    neighbour,  ///< another pair has the same points
    nobody,     ///< the surfaces are closer elsewhere
  };

  WEFT_HD bool vertex_faces(Index v, const Vec3<T>& away, T slack) const noexcept {
    const Offset* offset = a_.surface.ring_offset.data() + v;
    return in_vertex_cone(a_.surface.ring.subspan(static_cast<std::size_t>(offset[0]),
                                                  static_cast<std::size_t>(offset[1] - offset[0])),
                          a_.positions_t0, v, away, slack);
  }
  WEFT_HD bool edge_faces(Index e, const Vec3<T>& away, T slack) const noexcept {
    return in_edge_cone(a_.surface.edges.data()[e], a_.surface.wings.data()[e].v, a_.positions_t0,
                        away, slack);
  }

  WEFT_HD Owner owner_of_face_point(const Pair& pair, const Vec3<T>& n, T slack,
                                    unsigned corners) const noexcept {
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
  WEFT_HD Owner owner_of_edge_points(const Pair& pair, const Index v[4], const Vec3<T>& n,
                                     unsigned corners) const noexcept {
    // A vertex has a pair with a face there. Of parallel edges that is one of their ends.
    if (corners != 0b1111 || are_parallel(v)) return Owner::neighbour;
    const T slack = static_cast<T>(edge_slant);
    return edge_faces(pair.a, -n, slack) && edge_faces(pair.b, n, slack) ? Owner::pair
                                                                         : Owner::nobody;
  }

  /// How a pair meets.
  struct Meeting {
    T w[4];
    Vec3<T> n;
    T distance;   ///< [m] along n, at the start
    T predicted;  ///< [m] the same at the predicted end
  };

  template <int First>
  WEFT_HD Owner owner(const Pair& pair, const Index v[4], const Proximity<T>& p,
                      const Meeting& m) const noexcept {
    using std::fabs;
    T size = T(0);
    for (int i = 0; i < 3; ++i) size = greater(fabs(a_.positions_t0.data()[v[0]][i]), size);
    // With what rounding of the positions does to the direction of their difference.
    const T slack = static_cast<T>(flat) + T(8) * epsilon<T> * size / m.distance;
    const unsigned corners = active_corners(p);
    return First == 1 ? owner_of_face_point(pair, m.n, slack, corners)
                      : owner_of_edge_points(pair, v, m.n, corners);
  }

  /// Whether a contact at rest remains one although its closest points are another pair's now: as
  /// long as they are aside by no more than it may slide. Pairs that take turns drop and find
  /// loads, and so keep cloth at rest moving.
  template <int First>
  WEFT_HD bool stays(const Pair& pair, const Index v[4], const Proximity<T>& p,
                     const Meeting& m) const noexcept {
    const T bound = static_cast<T>(resting_slip);
    if (First == 1)
      return owner_of_face_point(pair, m.n, bound, active_corners(p)) != Owner::nobody;
    const Vec3<T>* x = a_.positions_t0.data();
    for (int j = 0; j < 4; j += 2) {
      const Vec3<T> along = x[v[j + 1]] - x[v[j]];
      const T slant = dot(along, m.n);
      if (slant * slant > bound * bound * length_sq(along)) return false;
    }
    return owner_of_edge_points(pair, v, m.n, 0b1111) == Owner::pair;
  }

  /// Whether a small turn of one of two edges would move their closest points along all of them.
  WEFT_HD bool are_parallel(const Index v[4]) const noexcept {
    const Vec3<T>* x = a_.positions_t0.data();
    const Vec3<T> a = x[v[1]] - x[v[0]];
    const Vec3<T> b = x[v[3]] - x[v[2]];
    return length_sq(cross(a, b)) <
           static_cast<T>(parallel * parallel) * length_sq(a) * length_sq(b);
  }

  /// A pair whose neighbour is closer now may be the one that meets in the end: then its plane
  /// there counts.
  template <int First>
  WEFT_HD bool meets_at_end(const Index v[4], const Vec3<T> u[4], Meeting& m) const noexcept {
    Vec3<T> x[4];
    for (int j = 0; j < 4; ++j) x[j] = a_.positions_t1.data()[v[j]];
    const Proximity<T> p = closest_points<First>(x);
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

  /// @return whether there is anything that can move
  WEFT_HD bool make_contact(const Pair& pair, const Index v[4], const Vec3<T> u[4],
                            const Meeting& m, T thickness, const Recalled& memory,
                            Contact<T>& c) const noexcept {
    c.pair = pair;
    c.n = m.n;
    c.thickness = thickness;
    c.reach = thickness;
    T inverse_mass = T(0);
    T free_weight_sq = T(0);
    Vec3<T> slip{};
    for (int j = 0; j < 4; ++j) {
      c.v[j] = v[j];
      c.w[j] = m.w[j];
      slip += m.w[j] * u[j];
      if (!heavy(v[j])) {
        inverse_mass += m.w[j] * m.w[j] / a_.mass.data()[v[j]];
        free_weight_sq += m.w[j] * m.w[j];
      }
      if (j == 0 || v[j] >= a_.cloth_vertex_count) c.friction = a_.friction_of_vertex.data()[v[j]];
    }
    if (!(inverse_mass > T(0))) return false;
    // If the closest points are almost those of held vertices, the free ones would have to move
    // many times as far as the gap is to open.
    inverse_mass *= greater(T(1), static_cast<T>(free_weight_sq_least) / free_weight_sq);
    c.yield = same_cloth(v[0], v[3]) ? yield_of(inverse_mass, thickness)
                                     : std::numeric_limits<T>::infinity();
    T ratio = a_.stiffness;
    if (m.distance < thickness / 2)
      ratio *= lesser(thickness / (2 * m.distance), static_cast<T>(stiffening_max));
    // A penalty leaves about 1 / ratio of what it meets: a fast approach needs a larger one, or it
    // ends beyond the thickness.
    if (!a_.hold_normal_forces) ratio *= greater((thickness - m.predicted) / (2 * thickness), T(1));
    const T unloaded = ratio / (inverse_mass * a_.step * a_.step);
    c.stiffness = unloaded;
    const bool at_rest = rests(memory, u, m);
    const T loaded = memory.bearing != nullptr && !a_.hold_normal_forces
                         ? stiffness_under(*memory.bearing, at_rest, unloaded, thickness)
                         : unloaded;
    if (const ContactMemory<T>* last = memory.own;
        last != nullptr && (last->normal_force > T(0) || m.distance < thickness)) {
      c.stiffness = loaded;
      go_on(last->normal_force, at_rest ? settled_stiffness_at_rest : settled_stiffness, m.distance,
            c);
    } else {
      stiffen(loaded, m.distance, c);
    }
    harden(unloaded, thickness, m.distance, c);
    c.hold = c.stiffness;
    c.push = hovers(m, thickness, memory) ? T(0) : c.stiffness;
    FrictionTangent<T> drag;
    if (const ContactMemory<T>* last = memory.bearing; last != nullptr) {
      const Vec3<T> force = turned_anchor(last->friction, last->n, c.n);
      const T held = length(force);
      c.anchor = force * (T(1) / c.stiffness);
      c.load = last->load;
      drag = friction_tangent(c.stiffness, c.friction * last->normal_force,
                              held > T(0) ? c.anchor * (last->sticking_force / held) : c.anchor);
    } else {
      c.anchor = {};
      c.load = T(0);
      // What stopping the approach will take after the solve has shared it with the masses.
      const T normal_force =
          c.stiffness *
          (greater(thickness - m.distance, T(0)) +
           greater(lesser(thickness, m.distance) - m.predicted, T(0)) / (T(1) + ratio));
      drag = friction_tangent(c.stiffness, c.friction * normal_force, tangential(slip, c.n));
    }
    if (!(c.push > T(0))) drag = {};
    c.drag = drag.stiffness;
    c.drag_limit = drag.limit;
    c.slide = drag.slide;
    return true;
  }

  WEFT_HD bool same_cloth(Index v, Index w) const noexcept {
    return v < a_.cloth_vertex_count && w < a_.cloth_vertex_count &&
           a_.cloth_of_vertex.data()[v] == a_.cloth_of_vertex.data()[w];
  }

  /// [N] Contact::yield within a cloth. The weights of a pile crush nothing, however long the step.
  WEFT_HD T yield_of(T inverse_mass, T thickness) const noexcept {
    return (a_.stiffness * thickness / (a_.step * a_.step) +
            static_cast<T>(heavy_load) * a_.gravity) /
           inverse_mass;
  }

  /// Whether a contact will bear nothing in this step: it bore nothing in the last one, nor did
  /// another whose load it takes over, it is no closer than the thickness, and it closes by hardly
  /// more than gravity takes it.
  WEFT_HD bool hovers(const Meeting& m, T thickness, const Recalled& memory) const noexcept {
    const ContactMemory<T>* last = memory.own != nullptr ? memory.own : memory.bearing;
    const bool bore = last != nullptr && last->normal_force > T(0);
    return !bore && m.distance >= thickness &&
           m.distance - m.predicted < static_cast<T>(hovering_falls) * a_.fall;
  }

  /// Makes a contact go on from its normal force F of the last step, by the gap from which it
  /// repels: with k its stiffness, s the settled factor, h that gap so far and g the gap at the
  /// start, the force at g is F + (s k (h - g) - F) / 5. So layers that are pushed together are not
  /// thrown apart within a step, and what rests in the end repels as if it were s times as stiff.
  /// If normal forces are held, the force at g is F + k (h - g).
  /// @param force [N]   @param gap [m] at the start
  WEFT_HD void go_on(T force, double settled_factor, T gap, Contact<T>& c) const noexcept {
    const T held = force / c.stiffness;
    if (a_.hold_normal_forces) {
      c.thickness += held;
      return;
    }
    const T settled = static_cast<T>(settled_factor) * (c.thickness - gap);
    c.thickness = gap + held + static_cast<T>(settling_share) * (settled - held);
  }

  /// Makes a contact whose vertices impact zones keep moving resist harder, by the largest factor
  /// of its vertices. Its force where it starts stays what it is, but at most the settled one: what
  /// hardens holds, and throws nothing apart.
  /// @param unloaded [N/m] stiffness that the factor applies to   @param gap [m] at the start
  WEFT_HD void harden(T unloaded, T thickness, T gap, Contact<T>& c) const noexcept {
    if (a_.hold_normal_forces || a_.touched.empty()) return;
    int level = 0;
    for (int j = 0; j < 4; ++j)
      if (c.v[j] < a_.cloth_vertex_count) {
        const int own = touched_level(a_.touched.data()[c.v[j]]);
        if (own > level) level = own;
      }
    if (level == 0) return;
    c.thickness = lesser(c.thickness,
                         gap + static_cast<T>(settled_stiffness) * greater(thickness - gap, T(0)));
    stiffen(hardening<T>(level) * unloaded, gap, c);
  }

  /// Makes a contact resist more, with the same force where it starts.
  /// @param stiffness [N/m] that it is to have at least   @param gap [m] at the start
  WEFT_HD static void stiffen(T stiffness, T gap, Contact<T>& c) noexcept {
    if (!(stiffness > c.stiffness)) return;
    if (gap < c.thickness) c.thickness = gap + (c.thickness - gap) * (c.stiffness / stiffness);
    c.stiffness = stiffness;
  }

  /// Stiffness of a contact whose like left this. [N/m]
  WEFT_HD T stiffness_under(const ContactMemory<T>& last, bool at_rest, T unloaded,
                            T thickness) const noexcept {
    const T most = static_cast<T>(stiffened_load_max) * unloaded * thickness;
    const T force = lesser(last.normal_force, most);
    const T closing = at_rest ? greater(lesser(last.load, most) / static_cast<T>(closed_at_rest),
                                        force / static_cast<T>(closed_at_once))
                              : force / a_.closed_share;
    return greater(unloaded, closing / thickness);
  }

  /// Whether a contact of the last step hardly slides in this one.
  WEFT_HD bool rests(const Recalled& memory, const Vec3<T> u[4], const Meeting& m) const noexcept {
    if (!a_.may_rest || memory.own == nullptr || !(memory.own->normal_force > T(0))) return false;
    Vec3<T> slip{};
    for (int j = 0; j < 4; ++j) slip += m.w[j] * u[j];
    return length(tangential(slip, m.n)) <= static_cast<T>(resting_slip) * m.distance;
  }

  /// How close neighbours of one cloth may be without repelling each other at rest.
  template <int First>
  WEFT_HD T rest_limit(const Pair& pair, const Index v[4]) const noexcept {
    using std::sqrt;
    Index cloth[4];
    Vec3<T> rest[4];
    for (int j = 0; j < 4; ++j) {
      cloth[j] = a_.cloth_of_vertex.data()[v[j]];
      const Vec2<T>& m = a_.material_points.data()[v[j]];
      rest[j] = {m[0], m[1], T(0)};
    }
    const unsigned cut = cut_of<First>(pair);
    const T limit = a_.thickness / static_cast<T>(rest_share);
    if (cut == 0 && farther<First>(rest, limit)) return a_.thickness;
    return static_cast<T>(rest_share) * sqrt(rest_distance_sq<First>(rest, cloth, cut));
  }

  /// Those edges of a pair that rest_distance_sq() takes for cut.
  template <int First>
  WEFT_HD unsigned cut_of(const Pair& pair) const noexcept {
    if (a_.cut.empty()) return 0;
    const unsigned char* cut = a_.cut.data();
    if (First == 2) return cut[pair.a] | cut[pair.b] << 1u;
    const Tri& e = a_.surface.edges_of_face.data()[pair.b];
    return cut[e.v[0]] | cut[e.v[1]] << 1u | cut[e.v[2]] << 2u;
  }

  /// Gap at which the thinner of the two sides starts to repel, see Model::start_thickness.
  template <int First>
  WEFT_HD T start_limit(const Index v[4], const Proximity<T>& at) const noexcept {
    using std::fabs;
    if (a_.start_thickness.empty()) return a_.thickness;
    T side[2] = {T(0), T(0)};
    for (int j = 0; j < 4; ++j)
      side[j < First ? 0 : 1] +=
          fabs(at.w[j]) *
          (v[j] < a_.cloth_vertex_count ? a_.start_thickness.data()[v[j]] : a_.thickness);
    return lesser(side[0], side[1]);
  }

  const CollideProximity<T>& a_;
};

}  // namespace weft
