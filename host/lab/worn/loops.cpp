#include "host/lab/worn/loops.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <numeric>
#include <utility>

#include "weft/core/at.hpp"

namespace weft::lab {
namespace {

struct Side {
  Index a, b, triangle;
  int corner;
};

/// The root of a vertex, with paths made shorter.
Index find(std::vector<Index>& root, Index v) {
  while (root[at(v)] != v) v = root[at(v)] = root[at(root[at(v)])];
  return v;
}

double volume(const Vec3<double>& a, const Vec3<double>& b, const Vec3<double>& c,
              const Vec3<double>& d) {
  return dot(cross(b - a, c - a), d - a);
}

/// +1, -1: the segment p q passes through the triangle along, or against, its normal; 0: it passes
/// beside it.
int passage(const Vec3<double>& p, const Vec3<double>& q, const Vec3<double>& a,
            const Vec3<double>& b, const Vec3<double>& c) {
  const bool from = volume(a, b, c, p) > 0, to = volume(a, b, c, q) > 0;
  if (from == to) return 0;
  // Signs count zero as negative throughout, so that a passage through a side counts once.
  const bool s = volume(p, q, a, b) > 0, t = volume(p, q, b, c) > 0, u = volume(p, q, c, a) > 0;
  return s == t && t == u ? (to ? 1 : -1) : 0;
}

}  // namespace

Welded weld(const Mesh& mesh, bool sewn) {
  Welded result;
  const std::size_t count = mesh.positions.size();
  result.vertex.resize(count);
  std::iota(result.vertex.begin(), result.vertex.end(), 0);
  if (sewn) {
    std::vector<Index> order(result.vertex);
    const auto key = [&](Index v) {
      const Vec3<double>& x = mesh.positions[at(v)];
      return std::array{x[0], x[1], x[2]};
    };
    std::sort(order.begin(), order.end(),
              [&](Index a, Index b) { return std::pair(key(a), a) < std::pair(key(b), b); });
    for (std::size_t k = 1; k < count; ++k)
      if (key(order[k]) == key(order[k - 1]))
        result.vertex[at(order[k])] = result.vertex[at(order[k - 1])];
  }
  std::vector<Index> root(count);
  std::iota(root.begin(), root.end(), 0);
  std::vector<Side> sides;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    for (int k = 0; k < 3; ++k) {
      const Index a = result.vertex[at(mesh.triangles[t].v[k])];
      const Index b = result.vertex[at(mesh.triangles[t].v[(k + 1) % 3])];
      root[at(find(root, a))] = find(root, b);
      sides.push_back({a, b, static_cast<Index>(t), k});
    }
  std::vector<Index> number(count, -1);
  for (const Tri& t : mesh.triangles) {
    Index& own = number[at(find(root, result.vertex[at(t.v[0])]))];
    if (own < 0) own = result.components++;
    result.component.push_back(own);
  }
  // Sides without a partner bound the cloth; the next one begins where one ends. Where one edge is
  // sewn to two others, as the waistband of a wrap skirt, three sheets meet. Two of them go on
  // through the seam; the third ends there, so that one side of the two that run alike is free.
  std::sort(sides.begin(), sides.end(), [](const Side& x, const Side& y) {
    return std::pair(std::minmax(x.a, x.b), x.triangle) <
           std::pair(std::minmax(y.a, y.b), y.triangle);
  });
  std::vector<Side> free;
  for (std::size_t s = 0; s < sides.size();) {
    std::size_t end = s + 1;
    while (end < sides.size() &&
           std::minmax(sides[s].a, sides[s].b) == std::minmax(sides[end].a, sides[end].b))
      ++end;
    if ((end - s) % 2 == 1) {
      const auto first = sides.begin() + static_cast<std::ptrdiff_t>(s);
      const auto ahead = std::partition(first, sides.begin() + static_cast<std::ptrdiff_t>(end),
                                        [](const Side& side) { return side.a < side.b; });
      const bool most = 2 * (ahead - first) > static_cast<std::ptrdiff_t>(end - s);
      free.push_back(most ? *first : *ahead);
    }
    s = end;
  }
  std::sort(free.begin(), free.end(),
            [](const Side& x, const Side& y) { return std::pair(x.a, x.b) < std::pair(y.a, y.b); });
  std::vector<char> used(free.size(), 0);
  for (std::size_t f = 0; f < free.size(); ++f) {
    if (used[f] != 0) continue;
    std::vector<Index> loop, triangles;
    std::size_t k = f;
    while (used[k] == 0) {
      used[k] = 1;
      loop.push_back(mesh.triangles[at(free[k].triangle)].v[free[k].corner]);
      triangles.push_back(free[k].triangle);
      auto next = std::lower_bound(free.begin(), free.end(), free[k].b,
                                   [](const Side& side, Index a) { return side.a < a; });
      while (next != free.end() && next->a == free[k].b &&
             used[static_cast<std::size_t>(next - free.begin())] != 0)
        ++next;
      if (next == free.end() || next->a != free[k].b) break;
      k = static_cast<std::size_t>(next - free.begin());
    }
    if (loop.size() < 3) continue;
    result.loop_component.push_back(result.component[at(triangles.front())]);
    result.loops.push_back(std::move(loop));
    result.loop_triangles.push_back(std::move(triangles));
  }
  return result;
}

Linking link(const std::vector<Vec3<double>>& curve, const BodyLines& lines) {
  Linking result;
  Vec3<double> centre{0, 0, 0};
  for (const Vec3<double>& x : curve) centre += x * (1.0 / static_cast<double>(curve.size()));
  for (std::size_t p = 0; p < body_part_count; ++p) {
    const std::vector<Vec3<double>>& line = lines.line[p];
    double along = 0;
    for (std::size_t s = 1; s < line.size(); ++s) {
      int turns = 0;
      for (std::size_t k = 0; k < curve.size(); ++k)
        turns += passage(line[s - 1], line[s], centre, curve[k], curve[(k + 1) % curve.size()]);
      if (p == 0 && turns != 0 && result.turns[0] == 0) result.trunk_at = along;
      result.turns[p] += turns;
      along += length(line[s] - line[s - 1]);
    }
  }
  // Around both legs is around the trunk that they hang from; the sense of the curve is free.
  auto& t = result.turns;
  if (t[0] == 0 && t[3] != 0 && t[3] == t[4]) {
    t[0] = t[3];
    t[3] = t[4] = 0;
    for (std::size_t s = 1; s < lines.line[0].size(); ++s)
      result.trunk_at += length(lines.line[0][s] - lines.line[0][s - 1]);
  }
  const auto first = std::find_if(t.begin(), t.end(), [](int n) { return n != 0; });
  if (first != t.end() && *first < 0)
    for (int& n : t) n = -n;
  return result;
}

LinePlace place_at(const Vec3<double>& x, const BodyLines& lines, BodyPart part) {
  const std::vector<Vec3<double>>& line = lines.line[static_cast<std::size_t>(part)];
  const std::vector<Vec3<double>>& directions = lines.ahead[static_cast<std::size_t>(part)];
  LinePlace best;
  best.distance = std::numeric_limits<double>::infinity();
  Vec3<double> tangent{0, 0, 1}, from{1, 0, 0};
  double along = 0;
  for (std::size_t s = 1; s < line.size(); ++s) {
    const Vec3<double> d = line[s] - line[s - 1];
    const double size = length(d);
    if (!(size > 0)) continue;
    // The first and last piece go on beyond their ends: what has left a limb is beyond its tip.
    const double low = s == 1 ? -4 * size : 0;
    const double high = s + 1 == line.size() ? 40 * size : size;
    const double t = std::clamp(dot(x - line[s - 1], d) / size, low, high);
    const Vec3<double> away = x - line[s - 1] - d * (t / size);
    if (length(away) < best.distance) {
      best.distance = length(away);
      best.along = along + t;
      best.away = away;
      tangent = d * (1 / size);
      const double share = std::clamp(t / size, 0.0, 1.0);
      from = directions[s - 1] * (1 - share) + directions[s] * share;
    }
    along += size;
  }
  const Vec3<double> ahead = from - tangent * dot(from, tangent);
  const Vec3<double> side = cross(tangent, ahead);
  best.angle = std::atan2(dot(best.away, side), dot(best.away, ahead));
  return best;
}

}  // namespace weft::lab
