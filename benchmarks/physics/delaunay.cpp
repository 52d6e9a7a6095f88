#include "benchmarks/physics/delaunay.hpp"

#include "weft/core/at.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <unordered_map>

namespace weft::physics {
namespace {

using Point = Vec2<double>;

/// Twice the area of a, b, c; positive: counter-clockwise.
double orientation(const Point& a, const Point& b, const Point& c) {
  return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
}

/// Whether d lies within the circle through a, b, c, which are counter-clockwise.
bool in_circle(const Point& a, const Point& b, const Point& c, const Point& d) {
  const Point u = a - d;
  const Point v = b - d;
  const Point w = c - d;
  const double uu = dot(u, u);
  const double vv = dot(v, v);
  const double ww = dot(w, w);
  return u[0] * (v[1] * ww - w[1] * vv) - u[1] * (v[0] * ww - w[0] * vv) +
             uu * (v[0] * w[1] - w[0] * v[1]) >
         0;
}

/// A triangulation as the corner that lies to the left of each directed edge.
class Triangulation {
 public:
  explicit Triangulation(std::vector<Point> points) : points_(std::move(points)) {}

  void add(Index a, Index b, Index c) {
    left_[key(a, b)] = c;
    left_[key(b, c)] = a;
    left_[key(c, a)] = b;
    recent_ = {{a, b, c}};
  }

  /// Splits the outer edge that passes through point p.
  void insert_on_side(Index p) {
    const Tri t = outer_triangle_at(p);
    const auto [a, b, c] = t.v;
    remove(a, b, c);
    add(a, p, c);
    add(p, b, c);
    legalize(c, a, p);
    legalize(b, c, p);
  }

  void insert_within(Index p) {
    const Tri t = triangle_at(p);
    const auto [a, b, c] = t.v;
    remove(a, b, c);
    add(a, b, p);
    add(b, c, p);
    add(c, a, p);
    legalize(a, b, p);
    legalize(b, c, p);
    legalize(c, a, p);
  }

  std::vector<Tri> triangles() const {
    std::vector<Tri> all;
    for (const auto& [edge, c] : left_) {
      const auto a = static_cast<Index>(edge >> 32);
      const auto b = static_cast<Index>(edge & 0xffffffffu);
      if (a < b && a < c) all.push_back({{a, b, c}});
    }
    std::sort(all.begin(), all.end(), [](const Tri& s, const Tri& t) {
      return std::lexicographical_compare(s.v, s.v + 3, t.v, t.v + 3);
    });
    return all;
  }

 private:
  static std::uint64_t key(Index a, Index b) {
    return static_cast<std::uint64_t>(a) << 32 | static_cast<std::uint64_t>(b);
  }

  const Point& point(Index i) const { return points_[at(i)]; }

  Index left_of(Index a, Index b) const {
    const auto found = left_.find(key(a, b));
    return found == left_.end() ? -1 : found->second;
  }

  void remove(Index a, Index b, Index c) {
    left_.erase(key(a, b));
    left_.erase(key(b, c));
    left_.erase(key(c, a));
  }

  /// Flips edge a-b of triangle a, b, p if the corner beyond it lies in the triangle's circle.
  void legalize(Index a, Index b, Index p) {
    const Index q = left_of(b, a);
    if (q < 0 || !in_circle(point(a), point(b), point(p), point(q))) return;
    remove(a, b, p);
    remove(b, a, q);
    add(a, q, p);
    add(q, b, p);
    legalize(a, q, p);
    legalize(q, b, p);
  }

  /// Walks from the triangle made last.
  Tri triangle_at(Index p) const {
    Tri t = recent_;
    for (int corner = 0; corner < 3; ++corner) {
      const Index a = t.v[corner];
      const Index b = t.v[(corner + 1) % 3];
      if (orientation(point(a), point(b), point(p)) >= 0) continue;
      t = {{b, a, left_of(b, a)}};
      corner = -1;
    }
    return t;
  }

  Tri outer_triangle_at(Index p) const {
    Tri best{};
    double least = HUGE_VAL;
    for (const auto& [edge, c] : left_) {
      const auto a = static_cast<Index>(edge >> 32);
      const auto b = static_cast<Index>(edge & 0xffffffffu);
      if (left_of(b, a) >= 0) continue;
      const double detour =
          length(point(p) - point(a)) + length(point(p) - point(b)) - length(point(a) - point(b));
      if (detour < least) best = {{a, b, c}};
      least = std::min(least, detour);
    }
    return best;
  }

  std::vector<Point> points_;
  std::unordered_map<std::uint64_t, Index> left_;
  Tri recent_{};
};

/// A number of [-0.5, 0.5) that depends on n alone.
double noise(std::uint64_t n) {
  n = (n ^ n >> 30) * 0xbf58476d1ce4e5b9u;
  n = (n ^ n >> 27) * 0x94d049bb133111ebu;
  return static_cast<double>((n ^ n >> 31) >> 11) * 0x1p-53 - 0.5;
}

}  // namespace

std::vector<Tri> triangulate_rectangle(const std::vector<Vec2<double>>& points,
                                       std::size_t on_sides) {
  std::vector<Point> moved = points;
  const double spacing =
      length(points[2] - points[0]) / std::sqrt(static_cast<double>(points.size()));
  for (std::size_t i = 4 + on_sides; i < moved.size(); ++i) {
    // A slight shear lets all squares of a lattice be split alike.
    moved[i][0] += 1e-5 * points[i][1];
    moved[i] += (1e-7 * spacing) * Point{noise(2 * i), noise(2 * i + 1)};
  }
  Triangulation t(std::move(moved));
  t.add(0, 1, 2);
  t.add(0, 2, 3);
  const auto count = static_cast<Index>(points.size());
  const auto first_within = static_cast<Index>(4 + on_sides);
  for (Index p = 4; p < first_within; ++p) t.insert_on_side(p);
  for (Index p = first_within; p < count; ++p) t.insert_within(p);
  return t.triangles();
}

}  // namespace weft::physics
