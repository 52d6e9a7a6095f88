#include "host/geometry/planar_domain.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <map>
#include <numeric>
#include <optional>
#include <utility>

namespace weft {
namespace {

constexpr double lattice_cells = 0x1p20;
/// Slivers beyond this make nothing but rounding.
constexpr double longest_over_height_max = 1000;

struct LatticePoint {
  std::int64_t x = 0, y = 0;
};

LatticePoint operator-(const LatticePoint& a, const LatticePoint& b) {
  return {a.x - b.x, a.y - b.y};
}
std::int64_t cross(const LatticePoint& a, const LatticePoint& b) {
  return a.x * b.y - a.y * b.x;
}
std::int64_t dot(const LatticePoint& a, const LatticePoint& b) {
  return a.x * b.x + a.y * b.y;
}
bool upwards(const LatticePoint& d) {
  return d.y > 0 || (d.y == 0 && d.x > 0);
}

/// Which connected piece each vertex belongs to, by the lowest vertex of it.
std::vector<Index> component_of_vertices(Index vertex_count, const std::vector<Tri>& triangles) {
  std::vector<Index> parent(static_cast<std::size_t>(vertex_count));
  std::iota(parent.begin(), parent.end(), 0);
  const auto root = [&](Index v) {
    while (parent[static_cast<std::size_t>(v)] != v) {
      Index& up = parent[static_cast<std::size_t>(v)];
      up = parent[static_cast<std::size_t>(up)];
      v = up;
    }
    return v;
  };
  for (const Tri& t : triangles)
    for (int k = 1; k < 3; ++k) {
      const Index a = root(t.v[0]), b = root(t.v[k]);
      parent[static_cast<std::size_t>(std::max(a, b))] = std::min(a, b);
    }
  for (Index v = 0; v < vertex_count; ++v) parent[static_cast<std::size_t>(v)] = root(v);
  return parent;
}

/// One piece: its triangles, and its picture on the lattice.
class Piece {
 public:
  /// @param points [vertices of all pieces] scratch
  Piece(std::vector<Index> vertices, std::vector<Tri> triangles,
        const std::vector<Vec2<double>>& picture, std::vector<LatticePoint>& points)
      : vertices_(std::move(vertices)), triangles_(std::move(triangles)), points_(points) {
    Vec2<double> low = picture[static_cast<std::size_t>(vertices_[0])], high = low;
    for (const Index v : vertices_)
      for (int c = 0; c < 2; ++c) {
        const double at = picture[static_cast<std::size_t>(v)][c];
        finite_ = finite_ && std::isfinite(at);
        low[c] = std::min(low[c], at);
        high[c] = std::max(high[c], at);
      }
    cell_ = std::max(high[0] - low[0], high[1] - low[1]) / lattice_cells;
    finite_ = finite_ && std::isfinite(cell_) && cell_ > 0;
    if (!finite_) return;
    for (const Index v : vertices_) {
      const Vec2<double>& p = picture[static_cast<std::size_t>(v)];
      point(v) = {std::llround((p[0] - low[0]) / cell_), std::llround((p[1] - low[1]) / cell_)};
    }
  }

  std::optional<PlanarDomain> domain() {
    if (!finite_ || !orient() || !find_sides()) return std::nullopt;
    PlanarDomain domain;
    domain.vertices = vertices_;
    domain.least_gap = std::numeric_limits<double>::infinity();
    for (const Tri& t : triangles_)
      if (!add_triangle(t, domain)) return std::nullopt;
    for (const Index from : loop_) {
      const Index to = next_.at(from);
      const LatticePoint d = point(to) - point(from);
      domain.sides.push_back(
          {{from, to}, {cell_ * static_cast<double>(d.y), -cell_ * static_cast<double>(d.x)}});
    }
    return domain;
  }

 private:
  /// Makes all triangles counter-clockwise.
  bool orient() {
    const bool mirrored = area(triangles_[0]) < 0;
    if (mirrored)
      for (const Index v : vertices_) point(v).x = -point(v).x;
    return std::all_of(triangles_.begin(), triangles_.end(),
                       [&](const Tri& t) { return area(t) > 0; });
  }

  std::int64_t area(const Tri& t) const {
    const LatticePoint& p = point(t.v[0]);
    return cross(point(t.v[1]) - p, point(t.v[2]) - p);
  }

  LatticePoint& point(Index v) const { return points_[static_cast<std::size_t>(v)]; }

  /// Whether the sides are one convex polygon, run through once.
  bool find_sides() {
    std::vector<std::pair<Index, Index>> directed;
    directed.reserve(3 * triangles_.size());
    for (const Tri& t : triangles_)
      for (int k = 0; k < 3; ++k) directed.emplace_back(t.v[k], t.v[(k + 1) % 3]);
    std::sort(directed.begin(), directed.end());
    if (std::adjacent_find(directed.begin(), directed.end()) != directed.end()) return false;
    for (const auto& [from, to] : directed)
      if (!std::binary_search(directed.begin(), directed.end(), std::pair(to, from)) &&
          !next_.emplace(from, to).second)
        return false;
    if (next_.empty()) return false;
    Index at = next_.begin()->first;
    do {
      loop_.push_back(at);
      const auto found = next_.find(at);
      if (found == next_.end() || loop_.size() > next_.size()) return false;
      at = found->second;
    } while (at != loop_.front());
    return loop_.size() == next_.size() && is_convex();
  }

  bool is_convex() const {
    int turns = 0;
    for (std::size_t k = 0; k < loop_.size(); ++k) {
      const std::size_t n = loop_.size();
      const LatticePoint a = point(loop_[(k + 1) % n]) - point(loop_[k]);
      const LatticePoint b = point(loop_[(k + 2) % n]) - point(loop_[(k + 1) % n]);
      const std::int64_t turn = cross(a, b);
      if (turn < 0 || (turn == 0 && dot(a, b) <= 0)) return false;
      if (!upwards(a) && upwards(b)) ++turns;
    }
    return turns == 1;
  }

  bool add_triangle(const Tri& t, PlanarDomain& domain) const {
    const auto metres = [&](const LatticePoint& d) {
      return Vec2<double>{cell_ * static_cast<double>(d.x), cell_ * static_cast<double>(d.y)};
    };
    const LatticePoint& p = point(t.v[0]);
    const Vec2<double> a = metres(point(t.v[1]) - p);
    const Vec2<double> b = metres(point(t.v[2]) - p);
    const double doubled = static_cast<double>(area(t)) * cell_ * cell_;
    const double longest = std::sqrt(std::max({length_sq(a), length_sq(b), length_sq(b - a)}));
    const double height = doubled / longest;
    if (!(longest <= longest_over_height_max * height)) return false;
    DomainTriangle triangle{{t.v[0], t.v[1], t.v[2]},
                            {b[1] / doubled, -b[0] / doubled, -a[1] / doubled, a[0] / doubled}};
    for (const double e : triangle.inverse)
      domain.largest_inverse = std::max(domain.largest_inverse, std::abs(e));
    domain.least_gap = std::min(domain.least_gap, (1 - 1e-12) * height);
    domain.triangles.push_back(triangle);
    return true;
  }

  std::vector<Index> vertices_;
  std::vector<Tri> triangles_;
  std::vector<LatticePoint>& points_;
  std::map<Index, Index> next_;  ///< along the sides
  std::vector<Index> loop_;
  double cell_ = 0;  ///< [m] of the lattice
  bool finite_ = true;
};

}  // namespace

std::vector<PlanarDomain> planar_domains(Index vertex_count, const std::vector<Tri>& triangles,
                                         const std::vector<Vec2<double>>& picture) {
  const std::vector<Index> piece = component_of_vertices(vertex_count, triangles);
  std::map<Index, std::pair<std::vector<Index>, std::vector<Tri>>> pieces;
  for (Index v = 0; v < vertex_count; ++v)
    pieces[piece[static_cast<std::size_t>(v)]].first.push_back(v);
  for (const Tri& t : triangles)
    pieces[piece[static_cast<std::size_t>(t.v[0])]].second.push_back(t);
  std::vector<PlanarDomain> domains;
  std::vector<LatticePoint> points(static_cast<std::size_t>(vertex_count));
  for (auto& [first, parts] : pieces) {
    if (parts.second.empty()) return {};
    auto domain = Piece(std::move(parts.first), std::move(parts.second), picture, points).domain();
    if (!domain) return {};
    domains.push_back(std::move(*domain));
  }
  return domains;
}

}  // namespace weft
