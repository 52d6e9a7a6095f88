#include "host/scene/plate.hpp"

#include <Eigen/Dense>

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>
#include <utility>

namespace weft {
namespace {

using Point = Eigen::Vector2d;

/// Norm of the inverse up to which three points around a triangle are taken as they come; those of
/// an equilateral mesh have 1.2. Barycentric coordinates: sizes and angles do not count.
constexpr double badness_max = 6;
/// How many triangles away points may lie.
constexpr int search_depth = 3;
/// Entries below this share of their diagonals are what rounding leaves of a zero.
constexpr double negligible = 1e-12;

std::size_t at(Index i) {
  return static_cast<std::size_t>(i);
}

double cross_of(const Point& a, const Point& b) {
  return a.x() * b.y() - a.y() * b.x();
}

/// A linear functional of the values of one coordinate: the sum of weight times value.
struct Functional {
  std::vector<std::pair<Index, double>> terms;

  void add(Index v, double weight) {
    for (auto& [u, w] : terms)
      if (u == v) {
        w += weight;
        return;
      }
    terms.emplace_back(v, weight);
  }
  void add(const Functional& other, double scale) {
    for (const auto& [v, w] : other.terms) add(v, scale * w);
  }
};

/// A triangle laid into the plane of another.
struct Placed {
  Index triangle;
  std::array<Point, 3> corner;
  int depth;
};

/// A vertex near a triangle, in the triangle's plane.
struct NearPoint {
  Index vertex;
  Point place;
  int depth;
};

/// The quadratic of one triangle: its linear interpolant plus bulge[i] times the product of the
/// barycentric coordinates other than i.
struct Quadratic {
  Functional bulge[3];
  Functional second[3];  ///< derivatives by u u, v v and u v
  Point gradient[3];     ///< [1/m] of the barycentric coordinates
};

class PlateBuilder {
 public:
  PlateBuilder(Index vertex_count, const std::vector<PlateTriangle>& triangles)
      : triangles_(triangles), neighbour_(triangles.size(), {-1, -1, -1}), rows_(at(vertex_count)) {
    find_neighbours();
    for (std::size_t t = 0; t < triangles.size(); ++t)
      quadratics_.push_back(quadratic_of(static_cast<Index>(t)));
  }

  PlateMatrix build() {
    for (std::size_t t = 0; t < triangles_.size(); ++t) add_triangle(t);
    for (std::size_t t = 0; t < triangles_.size(); ++t)
      for (int k = 0; k < 3; ++k)
        if (neighbour_[t][static_cast<std::size_t>(k)] > static_cast<Index>(t)) add_edge(t, k);
    return compressed();
  }

 private:
  struct Entry {
    Index column;
    double stiffness;
    double damping;
  };

  Point rest(std::size_t t, int corner) const {
    const Vec2<double>& p = triangles_[t].rest[static_cast<std::size_t>(corner)];
    return {p[0], p[1]};
  }
  double area(std::size_t t) const {
    return cross_of(rest(t, 1) - rest(t, 0), rest(t, 2) - rest(t, 0)) / 2;
  }
  Index neighbour(Index t, int edge) const {
    return neighbour_[at(t)][static_cast<std::size_t>(edge)];
  }

  /// Edge k of a triangle is the one opposite corner k. Only edges of two triangles that run along
  /// them in opposite directions join these.
  void find_neighbours() {
    struct Side {
      Index low, high, triangle;
      std::size_t edge;
      bool forward;
    };
    std::vector<Side> sides;
    for (std::size_t t = 0; t < triangles_.size(); ++t)
      for (std::size_t k = 0; k < 3; ++k) {
        const Index a = triangles_[t].v.v[(k + 1) % 3];
        const Index b = triangles_[t].v.v[(k + 2) % 3];
        sides.push_back({std::min(a, b), std::max(a, b), static_cast<Index>(t), k, a < b});
      }
    std::sort(sides.begin(), sides.end(), [](const Side& a, const Side& b) {
      return std::tie(a.low, a.high, a.triangle) < std::tie(b.low, b.high, b.triangle);
    });
    for (std::size_t s = 0; s < sides.size();) {
      std::size_t end = s + 1;
      while (end < sides.size() && sides[end].low == sides[s].low &&
             sides[end].high == sides[s].high)
        ++end;
      if (end - s == 2 && sides[s].forward != sides[s + 1].forward) {
        neighbour_[at(sides[s].triangle)][sides[s].edge] = sides[s + 1].triangle;
        neighbour_[at(sides[s + 1].triangle)][sides[s + 1].edge] = sides[s].triangle;
      }
      s = end;
    }
  }

  /// The neighbour of `from` across its edge k, unfolded into the same plane.
  Placed unfolded(const Placed& from, int k) const {
    const Index next = neighbour(from.triangle, k);
    const Index* v = triangles_[at(next)].v.v;
    const Index end = triangles_[at(from.triangle)].v.v[(k + 1) % 3];
    // Corner `e` of the neighbour is the end of the edge where it begins for `from`.
    const int e = v[0] == end ? 0 : v[1] == end ? 1 : 2;
    const int b = (e + 2) % 3;
    const Point& head = from.corner[static_cast<std::size_t>((k + 1) % 3)];
    const Point& tail = from.corner[static_cast<std::size_t>((k + 2) % 3)];
    const Point there = (head - tail).normalized();
    const Point here = (rest(at(next), e) - rest(at(next), b)).normalized();
    Eigen::Matrix2d turn;
    const double c = here.dot(there);
    const double s = cross_of(here, there);
    turn << c, -s, s, c;
    const Point middle = (head + tail) / 2;
    const Point own_middle = (rest(at(next), e) + rest(at(next), b)) / 2;
    Placed placed{next, {}, from.depth + 1};
    for (int i = 0; i < 3; ++i)
      placed.corner[static_cast<std::size_t>(i)] = middle + turn * (rest(at(next), i) - own_middle);
    return placed;
  }

  /// Vertices around a triangle, nearest triangles first.
  std::vector<NearPoint> points_around(Index triangle) const {
    const Tri& own = triangles_[at(triangle)].v;
    std::vector<Placed> placed{
        {triangle, {rest(at(triangle), 0), rest(at(triangle), 1), rest(at(triangle), 2)}, 0}};
    std::vector<NearPoint> points;
    const auto known = [&](Index v) {
      return v == own.v[0] || v == own.v[1] || v == own.v[2] ||
             std::any_of(points.begin(), points.end(),
                         [&](const NearPoint& p) { return p.vertex == v; });
    };
    for (std::size_t n = 0; n < placed.size() && placed[n].depth < search_depth; ++n)
      for (int k = 0; k < 3; ++k) {
        const Index next = neighbour(placed[n].triangle, k);
        if (next < 0 || std::any_of(placed.begin(), placed.end(),
                                    [&](const Placed& p) { return p.triangle == next; }))
          continue;
        placed.push_back(unfolded(placed[n], k));
        for (std::size_t c = 0; c < 3; ++c) {
          const Index v = triangles_[at(next)].v.v[c];
          if (!known(v)) points.push_back({v, placed.back().corner[c], placed.back().depth});
        }
      }
    return points;
  }

  /// Barycentric coordinates in triangle t of a point in its plane.
  Eigen::Vector3d barycentric(std::size_t t, const Point& p) const {
    const double twice = 2 * area(t);
    const double a = cross_of(rest(t, 1) - p, rest(t, 2) - p) / twice;
    const double b = cross_of(rest(t, 2) - p, rest(t, 0) - p) / twice;
    return {a, b, 1 - a - b};
  }

  /// Products of barycentric coordinates at the points, one a row.
  using Products = Eigen::Matrix<double, Eigen::Dynamic, 3, 0, 3, 3>;
  Products products_at(std::size_t t, const std::vector<NearPoint>& points) const {
    Products m(static_cast<Eigen::Index>(points.size()), 3);
    for (std::size_t i = 0; i < points.size(); ++i) {
      const Eigen::Vector3d l = barycentric(t, points[i].place);
      m.row(static_cast<Eigen::Index>(i)) << l[1] * l[2], l[2] * l[0], l[0] * l[1];
    }
    return m;
  }

  double badness(std::size_t t, const std::vector<NearPoint>& points) const {
    if (points.size() < 3) return std::numeric_limits<double>::infinity();
    const Eigen::Matrix3d m = products_at(t, points);
    const double determinant = m.determinant();
    if (!(std::abs(determinant) > 1e-9)) return std::numeric_limits<double>::infinity();
    return m.inverse().norm();
  }

  /// The three points that serve a triangle's quadratic; fewer if there are not as many.
  std::vector<NearPoint> choose_points(Index triangle) const {
    const std::vector<NearPoint> around = points_around(triangle);
    std::vector<NearPoint> chosen;
    for (const NearPoint& p : around)
      if (p.depth == 1) chosen.push_back(p);
    double best = badness(at(triangle), chosen);
    if (best <= badness_max) return chosen;
    if (around.size() <= 3) return around;
    // Points beside the neighbours' corners, or in their place where those lie badly.
    const std::size_t keep = chosen.size() < 3 ? chosen.size() : 0;
    for (int depth = 2; depth <= search_depth && best > badness_max; ++depth) {
      std::vector<NearPoint> pool;
      for (const NearPoint& p : around)
        if (p.depth <= depth) pool.push_back(p);
      std::vector<NearPoint> trial(pool.begin(), pool.begin() + static_cast<std::ptrdiff_t>(keep));
      try_points(at(triangle), pool, keep, trial, best, chosen);
    }
    if (chosen.size() < 3) chosen.assign(around.begin(), around.begin() + 3);
    return chosen;
  }

  void try_points(std::size_t t, const std::vector<NearPoint>& pool, std::size_t next,
                  std::vector<NearPoint>& trial, double& best,
                  std::vector<NearPoint>& chosen) const {
    if (trial.size() == 3) {
      const double bad = badness(t, trial);
      if (bad < best) {
        best = bad;
        chosen = trial;
      }
      return;
    }
    for (std::size_t i = next; i < pool.size(); ++i) {
      trial.push_back(pool[i]);
      try_points(t, pool, i + 1, trial, best, chosen);
      trial.pop_back();
    }
  }

  Quadratic quadratic_of(Index triangle) const {
    const std::size_t t = at(triangle);
    const std::vector<NearPoint> points = choose_points(triangle);
    Quadratic q;
    for (int i = 0; i < 3; ++i) {
      const Point e = rest(t, (i + 2) % 3) - rest(t, (i + 1) % 3);
      q.gradient[i] = Point(-e.y(), e.x()) / (2 * area(t));
    }
    if (points.empty()) return q;
    // With fewer than three points: the least bulges that fit.
    const Eigen::MatrixXd fit =
        Eigen::MatrixXd(products_at(t, points)).completeOrthogonalDecomposition().pseudoInverse();
    for (std::size_t p = 0; p < points.size(); ++p) {
      const Eigen::Vector3d l = barycentric(t, points[p].place);
      for (int i = 0; i < 3; ++i) {
        const double weight = fit(i, static_cast<Eigen::Index>(p));
        q.bulge[i].add(points[p].vertex, weight);
        for (int c = 0; c < 3; ++c) q.bulge[i].add(triangles_[t].v.v[c], -weight * l[c]);
      }
    }
    for (int i = 0; i < 3; ++i) {
      const Point& a = q.gradient[(i + 1) % 3];
      const Point& b = q.gradient[(i + 2) % 3];
      q.second[0].add(q.bulge[i], 2 * a.x() * b.x());
      q.second[1].add(q.bulge[i], 2 * a.y() * b.y());
      q.second[2].add(q.bulge[i], a.x() * b.y() + a.y() * b.x());
    }
    return q;
  }

  /// Energy and damping of a sum of products of functionals.
  void add(const Functional& a, const Functional& b, double stiffness, double damping) {
    for (const auto& [i, wa] : a.terms)
      for (const auto& [j, wb] : b.terms) {
        const double share = wa * wb;
        std::vector<Entry>& row = rows_[at(i)];
        const auto found = std::find_if(
            row.begin(), row.end(), [&, column = j](const Entry& e) { return e.column == column; });
        Entry& entry = found == row.end() ? row.emplace_back(Entry{j, 0, 0}) : *found;
        entry.stiffness += stiffness * share;
        entry.damping += damping * share;
      }
  }

  void add_triangle(std::size_t t) {
    const PlateTriangle& triangle = triangles_[t];
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) {
        const double k = area(t) * triangle.rigidity(i, j);
        if (k != 0)
          add(quadratics_[t].second[i], quadratics_[t].second[j], k, triangle.damping * k);
      }
  }

  struct EdgeSide {
    Functional slope;   ///< outwards, at the middle of the edge
    Functional moment;  ///< [N m] across the edge
    double length;      ///< [m]
    double penalty;     ///< [N m / m^2] n D_n / A
  };

  EdgeSide edge_side(std::size_t t, int k) const {
    const Quadratic& q = quadratics_[t];
    const int a = (k + 1) % 3;
    const int b = (k + 2) % 3;
    const Point e = rest(t, b) - rest(t, a);
    EdgeSide side;
    side.length = e.norm();
    const Point n = Point(e.y(), -e.x()) / side.length;
    for (int i = 0; i < 3; ++i) side.slope.add(triangles_[t].v.v[i], n.dot(q.gradient[i]));
    // Of lambda_a lambda_b in the middle, and of the two products that vanish along the edge.
    side.slope.add(q.bulge[k], n.dot(q.gradient[a] + q.gradient[b]) / 2);
    side.slope.add(q.bulge[a], n.dot(q.gradient[k]) / 2);
    side.slope.add(q.bulge[b], n.dot(q.gradient[k]) / 2);
    const Vec3<double> across{n.x() * n.x(), n.y() * n.y(), n.x() * n.y()};
    const Vec3<double> moment = triangles_[t].rigidity * across;
    for (int i = 0; i < 3; ++i) side.moment.add(q.second[i], moment[i]);
    int inner = 0;
    for (const Index other : neighbour_[t]) inner += other >= 0 ? 1 : 0;
    side.penalty = inner * dot(across, moment) / area(t);
    return side;
  }

  void add_edge(std::size_t t, int k) {
    const Index other = neighbour_[t][static_cast<std::size_t>(k)];
    int back = 0;
    while (neighbour(other, back) != static_cast<Index>(t) ||
           triangles_[at(other)].v.v[(back + 1) % 3] != triangles_[t].v.v[(k + 2) % 3])
      ++back;
    EdgeSide side = edge_side(t, k);
    const EdgeSide opposite = edge_side(at(other), back);
    side.slope.add(opposite.slope, 1);
    side.moment.add(opposite.moment, 1);
    // Sides that are sewn together need not be of one length.
    const double length = (side.length + opposite.length) / 2;
    const double damping = (triangles_[t].damping + triangles_[at(other)].damping) / 2;
    const double cross_term = -length / 2;
    add(side.slope, side.moment, cross_term, damping * cross_term);
    add(side.moment, side.slope, cross_term, damping * cross_term);
    const double penalty = length * length / 4 * (side.penalty + opposite.penalty);
    add(side.slope, side.slope, penalty, damping * penalty);
  }

  PlateMatrix compressed() {
    std::vector<double> diagonal(rows_.size(), 0);
    for (std::size_t i = 0; i < rows_.size(); ++i)
      for (const Entry& e : rows_[i])
        if (at(e.column) == i) diagonal[i] = e.stiffness;
    for (std::vector<Entry>& row : rows_)
      std::sort(row.begin(), row.end(),
                [](const Entry& a, const Entry& b) { return a.column < b.column; });
    // Symmetric to the bit: rounding depends on the order in which terms came.
    for (std::size_t i = 0; i < rows_.size(); ++i)
      for (Entry& e : rows_[i]) {
        if (at(e.column) <= i) continue;
        std::vector<Entry>& other = rows_[at(e.column)];
        const auto mirror =
            std::lower_bound(other.begin(), other.end(), static_cast<Index>(i),
                             [](const Entry& a, Index column) { return a.column < column; });
        e.stiffness = mirror->stiffness = (e.stiffness + mirror->stiffness) / 2;
        e.damping = mirror->damping = (e.damping + mirror->damping) / 2;
      }
    PlateMatrix m;
    m.row_offset.push_back(0);
    for (std::size_t i = 0; i < rows_.size(); ++i) {
      std::vector<Entry>& row = rows_[i];
      for (const Entry& e : row) {
        if (std::abs(e.stiffness) <= negligible * std::sqrt(diagonal[i] * diagonal[at(e.column)]))
          continue;
        m.column.push_back(e.column);
        m.stiffness.push_back(e.stiffness);
        m.damping.push_back(e.damping);
      }
      m.row_offset.push_back(static_cast<Offset>(m.column.size()));
      row = {};
    }
    return m;
  }

  const std::vector<PlateTriangle>& triangles_;
  std::vector<std::array<Index, 3>> neighbour_;  ///< across the edge opposite each corner, or -1
  std::vector<Quadratic> quadratics_;
  std::vector<std::vector<Entry>> rows_;
};

}  // namespace

PlateMatrix make_plate_matrix(Index vertex_count, const std::vector<PlateTriangle>& triangles) {
  return PlateBuilder(vertex_count, triangles).build();
}

double plate_energy(const PlateMatrix& matrix, const std::vector<Vec3<double>>& positions) {
  // Rows sum to zero, so differences say the same, and say it more exactly.
  double sum = 0;
  for (std::size_t i = 0; i + 1 < matrix.row_offset.size(); ++i)
    for (auto e = static_cast<std::size_t>(matrix.row_offset[i]);
         e < static_cast<std::size_t>(matrix.row_offset[i + 1]); ++e)
      sum -= matrix.stiffness[e] * length_sq(positions[at(matrix.column[e])] - positions[i]) / 4;
  return sum;
}

}  // namespace weft
