#include "host/io/pattern/start_shape.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <limits>
#include <map>
#include <numeric>
#include <optional>

#include "host/geometry/aabb.hpp"
#include "host/geometry/box_tree.hpp"
#include "weft/core/at.hpp"

namespace weft::io {
namespace {

constexpr int sweeps_max = 200;
constexpr int sweeps_per_check = 5;  ///< of the distance to the body, and of the stretch
constexpr double stretch_wanted = 1.5;
constexpr double gap = 0.004;   // m, from the body
constexpr double reach = 0.05;  // m, how deep within the body a vertex may be to be found

/// The point of a triangle that is nearest to p.
Vec3<double> nearest_point(const Vec3<double>& p, const Vec3<double>& a, const Vec3<double>& b,
                           const Vec3<double>& c) {
  const auto on_edge = [&](const Vec3<double>& from, const Vec3<double>& to) {
    const Vec3<double> side = to - from;
    const double square = dot(side, side);
    const double share = square > 0 ? std::clamp(dot(p - from, side) / square, 0.0, 1.0) : 0;
    return from + side * share;
  };
  const Vec3<double> normal = cross(b - a, c - a);
  const double square = dot(normal, normal);
  if (square > 0 && dot(cross(b - a, p - a), normal) >= 0 &&
      dot(cross(c - b, p - b), normal) >= 0 && dot(cross(a - c, p - c), normal) >= 0)
    return p - normal * (dot(p - a, normal) / square);
  Vec3<double> best = on_edge(a, b);
  for (const Vec3<double>& q : {on_edge(b, c), on_edge(c, a)})
    if (length(p - q) < length(p - best)) best = q;
  return best;
}

/// A body that keeps points out.
class Body {
 public:
  explicit Body(const Mesh& mesh) : mesh_(mesh) {
    if (mesh.triangles.empty()) return;
    tree_.emplace(points(), triangles(), Index{0}, static_cast<Index>(mesh.triangles.size()), 0.0);
    // Normals of edges and vertices, weighted by area: the sign at a ridge is that of the surface.
    normals_.assign(mesh.positions.size(), Vec3<double>{0, 0, 0});
    for (const Tri& t : mesh.triangles) {
      const Vec3<double> normal = cross(corner(t, 1) - corner(t, 0), corner(t, 2) - corner(t, 0));
      for (const Index v : t.v) normals_[at(v)] += normal;
    }
  }

  /// Moves a point that is inside, or nearer than `gap`, to the outside.
  void push_out(Vec3<double>& p) const {
    if (!tree_) return;
    const Vec3<double> margin{reach, reach, reach};
    double best = reach;
    Vec3<double> nearest{};
    Vec3<double> normal{};
    auto visit = [&](Index number) {
      const Tri& t = mesh_.triangles[at(number)];
      const Vec3<double> q = nearest_point(p, corner(t, 0), corner(t, 1), corner(t, 2));
      if (!(length(p - q) < best)) return;
      best = length(p - q);
      nearest = q;
      normal = cross(corner(t, 1) - corner(t, 0), corner(t, 2) - corner(t, 0));
      const double area = length(normal);
      normal = {0, 0, 0};
      if (!(area > 0)) return;
      // Between the corners' normals, by the areas opposite to them.
      for (int k = 0; k < 3; ++k) {
        const Vec3<double> opposite = cross(corner(t, (k + 1) % 3) - q, corner(t, (k + 2) % 3) - q);
        const Vec3<double>& n = normals_[at(t.v[k])];
        const double size = length(n);
        if (size > 0) normal += n * (length(opposite) / (area * size));
      }
    };
    visit_overlaps(*tree_, 1, Aabb{p - margin, p + margin}, visit);
    const double size = length(normal);
    if (!(best < reach) || !(size > 0)) return;
    normal *= 1 / size;
    if (dot(p - nearest, normal) < gap) p = nearest + normal * gap;
  }

 private:
  Span<const Vec3<double>> points() const {
    return {mesh_.positions.data(), mesh_.positions.size()};
  }
  Span<const Tri> triangles() const { return {mesh_.triangles.data(), mesh_.triangles.size()}; }
  const Vec3<double>& corner(const Tri& t, int k) const { return mesh_.positions[at(t.v[k])]; }

  const Mesh& mesh_;
  std::optional<BoxTree> tree_;
  std::vector<Vec3<double>> normals_;
};

/// An edge of the sewn garment.
struct Thread {
  std::array<Index, 2> ends;
  double rest;  ///< [m] at most: edges of different lengths may become one
};

double rest_length(const Mesh& mesh, Index a, Index b) {
  return length(mesh.material[at(a)] - mesh.material[at(b)]);
}

/// The lowest of the vertices that become one.
std::vector<Index> sewn_vertices(const Garment& garment) {
  std::vector<Index> same(garment.mesh.positions.size());
  std::iota(same.begin(), same.end(), Index{0});
  const auto find = [&](Index i) {
    while (same[at(i)] != i) i = same[at(i)] = same[at(same[at(i)])];
    return i;
  };
  for (const GarmentSeam& seam : garment.seams)
    for (const auto& [a, b] : seam.pairs) {
      const auto [low, high] = std::minmax({find(a), find(b)});
      same[at(high)] = low;
    }
  for (std::size_t v = 0; v < same.size(); ++v) same[v] = find(static_cast<Index>(v));
  return same;
}

std::vector<Thread> sewn_edges(const Mesh& mesh, const std::vector<Index>& same) {
  std::map<std::array<Index, 2>, double> lengths;
  for (const Tri& t : mesh.triangles)
    for (int k = 0; k < 3; ++k) {
      const Index a = t.v[k], b = t.v[(k + 1) % 3];
      const auto [low, high] = std::minmax({same[at(a)], same[at(b)]});
      double& rest = lengths[{low, high}];
      rest = std::max(rest, rest_length(mesh, a, b));
    }
  std::vector<Thread> threads;
  for (const auto& [ends, rest] : lengths)
    if (ends[0] != ends[1]) threads.push_back({ends, rest});
  return threads;
}

}  // namespace

void relax_start(Garment& garment, const Mesh& body_mesh) {
  std::vector<Vec3<double>>& x = garment.mesh.positions;
  const std::vector<Index> same = sewn_vertices(garment);
  std::vector<Vec3<double>> mean(x.size(), Vec3<double>{0, 0, 0});
  std::vector<int> count(x.size(), 0);
  for (std::size_t v = 0; v < x.size(); ++v) {
    mean[at(same[v])] += x[v];
    ++count[at(same[v])];
  }
  for (std::size_t v = 0; v < x.size(); ++v)
    if (count[v] > 0) x[v] = mean[v] * (1.0 / count[v]);

  const Body body(body_mesh);
  std::vector<Thread> threads = sewn_edges(garment.mesh, same);
  const auto push_out = [&] {
    for (std::size_t v = 0; v < x.size(); ++v)
      if (count[v] > 0) body.push_out(x[v]);
  };
  for (int sweep = 0; sweep < sweeps_max; ++sweep) {
    double largest = 0;
    for (const Thread& thread : threads) {
      Vec3<double>&a = x[at(thread.ends[0])], &b = x[at(thread.ends[1])];
      const Vec3<double> along = b - a;
      const double now = length(along);
      largest = std::max(largest, now / thread.rest);
      if (!(now > 0)) continue;
      // Compressed cloth would rather fold, but a fold is hard to undo.
      const double share = now > thread.rest ? 0.5 : 0.25;
      const Vec3<double> step = along * (share * (now - thread.rest) / now);
      a += step;
      b -= step;
    }
    // Back and forth, so that no direction is preferred.
    std::reverse(threads.begin(), threads.end());
    if (sweep % sweeps_per_check == sweeps_per_check - 1) {
      push_out();
      if (largest < stretch_wanted) break;
    }
  }
  push_out();
  for (std::size_t v = 0; v < x.size(); ++v) x[v] = x[at(same[v])];
}

double largest_stretch(const Garment& garment) {
  double largest = 0;
  const Mesh& mesh = garment.mesh;
  for (const Tri& t : mesh.triangles)
    for (int k = 0; k < 3; ++k) {
      const Index a = t.v[k], b = t.v[(k + 1) % 3];
      largest = std::max(
          largest, length(mesh.positions[at(a)] - mesh.positions[at(b)]) / rest_length(mesh, a, b));
    }
  return largest;
}

}  // namespace weft::io
