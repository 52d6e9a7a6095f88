#include "host/model/plate_patch.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "host/base/buckets.hpp"
#include "host/base/parallel.hpp"
#include "weft/core/assert.hpp"
#include "weft/core/at.hpp"

namespace weft {
namespace {

using Point = PlatePatches::Point;

/// Norm of the inverse up to which three points around a triangle are taken as they come; those of
/// an equilateral mesh have 1.2. Barycentric coordinates: sizes and angles do not count.
constexpr double badness_max = 6;
/// Bulges that would have to be so many times as large as what asks for them are left out: what
/// lies nearly on a conic through the corners says nothing of a quadratic, but rounding would. So
/// would the sagitta of a circle: along the hem of a coarse disc all points lie on one, and
/// energies there go with the square of this. With 60 they changed by a fifth of a run's kinetic
/// energy where a triangle took its points from elsewhere.
constexpr double badness_worst = 10;

double cross_of(const Point& a, const Point& b) {
  return a.x() * b.y() - a.y() * b.x();
}

/// Gradients of the barycentric coordinates of a triangle. [1/m]
std::array<Point, 3> gradients_of(const std::array<Point, 3>& corner) {
  const double twice = cross_of(corner[1] - corner[0], corner[2] - corner[0]);
  std::array<Point, 3> gradient;
  for (std::size_t i = 0; i < 3; ++i) {
    const Point e = corner[(i + 2) % 3] - corner[(i + 1) % 3];
    gradient[i] = Point(-e.y(), e.x()) / twice;
  }
  return gradient;
}

/// Barycentric coordinates of a point in the plane of a triangle.
Eigen::Vector3d barycentric(const std::array<Point, 3>& corner, const Point& p) {
  const double twice = cross_of(corner[1] - corner[0], corner[2] - corner[0]);
  const double a = cross_of(corner[1] - p, corner[2] - p) / twice;
  const double b = cross_of(corner[2] - p, corner[0] - p) / twice;
  return {a, b, 1 - a - b};
}

/// Ends of the edge opposite a corner before seams were welded, in order.
std::array<Index, 2> source_edge(const PlateTriangle& t, int edge) {
  const Index* v = t.source.v[0] < 0 ? t.v.v : t.source.v;
  const Index a = v[(edge + 1) % 3], b = v[(edge + 2) % 3];
  return {std::min(a, b), std::max(a, b)};
}

}  // namespace

std::size_t Bulges::place(Index v) {
  for (std::size_t i = 0; i < vertices.size(); ++i)
    if (vertices[i] == v) return i;
  for (Weights& weights : bulge) weights[vertices.size()] = 0;
  vertices.push_back(v);
  return vertices.size() - 1;
}

PlatePatches::PlatePatches(const std::vector<PlateTriangle>& triangles)
    : triangles_(triangles), neighbour_(triangles.size(), {-1, -1, -1}) {
  find_neighbours();
}

void PlatePatches::find_neighbours() {
  const unsigned threads = setup_threads(triangles_.size());
  const auto corner = [&](Index side, Index k) { return triangles_[at(side / 3)].v.v[k % 3]; };
  const auto low = [&](Index s) { return std::min(corner(s, s % 3 + 1), corner(s, s % 3 + 2)); };
  const auto high = [&](Index s) { return std::max(corner(s, s % 3 + 1), corner(s, s % 3 + 2)); };
  Index vertex_count = 0;
  for (const PlateTriangle& t : triangles_)
    vertex_count = std::max({vertex_count, t.v.v[0] + 1, t.v.v[1] + 1, t.v.v[2] + 1});
  // Side 3 t + k is edge k of triangle t.
  Buckets sides = buckets_by(3 * size(), vertex_count, low);
  for_each_index(threads, at(vertex_count), [&](std::size_t vertex) {
    Index* const begin = sides.begin(static_cast<Index>(vertex));
    Index* const last = sides.end(static_cast<Index>(vertex));
    std::sort(begin, last,
              [&](Index a, Index b) { return high(a) != high(b) ? high(a) < high(b) : a < b; });
    for (const Index* s = begin; s != last;) {
      const Index* end = s + 1;
      while (end != last && high(*end) == high(*s)) ++end;
      for (const Index* i = s; i != end; ++i)
        for (const Index* j = i + 1; j != end; ++j) join(*i, *j, end - s == 2);
      s = end;
    }
  });
}

/// Only two triangles that run along an edge in opposite directions are neighbours: those of one
/// piece, or else the only two that there are.
/// @param s         side: three times the triangle, and its edge   @param r another of the same
/// edge
/// @param only_ones whether no others are there
void PlatePatches::join(Index s, Index r, bool only_ones) {
  const auto forward = [&](Index side) {
    const Index* v = triangle(side / 3).v.v;
    return v[(side + 1) % 3] < v[(side + 2) % 3];
  };
  const auto source = [&](Index side) { return source_edge(triangle(side / 3), side % 3); };
  if (forward(s) == forward(r) || (!only_ones && source(s) != source(r))) return;
  neighbour_[at(s / 3)][at(s % 3)] = r / 3;
  neighbour_[at(r / 3)][at(r % 3)] = s / 3;
}

bool PlatePatches::same_piece(Index t, int edge) const {
  return source_edge(triangle(t), edge) ==
         source_edge(triangle(neighbour(t, edge)), edge_back(t, edge));
}

int PlatePatches::edge_back(Index t, int k) const {
  const Index other = neighbour(t, k);
  int back = 0;
  while (neighbour(other, back) != t ||
         triangle(other).v.v[(back + 1) % 3] != triangle(t).v.v[(k + 2) % 3])
    ++back;
  return back;
}

/// The neighbour of `from` across its edge k, unfolded into the same plane.
PlatePatches::Placed PlatePatches::unfolded(const Placed& from, int k) const {
  const Index next = neighbour(from.triangle, k);
  const Index* v = triangle(next).v.v;
  const Index end = triangle(from.triangle).v.v[(k + 1) % 3];
  // Corner `e` of the neighbour is the end of the edge where it begins for `from`.
  const int e = v[0] == end ? 0 : v[1] == end ? 1 : 2;
  const int b = (e + 2) % 3;
  const Point& head = from.corner[static_cast<std::size_t>((k + 1) % 3)];
  const Point& tail = from.corner[static_cast<std::size_t>((k + 2) % 3)];
  const Point there = (head - tail).normalized();
  const Point here = (rest(next, e) - rest(next, b)).normalized();
  Eigen::Matrix2d turn;
  const double c = here.dot(there);
  const double s = cross_of(here, there);
  turn << c, -s, s, c;
  const Point middle = (head + tail) / 2;
  const Point own_middle = (rest(next, e) + rest(next, b)) / 2;
  Placed placed{next,
                {},
                from.depth + 1,
                from.own && triangle(next).shape != nullptr && same_piece(from.triangle, k)};
  for (int i = 0; i < 3; ++i)
    placed.corner[static_cast<std::size_t>(i)] = middle + turn * (rest(next, i) - own_middle);
  return placed;
}

/// Vertices around a triangle, nearest triangles first. The way to them leads through no held
/// triangle: a clamp's far side bends otherwise.
/// @param depth how many triangles away they may lie
PlatePatches::NearPoints PlatePatches::points_around(Index t, int depth) const {
  const Tri& own = triangle(t).v;
  ShortList<Placed, around_max + 1> placed;
  placed.push_back({t, {rest(t, 0), rest(t, 1), rest(t, 2)}, 0, true});
  NearPoints points;
  const auto known = [&](Index v) {
    return v == own.v[0] || v == own.v[1] || v == own.v[2] ||
           std::any_of(points.begin(), points.end(),
                       [&](const NearPoint& p) { return p.vertex == v; });
  };
  for (std::size_t n = 0; n < placed.size() && placed[n].depth < depth; ++n)
    for (int k = 0; k < 3; ++k) {
      const Index next = neighbour(placed[n].triangle, k);
      if (next < 0 || triangle(next).held ||
          std::any_of(placed.begin(), placed.end(),
                      [&](const Placed& p) { return p.triangle == next; }))
        continue;
      placed.push_back(unfolded(placed[n], k));
      for (std::size_t c = 0; c < 3; ++c) {
        const Index v = triangle(next).v.v[c];
        if (!known(v))
          points.push_back({v, barycentric(placed[0].corner, placed.back().corner[c]),
                            placed.back().depth, next, static_cast<int>(c), placed.back().own});
      }
    }
  return points;
}

/// A point asks for products of its barycentric coordinates; a slope, in units of half the inverse
/// height over the edge, for those of a point opposite corner k.
PlatePatches::Products PlatePatches::products(const Conditions& conditions) {
  Products m(static_cast<Eigen::Index>(conditions.clamped.size() + conditions.points.size()), 3);
  Eigen::Index row = 0;
  for (const int k : conditions.clamped) {
    m.row(row).setConstant(-1);
    m(row++, k) = 1;
  }
  for (const NearPoint& p : conditions.points) {
    const Eigen::Vector3d& l = p.place;
    m.row(row++) << l[1] * l[2], l[2] * l[0], l[0] * l[1];
  }
  return m;
}

double PlatePatches::badness(const Conditions& conditions) {
  if (conditions.clamped.size() + conditions.points.size() < 3)
    return std::numeric_limits<double>::infinity();
  const Eigen::Matrix3d m = products(conditions);
  const double determinant = m.determinant();
  if (!(std::abs(determinant) > 1e-9)) return std::numeric_limits<double>::infinity();
  const double norm = m.inverse().norm();
  return norm <= badness_worst ? norm : std::numeric_limits<double>::infinity();
}

/// The three conditions that serve a triangle's quadratic; fewer if there are not as many.
/// @param near set to whether only neighbours have been looked at
PlatePatches::Conditions PlatePatches::choose(Index t, bool& near) const {
  Conditions chosen;
  for (int k = 0; k < 3; ++k)
    if (const Index other = neighbour(t, k); other >= 0 && triangle(other).held)
      chosen.clamped.push_back(k);
  const std::size_t wanted = 3 - chosen.clamped.size();
  // Most triangles need no more than the corners of their neighbours.
  for (const NearPoint& p : points_around(t, 1))
    if (chosen.points.size() < wanted) chosen.points.push_back(p);
  double best = badness(chosen);
  near = best <= badness_max;
  if (near) return chosen;
  const NearPoints around = points_around(t, search_depth);
  const auto take = [&](std::size_t count) {
    chosen.points.clear();
    for (std::size_t i = 0; i < count; ++i) chosen.points.push_back(around[i]);
  };
  if (around.size() <= wanted) {
    take(around.size());
    return chosen;
  }
  // Points beside the neighbours' corners, or in their place where those lie badly.
  const std::size_t keep = chosen.points.size() < wanted ? chosen.points.size() : 0;
  for (int depth = 2; depth <= search_depth && best > badness_max; ++depth) {
    NearPoints pool;
    for (const NearPoint& p : around)
      if (p.depth <= depth) pool.push_back(p);
    Conditions trial{chosen.clamped, {}};
    for (std::size_t i = 0; i < keep; ++i) trial.points.push_back(pool[i]);
    try_points(pool, keep, trial, best, chosen);
  }
  if (chosen.points.size() < wanted) take(wanted);
  return chosen;
}

void PlatePatches::try_points(const NearPoints& pool, std::size_t next, Conditions& trial,
                              double& best, Conditions& chosen) {
  if (trial.clamped.size() + trial.points.size() == 3) {
    const double bad = badness(trial);
    if (bad < best) {
      best = bad;
      chosen = trial;
    }
    return;
  }
  for (std::size_t i = next; i < pool.size(); ++i) {
    trial.points.push_back(pool[i]);
    try_points(pool, i + 1, trial, best, chosen);
    trial.points.pop_back();
  }
}

/// Adds what the held neighbour across edge k asks of the bulges of t, see products().
void PlatePatches::add_clamp(Index t, int k, const Fit& fit, Eigen::Index column,
                             Quadratic& q) const {
  const Placed held = unfolded({t, {rest(t, 0), rest(t, 1), rest(t, 2)}, 0, true}, k);
  const std::array<Point, 3> gradient = gradients_of(held.corner);
  // Outwards, of length 1 over the height.
  const Point out = -q.gradient[k];
  const double scale = 2 / out.squaredNorm();
  Quadratic value;  // the first of its bulges alone counts
  for (int i = 0; i < 3; ++i) {
    value.bulge[0][value.place(triangle(held.triangle).v.v[i])] +=
        scale * out.dot(gradient[static_cast<std::size_t>(i)]);
    value.bulge[0][value.place(triangle(t).v.v[i])] -= scale * out.dot(q.gradient[i]);
  }
  for (std::size_t n = 0; n < value.vertices.size(); ++n) {
    const std::size_t place = q.place(value.vertices[n]);
    for (int i = 0; i < 3; ++i) q.bulge[i][place] += fit(i, column) * value.bulge[0][n];
  }
}

PlatePatches::Fit PlatePatches::fit_of(const Products& m) {
  if (m.rows() == 3) {
    const Eigen::Matrix3d square = m;
    const Eigen::Matrix3d inverse = square.inverse();
    if (inverse.norm() <= badness_worst) return inverse;
  }
  const Eigen::JacobiSVD<Eigen::MatrixXd> svd(m, Eigen::ComputeThinU | Eigen::ComputeThinV);
  Eigen::VectorXd inverse = svd.singularValues();
  for (double& value : inverse) value = value * badness_worst >= 1 ? 1 / value : 0;
  return svd.matrixV() * inverse.asDiagonal() * svd.matrixU().transpose();
}

/// Where the rest shape of a triangle has a vertex that its quadratic reads. [m]
Vec3<double> PlatePatches::shape_point(Index t, const Conditions& conditions, Index v) const {
  const PlateTriangle& own = triangle(t);
  const std::array<Vec3<double>, 3>& shape = *own.shape;
  const auto in_plane = [&](const Eigen::Vector3d& place) {
    return place[0] * shape[0] + place[1] * shape[1] + place[2] * shape[2];
  };
  for (std::size_t c = 0; c < 3; ++c)
    if (own.v.v[c] == v) return shape[c];
  for (const NearPoint& p : conditions.points)
    if (p.vertex == v)
      return p.own ? (*triangle(p.triangle).shape)[static_cast<std::size_t>(p.corner)]
                   : in_plane(p.place);
  const std::array<Point, 3> corner{rest(t, 0), rest(t, 1), rest(t, 2)};
  for (const int k : conditions.clamped) {
    const Placed held = unfolded({t, corner, 0, true}, k);
    for (std::size_t c = 0; c < 3; ++c)
      if (triangle(held.triangle).v.v[c] == v)
        return held.own ? (*triangle(held.triangle).shape)[c]
                        : in_plane(barycentric(corner, held.corner[c]));
  }
  WEFT_ASSERT(false);
  return {};
}

namespace {

/// @param q has all else
void set_second(Quadratic& q) {
  for (Weights& weights : q.second) weights = {};
  for (int i = 0; i < 3; ++i) {
    const Point& a = q.gradient[(i + 1) % 3];
    const Point& b = q.gradient[(i + 2) % 3];
    const double part[3] = {2 * a.x() * b.x(), 2 * a.y() * b.y(), a.x() * b.y() + a.y() * b.x()};
    // Of all vertices that there may be: the compiler takes several at once.
    for (int n = 0; n < 3; ++n)
      for (std::size_t v = 0; v < quadratic_vertices; ++v)
        q.second[n][v] += part[n] * q.bulge[i][v];
  }
}

}  // namespace

void PlatePatches::complete(Index t, const Bulges& bulges, Quadratic& q) const {
  static_cast<Bulges&>(q) = bulges;
  const std::array<Point, 3> gradient = gradients_of({rest(t, 0), rest(t, 1), rest(t, 2)});
  std::copy(gradient.begin(), gradient.end(), q.gradient);
  set_second(q);
}

Quadratic PlatePatches::quadratic(Index t, bool* near, ShapePoints* shape) const {
  bool reads_neighbours = false;
  const Conditions conditions = choose(t, reads_neighbours);
  if (near != nullptr) *near = reads_neighbours;
  Quadratic q;
  for (Weights& weights : q.bulge) weights = {};
  const std::array<Point, 3> gradient = gradients_of({rest(t, 0), rest(t, 1), rest(t, 2)});
  std::copy(gradient.begin(), gradient.end(), q.gradient);
  const Products m = products(conditions);
  if (m.rows() == 0) return q;
  const Fit fit = fit_of(m);
  Eigen::Index column = 0;
  for (const int k : conditions.clamped) add_clamp(t, k, fit, column++, q);
  for (const NearPoint& p : conditions.points) {
    const std::size_t there = q.place(p.vertex);
    for (int i = 0; i < 3; ++i) q.bulge[i][there] += fit(i, column);
    for (int c = 0; c < 3; ++c) {
      const std::size_t own = q.place(triangle(t).v.v[c]);
      for (int i = 0; i < 3; ++i) q.bulge[i][own] -= fit(i, column) * p.place[c];
    }
    ++column;
  }
  set_second(q);
  if (shape != nullptr)
    for (const Index v : q.vertices) shape->push_back(shape_point(t, conditions, v));
  return q;
}

}  // namespace weft
