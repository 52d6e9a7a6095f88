#include "host/meshing/constrained_delaunay.hpp"

#include <cstddef>
#include <deque>

#include "weft/core/at.hpp"

namespace weft {
namespace {

constexpr int after(int k) {
  return (k + 1) % 3;
}
constexpr int before(int k) {
  return (k + 2) % 3;
}

}  // namespace

ConstrainedDelaunay::ConstrainedDelaunay()
    : points_{{-grid_limit, -grid_limit}, {grid_limit, -grid_limit}, {0, grid_limit}},
      faces_{Face{{0, 1, 2}}},
      face_of_{0, 0, 0} {}

int ConstrainedDelaunay::corner_of(Index f, Index vertex) const {
  const Face& t = face(f);
  return t.v[0] == vertex ? 0 : t.v[1] == vertex ? 1 : 2;
}

int ConstrainedDelaunay::side_towards(Index f, Index neighbour) const {
  const Face& t = face(f);
  return t.next[0] == neighbour ? 0 : t.next[1] == neighbour ? 1 : 2;
}

/// Lets a face and its neighbour know each other.
/// @param before the face that the neighbour knew in this place
void ConstrainedDelaunay::link(Index f, int side, Index neighbour, Index before) {
  face(f).next[at(side)] = neighbour;
  if (neighbour >= 0) face(neighbour).next[at(side_towards(neighbour, before))] = f;
}

/// Replaces the edge between two faces by the other diagonal. The face keeps its corner opposite
/// the edge, which becomes its first; so does the neighbour get it as its first.
void ConstrainedDelaunay::flip(Index f, int side) {
  const Face t = face(f);
  const Index g = t.next[at(side)];
  const Face u = face(g);
  const int m = side_towards(g, f);
  const Index a = t.v[at(side)], b = t.v[at(after(side))], c = t.v[at(before(side))];
  const Index d = u.v[at(m)];
  face(f).v = {a, b, d};
  face(g).v = {a, d, c};
  face(f).fixed = {u.fixed[at(after(m))], false, t.fixed[at(before(side))]};
  face(g).fixed = {u.fixed[at(before(m))], t.fixed[at(after(side))], false};
  face(f).next = {-1, g, t.next[at(before(side))]};
  face(g).next = {u.next[at(before(m))], -1, f};
  link(f, 0, u.next[at(after(m))], g);
  link(g, 1, t.next[at(after(side))], f);
  face_of_[at(a)] = face_of_[at(b)] = face_of_[at(d)] = f;
  face_of_[at(c)] = g;
}

/// Three faces around a new vertex, which is the first corner of each.
void ConstrainedDelaunay::split(Index f, Index p) {
  const Face t = face(f);
  const auto f1 = static_cast<Index>(faces_.size());
  const Index f2 = f1 + 1;
  faces_.push_back({{p, t.v[2], t.v[0]}, {-1, f2, f}, {t.fixed[1], false, false}, t.inside});
  faces_.push_back({{p, t.v[0], t.v[1]}, {-1, f, f1}, {t.fixed[2], false, false}, t.inside});
  face(f) = {{p, t.v[1], t.v[2]}, {t.next[0], f1, f2}, {t.fixed[0], false, false}, t.inside};
  link(f1, 0, t.next[1], f);
  link(f2, 0, t.next[2], f);
  face_of_[at(p)] = face_of_[at(t.v[1])] = face_of_[at(t.v[2])] = f;
  face_of_[at(t.v[0])] = f1;
}

/// Flips the sides opposite a new vertex until all of them are Delaunay.
/// @param around faces whose first corner is the vertex
void ConstrainedDelaunay::legalize(Index vertex, std::vector<Index>& around) {
  while (!around.empty()) {
    const Index f = around.back();
    around.pop_back();
    const int side = corner_of(f, vertex);
    const Face& t = face(f);
    const Index g = t.next[at(side)];
    if (g < 0 || t.fixed[at(side)]) continue;
    const Index opposite = face(g).v[at(side_towards(g, f))];
    const GridPoint &a = point(t.v[0]), &b = point(t.v[1]), &c = point(t.v[2]);
    // A vertex on an edge makes a face without area, whose edge has to go.
    const bool flat = orientation(a, b, c) == 0;
    if (!flat && !in_circle(a, b, c, point(opposite))) continue;
    flip(f, side);
    around.push_back(f);
    around.push_back(g);
  }
}

/// Walks from face to face towards a point. In a Delaunay triangulation such a walk visits no face
/// twice. With constrained edges it may go round in circles: then all faces are searched.
std::optional<Index> ConstrainedDelaunay::find(const GridPoint& p) const {
  const auto beyond = [&](Index f) {
    const Face& t = face(f);
    for (int k = 0; k < 3; ++k)
      if (orientation(point(t.v[at(after(k))]), point(t.v[at(before(k))]), p) < 0) return k;
    return -1;
  };
  Index f = last_;
  for (std::size_t steps = 0; steps < faces_.size(); ++steps) {
    const int k = beyond(f);
    if (k < 0) return f;
    if (face(f).next[at(k)] < 0) return std::nullopt;
    f = face(f).next[at(k)];
  }
  for (std::size_t i = 0; i < faces_.size(); ++i)
    if (beyond(static_cast<Index>(i)) < 0) return static_cast<Index>(i);
  return std::nullopt;
}

Index ConstrainedDelaunay::insert(const GridPoint& p) {
  const std::optional<Index> found = find(p);
  if (!found || !face(*found).inside) return -1;
  const Face& t = face(*found);
  for (const Index v : t.v)
    if (point(v) == p) return v;
  for (int k = 0; k < 3; ++k)
    if (t.fixed[at(k)] && orientation(point(t.v[at(after(k))]), point(t.v[at(before(k))]), p) == 0)
      return -1;
  const auto vertex = static_cast<Index>(points_.size());
  points_.push_back(p);
  face_of_.push_back(*found);
  last_ = *found;
  split(*found, vertex);
  // The face without area comes first, if there is one: the others see its far side only then.
  std::vector<Index> around = faces_around(vertex);
  for (std::size_t k = 0; k + 1 < around.size(); ++k) {
    const Face& s = face(around[k]);
    if (orientation(point(s.v[0]), point(s.v[1]), point(s.v[2])) == 0)
      std::swap(around[k], around.back());
  }
  legalize(vertex, around);
  return vertex;
}

std::vector<Index> ConstrainedDelaunay::faces_around(Index vertex) const {
  std::vector<Index> around;
  const Index first = face_of_[at(vertex)];
  Index f = first;
  do {
    around.push_back(f);
    f = face(f).next[at(after(corner_of(f, vertex)))];
  } while (f != first && f >= 0 && around.size() <= faces_.size());
  return around;
}

std::optional<std::array<Index, 2>> ConstrainedDelaunay::side_of(Index a, Index b) const {
  for (const Index f : faces_around(a)) {
    const int k = corner_of(f, a);
    if (face(f).v[at(after(k))] == b) return std::array<Index, 2>{f, before(k)};
  }
  return std::nullopt;
}

/// Edges that the line from a to b crosses, in order, each with its right end first.
std::optional<std::vector<std::array<Index, 2>>> ConstrainedDelaunay::crossed(Index a,
                                                                              Index b) const {
  const GridPoint &from = point(a), &to = point(b);
  Index f = -1;
  int side = 0;
  for (const Index g : faces_around(a)) {
    const int k = corner_of(g, a);
    const std::int64_t right = orientation(from, to, point(face(g).v[at(after(k))]));
    const std::int64_t left = orientation(from, to, point(face(g).v[at(before(k))]));
    if (right < 0 && left > 0) {
      f = g;
      side = k;
      break;
    }
  }
  if (f < 0) return std::nullopt;
  std::vector<std::array<Index, 2>> edges;
  for (std::size_t steps = 0; steps < faces_.size(); ++steps) {
    const Face& t = face(f);
    if (t.fixed[at(side)]) return std::nullopt;
    const Index right = t.v[at(after(side))], left = t.v[at(before(side))];
    edges.push_back({right, left});
    const Index g = t.next[at(side)];
    const int m = side_towards(g, f);
    const Index opposite = face(g).v[at(m)];
    if (opposite == b) return edges;
    const std::int64_t turn = orientation(from, to, point(opposite));
    if (turn == 0) return std::nullopt;
    f = g;
    // On through the side between the opposite corner and the end on the line's other side.
    side = corner_of(g, turn > 0 ? left : right);
  }
  return std::nullopt;
}

bool ConstrainedDelaunay::fix_edge(Index a, Index b) {
  if (!side_of(a, b)) {
    auto edges = crossed(a, b);
    if (!edges) return false;
    std::deque<std::array<Index, 2>> waiting(edges->begin(), edges->end());
    // Sloan: each edge waits only for flips of others, so that n of them take fewer than n^2.
    std::size_t left = waiting.size() * waiting.size() + 16;
    while (!waiting.empty() && left-- > 0) {
      const auto [u, w] = waiting.front();
      waiting.pop_front();
      const auto place = side_of(u, w);
      if (!place) continue;
      const Index f = (*place)[0];
      const int side = (*place)[1];
      const Index g = face(f).next[at(side)];
      const Index p = face(f).v[at(side)], q = face(g).v[at(side_towards(g, f))];
      const bool convex = orientation(point(p), point(u), point(q)) > 0 &&
                          orientation(point(q), point(w), point(p)) > 0;
      if (!convex) {
        waiting.push_back({u, w});
        continue;
      }
      flip(f, side);
      const std::int64_t side_p = orientation(point(a), point(b), point(p));
      const std::int64_t side_q = orientation(point(a), point(b), point(q));
      if (p != a && p != b && q != a && q != b && (side_p < 0) != (side_q < 0))
        waiting.push_back(side_p < 0 ? std::array<Index, 2>{p, q} : std::array<Index, 2>{q, p});
    }
  }
  const auto place = side_of(a, b);
  if (!place) return false;
  const Index f = (*place)[0], g = face(f).next[at((*place)[1])];
  face(f).fixed[at((*place)[1])] = true;
  face(g).fixed[at(side_towards(g, f))] = true;
  return true;
}

void ConstrainedDelaunay::remove_outside() {
  std::vector<Index> waiting{face_of_[0]};
  face(face_of_[0]).inside = false;
  while (!waiting.empty()) {
    const Index f = waiting.back();
    waiting.pop_back();
    for (int k = 0; k < 3; ++k) {
      const Index g = face(f).next[at(k)];
      if (g < 0 || face(f).fixed[at(k)] || !face(g).inside) continue;
      face(g).inside = false;
      waiting.push_back(g);
    }
  }
  bounded_ = true;
}

void ConstrainedDelaunay::restore_delaunay() {
  std::vector<Index> waiting;
  for (std::size_t f = 0; f < faces_.size(); ++f)
    if (!bounded_ || faces_[f].inside) waiting.push_back(static_cast<Index>(f));
  while (!waiting.empty()) {
    const Index f = waiting.back();
    waiting.pop_back();
    for (int k = 0; k < 3; ++k) {
      const Face& t = face(f);
      const Index g = t.next[at(k)];
      if (g < 0 || t.fixed[at(k)]) continue;
      const Index opposite = face(g).v[at(side_towards(g, f))];
      if (!in_circle(point(t.v[0]), point(t.v[1]), point(t.v[2]), point(opposite))) continue;
      flip(f, k);
      waiting.push_back(f);
      waiting.push_back(g);
      break;
    }
  }
}

bool ConstrainedDelaunay::move(Index vertex, const GridPoint& to) {
  const GridPoint from = point(vertex);
  points_[at(vertex)] = to;
  for (const Index f : faces_around(vertex)) {
    const Face& t = face(f);
    if (orientation(point(t.v[0]), point(t.v[1]), point(t.v[2])) > 0) continue;
    points_[at(vertex)] = from;
    return false;
  }
  return true;
}

}  // namespace weft
