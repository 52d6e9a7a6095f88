#include "host/meshing/planar_mesher.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>

#include "host/meshing/constrained_delaunay.hpp"
#include "weft/core/at.hpp"

namespace weft {
namespace {

constexpr double degree = std::numbers::pi / 180;
/// Points of the lattice stay this far from the outline, over the edge length: between half and
/// the whole height of an equilateral triangle.
constexpr double least_distance = 0.6;
constexpr int smoothing_rounds = 6;
constexpr int refinement_rounds = 8;

/// Whole coordinates for points of the plane.
class Grid {
 public:
  explicit Grid(const std::vector<Vec2<double>>& outline) : low_(outline[0]), high_(outline[0]) {
    for (const Vec2<double>& p : outline)
      for (int k = 0; k < 2; ++k) {
        low_[k] = std::min(low_[k], p[k]);
        high_[k] = std::max(high_[k], p[k]);
      }
    const double size = std::max(high_[0] - low_[0], high_[1] - low_[1]);
    cell_ = size > 0 ? size / cells : 1;
  }
  GridPoint point(const Vec2<double>& p) const {
    return {std::llround((p[0] - low_[0]) / cell_), std::llround((p[1] - low_[1]) / cell_)};
  }
  Vec2<double> place(const GridPoint& p) const {
    return {low_[0] + static_cast<double>(p.x) * cell_, low_[1] + static_cast<double>(p.y) * cell_};
  }
  const Vec2<double>& low() const { return low_; }
  const Vec2<double>& high() const { return high_; }

 private:
  static constexpr double cells = 1 << 22;
  Vec2<double> low_, high_;
  double cell_;
};

bool within(std::int64_t value, std::int64_t a, std::int64_t b) {
  return std::min(a, b) <= value && value <= std::max(a, b);
}

/// Whether two sides have a point in common.
bool meet(const GridPoint& a, const GridPoint& b, const GridPoint& c, const GridPoint& d) {
  const auto sign = [](std::int64_t x) { return x > 0 ? 1 : x < 0 ? -1 : 0; };
  const int c_side = sign(orientation(a, b, c)), d_side = sign(orientation(a, b, d));
  const int a_side = sign(orientation(c, d, a)), b_side = sign(orientation(c, d, b));
  if (c_side * d_side < 0 && a_side * b_side < 0) return true;
  const auto on = [](const GridPoint& p, const GridPoint& from, const GridPoint& to, int side) {
    return side == 0 && within(p.x, from.x, to.x) && within(p.y, from.y, to.y);
  };
  return on(c, a, b, c_side) || on(d, a, b, d_side) || on(a, c, d, a_side) || on(b, c, d, b_side);
}

/// [m] of a point from the line between two others
double distance(const Vec2<double>& p, const Vec2<double>& a, const Vec2<double>& b) {
  const Vec2<double> side = b - a;
  const double square = dot(side, side);
  const double share = square > 0 ? std::clamp(dot(p - a, side) / square, 0.0, 1.0) : 0;
  return length(p - (a + side * share));
}

/// Sides of an outline by the rows of a lattice that they come near to.
class OutlineRows {
 public:
  OutlineRows(const std::vector<Vec2<double>>& outline, const Grid& grid, double height)
      : outline_(outline), low_(grid.low()[1]), height_(height) {
    rows_.resize(row_of(grid.high()[1]) + 1);
    for (std::size_t k = 0; k < outline.size(); ++k) {
      const auto [from, to] = std::minmax(outline[k][1], outline[(k + 1) % outline.size()][1]);
      for (std::size_t row = row_of(from - height); row <= row_of(to + height); ++row)
        rows_[row].push_back(k);
    }
  }

  /// Whether a point lies inside, and at least so far from all sides that come near its row.
  bool deep_inside(const Vec2<double>& p, double least) const {
    bool inside = false;
    for (const std::size_t k : rows_[row_of(p[1])]) {
      const Vec2<double>&a = outline_[k], &b = outline_[(k + 1) % outline_.size()];
      if (distance(p, a, b) < least) return false;
      if ((a[1] > p[1]) == (b[1] > p[1])) continue;
      if (p[0] < a[0] + (b[0] - a[0]) * ((p[1] - a[1]) / (b[1] - a[1]))) inside = !inside;
    }
    return inside;
  }

 private:
  std::size_t row_of(double y) const {
    const double row = std::floor((y - low_) / height_);
    const auto last = rows_.empty() ? std::numeric_limits<std::size_t>::max() : rows_.size() - 1;
    return row > 0 ? std::min(static_cast<std::size_t>(row), last) : 0;
  }

  const std::vector<Vec2<double>>& outline_;
  double low_;
  double height_;
  std::vector<std::vector<std::size_t>> rows_;
};

/// Points of a hexagonal lattice within an outline.
std::vector<Vec2<double>> lattice_points(const std::vector<Vec2<double>>& outline, const Grid& grid,
                                         double edge) {
  const Vec2<double> size = grid.high() - grid.low();
  const OutlineRows rows(outline, grid, edge);
  const auto count = [](double length, double step) {
    return std::max(1, static_cast<int>(std::lround(length / step)));
  };
  const int row_count = count(size[1], edge * std::numbers::sqrt3 / 2);
  const int columns = count(size[0], edge) + 1;
  // The first and the last row lie on the ends, so that strips get whole rows. Rows begin as far
  // from both ends, so that a mirrored outline gets nearly a mirrored mesh.
  const double height = size[1] / row_count;
  const double left = grid.low()[0] + (size[0] - (columns - 1) * edge) / 2;
  const double bottom = grid.low()[1];
  std::vector<Vec2<double>> points;
  for (int j = 0; j <= row_count; ++j)
    for (int i = j % 2 == 0 ? 0 : -1; i <= columns; ++i) {
      const Vec2<double> p{left + (i + (j % 2 == 0 ? 0.0 : 0.5)) * edge, bottom + j * height};
      if (rows.deep_inside(p, least_distance * edge)) points.push_back(p);
    }
  return points;
}

/// A mesh on its way: a triangulation, and where its points stand.
class MeshDraft {
 public:
  MeshDraft(const std::vector<Vec2<double>>& outline, double edge)
      : outline_(outline), grid_(outline), edge_(edge) {
    for (const Vec2<double>& p : outline) triangulation_.insert(grid_.point(p));
    border_end_ = triangulation_.vertex_count();
    for (const Vec2<double>& p : lattice_points(outline, grid_, edge))
      triangulation_.insert(grid_.point(p));
    const auto n = static_cast<Index>(outline.size());
    for (Index k = 0; k < n; ++k) triangulation_.fix_edge(first + k, first + (k + 1) % n);
    triangulation_.remove_outside();
    triangulation_.restore_delaunay();
  }

  void smooth() {
    for (int round = 0; round < smoothing_rounds; ++round) {
      for (Index v = border_end_; v < triangulation_.vertex_count(); ++v) smooth_vertex(v);
      triangulation_.restore_delaunay();
    }
  }

  /// Puts points into the middle of circles around triangles with small angles.
  /// @return how many
  int refine() {
    std::vector<std::pair<double, Index>> poor;
    for (std::size_t f = 0; f < triangulation_.faces().size(); ++f) {
      const auto& face = triangulation_.faces()[f];
      if (!face.inside) continue;
      const double angle = face_angle(face);
      if (angle < least_mesh_angle && !in_sharp_corner(face))
        poor.emplace_back(angle, static_cast<Index>(f));
    }
    std::sort(poor.begin(), poor.end());
    int added = 0;
    for (const auto& [angle, f] : poor) {
      const auto& face = triangulation_.faces()[at(f)];
      // An earlier point may have changed it.
      if (face_angle(face) != angle) continue;
      if (try_point(circle_centre(face))) ++added;
    }
    return added;
  }

  PlanarMesh take() const {
    PlanarMesh mesh;
    mesh.points = outline_;
    for (Index v = border_end_; v < triangulation_.vertex_count(); ++v)
      mesh.points.push_back(place(v));
    for (const auto& face : triangulation_.faces())
      if (face.inside)
        mesh.triangles.push_back({{face.v[0] - first, face.v[1] - first, face.v[2] - first}});
    return mesh;
  }

 private:
  static constexpr Index first = ConstrainedDelaunay::first_vertex;

  Vec2<double> place(Index v) const { return grid_.place(triangulation_.point(v)); }

  double face_angle(const ConstrainedDelaunay::Face& face) const {
    return least_angle(place(face.v[0]), place(face.v[1]), place(face.v[2]));
  }

  /// Whether two sides of the face are sides of the outline that meet in a small angle.
  bool in_sharp_corner(const ConstrainedDelaunay::Face& face) const {
    for (std::size_t k = 0; k < 3; ++k) {
      if (!face.fixed[(k + 1) % 3] || !face.fixed[(k + 2) % 3]) continue;
      const Vec2<double> corner = place(face.v[k]);
      const Vec2<double> p = place(face.v[(k + 1) % 3]) - corner;
      const Vec2<double> q = place(face.v[(k + 2) % 3]) - corner;
      const double angle = std::atan2(std::abs(p[0] * q[1] - p[1] * q[0]), dot(p, q)) / degree;
      if (angle < least_mesh_angle) return true;
    }
    return false;
  }

  double least_angle_around(const std::vector<Index>& faces) const {
    double least = 180;
    for (const Index f : faces) least = std::min(least, face_angle(triangulation_.faces()[at(f)]));
    return least;
  }

  /// Moves a vertex to the centroid of its triangles, or half way, if no angle gets smaller than
  /// the smallest was.
  void smooth_vertex(Index v) {
    const std::vector<Index> around = triangulation_.faces_around(v);
    Vec2<double> sum{0, 0};
    double area = 0;
    for (const Index f : around) {
      const auto& face = triangulation_.faces()[at(f)];
      const Vec2<double> a = place(face.v[0]), b = place(face.v[1]), c = place(face.v[2]);
      const double twice = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
      sum += (a + b + c) * (twice / 3);
      area += twice;
    }
    if (!(area > 0)) return;
    const GridPoint from = triangulation_.point(v);
    const double before = least_angle_around(around);
    const Vec2<double> start = place(v);
    for (const double share : {1.0, 0.5}) {
      const GridPoint to = grid_.point(start + (sum * (1 / area) - start) * share);
      if (!triangulation_.move(v, to)) continue;
      if (least_angle_around(around) >= before) return;
      triangulation_.move(v, from);
    }
  }

  Vec2<double> circle_centre(const ConstrainedDelaunay::Face& face) const {
    const Vec2<double> a = place(face.v[0]), b = place(face.v[1]) - a, c = place(face.v[2]) - a;
    const double twice = 2 * (b[0] * c[1] - b[1] * c[0]);
    const double bb = dot(b, b), cc = dot(c, c);
    return a + Vec2<double>{(c[1] * bb - b[1] * cc) / twice, (b[0] * cc - c[0] * bb) / twice};
  }

  /// Adds a point unless it comes too near to the outline or another point.
  bool try_point(const Vec2<double>& p) {
    if (!std::isfinite(p[0]) || !std::isfinite(p[1])) return false;
    for (int k = 0; k < 2; ++k)
      if (p[k] < grid_.low()[k] || p[k] > grid_.high()[k]) return false;
    double near = std::numeric_limits<double>::infinity(), side = 0;
    for (std::size_t k = 0; k < outline_.size(); ++k) {
      const Vec2<double>&a = outline_[k], &b = outline_[(k + 1) % outline_.size()];
      const double d = distance(p, a, b);
      if (d < near) {
        near = d;
        side = length(b - a);
      }
    }
    if (near < 0.3 * std::min(side, edge_)) return false;
    const Index before = triangulation_.vertex_count();
    const Index vertex = triangulation_.insert(grid_.point(p));
    return vertex >= before;
  }

  const std::vector<Vec2<double>>& outline_;
  Grid grid_;
  double edge_;
  ConstrainedDelaunay triangulation_;
  Index border_end_ = 0;  ///< first vertex that is none of the outline
};

}  // namespace

double least_angle(const Vec2<double>& a, const Vec2<double>& b, const Vec2<double>& c) {
  const auto angle = [](const Vec2<double>& p, const Vec2<double>& q) {
    return std::atan2(std::abs(p[0] * q[1] - p[1] * q[0]), dot(p, q));
  };
  return std::min({angle(b - a, c - a), angle(c - b, a - b), angle(a - c, b - c)}) / degree;
}

std::optional<OutlineCrossing> find_crossing(const std::vector<Vec2<double>>& outline) {
  const Grid grid(outline);
  const std::size_t n = outline.size();
  std::vector<GridPoint> points;
  points.reserve(n);
  for (const Vec2<double>& p : outline) points.push_back(grid.point(p));
  const auto end = [&](std::size_t k) -> const GridPoint& { return points[(k + 1) % n]; };
  const auto low = [&](std::size_t k) { return std::min(points[k].x, end(k).x); };
  const auto high = [&](std::size_t k) { return std::max(points[k].x, end(k).x); };
  // By their least x, so that only sides whose x overlap are looked at.
  std::vector<std::size_t> order(n);
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return std::pair(low(a), a) < std::pair(low(b), b);
  });
  std::optional<OutlineCrossing> found;
  const auto note = [&](std::size_t a, std::size_t b) {
    const OutlineCrossing crossing{std::min(a, b), std::max(a, b)};
    if (!found || crossing < *found) found = crossing;
  };
  for (std::size_t i = 0; i < n; ++i) {
    const std::size_t a = order[i];
    if (points[a] == end(a)) note(a, a);
    for (std::size_t j = i + 1; j < n && low(order[j]) <= high(a); ++j) {
      const std::size_t b = order[j];
      const bool a_first = (a + 1) % n == b, b_first = (b + 1) % n == a;
      if (a_first || b_first) {
        // Neighbours may only meet in the point between them: they must not fold back.
        const GridPoint& shared = a_first ? end(a) : end(b);
        const GridPoint &p = a_first ? points[a] : points[b], &q = a_first ? end(b) : end(a);
        const bool folded =
            orientation(p, shared, q) == 0 &&
            (p.x - shared.x) * (q.x - shared.x) + (p.y - shared.y) * (q.y - shared.y) > 0;
        if (folded) note(a, b);
        continue;
      }
      if (meet(points[a], end(a), points[b], end(b))) note(a, b);
    }
  }
  return found;
}

double signed_area(const std::vector<Vec2<double>>& outline) {
  double twice = 0;
  const Vec2<double> origin = outline.empty() ? Vec2<double>{0, 0} : outline[0];
  for (std::size_t k = 0; k < outline.size(); ++k) {
    const Vec2<double> a = outline[k] - origin, b = outline[(k + 1) % outline.size()] - origin;
    twice += a[0] * b[1] - a[1] * b[0];
  }
  return twice / 2;
}

double most_mesh_points(const std::vector<Vec2<double>>& outline, double edge) {
  // One point for each area of the lattice, twice as many for refinement, and the outline.
  const double lattice = signed_area(outline) / (edge * edge * std::numbers::sqrt3 / 2);
  return 2 * lattice + 4 * static_cast<double>(outline.size());
}

PlanarMesh mesh_outline(const std::vector<Vec2<double>>& outline, double edge) {
  MeshDraft draft(outline, edge);
  draft.smooth();
  for (int round = 0; round < refinement_rounds && draft.refine() > 0; ++round) draft.smooth();
  return draft.take();
}

}  // namespace weft
