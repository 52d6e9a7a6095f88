#include "tests/unit/lab/worn/level_surface.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <unordered_map>

#include "weft/core/at.hpp"

namespace weft::lab::test {
namespace {

std::uint64_t key(std::uint32_t a, std::uint32_t b) {
  return a < b ? (std::uint64_t{a} << 32) | b : (std::uint64_t{b} << 32) | a;
}

std::uint64_t key(Index a, Index b) {
  return key(static_cast<std::uint32_t>(a), static_cast<std::uint32_t>(b));
}

// The corners of a cube are numbered by bits; each tetrahedron is a path from corner 0 to 7.
constexpr std::array<std::array<int, 4>, 6> tetrahedra{
    {{0, 1, 3, 7}, {0, 1, 5, 7}, {0, 2, 3, 7}, {0, 2, 6, 7}, {0, 4, 5, 7}, {0, 4, 6, 7}}};

Point onto(const SmoothField& field, Point p, double step) {
  Point g{0, 0, 1};
  const double value = field(p, &g);
  const double square = length_sq(g);
  if (square < 1e-4) return p;
  return p - std::clamp(value / square, -step, step) * g;
}

}  // namespace

LevelSurface polygonised(const SmoothField& field, Point low, Point high, double size,
                         const Frame& lattice) {
  const Point middle = 0.5 * (low + high), half = 0.5 * (high - low);
  std::array<int, 3> n{};
  for (int d = 0; d < 3; ++d) {
    const Point axis = d == 0 ? lattice.x : d == 1 ? lattice.y : lattice.z;
    const double reach =
        std::abs(axis[0]) * half[0] + std::abs(axis[1]) * half[1] + std::abs(axis[2]) * half[2];
    n[static_cast<std::size_t>(d)] = 2 * static_cast<int>(std::ceil(reach / size)) + 5;
  }
  const auto number = [&](int i, int j, int k) {
    return static_cast<std::uint32_t>(i + n[0] * (j + n[1] * k));
  };
  // Fields change by about the distance at most, so that whole blocks of cubes are far from 0.
  constexpr int block = 4;
  std::vector<Point> node;
  for (int k = 0; k < n[2]; ++k)
    for (int j = 0; j < n[1]; ++j)
      for (int i = 0; i < n[0]; ++i)
        node.push_back(middle +
                       lattice.vector({(i - 0.5 * (n[0] - 1)) * size, (j - 0.5 * (n[1] - 1)) * size,
                                       (k - 0.5 * (n[2] - 1)) * size}));
  constexpr double unknown = 1e9;
  std::vector<double> value(node.size(), unknown);
  std::vector<std::array<int, 3>> cubes;
  for (int k = 0; k + 1 < n[2]; k += block)
    for (int j = 0; j + 1 < n[1]; j += block)
      for (int i = 0; i + 1 < n[0]; i += block) {
        const Point half_block = (0.5 * block * size) * (lattice.x + lattice.y + lattice.z);
        const double reach = 1.3 * std::sqrt(3.0) * 0.5 * block * size;
        if (std::abs(field(node[number(i, j, k)] + half_block, nullptr)) > reach) continue;
        for (int c = 0; c < block * block * block; ++c) {
          const std::array<int, 3> cube{i + c % block, j + c / block % block,
                                        k + c / (block * block)};
          if (cube[0] + 1 >= n[0] || cube[1] + 1 >= n[1] || cube[2] + 1 >= n[2]) continue;
          cubes.push_back(cube);
          for (int corner = 0; corner < 8; ++corner) {
            const std::uint32_t v = number(cube[0] + (corner & 1), cube[1] + (corner >> 1 & 1),
                                           cube[2] + (corner >> 2));
            if (value[v] == unknown) value[v] = field(node[v], nullptr);
          }
        }
      }
  LevelSurface s;
  std::unordered_map<std::uint64_t, Index> crossing;
  const auto vertex = [&](std::uint32_t a, std::uint32_t b) {
    const auto [place, added] = crossing.try_emplace(key(a, b), 0);
    if (added) {
      place->second = static_cast<Index>(s.positions.size());
      const double t = std::clamp(value[a] / (value[a] - value[b]), 0.02, 0.98);
      s.positions.push_back(node[a] + t * (node[b] - node[a]));
    }
    return place->second;
  };
  const auto add = [&](Index a, Index b, Index c, Point outward) {
    const Point pa = s.positions[at(a)];
    const Point normal = cross(s.positions[at(b)] - pa, s.positions[at(c)] - pa);
    if (dot(normal, outward) < 0) std::swap(b, c);
    s.triangles.push_back({{a, b, c}});
  };
  for (const auto& [i, j, k] : cubes) {
    std::array<std::uint32_t, 8> corner{};
    int inside_corners = 0;
    for (int c = 0; c < 8; ++c) {
      const std::uint32_t v = number(i + (c & 1), j + (c >> 1 & 1), k + (c >> 2));
      corner[static_cast<std::size_t>(c)] = v;
      inside_corners += value[v] < 0;
    }
    if (inside_corners == 0 || inside_corners == 8) continue;
    for (const auto& tetrahedron : tetrahedra) {
      std::array<std::uint32_t, 4> in{}, out{};
      std::size_t ins = 0, outs = 0;
      Point sum_in{0, 0, 0}, sum_out{0, 0, 0};
      for (const int c : tetrahedron) {
        const std::uint32_t v = corner[static_cast<std::size_t>(c)];
        const bool inside = value[v] < 0;
        (inside ? in[ins++] : out[outs++]) = v;
        (inside ? sum_in : sum_out) += node[v];
      }
      if (ins == 0 || outs == 0) continue;
      const Point outward =
          (1.0 / static_cast<double>(outs)) * sum_out - (1.0 / static_cast<double>(ins)) * sum_in;
      if (ins == 2) {
        const Index a = vertex(in[0], out[0]), b = vertex(in[0], out[1]);
        const Index c = vertex(in[1], out[1]), d = vertex(in[1], out[0]);
        add(a, b, c, outward);
        add(a, c, d, outward);
      } else {
        const auto& one = ins == 1 ? in : out;
        const auto& three = ins == 1 ? out : in;
        add(vertex(one[0], three[0]), vertex(one[0], three[1]), vertex(one[0], three[2]), outward);
      }
    }
  }
  s.sides.assign(s.triangles.size(), 0);
  return s;
}

void even_out(LevelSurface& surface, const SmoothField& field, int rounds, double jitter,
              Draw& draw) {
  const MeshEdges all = edges_of(surface.triangles);
  std::vector<double> degree(surface.positions.size());
  for (const Edge& e : all.edges)
    for (const Index v : e.v) degree[at(v)] += 1;
  for (int round = 0; round < rounds; ++round) {
    std::vector<Point> sum(surface.positions.size(), Point{0, 0, 0});
    for (const Edge& e : all.edges)
      for (int c = 0; c < 2; ++c) sum[at(e.v[c])] += surface.positions[at(e.v[1 - c])];
    for (std::size_t v = 0; v < sum.size(); ++v) {
      Point& p = surface.positions[v];
      const Point to_middle = (1 / degree[v]) * sum[v] - p;
      p += 0.6 * to_middle;
      if (round + 1 == rounds && jitter > 0) {
        const double size = jitter * length(surface.positions[at(all.edges[0].v[0])] -
                                            surface.positions[at(all.edges[0].v[1])]);
        const double around = std::min(size, 0.006);
        p += Point{draw.between(-around, around), draw.between(-around, around),
                   draw.between(-around, around)};
      }
      p = onto(field, p, 0.02);
    }
  }
  for (Point& p : surface.positions) p = onto(field, p, 0.02);
}

void LevelSurface::cut(const Field& field, int bit) {
  std::vector<double> g;
  g.reserve(positions.size());
  for (const Point& p : positions) g.push_back(field(p));
  // Vertices close to the cut move onto it.
  for (const Edge& e : edges_of(triangles).edges) {
    const std::size_t a = at(e.v[0]), b = at(e.v[1]);
    if (!(g[a] * g[b] < 0)) continue;
    const double t = g[a] / (g[a] - g[b]);
    if (t < 0.3) {
      positions[a] += t * (positions[b] - positions[a]);
      g[a] = 0;
    } else if (t > 0.7) {
      positions[b] += (1 - t) * (positions[a] - positions[b]);
      g[b] = 0;
    }
  }
  std::unordered_map<std::uint64_t, Index> crossing;
  const auto vertex = [&](Index a, Index b) {
    const auto [place, added] = crossing.try_emplace(key(a, b), 0);
    if (added) {
      place->second = static_cast<Index>(positions.size());
      const double t = g[at(a)] / (g[at(a)] - g[at(b)]);
      positions.push_back(positions[at(a)] + t * (positions[at(b)] - positions[at(a)]));
    }
    return place->second;
  };
  std::vector<Tri> new_triangles;
  std::vector<unsigned> new_sides;
  const auto add = [&](Index a, Index b, Index c, unsigned side, bool positive) {
    new_triangles.push_back({{a, b, c}});
    new_sides.push_back(positive ? side | (1u << bit) : side);
  };
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    const auto& v = triangles[t].v;
    const unsigned side = sides[t];
    const auto crosses = [&](int c) { return g[at(v[c])] * g[at(v[(c + 1) % 3])] < 0; };
    const int crossings = crosses(0) + crosses(1) + crosses(2);
    if (crossings == 0) {
      add(v[0], v[1], v[2], side, g[at(v[0])] + g[at(v[1])] + g[at(v[2])] > 0);
    } else if (crossings == 1) {
      const int c = crosses(0) ? 0 : crosses(1) ? 1 : 2;
      const Index a = v[c], b = v[(c + 1) % 3], o = v[(c + 2) % 3], m = vertex(a, b);
      add(a, m, o, side, g[at(a)] > 0);
      add(m, b, o, side, g[at(b)] > 0);
    } else {
      const int c = !crosses(0) ? 2 : !crosses(1) ? 0 : 1;  // the corner alone on its side
      const Index a = v[c], b = v[(c + 1) % 3], o = v[(c + 2) % 3];
      const Index mb = vertex(a, b), mo = vertex(a, o);
      add(a, mb, mo, side, g[at(a)] > 0);
      add(mb, b, o, side, g[at(b)] > 0);
      add(mb, o, mo, side, g[at(b)] > 0);
    }
  }
  triangles = std::move(new_triangles);
  sides = std::move(new_sides);
}

void LevelSurface::remove(unsigned bits) {
  std::vector<Index> root(positions.size());
  std::iota(root.begin(), root.end(), 0);
  const auto find = [&](Index v) {
    while (root[at(v)] != v) v = root[at(v)] = root[at(root[at(v)])];
    return v;
  };
  std::vector<int> count(positions.size());
  for (std::size_t t = 0; t < triangles.size(); ++t)
    if (!(sides[t] & bits))
      for (int c = 1; c < 3; ++c) root[at(find(triangles[t].v[c]))] = find(triangles[t].v[0]);
  for (std::size_t t = 0; t < triangles.size(); ++t)
    if (!(sides[t] & bits)) ++count[at(find(triangles[t].v[0]))];
  const Index largest =
      static_cast<Index>(std::max_element(count.begin(), count.end()) - count.begin());
  std::vector<Index> number(positions.size(), -1);
  std::vector<Point> kept;
  std::vector<Tri> new_triangles;
  std::vector<unsigned> new_sides;
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    if ((sides[t] & bits) || find(triangles[t].v[0]) != largest) continue;
    Tri tri = triangles[t];
    for (Index& v : tri.v) {
      if (number[at(v)] < 0) {
        number[at(v)] = static_cast<Index>(kept.size());
        kept.push_back(positions[at(v)]);
      }
      v = number[at(v)];
    }
    new_triangles.push_back(tri);
    new_sides.push_back(sides[t]);
  }
  positions = std::move(kept);
  triangles = std::move(new_triangles);
  sides = std::move(new_sides);
}

MeshEdges edges_of(const std::vector<Tri>& triangles) {
  std::unordered_map<std::uint64_t, std::size_t> number;
  MeshEdges all;
  for (const Tri& t : triangles)
    for (int c = 0; c < 3; ++c) {
      const Index a = t.v[c], b = t.v[(c + 1) % 3];
      const auto [place, added] = number.try_emplace(key(a, b), all.edges.size());
      if (added) {
        all.edges.push_back({{std::min(a, b), std::max(a, b)}});
        all.triangles.push_back(0);
      }
      ++all.triangles[place->second];
    }
  return all;
}

}  // namespace weft::lab::test
