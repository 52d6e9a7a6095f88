#include "host/geometry/ribbon.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "weft/shapes.hpp"

namespace weft {
namespace {

using Point = Vec3<double>;

/// Straight pieces that stand for the curve between two points of the path.
constexpr int pieces = 64;

/// The point at `t` on the line through a at t = ta and b at t = tb.
Point on_line(const Point& a, const Point& b, double ta, double tb, double t) {
  return a + (b - a) * ((t - ta) / (tb - ta));
}

/// One piece of the curve: from p[1] at u = 0 to p[2] at u = 1 (Barry and Goldman's pyramid).
Point between(const Point (&p)[4], double u) {
  double t[4] = {0, 0, 0, 0};
  for (int k = 0; k < 3; ++k) t[k + 1] = t[k] + std::sqrt(length(p[k + 1] - p[k]));
  const double at = t[1] + (t[2] - t[1]) * u;
  Point a[3];
  for (int k = 0; k < 3; ++k) a[k] = on_line(p[k], p[k + 1], t[k], t[k + 1], at);
  const Point b0 = on_line(a[0], a[1], t[0], t[2], at);
  const Point b1 = on_line(a[1], a[2], t[1], t[3], at);
  return on_line(b0, b1, t[1], t[2], at);
}

/// The middle line as many short straight pieces.
std::vector<Point> curve_of(const std::vector<Point>& path) {
  const std::size_t last = path.size() - 1;
  std::vector<Point> curve;
  for (std::size_t k = 0; k < last; ++k) {
    const Point before = k > 0 ? path[k - 1] : path[0] * 2.0 - path[1];
    const Point after = k + 1 < last ? path[k + 2] : path[last] * 2.0 - path[last - 1];
    const Point p[4] = {before, path[k], path[k + 1], after};
    for (int n = 0; n < pieces; ++n) curve.push_back(between(p, static_cast<double>(n) / pieces));
  }
  curve.push_back(path.back());
  return curve;
}

/// [points] [m] along the curve from its start
std::vector<double> arc_lengths(const std::vector<Point>& curve) {
  std::vector<double> along{0};
  for (std::size_t i = 1; i < curve.size(); ++i)
    along.push_back(along.back() + length(curve[i] - curve[i - 1]));
  return along;
}

}  // namespace

double ribbon_length(const Ribbon& ribbon) {
  return arc_lengths(curve_of(ribbon.path)).back();
}

double ribbon_steepness(const Ribbon& ribbon) {
  const std::vector<Point> curve = curve_of(ribbon.path);
  double least = 1;
  for (std::size_t i = 1; i < curve.size(); ++i) {
    const Point step = curve[i] - curve[i - 1];
    if (!(length(step) > 0)) return 0;
    least = std::min(least, length(cross(step, ribbon.across)) / length(step));
  }
  return least;
}

Mesh make_ribbon(const Ribbon& ribbon, const std::array<Index, 2>& cells) {
  const auto [along, across] = cells;
  const std::vector<Point> curve = curve_of(ribbon.path);
  const std::vector<double> arc = arc_lengths(curve);
  Mesh mesh = make_grid({arc.back(), ribbon.width}, cells, Diagonals::alternating);
  std::size_t piece = 0;
  for (Index i = 0; i <= along; ++i) {
    const double at = arc.back() * i / along;
    while (piece + 2 < curve.size() && arc[piece + 1] < at) ++piece;
    const Point middle = on_line(curve[piece], curve[piece + 1], arc[piece], arc[piece + 1], at);
    // The direction at a vertex is that of the curve around it.
    const Point step =
        curve[std::min(piece + 2, curve.size() - 1)] - curve[piece > 0 ? piece - 1 : 0];
    Point side = ribbon.across - step * (dot(step, ribbon.across) / length_sq(step));
    side *= 1 / length(side);
    for (Index j = 0; j <= across; ++j) {
      const auto v = static_cast<std::size_t>(grid_vertex(along, i, j));
      mesh.positions[v] = middle + side * mesh.material[v][1];
    }
  }
  return mesh;
}

}  // namespace weft
