#include "host/time_parallel/material_map.hpp"

#include "weft/core/at.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

namespace weft {
namespace {

using Point = Vec2<double>;

/// Points this close to a triangle, as a share of its size, are in it.
constexpr double touching = 1e-9;

const Tri& corners_of(const Mesh& mesh, std::size_t t) {
  return mesh.material_triangles.empty() ? mesh.triangles[t] : mesh.material_triangles[t];
}

double cross2(const Point& a, const Point& b) {
  return a[0] * b[1] - a[1] * b[0];
}

/// One material point of each vertex: that of the first triangle that has the vertex.
std::vector<Point> points_of(const Mesh& mesh) {
  if (mesh.material_triangles.empty()) return mesh.material;
  std::vector<Point> points(mesh.positions.size());
  for (std::size_t t = mesh.triangles.size(); t-- > 0;)
    for (int k = 0; k < 3; ++k)
      points[at(mesh.triangles[t].v[k])] = mesh.material[at(mesh.material_triangles[t].v[k])];
  return points;
}

/// Triangles of a mesh in material space, by the cells of a grid that their boxes meet.
class Bins {
 public:
  explicit Bins(const Mesh& mesh) : mesh_(mesh) {
    low_ = high_ = mesh.material.front();
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
      for (const Index u : corners_of(mesh, t).v)
        for (int c = 0; c < 2; ++c) {
          low_[c] = std::min(low_[c], mesh.material[at(u)][c]);
          high_[c] = std::max(high_[c], mesh.material[at(u)][c]);
        }
    const Point size = high_ - low_;
    const double area = std::max(size[0] * size[1], 1e-300);
    cell_ = std::max(std::sqrt(area / static_cast<double>(mesh.triangles.size())),
                     std::max(size[0], size[1]) / cells_max);
    for (int c = 0; c < 2; ++c)
      count_[c] = std::max(1, static_cast<int>(std::ceil(size[c] / cell_)));
    bins_.resize(static_cast<std::size_t>(count_[0]) * static_cast<std::size_t>(count_[1]));
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) add(t);
  }

  /// Calls visit(triangle) for those in cells at most `ring` cells away from the point's.
  template <class Visit>
  void visit(const Point& x, int ring, Visit use) const {
    const int i = cell_of(x, 0);
    const int j = cell_of(x, 1);
    for (int b = std::max(0, j - ring); b <= std::min(count_[1] - 1, j + ring); ++b)
      for (int a = std::max(0, i - ring); a <= std::min(count_[0] - 1, i + ring); ++a)
        for (const std::size_t t : bin(a, b)) use(t);
  }
  int rings() const { return std::max(count_[0], count_[1]); }

 private:
  static constexpr double cells_max = 2048;

  int cell_of(const Point& x, int axis) const {
    const double place = std::floor((x[axis] - low_[axis]) / cell_);
    return static_cast<int>(std::clamp(place, 0.0, static_cast<double>(count_[axis] - 1)));
  }
  const std::vector<std::size_t>& bin(int a, int b) const {
    return bins_[static_cast<std::size_t>(b) * static_cast<std::size_t>(count_[0]) +
                 static_cast<std::size_t>(a)];
  }
  void add(std::size_t t) {
    int first[2], last[2];
    for (int c = 0; c < 2; ++c) {
      first[c] = count_[c];
      last[c] = 0;
      for (const Index u : corners_of(mesh_, t).v) {
        first[c] = std::min(first[c], cell_of(mesh_.material[at(u)], c));
        last[c] = std::max(last[c], cell_of(mesh_.material[at(u)], c));
      }
    }
    for (int b = first[1]; b <= last[1]; ++b)
      for (int a = first[0]; a <= last[0]; ++a)
        bins_[static_cast<std::size_t>(b) * static_cast<std::size_t>(count_[0]) +
              static_cast<std::size_t>(a)]
            .push_back(t);
  }

  const Mesh& mesh_;
  Point low_, high_;
  double cell_ = 1;
  int count_[2] = {1, 1};
  std::vector<std::vector<std::size_t>> bins_;
};

double distance_to_segment(const Point& x, const Point& a, const Point& b) {
  const Point ab = b - a;
  const double share = std::clamp(dot(x - a, ab) / std::max(dot(ab, ab), 1e-300), 0.0, 1.0);
  return length(x - a - share * ab);
}

/// A triangle as a place for a point.
struct Candidate {
  std::size_t triangle = 0;
  double distance = std::numeric_limits<double>::infinity();  ///< [m] in material space; 0: inside
  double apart = std::numeric_limits<double>::infinity();     ///< [m] of the positions
  std::array<double, 3> weight{};

  bool better_than(const Candidate& b) const {
    if (distance != b.distance) return distance < b.distance;
    if (apart != b.apart) return apart < b.apart;
    return triangle < b.triangle;
  }
};

Candidate place_in(const Mesh& on, std::size_t t, const Point& x, const Vec3<double>& position) {
  const Tri& corner = corners_of(on, t);
  Point p[3];
  for (int k = 0; k < 3; ++k) p[k] = on.material[at(corner.v[k])];
  const double det = cross2(p[1] - p[0], p[2] - p[0]);
  Candidate c;
  if (det == 0) return c;
  c.triangle = t;
  c.weight[1] = cross2(x - p[0], p[2] - p[0]) / det;
  c.weight[2] = cross2(p[1] - p[0], x - p[0]) / det;
  c.weight[0] = 1 - c.weight[1] - c.weight[2];
  if (*std::min_element(c.weight.begin(), c.weight.end()) >= -touching) {
    c.distance = 0;
    // So that a vertex on a vertex, or on an edge, has no part in what is across.
    for (double& w : c.weight)
      if (std::abs(w) <= touching) w = 0;
    const double sum = c.weight[0] + c.weight[1] + c.weight[2];
    for (double& w : c.weight) w /= sum;
  } else {
    for (int k = 0; k < 3; ++k)
      c.distance = std::min(c.distance, distance_to_segment(x, p[k], p[(k + 1) % 3]));
  }
  Vec3<double> there{};
  for (int k = 0; k < 3; ++k)
    there += c.weight[static_cast<std::size_t>(k)] * on.positions[at(on.triangles[t].v[k])];
  c.apart = length(there - position);
  return c;
}

}  // namespace

MaterialMap map_material(const Mesh& mesh, const Mesh& on) {
  const Bins bins(on);
  const std::vector<Point> points = points_of(mesh);
  MaterialMap map;
  for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
    Candidate best;
    // The nearest triangle may be one ring beyond the first in which there is any.
    for (int ring = 0, beyond = 0; ring <= bins.rings() && beyond < 2; ++ring) {
      bins.visit(points[v], ring, [&](std::size_t t) {
        const Candidate c = place_in(on, t, points[v], mesh.positions[v]);
        if (c.better_than(best)) best = c;
      });
      if (best.distance == 0) break;
      if (std::isfinite(best.distance)) ++beyond;
    }
    const Tri& t = on.triangles[best.triangle];
    map.corner.push_back({t.v[0], t.v[1], t.v[2]});
    map.weight.push_back(best.weight);
  }
  return map;
}

}  // namespace weft
