#include "host/geometry/triangle_pair.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "host/geometry/plane_side.hpp"
#include "weft/elements/distance.hpp"

namespace weft {
namespace {

using Point = Vec3<double>;

/// As plainly_apart(), for what of two triangles with one common vertex, corner i of s and j of t,
/// must not meet: the edge opposite it of each, and the other triangle.
bool plainly_apart_beyond(const Corners& s, std::size_t i, const Corners& t, std::size_t j,
                          double gap) {
  return plainly_apart({s[(i + 1) % 3], s[(i + 2) % 3], s[(i + 2) % 3]}, t, gap) &&
         plainly_apart({t[(j + 1) % 3], t[(j + 2) % 3], t[(j + 2) % 3]}, s, gap);
}

/// True if a plane through the common vertex, corner i of s and j of t, has what else there is of
/// the triangles on its two sides, farther from it than `gap` in spite of rounding: as in most of
/// a fan. False may be either.
bool leans_apart(const Corners& s, std::size_t i, const Corners& t, std::size_t j, double gap) {
  const Point& p = s[i];
  if (length_sq(t[j] - p) != 0) return false;  // one by its number only
  const Point a = s[(i + 1) % 3] - p, b = s[(i + 2) % 3] - p;
  const Point c = t[(j + 1) % 3] - p, d = t[(j + 2) % 3] - p;
  const Point s_way = a + b, t_way = c + d;
  const Point axis = s_way * length(t_way) - t_way * length(s_way);
  double reach = 0;
  for (const Point& x : {p, a, b, c, d})
    for (int k = 0; k < 3; ++k) reach = std::max(reach, std::fabs(x[k]));
  const double size = std::fabs(axis[0]) + std::fabs(axis[1]) + std::fabs(axis[2]);
  const double least = size * (gap + 16 * epsilon<double> * reach) + smallest_normal<double>;
  return dot(axis, a) > least && dot(axis, b) > least && dot(axis, c) < -least &&
         dot(axis, d) < -least;
}

/// Longest side of the box about both triangles.
double longest_side(const Corners& s, const Corners& t) {
  double longest = 0;
  for (int c = 0; c < 3; ++c)
    longest =
        std::max(longest, std::max({s[0][c], s[1][c], s[2][c], t[0][c], t[1][c], t[2][c]}) -
                              std::min({s[0][c], s[1][c], s[2][c], t[0][c], t[1][c], t[2][c]}));
  return longest;
}

/// True if two triangles with a common edge lie on opposite sides of a plane through it, and have
/// no corner near enough to the plane or to another for what they do not share to touch.
bool opens_wide(const Corners& s, const Corners& t, const std::array<bool, 3>& s_shared,
                const std::array<bool, 3>& t_shared) {
  const std::size_t i = s_shared[0] ? (s_shared[1] ? 2 : 1) : 0;
  const std::size_t j = t_shared[0] ? (t_shared[1] ? 2 : 1) : 0;
  const Point& start = s[(i + 1) % 3];
  const Point edge = s[(i + 2) % 3] - start;
  const double edge_sq = length_sq(edge);
  const auto height = [&](const Point& x) {
    return (x - start) - edge * (dot(x - start, edge) / edge_sq);
  };
  const Point s_height = height(s[i]);
  const Point t_height = height(t[j]);
  const double size = longest_side(s, t);
  const double least_sq = 1e-4 * size * size;
  const double across = -dot(s_height, t_height);
  return edge_sq > least_sq && across > 0 && across * across > least_sq * length_sq(s_height) &&
         across * across > least_sq * length_sq(t_height);
}

bool vertex_touches(const Point& p, const Corners& t, double gap) {
  const Point x[4] = {p, t[0], t[1], t[2]};
  return !vertex_triangle_farther(x, gap) && vertex_triangle(x).distance_sq <= gap * gap;
}

bool edges_touch(const Point& p, const Point& q, const Point& r, const Point& s, double gap) {
  const Point x[4] = {p, q, r, s};
  return !edge_edge_farther(x, gap) && edge_edge(x).distance_sq <= gap * gap;
}

}  // namespace

bool plainly_apart(const Corners& s, const Corners& t, double gap) {
  std::array<Point, 6> x;
  double reach = 0;
  for (std::size_t k = 0; k < 6; ++k) {
    x[k] = (k < 3 ? s[k] : t[k - 3]) - s[0];
    for (int c = 0; c < 3; ++c) reach = std::max(reach, std::fabs(x[k][c]));
  }
  const auto separates = [&](const Point& axis) {
    std::array<double, 6> h;
    for (std::size_t k = 0; k < 6; ++k) h[k] = dot(axis, x[k]);
    const double between = std::max(std::min({h[0], h[1], h[2]}) - std::max({h[3], h[4], h[5]}),
                                    std::min({h[3], h[4], h[5]}) - std::max({h[0], h[1], h[2]}));
    const double size = std::fabs(axis[0]) + std::fabs(axis[1]) + std::fabs(axis[2]);
    return between > size * (gap + 16 * epsilon<double> * reach) + smallest_normal<double>;
  };
  // Any axis will do to show a gap; the line of the centres is a good initial guess.
  if (separates((x[3] + x[4] + x[5]) - (x[0] + x[1] + x[2]))) return true;
  const std::array<Point, 2> normals{cross(x[1], x[2]), cross(x[4] - x[3], x[5] - x[3])};
  if (separates(normals[0]) || separates(normals[1])) return true;
  for (const Point& normal : normals)
    for (std::size_t k = 0; k < 6; ++k) {
      const std::size_t next = k < 3 ? (k + 1) % 3 : 3 + (k + 1) % 3;
      if (separates(cross(normal, x[next] - x[k]))) return true;
    }
  return false;
}

bool pierces(const Point& p, const Point& q, const Corners& t) {
  const int side_p = plane_side(t[0], t[1], t[2], p);
  if (side_p == 0 || plane_side(t[0], t[1], t[2], q) != -side_p) return false;
  const int turn = plane_side(p, q, t[0], t[1]);
  return turn != 0 && plane_side(p, q, t[1], t[2]) == turn && plane_side(p, q, t[2], t[0]) == turn;
}

bool triangles_intersect(const Tri& s_tri, const Tri& t_tri, const Corners& s, const Corners& t) {
  std::array<bool, 3> s_shared{};
  std::array<bool, 3> t_shared{};
  std::size_t shared = 0;
  std::size_t s_last = 0;
  std::size_t t_last = 0;
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = 0; j < 3; ++j)
      if (s_tri.v[i] == t_tri.v[j]) {
        s_shared[s_last = i] = t_shared[t_last = j] = true;
        ++shared;
      }
  const double gap = touching * longest_side(s, t);
  if (shared == 0 && plainly_apart(s, t, gap)) return false;
  if (shared == 1 && leans_apart(s, s_last, t, t_last, gap)) return false;
  if (shared == 1 && plainly_apart_beyond(s, s_last, t, t_last, gap)) return false;
  if (shared == 2 && opens_wide(s, t, s_shared, t_shared)) return false;

  for (std::size_t i = 0; i < 3; ++i) {
    if (!s_shared[i] && vertex_touches(s[i], t, gap)) return true;
    if (!t_shared[i] && vertex_touches(t[i], s, gap)) return true;
  }
  for (std::size_t i = 0; i < 3; ++i) {
    const std::size_t i2 = (i + 1) % 3;
    if (!s_shared[i] && !s_shared[i2] && pierces(s[i], s[i2], t)) return true;
    if (!t_shared[i] && !t_shared[i2] && pierces(t[i], t[i2], s)) return true;
    for (std::size_t j = 0; j < 3; ++j) {
      const std::size_t j2 = (j + 1) % 3;
      const auto same = [&](std::size_t a, std::size_t b) { return s_tri.v[a] == t_tri.v[b]; };
      if (!same(i, j) && !same(i, j2) && !same(i2, j) && !same(i2, j2) &&
          edges_touch(s[i], s[i2], t[j], t[j2], gap))
        return true;
    }
  }
  return false;
}

}  // namespace weft
