#include "host/adaptive/surface_mesh.hpp"

#include <algorithm>
#include <cmath>

#include "host/base/buckets.hpp"
#include "weft/core/at.hpp"

namespace weft {
namespace {

void pair_up(SurfaceMesh& m, Index h, Index g) {
  if (h >= 0) m.twin[at(h)] = g;
  if (g >= 0) m.twin[at(g)] = h;
}

/// Makes a half-edge at the boundary the first, so that stars are found in one go.
void set_leaving(SurfaceMesh& m, Index t) {
  for (Index j = 0; j < 3; ++j) {
    const Index h = 3 * t + j;
    Index& first = m.leaving[at(m.from(h))];
    if (first < 0 || !m.alive(first / 3) || m.from(first) != m.from(h) || m.twin[at(h)] < 0)
      first = h;
  }
}

/// Adds the triangle's share of mass to its corners.
void add_mass(SurfaceMesh& m, Index t, double sign) {
  const double share = sign * m.triangle_mass(t) / 3;
  for (const Index v : m.triangles[at(t)].v) m.mass[at(v)] += share;
}

Index append_triangle(SurfaceMesh& m, Index like) {
  const auto t = static_cast<Index>(m.triangles.size());
  m.triangles.push_back({});
  m.corners.push_back({});
  m.kind.push_back(m.kind[at(like)]);
  m.twin.insert(m.twin.end(), 3, -1);
  m.locked.insert(m.locked.end(), 3, 0);
  return t;
}

Vec3<double> rounded(const Vec3<double>& x, bool single) {
  return single ? vec_cast<double>(vec_cast<float>(x)) : x;
}

Index append_vertex(SurfaceMesh& m, Index a, Index b, bool single) {
  const auto v = static_cast<Index>(m.positions.size());
  const auto mean = [&](const std::vector<Vec3<double>>& values) {
    return 0.5 * (values[at(a)] + values[at(b)]);
  };
  m.positions.push_back(rounded(mean(m.positions), single));
  m.velocities.push_back(mean(m.velocities));
  if (!m.previous_velocities.empty()) m.previous_velocities.push_back(mean(m.previous_velocities));
  m.starts.push_back(mean(m.starts));
  m.mass.push_back(0);
  m.hold.push_back(0);
  m.kept.push_back(0);
  m.heavy.push_back(0);
  m.place.push_back(v);
  m.leaving.push_back(-1);
  m.parents.push_back({a, b});
  return v;
}

Index append_material(SurfaceMesh& m, Index a, Index b) {
  m.material.push_back(0.5 * (m.material[at(a)] + m.material[at(b)]));
  m.metric.push_back(0.5 * (m.metric[at(a)] + m.metric[at(b)]));
  return static_cast<Index>(m.material.size()) - 1;
}

/// Splits the triangle of h: its first half stays, the second is new.
/// @return the new triangle
Index split_side(SurfaceMesh& m, Index h, Index v, Index corner) {
  const Index t = h / 3;
  const Index n = append_triangle(m, t);
  const Index j = h % 3;
  const Index next = (j + 1) % 3;
  const Index far = SurfaceMesh::next(h);
  m.triangles[at(n)] = m.triangles[at(t)];
  m.corners[at(n)] = m.corners[at(t)];
  m.triangles[at(n)].v[j] = v;
  m.corners[at(n)].v[j] = corner;
  m.triangles[at(t)].v[next] = v;
  m.corners[at(t)].v[next] = corner;
  // what was across the far edge is now across the new triangle
  pair_up(m, 3 * n + next, m.twin[at(far)]);
  m.locked[at(3 * n + next)] = m.locked[at(far)];
  m.locked[at(far)] = 0;
  pair_up(m, far, 3 * n + (j + 2) % 3);
  return n;
}

/// Vertices that share an edge with `vertex`.
std::vector<Index> neighbours(const SurfaceMesh& m, const std::vector<Index>& star) {
  std::vector<Index> around;
  for (const Index h : star) {
    around.push_back(m.to(h));
    if (m.twin[at(SurfaceMesh::previous(h))] < 0) around.push_back(m.apex(h));
  }
  std::sort(around.begin(), around.end());
  around.erase(std::unique(around.begin(), around.end()), around.end());
  return around;
}

/// Material corners of `vertex` on the two sides of a border edge.
struct BorderEnd {
  Index vertex;                               ///< at the other end
  std::vector<std::array<Index, 2>> corners;  ///< on each side: at the vertex, at the other end
};

std::vector<BorderEnd> border_ends(const SurfaceMesh& m, const std::vector<Index>& star) {
  std::vector<BorderEnd> ends;
  for (const Index h : star) {
    if (m.is_border(h)) {
      BorderEnd end{m.to(h), {{m.corner_from(h), m.corner_to(h)}}};
      const Index g = m.twin[at(h)];
      if (g >= 0) end.corners.push_back({m.corner_to(g), m.corner_from(g)});
      ends.push_back(std::move(end));
    }
    const Index p = SurfaceMesh::previous(h);
    if (m.twin[at(p)] < 0) ends.push_back({m.from(p), {{m.corner_to(p), m.corner_from(p)}}});
  }
  return ends;
}

/// Whether on every side of a border the corner lies on the straight line between its neighbours.
bool is_straight(const SurfaceMesh& m, const BorderEnd& to, const BorderEnd& other) {
  if (to.corners.size() != other.corners.size()) return false;
  for (const auto& [here, there] : to.corners) {
    bool found = false;
    for (const auto& [own, before] : other.corners) {
      if (own != here) continue;
      const Vec2<double> d = m.material[at(there)] - m.material[at(here)];
      const Vec2<double> e = m.material[at(before)] - m.material[at(here)];
      const double turn = d[0] * e[1] - d[1] * e[0];
      // Midpoints are collinear but for their rounding; a real corner of a pattern is not.
      found = dot(d, e) < 0 && std::abs(turn) <= 1e-11 * length(d) * length(e);
    }
    if (!found) return false;
  }
  return true;
}

/// Whether the pins that hold `a` hold both of its neighbours on the outline too, on a straight
/// line at time 0, so that they hold the same points of the edge without it.
bool keeps_pinned_edge(const SurfaceMesh& m, Index a, Index b, Index before) {
  if (m.hold[at(a)] != m.hold[at(b)] || m.hold[at(a)] != m.hold[at(before)]) return false;
  const Vec3<double> d = m.starts[at(b)] - m.starts[at(a)];
  const Vec3<double> e = m.starts[at(before)] - m.starts[at(a)];
  return dot(d, e) < 0 && length(cross(d, e)) <= 1e-9 * length(d) * length(e);
}

}  // namespace

std::vector<Index> SurfaceMesh::star(Index vertex) const {
  std::vector<Index> result;
  Index first = leaving[at(vertex)];
  if (first < 0) return result;
  // backwards to the boundary, if there is one
  for (Index h = first; twin[at(h)] >= 0;) {
    h = next(twin[at(h)]);
    if (h == leaving[at(vertex)]) {
      first = h;
      break;
    }
    first = h;
  }
  for (Index h = first; h >= 0;) {
    result.push_back(h);
    h = twin[at(previous(h))];
    if (h == first) break;
  }
  return result;
}

bool SurfaceMesh::is_border(Index h) const {
  const Index g = twin[at(h)];
  return g < 0 || kind[tri(h)] != kind[tri(g)] || corner_from(h) != corner_to(g) ||
         corner_to(h) != corner_from(g);
}

double SurfaceMesh::material_det(const Tri& c) const {
  const Vec2<double> a = material[at(c.v[1])] - material[at(c.v[0])];
  const Vec2<double> b = material[at(c.v[2])] - material[at(c.v[0])];
  return a[0] * b[1] - a[1] * b[0];
}

double SurfaceMesh::triangle_mass(Index t) const {
  return kinds[at(kind[at(t)])].density * material_det(corners[at(t)]) / 2;
}

double SurfaceMesh::total_mass() const {
  double sum = 0;
  for (std::size_t t = 0; t < triangles.size(); ++t)
    if (kind[t] >= 0) sum += triangle_mass(static_cast<Index>(t));
  return sum;
}

Vec3<double> SurfaceMesh::momentum() const {
  Vec3<double> sum{0, 0, 0};
  for (std::size_t v = 0; v < positions.size(); ++v)
    if (leaving[v] >= 0) sum += mass[v] * velocities[v];
  return sum;
}

void connect(SurfaceMesh& m) {
  const auto count = static_cast<Index>(3 * m.triangles.size());
  m.twin.assign(at(count), -1);
  m.locked.resize(at(count), 0);
  m.leaving.assign(m.positions.size(), -1);
  // Half-edges by their lower vertex, and of each by the upper one: two of one edge are neighbours.
  const auto vertex_count = static_cast<Index>(m.positions.size());
  Buckets sides = buckets_by(count, vertex_count, [&](Index h) {
    return m.alive(h / 3) ? std::min(m.from(h), m.to(h)) : -1;
  });
  const auto high = [&](Index h) { return std::max(m.from(h), m.to(h)); };
  for (Index v = 0; v < vertex_count; ++v) {
    Index* const end = sides.end(v);
    std::sort(sides.begin(v), end,
              [&](Index g, Index h) { return high(g) != high(h) ? high(g) < high(h) : g < h; });
    for (const Index* h = sides.begin(v); h != end && h + 1 != end; ++h)
      if (high(h[0]) == high(h[1])) pair_up(m, h[0], h[1]);
  }
  m.mass.assign(m.positions.size(), 0);
  std::vector<Index> fans(m.positions.size(), 0);
  for (Index t = 0; t < count / 3; ++t) {
    if (!m.alive(t)) continue;
    set_leaving(m, t);
    add_mass(m, t, 1);
    for (const Index v : m.triangles[at(t)].v) ++fans[at(v)];
  }
  for (std::size_t v = 0; v < m.positions.size(); ++v)
    if (m.leaving[v] >= 0 &&
        m.star(static_cast<Index>(v)).size() != static_cast<std::size_t>(fans[v]))
      m.kept[v] = always_kept;
}

Index split_edge(SurfaceMesh& m, Index h, bool single, std::vector<Index>& touched) {
  const Index g = m.twin[at(h)];
  const bool border = m.is_border(h);
  const Index a = m.from(h);
  const Index b = m.to(h);
  const Index v = append_vertex(m, a, b, single);
  add_mass(m, h / 3, -1);
  if (g >= 0) add_mass(m, g / 3, -1);
  const Index corner = append_material(m, m.corner_from(h), m.corner_to(h));
  Index other = corner;
  if (g >= 0 && border &&
      (m.corner_from(h) != m.corner_to(g) || m.corner_to(h) != m.corner_from(g)))
    other = append_material(m, m.corner_from(g), m.corner_to(g));
  const Index n = split_side(m, h, v, corner);
  touched = {h / 3, n};
  if (g >= 0) {
    const Index o = split_side(m, g, v, other);
    touched.push_back(g / 3);
    touched.push_back(o);
    pair_up(m, h, 3 * o + g % 3);
    pair_up(m, g, 3 * n + h % 3);
  } else {
    m.twin[at(3 * n + h % 3)] = -1;
  }
  for (const Index t : touched) {
    add_mass(m, t, 1);
    set_leaving(m, t);
  }
  return v;
}

void undo_split(SurfaceMesh& m, Index h, Index vertex, const std::vector<Index>& touched) {
  const Index g = touched.size() > 2
                      ? 3 * touched[2] + (m.triangles[at(touched[2])].v[0] == vertex   ? 2
                                          : m.triangles[at(touched[2])].v[1] == vertex ? 0
                                                                                       : 1)
                      : -1;
  for (const Index t : touched) add_mass(m, t, -1);
  const auto join = [&](Index half, Index n) {
    const Index t = half / 3;
    const Index next = (half + 1) % 3 == 0 ? 0 : half % 3 + 1;
    m.triangles[at(t)].v[next] = m.triangles[at(n)].v[next];
    m.corners[at(t)].v[next] = m.corners[at(n)].v[next];
    pair_up(m, 3 * t + next, m.twin[at(3 * n + next)]);
    if (m.twin[at(3 * n + next)] < 0) m.twin[at(3 * t + next)] = -1;
    m.locked[at(3 * t + next)] = m.locked[at(3 * n + next)];
    m.kind[at(n)] = -1;
  };
  join(h, touched[1]);
  if (g >= 0) join(g, touched[3]);
  if (g >= 0)
    pair_up(m, h, g);
  else
    m.twin[at(h)] = -1;
  m.leaving[at(vertex)] = -1;
  for (std::size_t k = 0; k < touched.size(); k += 2) {
    add_mass(m, touched[k], 1);
    set_leaving(m, touched[k]);
  }
}

void flip_edge(SurfaceMesh& m, Index h) {
  const Index g = m.twin[at(h)];
  const Index t = h / 3;
  const Index s = g / 3;
  // Around the two triangles: a, d, b, c.
  const Index a = m.from(h), b = m.to(h), c = m.apex(h), d = m.apex(g);
  const Index ua = m.corner_from(h), ub = m.corner_to(h);
  const Index uc = m.corners[at(t)].v[(h + 2) % 3], ud = m.corners[at(s)].v[(g + 2) % 3];
  const Index bc = m.twin[at(SurfaceMesh::next(h))], ca = m.twin[at(SurfaceMesh::previous(h))];
  const Index ad = m.twin[at(SurfaceMesh::next(g))], db = m.twin[at(SurfaceMesh::previous(g))];
  const unsigned char lock_bc = m.locked[at(SurfaceMesh::next(h))];
  const unsigned char lock_ca = m.locked[at(SurfaceMesh::previous(h))];
  const unsigned char lock_ad = m.locked[at(SurfaceMesh::next(g))];
  const unsigned char lock_db = m.locked[at(SurfaceMesh::previous(g))];
  add_mass(m, t, -1);
  add_mass(m, s, -1);
  m.triangles[at(t)] = {{a, d, c}};
  m.corners[at(t)] = {{ua, ud, uc}};
  m.triangles[at(s)] = {{d, b, c}};
  m.corners[at(s)] = {{ud, ub, uc}};
  const auto attach = [&](Index half, Index across, unsigned char lock) {
    m.twin[at(half)] = across;
    if (across >= 0) m.twin[at(across)] = half;
    m.locked[at(half)] = lock;
  };
  attach(3 * t, ad, lock_ad);
  attach(3 * t + 1, 3 * s + 2, 0);
  attach(3 * t + 2, ca, lock_ca);
  attach(3 * s, db, lock_db);
  attach(3 * s + 1, bc, lock_bc);
  m.locked[at(3 * s + 2)] = 0;
  for (const Index x : {t, s}) add_mass(m, x, 1);
  // Half-edges have moved, so whoever left by one of these must be told.
  for (const Index v : {a, b, c, d}) m.leaving[at(v)] = -1;
  for (const Index x : {t, s}) set_leaving(m, x);
}

bool plan_collapse(const SurfaceMesh& m, Index h, CollapseResult& result) {
  const Index a = m.from(h);
  const Index b = m.to(h);
  if (m.kept[at(a)] == always_kept || m.locked[at(h)] != 0) return false;
  // A held vertex may only go where the same pins hold, and along their edge.
  if (m.hold[at(a)] != 0 && m.hold[at(a)] != m.hold[at(b)]) return false;
  const std::vector<Index> star = m.star(a);
  const std::vector<BorderEnd> ends = border_ends(m, star);
  if (!ends.empty()) {
    if (ends.size() != 2) return false;
    const std::size_t towards = ends[0].vertex == b ? 0 : 1;
    if (ends[towards].vertex != b || ends[0].vertex == ends[1].vertex) return false;
    if (!is_straight(m, ends[towards], ends[1 - towards])) return false;
    if (m.kept[at(a)] == kept_as_corner && !keeps_pinned_edge(m, a, b, ends[1 - towards].vertex))
      return false;
  } else if (m.kept[at(a)] == kept_as_corner) {
    return false;
  }
  const Index g = m.twin[at(h)];
  const Index c = m.apex(h);
  const Index d = g >= 0 ? m.apex(g) : -1;
  const std::vector<Index> around_a = neighbours(m, star);
  const std::vector<Index> around_b = neighbours(m, m.star(b));
  std::vector<Index> common;
  std::set_intersection(around_a.begin(), around_a.end(), around_b.begin(), around_b.end(),
                        std::back_inserter(common));
  if (common.size() != (g >= 0 ? 2u : 1u) || c == d) return false;
  // Who loses a triangle must keep a fan of two or, inside, of three.
  for (const Index v : {c, d}) {
    if (v < 0) continue;
    const std::vector<Index> fan = m.star(v);
    const bool inside = neighbours(m, fan).size() == fan.size();
    if (fan.size() < (inside ? 4u : 2u)) return false;
  }
  result = {};
  result.gone.push_back(h / 3);
  if (g >= 0) result.gone.push_back(g / 3);
  std::vector<std::array<Index, 2>> moved{{m.corner_from(h), m.corner_to(h)}};
  if (g >= 0) moved.push_back({m.corner_to(g), m.corner_from(g)});
  for (const Index s : star) {
    const Index t = s / 3;
    if (std::find(result.gone.begin(), result.gone.end(), t) != result.gone.end()) continue;
    Tri tri = m.triangles[at(t)];
    Tri corner = m.corners[at(t)];
    const Index own = corner.v[s % 3];
    const auto target =
        std::find_if(moved.begin(), moved.end(), [&](const auto& p) { return p[0] == own; });
    if (target == moved.end()) return false;
    tri.v[s % 3] = b;
    corner.v[s % 3] = (*target)[1];
    result.changed.push_back(t);
    result.triangles.push_back(tri);
    result.corners.push_back(corner);
  }
  return !result.changed.empty();
}

void collapse_edge(SurfaceMesh& m, Index h, const CollapseResult& plan) {
  const Index a = m.from(h);
  std::vector<Index> corners_of;  // whose leaving half-edge may be gone
  for (const Index t : plan.gone) {
    add_mass(m, t, -1);
    for (const Index v : m.triangles[at(t)].v) corners_of.push_back(v);
  }
  for (const Index t : plan.changed) add_mass(m, t, -1);
  const Index sides[2] = {h, m.twin[at(h)]};
  for (const Index side : sides) {
    if (side < 0) continue;
    const Index out = SurfaceMesh::next(side);
    const Index in = SurfaceMesh::previous(side);
    const Index p = m.twin[at(out)];
    const Index q = m.twin[at(in)];
    const unsigned char lock = m.locked[at(out)] | m.locked[at(in)];
    if (p >= 0) m.locked[at(p)] |= lock;
    if (q >= 0) m.locked[at(q)] |= lock;
    if (p >= 0) m.twin[at(p)] = q;
    if (q >= 0) m.twin[at(q)] = p;
  }
  for (const Index t : plan.gone) m.kind[at(t)] = -1;
  for (std::size_t k = 0; k < plan.changed.size(); ++k) {
    m.triangles[at(plan.changed[k])] = plan.triangles[k];
    m.corners[at(plan.changed[k])] = plan.corners[k];
  }
  m.leaving[at(a)] = -1;
  for (const Index t : plan.changed) add_mass(m, t, 1);
  // Find the fan around each vertex that lost a triangle again.
  for (const Index v : corners_of)
    if (v != a) m.leaving[at(v)] = -1;
  for (const Index t : plan.changed) set_leaving(m, t);
  for (const Index t : plan.gone)
    for (Index j = 0; j < 3; ++j) {
      const Index g = m.twin[at(3 * t + j)];
      if (g >= 0 && m.alive(g / 3)) set_leaving(m, g / 3);
    }
}

}  // namespace weft
