#include "host/time_parallel/slice_boundary.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <map>
#include <numbers>
#include <utility>

#include "host/scene/intersection_check.hpp"
#include "weft/core/at.hpp"
#include "weft/error.hpp"

namespace weft {
namespace {

/// Inner edges of a mesh: the two ends, then the corners opposite in the triangles left and right.
std::vector<std::array<Index, 4>> inner_edges(const Mesh& mesh) {
  std::map<std::pair<Index, Index>, Index> opposite;
  for (const Tri& t : mesh.triangles)
    for (int k = 0; k < 3; ++k) opposite[{t.v[k], t.v[(k + 1) % 3]}] = t.v[(k + 2) % 3];
  std::vector<std::array<Index, 4>> edges;
  for (const auto& [edge, left] : opposite) {
    if (edge.first > edge.second) continue;
    const auto right = opposite.find({edge.second, edge.first});
    if (right != opposite.end()) edges.push_back({edge.first, edge.second, left, right->second});
  }
  return edges;
}

/// Angle between the normals on both sides of an edge, with its sign. [rad]
double angle_at(const std::array<Index, 4>& edge, const std::vector<Vec3<double>>& x) {
  const Vec3<double>& a = x[at(edge[0])];
  const Vec3<double> along = x[at(edge[1])] - a;
  const Vec3<double> left = cross(along, x[at(edge[2])] - a);
  const Vec3<double> right = cross(x[at(edge[3])] - a, along);
  const double size = length(along);
  if (!(size > 0)) return 0;
  return std::atan2(dot(cross(left, right), along) / size, dot(left, right));
}

/// Sum of the differences of angles over the sum of angles, where an edge that is flat has `flat`.
double angle_error(const Scene& scene, const Frame& reference, const Frame& other, double flat) {
  double difference = 0;
  double sum = 0;
  for (std::size_t c = 0; c < reference.cloth_positions.size(); ++c)
    for (const auto& edge : inner_edges(scene.cloths[c].mesh)) {
      const double wanted = angle_at(edge, reference.cloth_positions[c]);
      difference += std::abs(wanted - angle_at(edge, other.cloth_positions[c]));
      sum += std::abs(flat - wanted);
    }
  if (sum > 0) return difference / sum;
  return difference > 0 ? std::numeric_limits<double>::infinity() : 0;
}

}  // namespace

BoundaryJump boundary_jump(const Scene& scene, const Frame& before, const Frame& after) {
  BoundaryJump jump;
  double sum = 0;
  std::size_t count = 0;
  for (std::size_t c = 0; c < before.cloth_positions.size(); ++c)
    for (std::size_t v = 0; v < before.cloth_positions[c].size(); ++v) {
      const double moved = length(after.cloth_positions[c][v] - before.cloth_positions[c][v]);
      jump.position = std::max(jump.position, moved);
      jump.velocity = std::max(
          jump.velocity, length(after.cloth_velocities[c][v] - before.cloth_velocities[c][v]));
      sum += moved * moved;
      ++count;
    }
  if (count > 0) jump.position_rms = std::sqrt(sum / static_cast<double>(count));
  jump.curvature = curvature_error(scene, before, after);
  return jump;
}

double curvature_error(const Scene& scene, const Frame& reference, const Frame& other) {
  return angle_error(scene, reference, other, 0);
}

double dihedral_error(const Scene& scene, const Frame& reference, const Frame& other) {
  return angle_error(scene, reference, other, std::numbers::pi);
}

double angle_sum(const Scene& scene, const Frame& frame) {
  double sum = 0;
  for (std::size_t c = 0; c < frame.cloth_positions.size(); ++c)
    for (const auto& edge : inner_edges(scene.cloths[c].mesh))
      sum += std::abs(angle_at(edge, frame.cloth_positions[c]));
  return sum;
}

double largest_move(const Frame& from, const Frame& to) {
  double most = 0;
  for (std::size_t c = 0; c < from.cloth_positions.size(); ++c)
    for (std::size_t v = 0; v < from.cloth_positions[c].size(); ++v)
      most = std::max(most, length(to.cloth_positions[c][v] - from.cloth_positions[c][v]));
  return most;
}

Frame blended(const Frame& frame, const Frame& before, const Frame& after, double share) {
  Frame result = frame;
  for (std::size_t c = 0; c < result.cloth_positions.size(); ++c)
    for (std::size_t v = 0; v < result.cloth_positions[c].size(); ++v)
      result.cloth_positions[c][v] +=
          share * (before.cloth_positions[c][v] - after.cloth_positions[c][v]);
  return result;
}

bool free_of_intersections(const Scene& scene, const Frame& frame) {
  Scene now = scene;
  for (std::size_t c = 0; c < now.cloths.size(); ++c)
    now.cloths[c].mesh.positions = frame.cloth_positions[c];
  for (std::size_t o = 0; o < now.obstacles.size(); ++o) {
    now.obstacles[o].transform = {};
    now.obstacles[o].motion.clear();
    now.obstacles[o].deformation.reset();
    now.obstacles[o].mesh.positions = frame.simulated_obstacle(o);
  }
  try {
    refuse_intersecting_start(now);
    return true;
  } catch (const SceneError&) {
    return false;
  }
}

}  // namespace weft
