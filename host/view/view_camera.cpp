#include "host/view/view_camera.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "host/geometry/triangle_gradient.hpp"
#include "weft/elements/distance.hpp"

namespace weft {
namespace {

constexpr double near_share = 0.01;

Vec3<double> unit(const Vec3<double>& x) {
  return (1 / length(x)) * x;
}

/// From a ray that starts at the origin.
double ray_distance(const Vec3<double>& direction, const Vec3<double>& p) {
  return length(p - std::max(0.0, dot(p, direction)) * direction);
}

/// From what two rays span.
/// @param a, b unit, across each other
double wedge_distance(const Vec3<double>& a, const Vec3<double>& b, const Vec3<double>& p) {
  const Vec3<double> normal = unit(cross(a, b));
  const Vec3<double> foot = p - dot(p, normal) * normal;
  if (dot(cross(a, foot), normal) >= 0 && dot(cross(foot, b), normal) >= 0)
    return std::abs(dot(p, normal));
  return std::min(ray_distance(a, p), ray_distance(b, p));
}

/// Inward normals of the four sides, not unit.
std::array<Vec3<double>, 4> sides(const Frustum& f) {
  return {Vec3<double>{-1, 0, f.tan_x}, {1, 0, f.tan_x}, {0, -1, f.tan_y}, {0, 1, f.tan_y}};
}

bool meets(const Frustum& f, const Vec3<double> triangle[3]) {
  std::vector<Vec3<double>> polygon(triangle, triangle + 3), rest;
  for (const Vec3<double>& side : sides(f)) {
    rest.clear();
    for (std::size_t i = 0; i < polygon.size(); ++i) {
      const Vec3<double>&p = polygon[i], &q = polygon[(i + 1) % polygon.size()];
      const double a = dot(p, side), b = dot(q, side);
      if (a >= 0) rest.push_back(p);
      if ((a > 0 && b < 0) || (a < 0 && b > 0)) rest.push_back(p + (a / (a - b)) * (q - p));
    }
    polygon.swap(rest);
  }
  return !polygon.empty();
}

}  // namespace

double frustum_distance(const Frustum& f, const Vec3<double>& point) {
  // Both pairs of sides are mirror images.
  const Vec3<double> p{std::abs(point[0]), std::abs(point[1]), point[2]};
  if (p[0] <= f.tan_x * p[2] && p[1] <= f.tan_y * p[2]) return 0;
  const Vec3<double> corner = unit({f.tan_x, f.tan_y, 1});
  const Vec3<double> below = unit({f.tan_x, -f.tan_y, 1});
  const Vec3<double> left = unit({-f.tan_x, f.tan_y, 1});
  return std::min(wedge_distance(below, corner, p), wedge_distance(left, corner, p));
}

double frustum_distance(const Frustum& f, const Vec3<double> triangle[3]) {
  if (meets(f, triangle)) return 0;
  // Two convex bodies apart are nearest at a corner of one, or at an edge of each.
  double least = length(triangle[0]), reach = 0;
  for (int j = 0; j < 3; ++j) {
    least = std::min(least, frustum_distance(f, triangle[j]));
    reach = std::max(reach, length(triangle[j]));
  }
  const Vec3<double> apex[4] = {{0, 0, 0}, triangle[0], triangle[1], triangle[2]};
  double least_sq = std::min(least * least, vertex_triangle(apex).distance_sq);
  for (const double x : {-f.tan_x, f.tan_x})
    for (const double y : {-f.tan_y, f.tan_y}) {
      const Vec3<double> far = (2 * reach) * unit({x, y, 1});
      for (int j = 0; j < 3; ++j) {
        const Vec3<double> edges[4] = {{0, 0, 0}, far, triangle[j], triangle[(j + 1) % 3]};
        least_sq = std::min(least_sq, edge_edge(edges).distance_sq);
      }
    }
  return std::sqrt(least_sq);
}

ViewCamera::ViewCamera(const CameraKey& key, int width, int height)
    : eye_(key.position),
      right_(unit(cross(key.look_at - key.position, key.up))),
      forward_(unit(key.look_at - key.position)),
      near_(near_share * length(key.look_at - key.position)),
      width_(width),
      height_(height) {
  up_ = cross(right_, forward_);
  frustum_.tan_y = std::tan(key.field_of_view / 2);
  frustum_.tan_x = frustum_.tan_y * width / height;
  scale_ = height / (2 * frustum_.tan_y);
}

Vec3<double> ViewCamera::seen(const Vec3<double>& x) const {
  const Vec3<double> d = x - eye_;
  return {dot(d, right_), dot(d, up_), dot(d, forward_)};
}

Vec2<double> ViewCamera::pixel(const Vec3<double>& p) const {
  return {0.5 * width_ + scale_ * p[0] / p[2], 0.5 * height_ - scale_ * p[1] / p[2]};
}

Mat2<double> screen_jacobian(const Vec2<double> pixels[3], const Vec2<double> material[3]) {
  return gradient(pixels, material);
}

}  // namespace weft
