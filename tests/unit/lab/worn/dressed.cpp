#include "tests/unit/lab/worn/dressed.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <map>
#include <numbers>
#include <utility>

namespace weft::lab::test {
namespace {

using V = Vec3<double>;

double field(const Capsule& c, const V& x) {
  const V d = c.b - c.a;
  const double t = std::clamp(dot(x - c.a, d) / std::max(dot(d, d), 1e-12), 0.0, 1.0);
  return length(x - c.a - d * t) - (c.ra + (c.rb - c.ra) * t);
}

std::size_t nearest(const std::vector<Capsule>& capsules, const V& x) {
  std::size_t best = 0;
  for (std::size_t k = 1; k < capsules.size(); ++k)
    if (field(capsules[k], x) < field(capsules[best], x)) best = k;
  return best;
}

/// Along a capsule from its first end. [m]
double along(const Capsule& c, const V& x) {
  const V d = c.b - c.a;
  return dot(x - c.a, d) / length(d);
}

/// The part of a mesh where g > 0, with new vertices where g is 0.
Mesh clip(const Mesh& mesh, const std::function<double(const V&)>& g) {
  Mesh out;
  std::vector<double> value;
  for (const V& x : mesh.positions) value.push_back(g(x));
  std::map<std::pair<Index, Index>, Index> cuts;
  std::vector<Index> kept(mesh.positions.size(), -1);
  const auto keep = [&](Index v) {
    Index& k = kept[static_cast<std::size_t>(v)];
    if (k < 0) {
      k = static_cast<Index>(out.positions.size());
      out.positions.push_back(mesh.positions[static_cast<std::size_t>(v)]);
    }
    return k;
  };
  const auto cut = [&](Index a, Index b) {
    const auto [low, high] = std::minmax(a, b);
    const auto found = cuts.find({low, high});
    if (found != cuts.end()) return found->second;
    const auto i = static_cast<std::size_t>(low), j = static_cast<std::size_t>(high);
    const double t = std::clamp(value[i] / (value[i] - value[j]), 0.2, 0.8);
    const auto v = static_cast<Index>(out.positions.size());
    out.positions.push_back(mesh.positions[i] + (mesh.positions[j] - mesh.positions[i]) * t);
    cuts[{low, high}] = v;
    return v;
  };
  for (const Tri& t : mesh.triangles) {
    std::vector<Index> polygon;
    for (int k = 0; k < 3; ++k) {
      const Index a = t.v[k], b = t.v[(k + 1) % 3];
      const bool in = value[static_cast<std::size_t>(a)] > 0;
      if (in) polygon.push_back(keep(a));
      if (in != (value[static_cast<std::size_t>(b)] > 0)) polygon.push_back(cut(a, b));
    }
    for (std::size_t k = 2; k < polygon.size(); ++k)
      out.triangles.push_back({{polygon[0], polygon[k - 1], polygon[k]}});
  }
  return out;
}

V arm_direction(const BodyShape& s, double side) {
  return {side * std::sin(s.arm), 0, -std::cos(s.arm)};
}

bool is_arm(const std::string& name) {
  return name.starts_with("arm");
}
bool is_leg(const std::string& name) {
  return name.starts_with("leg");
}

void turn(std::vector<V>& points, double angle) {
  for (V& x : points)
    x = {std::cos(angle) * x[0] - std::sin(angle) * x[1],
         std::sin(angle) * x[0] + std::cos(angle) * x[1], x[2]};
}

void go(std::vector<V>& points, const V& by) {
  for (V& x : points) x += by;
}

}  // namespace

double between(Rng& rng, double low, double high) {
  // Not std::uniform_real_distribution, whose numbers differ between libraries.
  return low + (high - low) * (static_cast<double>(rng()) / 4294967296.0);
}

BodyShape any_shape(Rng& rng) {
  BodyShape s;
  s.arm = between(rng, 0.5, 1.5);
  s.spread = between(rng, 0.1, 0.25);
  s.girth = between(rng, 0.9, 1.15);
  s.scale = between(rng, 0.75, 1.15);
  return s;
}

std::vector<Capsule> capsules_of(const BodyShape& s) {
  const double g = s.girth;
  std::vector<Capsule> c{{"torso", {0, 0, 0.95}, {0, 0, 1.28}, 0.14 * g, 0.135 * g},
                         {"shoulders", {-0.15, 0, 1.38}, {0.15, 0, 1.38}, 0.065, 0.065},
                         {"neck", {0, 0, 1.38}, {0, 0, 1.53}, 0.055, 0.05},
                         {"head", {0, 0, 1.58}, {0, 0, 1.64}, 0.09, 0.09}};
  for (const double side : {-1.0, 1.0}) {
    const V a{side * 0.17, 0, 1.38}, hip{side * 0.09, 0, 0.9};
    const V foot{side * (0.09 + s.spread), 0, 0.06};
    const std::string tag = side < 0 ? "_r" : "_l";
    c.push_back({"arm" + tag, a, a + arm_direction(s, side) * 0.62, 0.05, 0.035});
    c.push_back({"leg" + tag, hip, foot, 0.08, 0.05});
    c.push_back({"foot" + tag, foot, foot + V{0, 0.1, -0.01}, 0.045, 0.04});
  }
  for (Capsule& k : c) {
    k.a = k.a * s.scale;
    k.b = k.b * s.scale;
    k.ra *= s.scale;
    k.rb *= s.scale;
  }
  return c;
}

Mesh surface_of(const std::vector<Capsule>& capsules, double cell) {
  V low{1e9, 1e9, 1e9}, high{-1e9, -1e9, -1e9};
  for (const Capsule& c : capsules)
    for (const V& x : {c.a, c.b})
      for (int k = 0; k < 3; ++k) {
        low[k] = std::min(low[k], x[k] - std::max(c.ra, c.rb) - 1.3 * cell);
        high[k] = std::max(high[k], x[k] + std::max(c.ra, c.rb) + 2.3 * cell);
      }
  std::array<int, 3> n{};
  for (int k = 0; k < 3; ++k)
    n[static_cast<std::size_t>(k)] = static_cast<int>((high[k] - low[k]) / cell) + 1;
  const auto number = [&](int i, int j, int k) { return (k * n[1] + j) * n[0] + i; };
  const auto place = [&](int i, int j, int k) { return low + V{i * cell, j * cell, k * cell}; };
  std::vector<V> points;
  std::vector<double> value;
  for (int k = 0; k < n[2]; ++k)
    for (int j = 0; j < n[1]; ++j)
      for (int i = 0; i < n[0]; ++i) {
        points.push_back(place(i, j, k));
        double f = 1e9;
        for (const Capsule& c : capsules) f = std::min(f, field(c, points.back()));
        value.push_back(f);
      }
  Mesh mesh;
  std::map<std::pair<Index, Index>, Index> cuts;
  const auto cut = [&](Index a, Index b) {
    const auto [p, q] = std::minmax(a, b);
    const auto found = cuts.find({p, q});
    if (found != cuts.end()) return found->second;
    const auto i = static_cast<std::size_t>(p), j = static_cast<std::size_t>(q);
    const double t = std::clamp(value[i] / (value[i] - value[j]), 0.3, 0.7);
    const auto v = static_cast<Index>(mesh.positions.size());
    mesh.positions.push_back(points[i] + (points[j] - points[i]) * t);
    cuts[{p, q}] = v;
    return v;
  };
  const auto add = [&](Index a, Index b, Index c, const V& outward) {
    const auto x = [&](Index v) { return mesh.positions[static_cast<std::size_t>(v)]; };
    if (dot(cross(x(b) - x(a), x(c) - x(a)), outward) < 0) std::swap(b, c);
    mesh.triangles.push_back({{a, b, c}});
  };
  constexpr int tets[6][4] = {{0, 1, 3, 7}, {0, 3, 2, 7}, {0, 2, 6, 7},
                              {0, 6, 4, 7}, {0, 4, 5, 7}, {0, 5, 1, 7}};
  for (int k = 0; k + 1 < n[2]; ++k)
    for (int j = 0; j + 1 < n[1]; ++j)
      for (int i = 0; i + 1 < n[0]; ++i)
        for (const auto& tet : tets) {
          std::vector<Index> in, out;
          for (const int corner : tet) {
            const Index v = number(i + (corner & 1), j + ((corner >> 1) & 1), k + (corner >> 2));
            (value[static_cast<std::size_t>(v)] < 0 ? in : out).push_back(v);
          }
          if (in.empty() || out.empty()) continue;
          V outward{0, 0, 0};
          for (const Index v : out)
            outward +=
                points[static_cast<std::size_t>(v)] * (1.0 / static_cast<double>(out.size()));
          for (const Index v : in)
            outward -= points[static_cast<std::size_t>(v)] * (1.0 / static_cast<double>(in.size()));
          if (in.size() == 2) {
            const Index a = cut(in[0], out[0]), b = cut(in[0], out[1]), c = cut(in[1], out[1]),
                        d = cut(in[1], out[0]);
            add(a, b, c, outward);
            add(a, c, d, outward);
          } else {
            const bool one = in.size() == 1;
            const Index apex = one ? in[0] : out[0];
            const auto& other = one ? out : in;
            add(cut(apex, other[0]), cut(apex, other[1]), cut(apex, other[2]), outward);
          }
        }
  return mesh;
}

Dressed dress(GarmentKind kind, const BodyShape& shape, bool labelled, Rng& rng) {
  Dressed d;
  d.shape = shape;
  d.kind = kind;
  const std::vector<Capsule> body = capsules_of(shape);
  const double s = shape.scale, cell = 0.04 * s;
  d.body = surface_of(body, cell);
  const double ease = between(rng, 0.018, 0.035) * s;
  std::vector<Capsule> over;
  for (Capsule c : body) {
    const bool upper =
        kind == GarmentKind::shirt || kind == GarmentKind::vest || kind == GarmentKind::dress;
    const bool take = c.name == "torso" || (upper && (c.name == "shoulders" || c.name == "neck")) ||
                      (kind == GarmentKind::shirt && is_arm(c.name)) ||
                      (kind == GarmentKind::trousers && is_leg(c.name));
    if (!take) continue;
    c.ra += c.name == "neck" ? 0.02 * s : ease;
    c.rb += c.name == "neck" ? 0.02 * s : ease;
    if (is_leg(c.name)) c.ra = 0.09 * s, c.rb = 0.085 * s;
    over.push_back(c);
  }
  if (kind == GarmentKind::skirt || kind == GarmentKind::dress || kind == GarmentKind::strapless)
    over.push_back({"skirt",
                    {0, 0, 0.95 * s},
                    {0, 0, 0.4 * s},
                    0.14 * shape.girth * s + ease,
                    between(rng, 0.24, 0.36) * s});
  const double hem =
      (kind == GarmentKind::shirt || kind == GarmentKind::vest ? between(rng, 0.86, 0.97)
                                                               : between(rng, 0.42, 0.7)) *
      s;
  const double waist = between(rng, 1.0, 1.06) * s, top = between(rng, 1.22, 1.28) * s;
  const double sleeve = between(rng, 0.15, 0.5) * s, cuff = between(rng, 0.45, 0.75) * s;
  const double neck = between(rng, 1.46, 1.49) * s;
  d.cloth = surface_of(over, cell);
  const auto where = [&](const V& x) { return over[nearest(over, x)]; };
  if (kind != GarmentKind::trousers)
    d.cloth = clip(d.cloth, [&](const V& x) { return x[2] - hem; });
  if (kind == GarmentKind::trousers || kind == GarmentKind::skirt)
    d.cloth = clip(d.cloth, [&](const V& x) { return waist - x[2]; });
  else if (kind == GarmentKind::strapless)
    d.cloth = clip(d.cloth, [&](const V& x) { return top - x[2]; });
  else
    d.cloth = clip(d.cloth, [&](const V& x) { return neck - x[2]; });
  d.cloth = clip(d.cloth, [&](const V& x) {
    const Capsule c = where(x);
    if (is_arm(c.name)) return sleeve - along(c, x);
    if (is_leg(c.name)) return cuff - along(c, x);
    if (c.name == "shoulders" && kind != GarmentKind::shirt) return 0.165 * s - std::abs(x[0]);
    return 1.0;
  });
  for (const V& x : d.cloth.positions) d.capsule.push_back(where(x).name);
  d.cloth.group_names = labelled ? std::vector<std::string>{"front",    "back",   "sleeve_l",
                                                            "sleeve_r", "pant_l", "pant_r"}
                                 : std::vector<std::string>{"cloth"};
  for (const Tri& t : d.cloth.triangles) {
    V c{0, 0, 0};
    for (const Index v : t.v) c += d.cloth.positions[static_cast<std::size_t>(v)] * (1.0 / 3);
    const std::string name = where(c).name;
    const bool left = c[0] > 0;
    const Index panel = is_arm(name)                    ? (left ? 2 : 3)
                        : kind == GarmentKind::trousers ? (left ? 4 : 5)
                                                        : (c[1] > 0 ? 0 : 1);
    d.cloth.group.push_back(labelled ? panel : 0);
  }
  // The start stands off the body, somewhat higher; the end has wrinkles and has sagged.
  const double off = between(rng, 0.01, 0.06), rise = between(rng, 0, 0.04) * s;
  const double waves = between(rng, 20, 60) / s, depth = between(rng, 0, 0.12) / waves;
  d.cloth_start = d.cloth.positions;
  d.body_start = d.body.positions;
  for (std::size_t v = 0; v < d.cloth.positions.size(); ++v) {
    V& x = d.cloth.positions[v];
    d.cloth_start[v] = {x[0] * (1 + off), x[1] * (1 + off), x[2] + rise};
    x[1] += depth * std::sin(waves * (x[0] + 0.4 * x[2]));
    x[0] += depth * std::sin(waves * (x[1] - 0.6 * x[2]));
  }
  return d;
}

Dressed good_fit(int number, Rng& rng) {
  const auto kind = static_cast<GarmentKind>(number % garment_kinds);
  const BodyShape shape = any_shape(rng);
  const bool labelled = rng() % 2 == 0;
  Dressed d = dress(kind, shape, labelled, rng);
  d.with_start = rng() % 4 != 0;
  if (rng() % 3 == 0) {  // the body walks on, and turns
    const double angle = between(rng, -2, 2);
    const V by{between(rng, -1, 1), between(rng, -1, 1), between(rng, 0, 0.2)};
    turn(d.body.positions, angle);
    turn(d.cloth.positions, angle);
    go(d.body.positions, by);
    go(d.cloth.positions, by);
  }
  return d;
}

std::string plant_fault(int number, Dressed& d, Rng& rng) {
  std::vector<V>& x = d.cloth.positions;
  const double s = d.shape.scale;
  const double side = rng() % 2 == 0 ? 1 : -1;
  switch (number % fault_kinds) {
    case 0: {
      const double by = between(rng, 0.2, 0.35) * s;
      go(x, {0, 0, -by});
      return "has slid down";
    }
    case 1: {
      const V shoulder{side * 0.17 * s, 0, 1.38 * s};
      const V to{0, between(rng, 0.8, 1) * (rng() % 2 == 0 ? 1 : -1), between(rng, -0.6, -0.3)};
      const V from = arm_direction(d.shape, side), unit = to * (1 / length(to));
      for (std::size_t v = 0; v < x.size(); ++v) {
        if (!is_arm(d.capsule[v]) || side * x[v][0] < 0) continue;
        const double t = dot(x[v] - shoulder, from);
        const V off = x[v] - shoulder - from * t;
        x[v] = shoulder + unit * t + off + unit * (0.1 * s);
      }
      return "a sleeve is not on its arm";
    }
    case 2:
      for (std::size_t v = 0; v < x.size(); ++v) {
        if (!is_leg(d.capsule[v])) continue;
        const double depth = std::clamp((0.8 * s - x[v][2]) / (0.25 * s), 0.0, 1.0);
        const double own = x[v][0] > 0 ? 1 : -1;
        const double centre = own * (0.09 * s + d.shape.spread * (0.9 * s - x[v][2]) / 0.84);
        if (own == side) {
          const double wide = 1 + depth * (2 * std::abs(centre) / (0.09 * s) + 0.3);
          x[v][0] = centre * (1 - depth) + (x[v][0] - centre) * wide;
          x[v][1] *= 1 + 0.3 * depth;
        } else {
          x[v][0] += depth * own * 0.4 * s;
        }
      }
      return "both legs are in one trouser leg";
    case 3: {
      double low = 1e9;
      for (V& p : x) {
        p[2] = (0.03 + 0.15 * p[2]);
        low = std::min(low, p[2]);
      }
      go(x, {0, 0, 0.02 - low});
      return "has fallen to the floor";
    }
    case 4:
      for (std::size_t v = 0; v < x.size(); ++v) x[v][0] = -x[v][0];
      return "is inside out";
    case 5:
      go(x, {side * between(rng, 0.5, 1.5), between(rng, 0.6, 1.2), between(rng, -0.2, 0.1)});
      return "lies beside the body";
    case 6: {
      const double by = between(rng, 1.4, 1.9);
      double high = 0;
      for (const V& p : x) high = std::max(high, p[2]);
      for (V& p : x) p[2] = high - (high - p[2]) * by;
      return "is overstretched";
    }
    case 7: {
      const double by = side * between(rng, 1.4, 2.6);
      turn(x, by);
      return "has turned about the body";
    }
    case 8: {
      double low = 1e9, high = 0;
      for (const V& p : x) {
        low = std::min(low, p[2]);
        high = std::max(high, p[2]);
      }
      const double by = side * between(rng, 1.6, 3);
      for (V& p : x) {
        const double a = by * (high - p[2]) / (high - low);
        p = {std::cos(a) * p[0] - std::sin(a) * p[1], std::sin(a) * p[0] + std::cos(a) * p[1],
             p[2]};
      }
      return "is twisted between waist and hem";
    }
    case 9: {
      const double by = between(rng, 0.2, 0.3) * s;
      for (V& p : x) p[2] += by;
      return "has ridden up";
    }
    case 10: {
      const double by = between(rng, 0.22, 0.3) * s;
      for (V& p : x) {
        const double t = std::clamp((side * p[0] + 0.02 * s) / (0.08 * s), 0.0, 1.0);
        p[2] -= t * by;
        p[0] += side * t * 0.15 * s;
      }
      return "has slipped off one shoulder";
    }
    default:
      for (V& p : x) p[2] -= between(rng, 0.33, 0.34) * s;
      return "hangs at the knees";
  }
}

Dressed bad_fit(int number, Rng& rng, std::string& what) {
  using K = GarmentKind;
  const std::vector<std::vector<K>> kinds{
      {K::vest, K::strapless, K::skirt, K::dress},
      {K::shirt},
      {K::trousers},
      {K::skirt, K::strapless},
      {K::skirt, K::dress, K::strapless},
      {K::shirt, K::vest, K::trousers, K::skirt, K::dress, K::strapless},
      {K::skirt, K::vest, K::trousers, K::dress},
      {K::skirt, K::strapless},
      {K::skirt, K::strapless},
      {K::skirt, K::strapless},
      {K::vest, K::dress},
      {K::trousers, K::skirt}};
  const auto& list = kinds[static_cast<std::size_t>(number % fault_kinds)];
  const BodyShape shape = any_shape(rng);
  const K kind = list[rng() % list.size()];
  const bool labelled = rng() % 2 == 0;
  Dressed d = dress(kind, shape, labelled, rng);
  what = plant_fault(number, d, rng);
  return d;
}

}  // namespace weft::lab::test
