#pragma once

#include <optional>

#include "tests/parity/collide/layers.hpp"
#include "weft/kernels/collide/proximity.hpp"

namespace weft::parity {

using Point = Vec3<double>;

/// Closest points of two primitives, the plain way.
struct PlainClosest {
  double w[4];
  Point difference;
  double distance() const { return length(difference); }
  int active() const {
    int mask = 0;
    for (int j = 0; j < 4; ++j) mask |= (w[j] != 0 ? 1 : 0) << j;
    return mask;
  }
};

inline PlainClosest weighted(const Point x[4], double a, double b, double c, double d) {
  return {{a, b, c, d}, a * x[0] + b * x[1] + c * x[2] + d * x[3]};
}

/// Of the point p and the segment from a to b: the share of b.
inline double along_segment(const Point& p, const Point& a, const Point& b) {
  return std::clamp(dot(p - a, b - a) / dot(b - a, b - a), 0.0, 1.0);
}

/// By the normal equations where they do not lead outside, or by all vertices against all edges.
/// @param first corners of the first primitive
inline PlainClosest plain_closest(const Point x[4], int first) {
  const Point r = x[0] - x[first];
  const Point p = first == 1 ? x[2] - x[1] : x[0] - x[1];
  const Point q = first == 1 ? x[3] - x[1] : x[3] - x[2];
  const double pp = dot(p, p), pq = dot(p, q), qq = dot(q, q), det = pp * qq - pq * pq;
  const double s = (dot(r, p) * qq - dot(r, q) * pq) / det;
  const double t = (dot(r, q) * pp - dot(r, p) * pq) / det;
  std::vector<PlainClosest> all;
  if (first == 1) {
    const double t1 = along_segment(x[0], x[1], x[2]), t2 = along_segment(x[0], x[1], x[3]),
                 t3 = along_segment(x[0], x[2], x[3]);
    all = {weighted(x, 1, t1 - 1, -t1, 0), weighted(x, 1, t2 - 1, 0, -t2),
           weighted(x, 1, 0, t3 - 1, -t3)};
    if (s > 0 && t > 0 && s + t < 1) all.push_back(weighted(x, 1, s + t - 1, -s, -t));
  } else {
    const double t0 = along_segment(x[0], x[2], x[3]), t1 = along_segment(x[1], x[2], x[3]),
                 s0 = along_segment(x[2], x[0], x[1]), s1 = along_segment(x[3], x[0], x[1]);
    all = {weighted(x, 1, 0, t0 - 1, -t0), weighted(x, 0, 1, t1 - 1, -t1),
           weighted(x, 1 - s0, s0, -1, 0), weighted(x, 1 - s1, s1, 0, -1)};
    if (s > 0 && s < 1 && t > 0 && t < 1) all.push_back(weighted(x, 1 - s, s, t - 1, -t));
  }
  return *std::min_element(all.begin(), all.end(), [](const auto& a, const auto& b) {
    return a.distance() < b.distance();
  });
}

/// Largest displacements about the mean, of both primitives together.
inline double plain_closing(const Point u[4], int first) {
  const Point mean = 0.25 * (u[0] + u[1] + u[2] + u[3]);
  double most[2] = {0, 0};
  for (int j = 0; j < 4; ++j)
    most[j < first ? 0 : 1] = std::max(most[j < first ? 0 : 1], length(u[j] - mean));
  return most[0] + most[1];
}

/// Gap between boxes along the axis where it is largest.
inline double plain_box_gap(const std::vector<Point>& a, const std::vector<Point>& b) {
  double gap = -1e9;
  for (int c = 0; c < 3; ++c) {
    double a_lo = 1e9, a_hi = -1e9, b_lo = 1e9, b_hi = -1e9;
    for (const Point& x : a) a_lo = std::min(a_lo, x[c]), a_hi = std::max(a_hi, x[c]);
    for (const Point& x : b) b_lo = std::min(b_lo, x[c]), b_hi = std::max(b_hi, x[c]);
    gap = std::max({gap, a_lo - b_hi, b_lo - a_hi});
  }
  return gap;
}

/// Whether along some axis all of one primitive lies beyond all of the other by more than `by`, on
/// the same side at the start and at the end.
inline bool plain_passes_by(const Point x[4], const Point y[4], int first, double by) {
  for (int c = 0; c < 3; ++c)
    for (const double side : {-1.0, 1.0}) {
      bool beyond = true;
      for (int i = 0; i < first; ++i)
        for (int j = first; j < 4; ++j)
          beyond = beyond && side * (x[i][c] - x[j][c]) > by && side * (y[i][c] - y[j][c]) > by;
      if (beyond) return true;
    }
  return false;
}

/// Gap between the parallel planes through both primitives, less what rounding can make of it.
inline double plain_plane_gap(const Point x[4], int first, double unit) {
  const Point e = first == 1 ? x[2] - x[1] : x[1] - x[0], f = x[3] - x[first];
  const Point n = cross(e, f), r = x[0] - x[first];
  const auto sum = [](const Point& p) { return std::abs(p[0]) + std::abs(p[1]) + std::abs(p[2]); };
  return (std::abs(dot(n, r)) - 16 * unit * sum(e) * sum(f) * sum(r)) / length(n);
}

/// What the contract of CollideProximity says of one pair, a sentence at a time, in double.
template <class T>
class PlainContacts {
 public:
  /// @param args spans of host memory
  explicit PlainContacts(const CollideProximity<T>& args) : a_(args) {}

  struct Verdict {
    double separation_bound;
    bool known = false;
    std::optional<Contact<double>> contact;
  };

  Verdict judge(const Pair& pair, int first) const {
    Index v[4];
    if (first == 1) {
      v[0] = pair.a;
      std::copy_n(a_.triangles[at(pair.b)].v, 3, v + 1);
    } else {
      std::copy_n(a_.surface.edges[at(pair.a)].v, 2, v);
      std::copy_n(a_.surface.edges[at(pair.b)].v, 2, v + 2);
    }
    Point x[4], y[4], u[4];
    for (int j = 0; j < 4; ++j) {
      x[j] = vec_cast<double>(a_.positions_t0[at(v[j])]);
      y[j] = vec_cast<double>(a_.positions_t1[at(v[j])]);
      u[j] = y[j] - x[j];
    }
    const double closing = plain_closing(u, first), thickness = double{a_.thickness};
    const double reach = thickness + 1.01 * closing;
    const PlainClosest start = plain_closest(x, first);
    constexpr double unit = std::numeric_limits<T>::epsilon();
    const double gap = std::max(plain_plane_gap(x, first, unit),
                                plain_box_gap({x, x + first}, {x + first, x + 4}));
    double size = 0;
    for (int c = 0; c < 3; ++c) size = std::max(size, std::abs(x[0][c]) + std::abs(u[0][c]));
    Verdict verdict{
        0.9999 * (gap > reach ? gap : start.distance()) - 1.0001 * closing - 8 * unit * size,
        false,
        {}};
    if (start.distance() - closing < thickness && !plain_passes_by(x, y, first, thickness))
      meet(pair, first, v, x, y, start, verdict);
    return verdict;
  }

 private:
  static std::size_t at(Index i) { return static_cast<std::size_t>(i); }
  Point position(Index v) const { return vec_cast<double>(a_.positions_t0[at(v)]); }

  struct Meeting {
    double w[4];
    Point n;
    double distance, predicted;
  };

  void meet(const Pair& pair, int first, const Index v[4], const Point x[4], const Point y[4],
            const PlainClosest& start, Verdict& verdict) const {
    const double thickness = double{a_.thickness};
    for (int i = 0; i < first; ++i)
      for (int j = first; j < 4; ++j)
        if (std::max(v[i], v[j]) < a_.cloth_vertex_count && a_.tied[at(v[i])] == a_.tied[at(v[j])])
          return;
    Meeting m = meeting(start.w, (1 / start.distance()) * start.difference, x, y);
    if (m.predicted >= thickness && m.distance >= thickness) return;
    const double limit =
        std::min({thickness, rest_limit(pair, v, first), start_limit(v, first, start.w)});
    bool other = false;  // another pair stands for this one
    const Span<const ContactMemory<T>> all = first == 1 ? a_.face_memory : a_.edge_memory;
    bool closest = closest_surfaces(pair, v, first, start.active(), m, other);
    if ((!closest || other) && rests(own(all, pair), x, y, m) &&
        stays(pair, v, first, start.active(), m)) {
      closest = true;
      other = false;
    }
    if (!closest) {
      const PlainClosest end = plain_closest(y, first);
      if (end.active() != 15) return;
      m = meeting(end.w, normal(y, first), x, y);
      if (m.distance < 0) m = meeting(end.w, -m.n, x, y);
      if (first == 2 && m.predicted >= 0) return;
      other = false;
    }
    const ContactMemory<T>* memory = recall(all, pair, m.n);
    if (m.predicted >= limit && (memory == nullptr || m.distance >= limit)) return;
    verdict.known = true;
    if (!other && limit >= 0.01 * thickness)
      fill(pair, v, x, y, m, limit, own(all, pair), memory, verdict.contact);
  }

  static Point normal(const Point x[4], int first) {
    const Point n = first == 1 ? cross(x[2] - x[1], x[3] - x[1]) : cross(x[1] - x[0], x[3] - x[2]);
    return (1 / length(n)) * n;
  }
  static Meeting meeting(const double w[4], const Point& n, const Point x[4], const Point y[4]) {
    Meeting m{{w[0], w[1], w[2], w[3]}, n, 0, 0};
    for (int j = 0; j < 4; ++j) {
      m.distance += w[j] * dot(n, x[j]);
      m.predicted += w[j] * dot(n, y[j]);
    }
    return m;
  }

  /// Nine tenths of the distance at rest of two primitives of one cloth.
  double rest_limit(const Pair& pair, const Index v[4], int first) const {
    for (int j = 0; j < 4; ++j)
      if (v[j] >= a_.cloth_vertex_count) return 1e9;
    std::vector<Index> edges[2];
    if (first == 2) edges[0] = {pair.a}, edges[1] = {pair.b};
    if (first == 1)
      edges[1].assign(a_.surface.edges_of_face[at(pair.b)].v,
                      a_.surface.edges_of_face[at(pair.b)].v + 3);
    const bool cut = std::any_of(edges[0].begin(), edges[0].end(), is_cut()) ||
                     std::any_of(edges[1].begin(), edges[1].end(), is_cut());
    // Crossing edges of a plane and points in a triangle of it touch: what is left is the boundary.
    if (!cut) return 0.9 * rest_distance(v, first);
    double nearest = 1e9;
    const std::vector<Edge> second = parts(edges[1]);
    for (const Edge& p : first == 1 ? std::vector<Edge>{{{v[0], v[0]}}} : parts(edges[0]))
      for (const Edge& q : second) nearest = std::min(nearest, part_distance(p, q));
    return 0.9 * nearest;
  }

  auto is_cut() const {
    return [this](Index edge) { return !a_.cut.empty() && a_.cut[at(edge)] != 0; };
  }

  /// The edges that are not cut, and the ends of those that are, twice each.
  std::vector<Edge> parts(const std::vector<Index>& edges) const {
    std::vector<Edge> result;
    for (const Index e : edges) {
      const Edge& edge = a_.surface.edges[at(e)];
      if (!is_cut()(e)) {
        result.push_back(edge);
        continue;
      }
      for (const Index v : edge.v) result.push_back({{v, v}});
    }
    return result;
  }

  Point rest(Index v) const {
    const Vec2<T>& p = a_.material_points[at(v)];
    return {double{p[0]}, double{p[1]}, 0};
  }

  double rest_distance(const Index v[4], int first) const {
    Point x[4];
    for (int j = 0; j < 4; ++j) {
      if (a_.cloth_of_vertex[at(v[j])] != a_.cloth_of_vertex[at(v[0])]) return 1e9;
      x[j] = rest(v[j]);
    }
    return plain_closest(x, first).distance();
  }

  /// Both ends of a part are one vertex where it is not an edge.
  double part_distance(const Edge& p, const Edge& q) const {
    const Index v[4] = {p.v[0], p.v[1], q.v[0], q.v[1]};
    if (v[0] != v[1] && v[2] != v[3]) return rest_distance(v, 2);
    if (v[2] != v[3]) return part_distance(q, p);
    for (int j = 1; j < 4; ++j)
      if (a_.cloth_of_vertex[at(v[j])] != a_.cloth_of_vertex[at(v[0])]) return 1e9;
    const Point a = rest(v[0]), b = rest(v[1]), c = rest(v[2]);
    return v[0] == v[1] ? length(a - c) : length(a + along_segment(c, a, b) * (b - a) - c);
  }

  /// What cloth that started near has left of the thickness, at the closest points of the thinner
  /// side.
  double start_limit(const Index v[4], int first, const double w[4]) const {
    if (a_.start_thickness.empty()) return 1e9;
    double of_first = 0, of_second = 0;
    for (int j = 0; j < 4; ++j) {
      const double own = v[j] < a_.cloth_vertex_count ? double{a_.start_thickness[at(v[j])]}
                                                      : double{a_.thickness};
      if (j < first)
        of_first += w[j] * own;
      else
        of_second -= w[j] * own;
    }
    return std::min(of_first, of_second);
  }

  static bool leads_closer(const Point& along, const Point& away, double separation_bound) {
    return dot(along, away) > separation_bound * length(along);
  }
  bool vertex_is_closest(Index v, const Point& away, double separation_bound) const {
    for (auto k = at(static_cast<Index>(a_.surface.ring_offset[at(v)]));
         k < static_cast<std::size_t>(a_.surface.ring_offset[at(v) + 1]); ++k)
      if (leads_closer(position(a_.surface.ring[k]) - position(v), away, separation_bound))
        return false;
    return true;
  }
  bool edge_is_closest(Index e, const Point& away, double separation_bound) const {
    const Edge& edge = a_.surface.edges[at(e)];
    for (const Index wing : a_.surface.wings[at(e)].v) {
      if (wing < 0) continue;
      const Point along = position(edge.v[1]) - position(edge.v[0]);
      Point out = position(wing) - position(edge.v[0]);
      out -= (dot(out, along) / dot(along, along)) * along;
      if (leads_closer(out, away, separation_bound)) return false;
    }
    return true;
  }

  /// Whether the surfaces are closest where the pair is; `other`: another pair is to say so.
  bool closest_surfaces(const Pair& pair, const Index v[4], int first, int active, const Meeting& m,
                        bool& other) const {
    if (first == 2) {
      other = active != 15 || parallel(v);
      return other || (edge_is_closest(pair.a, -m.n, 0.5) && edge_is_closest(pair.b, m.n, 0.5));
    }
    const Point x = position(v[0]);
    const double size = std::max({std::abs(x[0]), std::abs(x[1]), std::abs(x[2])});
    const double separation_bound =
        1e-3 + 8 * double{std::numeric_limits<T>::epsilon()} * size / m.distance;
    return closest_to_face(pair, active, m, separation_bound, other);
  }

  Point along(Index from, Index to) const {
    const Point e = position(to) - position(from);
    return (1 / length(e)) * e;
  }
  bool parallel(const Index v[4]) const {
    return length(cross(along(v[0], v[1]), along(v[2], v[3]))) < 0.02;
  }

  static bool rests(const ContactMemory<T>* own, const Point x[4], const Point y[4],
                    const Meeting& m) {
    if (own == nullptr || own->normal_force == 0) return false;
    Point slip{};
    for (int j = 0; j < 4; ++j) slip += m.w[j] * (y[j] - x[j]);
    return length(slip - dot(slip, m.n) * m.n) <= 0.05 * m.distance;
  }

  bool stays(const Pair& pair, const Index v[4], int first, int active, const Meeting& m) const {
    bool other = false;
    if (first == 1) return closest_to_face(pair, active, m, 0.05, other);
    return std::abs(dot(along(v[0], v[1]), m.n)) <= 0.05 &&
           std::abs(dot(along(v[2], v[3]), m.n)) <= 0.05 && !parallel(v) &&
           edge_is_closest(pair.a, -m.n, 0.5) && edge_is_closest(pair.b, m.n, 0.5);
  }

  bool closest_to_face(const Pair& pair, int active, const Meeting& m, double separation_bound,
                       bool& other) const {
    if (active == 15) return true;
    if (!vertex_is_closest(pair.a, -m.n, separation_bound)) return false;
    const Tri& face = a_.triangles[at(pair.b)];
    for (int k = 0; k < 3; ++k) {
      if (active == (15 & ~(2 << k))) {
        const Index e = a_.surface.edges_of_face[at(pair.b)].v[k];
        other = a_.surface.wings[at(e)].first_face != pair.b;
        return edge_is_closest(e, m.n, separation_bound);
      }
      if (active == (1 | 2 << k)) {
        other = pair.a > face.v[k] || a_.surface.face_of_vertex[at(face.v[k])] != pair.b;
        return vertex_is_closest(face.v[k], m.n, separation_bound);
      }
    }
    return true;
  }

  static const ContactMemory<T>* recall(Span<const ContactMemory<T>> all, const Pair& pair,
                                        const Point& n) {
    const ContactMemory<T>* best = nullptr;
    double likeness = 0.7;
    for (const ContactMemory<T>& m : all) {
      if (m.pair.a != pair.a || !(m.normal_force > T(0))) continue;
      if (m.pair.b == pair.b) return &m;
      const double alike = dot(vec_cast<double>(m.n), n);
      if (alike > likeness) {
        best = &m;
        likeness = alike;
      }
    }
    return best;
  }

  static const ContactMemory<T>* own(Span<const ContactMemory<T>> all, const Pair& pair) {
    for (const ContactMemory<T>& m : all)
      if (m.pair.a == pair.a && m.pair.b == pair.b) return &m;
    return nullptr;
  }

  /// Largest factor of a pair's cloth: doubled by eight levels, in straight lines between.
  double hardest(const Index v[4]) const {
    double most = 1;
    for (int j = 0; j < 4; ++j) {
      if (v[j] >= a_.cloth_vertex_count) continue;
      const int level = a_.touched[at(v[j])] % 128;
      most = std::max(most, std::pow(2.0, level / 8) * (1 + level % 8 / 8.0));
    }
    return most;
  }

  void fill(const Pair& pair, const Index v[4], const Point x[4], const Point y[4],
            const Meeting& m, double limit, const ContactMemory<T>* own,
            const ContactMemory<T>* memory, std::optional<Contact<double>>& out) const {
    Contact<double> c{};
    c.pair = pair;
    c.n = m.n;
    c.thickness = c.reach = limit;
    double inverse_mass = 0, free_weight_sq = 0;
    Point slip{};
    c.friction = double{a_.friction_of_vertex[at(v[0])]};
    for (int j = 0; j < 4; ++j) {
      c.v[j] = v[j];
      c.w[j] = m.w[j];
      slip += m.w[j] * (y[j] - x[j]);
      const bool obstacle = v[j] >= a_.cloth_vertex_count;
      if (!obstacle && a_.fixed[at(v[j])] == 0) {
        inverse_mass += m.w[j] * m.w[j] / double{a_.mass[at(v[j])]};
        free_weight_sq += m.w[j] * m.w[j];
      }
      if (obstacle) c.friction = double{a_.friction_of_vertex[at(v[j])]};
    }
    if (inverse_mass == 0) return;
    if (free_weight_sq < 0.1) inverse_mass *= 0.1 / free_weight_sq;
    c.yield = std::numeric_limits<double>::infinity();
    if (v[0] < a_.cloth_vertex_count && v[3] < a_.cloth_vertex_count &&
        a_.cloth_of_vertex[at(v[0])] == a_.cloth_of_vertex[at(v[3])]) {
      const double step = double{a_.step};
      c.yield =
          (double{a_.stiffness} * limit / (step * step) + 20 * double{a_.gravity}) / inverse_mass;
    }
    const double gap_factor = std::clamp(limit / (2 * m.distance), 1.0, 8.0);
    const double depth_factor =
        a_.hold_normal_forces ? 1 : std::max(1.0, (limit - m.predicted) / (2 * limit));
    const double ratio = double{a_.stiffness} * gap_factor * depth_factor;
    const double unloaded = ratio / (inverse_mass * double{a_.step} * double{a_.step});
    c.stiffness = unloaded;
    const bool at_rest = rests(own, x, y, m);
    const double settled = at_rest ? 1.2 : 1.5;
    if (memory != nullptr && !a_.hold_normal_forces) {
      const double force = double{memory->normal_force} / limit;
      const double load = double{memory->load} / limit;
      c.stiffness = at_rest ? std::max({unloaded, std::min(force / 0.5, 30 * unloaded),
                                        std::min(load / 0.04, 375 * unloaded)})
                            : std::clamp(force / 0.2, unloaded, 75 * unloaded);
    }
    if (own != nullptr && (own->normal_force > T(0) || m.distance < limit)) {
      const double before = double{own->normal_force};
      const double at_start =
          before + 0.2 * (settled * c.stiffness * (limit - m.distance) - before);
      c.thickness = a_.hold_normal_forces ? limit + before / c.stiffness
                                          : m.distance + at_start / c.stiffness;
    } else if (m.distance < limit) {
      c.thickness = m.distance + unloaded * (limit - m.distance) / c.stiffness;
    }
    if (const double factor = hardest(v); !a_.hold_normal_forces && factor > 1) {
      const double force = std::min(c.stiffness * (c.thickness - m.distance),
                                    1.5 * c.stiffness * std::max(0.0, limit - m.distance));
      c.stiffness = std::max(c.stiffness, factor * unloaded);
      c.thickness =
          force > 0 ? m.distance + force / c.stiffness : std::min(c.thickness, m.distance);
    }
    c.push = c.hold = c.stiffness;
    double force =
        c.stiffness * (std::max(0.0, limit - m.distance) +
                       std::max(0.0, std::min(m.distance, limit) - m.predicted) / (1 + ratio));
    Point displacement = slip - dot(slip, m.n) * m.n;
    if (memory != nullptr) {
      const Point friction =
          turned_anchor(vec_cast<double>(memory->friction), vec_cast<double>(memory->n), c.n);
      c.anchor = (1 / c.stiffness) * friction;
      c.load = double{memory->load};
      force = double{memory->normal_force};
      displacement = length(friction) > 0 ? (double{memory->sticking_force} / c.stiffness) *
                                                ((1 / length(friction)) * friction)
                                          : c.anchor;
    }
    const FrictionTangent<double> drag =
        friction_tangent(c.stiffness, c.friction * force, displacement);
    c.drag = drag.stiffness;
    c.drag_limit = drag.limit;
    c.slide = drag.slide;
    const bool bore = own != nullptr ? own->normal_force > 0 : memory != nullptr;
    if (!bore && m.distance >= limit && m.distance - m.predicted < 1.5 * double{a_.fall}) {
      c.push = c.drag = c.drag_limit = 0;
      c.slide = {};
    }
    out = c;
  }

  CollideProximity<T> a_;
};

}  // namespace weft::parity
