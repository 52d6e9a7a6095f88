#include "host/geometry/attachment.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

#include "weft/core/assert.hpp"
#include "weft/elements/distance.hpp"

namespace weft {
namespace {

struct TriangleCorners {
  Vec3<double> x[3];
};

TriangleCorners corners_of(const Tri& tri, Span<const Vec3<double>> positions) {
  TriangleCorners c;
  for (int j = 0; j < 3; ++j) c.x[j] = positions[static_cast<std::size_t>(tri.v[j])];
  return c;
}

/// Right-handed: the first edge, across it within the triangle, the normal. All zero without area.
struct CornerFrame {
  Vec3<double> axis[3]{};
};

CornerFrame frame_of(const TriangleCorners& c) {
  CornerFrame frame;
  const Vec3<double> edge = c.x[1] - c.x[0];
  const Vec3<double> normal = cross(edge, c.x[2] - c.x[0]);
  const double edge_length = length(edge);
  const double normal_length = length(normal);
  if (!(edge_length > 0) || !(normal_length > 0)) return frame;
  frame.axis[0] = edge * (1 / edge_length);
  frame.axis[2] = normal * (1 / normal_length);
  frame.axis[1] = cross(frame.axis[2], frame.axis[0]);
  return frame;
}

/// A ball around a triangle.
struct Ball {
  Vec3<double> centre;
  double radius;
};

Ball ball_around(const TriangleCorners& c) {
  const Vec3<double> centre = (c.x[0] + c.x[1] + c.x[2]) * (1.0 / 3);
  double radius = 0;
  for (const Vec3<double>& x : c.x) radius = std::max(radius, length(x - centre));
  return {centre, radius};
}

Attachment attachment_to(const Tri& tri, const TriangleCorners& c,
                         const Proximity<double>& nearest) {
  Attachment result;
  result.corners = tri;
  for (int j = 0; j < 3; ++j) result.weights[j] = -nearest.w[j + 1];
  const CornerFrame frame = frame_of(c);
  for (int k = 0; k < 3; ++k) result.offset[k] = dot(frame.axis[k], nearest.difference);
  return result;
}

}  // namespace

std::vector<Attachment> attach(const std::vector<Vec3<double>>& points, Span<const Tri> triangles,
                               Span<const Vec3<double>> positions) {
  WEFT_ASSERT(!triangles.empty());
  std::vector<Ball> balls;
  balls.reserve(triangles.size());
  for (const Tri& tri : triangles) balls.push_back(ball_around(corners_of(tri, positions)));
  std::vector<Attachment> result;
  result.reserve(points.size());
  for (const Vec3<double>& point : points) {
    double best = std::numeric_limits<double>::infinity();
    Attachment attachment;
    for (std::size_t t = 0; t < triangles.size(); ++t) {
      // The share on top covers rounding, so that no triangle that is nearest is passed over.
      const double reach = 1.000001 * (best + balls[t].radius);
      if (length_sq(point - balls[t].centre) > reach * reach) continue;
      const TriangleCorners c = corners_of(triangles[t], positions);
      const Vec3<double> x[4]{point, c.x[0], c.x[1], c.x[2]};
      const Proximity<double> nearest = vertex_triangle(x);
      const double distance = std::sqrt(nearest.distance_sq);
      if (!(distance < best)) continue;
      best = distance;
      attachment = attachment_to(triangles[t], c, nearest);
    }
    result.push_back(attachment);
  }
  return result;
}

Vec3<double> attached_position(const Attachment& attachment, Span<const Vec3<double>> positions) {
  const TriangleCorners c = corners_of(attachment.corners, positions);
  const CornerFrame frame = frame_of(c);
  Vec3<double> at{0, 0, 0};
  for (int j = 0; j < 3; ++j) at += c.x[j] * attachment.weights[j];
  for (int k = 0; k < 3; ++k) at += frame.axis[k] * attachment.offset[k];
  return at;
}

}  // namespace weft
