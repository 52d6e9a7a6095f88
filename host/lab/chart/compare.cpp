#include "host/lab/chart/compare.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>

#include "host/geometry/aabb.hpp"
#include "host/lab/check/box_tree.hpp"
#include "weft/core/at.hpp"
#include "weft/elements/distance.hpp"

namespace weft::lab {
namespace {

double triangle_area(const std::vector<Vec3<double>>& x, const Tri& t) {
  return 0.5 * length(cross(x[at(t.v[1])] - x[at(t.v[0])], x[at(t.v[2])] - x[at(t.v[0])]));
}

/// A third of the area of its triangles belongs to each vertex.
std::vector<double> vertex_areas(const std::vector<Tri>& triangles,
                                 const std::vector<Vec3<double>>& x) {
  std::vector<double> areas(x.size(), 0.0);
  for (const Tri& t : triangles)
    for (const Index v : t.v) areas[at(v)] += triangle_area(x, t) / 3;
  return areas;
}

/// Largest distance of any of the points from a surface.
double farthest(const std::vector<Vec3<double>>& from, const Mesh& to) {
  std::vector<Box> boxes;
  std::vector<Index> ids;
  for (const Tri& t : to.triangles) {
    const Vec3<double>& x = to.positions[at(t.v[0])];
    Box box{x, x};
    for (const Index v : t.v) box = join(box, {to.positions[at(v)], to.positions[at(v)]});
    ids.push_back(static_cast<Index>(boxes.size()));
    boxes.push_back(box);
  }
  const BoxTree tree(boxes, ids);
  const double least = std::max(1e-3 * diagonal(to.positions), 1e-300);
  double largest = 0, reach = 0;
  for (const Vec3<double>& x : from) {
    double nearest = std::numeric_limits<double>::infinity();
    // What is beyond the box around the point is farther than its half side.
    for (double half = std::max(reach, least); nearest > half * half; half *= 2) {
      const Vec3<double> side{half, half, half};
      tree.overlapping({x - side, x + side}, [&](Index id) {
        const Tri& t = to.triangles[at(id)];
        const Vec3<double> corners[4] = {x, to.positions[at(t.v[0])], to.positions[at(t.v[1])],
                                         to.positions[at(t.v[2])]};
        nearest = std::min(nearest, vertex_triangle(corners).distance_sq);
      });
    }
    largest = std::max(largest, nearest);
    reach = std::sqrt(nearest);  // neighbours are about as far
  }
  return std::sqrt(largest);
}

/// Signed angle by which the surface bends at an edge; 0 where a triangle has no area.
double bend(const std::vector<Vec3<double>>& x, Index a, Index b, Index left, Index right) {
  const Vec3<double> edge = x[at(b)] - x[at(a)];
  const Vec3<double> n = cross(edge, x[at(left)] - x[at(a)]);
  const Vec3<double> m = cross(x[at(right)] - x[at(a)], edge);
  const double size = length(edge);
  if (!(size > 0)) return 0;
  return std::atan2(dot(cross(n, m), edge) / size, dot(n, m));
}

}  // namespace

double mean_distance(const std::vector<Tri>& triangles, const std::vector<Vec3<double>>& a,
                     const std::vector<Vec3<double>>& b) {
  const std::vector<double> areas = vertex_areas(triangles, a);
  double sum = 0, area = 0;
  for (std::size_t v = 0; v < a.size(); ++v) {
    sum += areas[v] * length_sq(a[v] - b[v]);
    area += areas[v];
  }
  return area > 0 ? std::sqrt(sum / area) : 0;
}

double curvature_error(const std::vector<Tri>& triangles,
                       const std::vector<Vec3<double>>& reference,
                       const std::vector<Vec3<double>>& positions) {
  std::map<std::array<Index, 2>, Index> opposite;  // of directed edges
  for (const Tri& t : triangles)
    for (int k = 0; k < 3; ++k) opposite[{t.v[k], t.v[(k + 1) % 3]}] = t.v[(k + 2) % 3];
  double differences = 0, angles = 0;
  for (const auto& [edge, left] : opposite) {
    if (edge[0] > edge[1]) continue;
    const auto other = opposite.find({edge[1], edge[0]});
    if (other == opposite.end()) continue;
    const double expected = bend(reference, edge[0], edge[1], left, other->second);
    differences += std::abs(bend(positions, edge[0], edge[1], left, other->second) - expected);
    angles += std::abs(expected);
  }
  if (angles > 0) return differences / angles;
  return differences > 0 ? std::numeric_limits<double>::infinity() : 0;
}

double hausdorff_distance(const Mesh& a, const Mesh& b) {
  return std::max(farthest(a.positions, b), farthest(b.positions, a));
}

Statistics statistics(const Mesh& mesh) {
  const std::vector<double> areas = vertex_areas(mesh.triangles, mesh.positions);
  Statistics s;
  double area = 0;
  for (std::size_t v = 0; v < areas.size(); ++v) {
    s.mean += areas[v] * mesh.positions[v];
    area += areas[v];
  }
  if (!(area > 0)) return s;
  s.mean = (1 / area) * s.mean;
  for (std::size_t v = 0; v < areas.size(); ++v)
    for (int k = 0; k < 3; ++k) {
      const double d = mesh.positions[v][k] - s.mean[k];
      s.spread[k] += areas[v] * d * d;
    }
  for (int k = 0; k < 3; ++k) s.spread[k] = std::sqrt(s.spread[k] / area);
  return s;
}

double difference(const Statistics& a, const Statistics& b) {
  double largest = 0;
  for (int k = 0; k < 3; ++k)
    largest =
        std::max({largest, std::abs(a.mean[k] - b.mean[k]), std::abs(a.spread[k] - b.spread[k])});
  return largest;
}

MeanStatistics mean_statistics(const std::vector<Statistics>& of_starts) {
  const auto count = static_cast<double>(of_starts.size());
  MeanStatistics result;
  for (Vec3<double> Statistics::*number : {&Statistics::mean, &Statistics::spread})
    for (int k = 0; k < 3; ++k) {
      double sum = 0, squares = 0;
      for (const Statistics& s : of_starts) sum += (s.*number)[k];
      const double mean = sum / count;
      for (const Statistics& s : of_starts)
        squares += ((s.*number)[k] - mean) * ((s.*number)[k] - mean);
      (result.mean.*number)[k] = mean;
      if (count > 1) (result.error.*number)[k] = std::sqrt(squares / (count - 1) / count);
    }
  return result;
}

double difference_error(const MeanStatistics& a, const MeanStatistics& b) {
  double largest = 0;
  for (int k = 0; k < 3; ++k)
    largest = std::max({largest, std::hypot(a.error.mean[k], b.error.mean[k]),
                        std::hypot(a.error.spread[k], b.error.spread[k])});
  return largest;
}

double diagonal(const std::vector<Vec3<double>>& positions) {
  return aabb_of(positions).diagonal();
}

std::vector<Vec3<double>> extrapolated(const std::vector<Vec3<double>>& coarse,
                                       const std::vector<Vec3<double>>& fine, int order) {
  const double share = 1 / (std::pow(2.0, order) - 1);
  std::vector<Vec3<double>> limit(fine.size());
  for (std::size_t v = 0; v < fine.size(); ++v) limit[v] = fine[v] + share * (fine[v] - coarse[v]);
  return limit;
}

}  // namespace weft::lab
