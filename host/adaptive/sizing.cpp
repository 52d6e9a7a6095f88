#include "host/adaptive/sizing.hpp"

#include <cmath>
#include <cstddef>

#include "host/geometry/tensor.hpp"
#include "host/geometry/triangle_gradient.hpp"
#include "host/view/view_sizing.hpp"
#include "weft/core/at.hpp"

namespace weft {
namespace {

Vec3<double> normal_of(const SurfaceMesh& m, Index t) {
  const Tri& v = m.triangles[at(t)];
  const Vec3<double>& x = m.positions[at(v.v[0])];
  return cross(m.positions[at(v.v[1])] - x, m.positions[at(v.v[2])] - x);
}

Vec3<double> unit(const Vec3<double>& x) {
  const double l = length(x);
  return l > 0 ? (1 / l) * x : Vec3<double>{0, 0, 0};
}

/// [vertices] unit; vertices that seams have made one share theirs
std::vector<Vec3<double>> vertex_normals(const SurfaceMesh& m) {
  std::vector<Vec3<double>> sum(m.positions.size(), Vec3<double>{0, 0, 0});
  for (std::size_t t = 0; t < m.triangles.size(); ++t) {
    if (m.kind[t] < 0) continue;
    const Vec3<double> n = normal_of(m, static_cast<Index>(t));
    for (const Index v : m.triangles[t].v) sum[at(m.place[at(v)])] += n;
  }
  std::vector<Vec3<double>> normals(m.positions.size());
  for (std::size_t v = 0; v < normals.size(); ++v) normals[v] = unit(sum[at(m.place[v])]);
  return normals;
}

/// Angle between a triangle and its neighbour across h, positive where it bends to the back.
double angle_across(const SurfaceMesh& m, Index h) {
  const Index g = m.twin[at(h)];
  if (g < 0) return 0;
  const Vec3<double> edge = unit(m.positions[at(m.to(h))] - m.positions[at(m.from(h))]);
  const Vec3<double> n = unit(normal_of(m, h / 3));
  const Vec3<double> o = unit(normal_of(m, g / 3));
  return std::atan2(dot(cross(n, o), edge), dot(n, o));
}

/// Half of every edge's bend belongs to each of its triangles: sum of angle |e| t t^T / (2 area),
/// t across the edge.
Mat2<double> bend_of(const SurfaceMesh& m, Index t, double area) {
  Mat2<double> sum{};
  for (Index h = 3 * t; h < 3 * t + 3; ++h) {
    const Vec2<double> e = m.material[at(m.corner_to(h))] - m.material[at(m.corner_from(h))];
    const double l = length(e);
    const Vec2<double> across{e[1] / l, -e[0] / l};
    sum += (angle_across(m, h) * l / 2) * outer(across, across);
  }
  return (1 / area) * sum;
}

Mat2<double> obstacle_part(const Vec3<double> x[3], const Vec2<double> u[3],
                           const Clearance::Plane planes[3]) {
  Mat2<double> sum{};
  for (int corner = 0; corner < 3; ++corner) {
    const Clearance::Plane& plane = planes[corner];
    if (length_sq(plane.normal) == 0) continue;
    Vec<double, 1> h[3];
    for (int j = 0; j < 3; ++j) h[j] = {dot(x[j] - plane.point, plane.normal)};
    const Mat<double, 1, 2> slope = gradient(h, u);
    sum += (1 / (3 * h[corner][0] * h[corner][0])) * (transpose(slope) * slope);
  }
  return sum;
}

template <int R>
Mat2<double> squared(const Mat<double, R, 2>& m) {
  return transpose(m) * m;
}

}  // namespace

Mat2<double> sizing_tensor(const FaceShape& face, const Remeshing& s) {
  Tensors parts{face.obstacle};
  const Mat2<double> curvature = squared(face.normals);
  const auto over = [](double limit) { return 1 / (limit * limit); };
  if (std::isfinite(s.refine_angle)) {
    parts.push_back(over(s.refine_angle) * curvature);
    parts.push_back(over(s.refine_angle) * squared(face.bend));
  }
  if (std::isfinite(s.refine_velocity))
    parts.push_back(over(s.refine_velocity) * squared(face.velocity));
  if (std::isfinite(s.refine_compression)) {
    Mat2<double> green = squared(face.deformation);
    green -= Mat2<double>::identity();
    parts.push_back(compression_tensor(green, curvature, s.refine_compression));
  }
  return clamped(tensor_above(parts), over(s.size_max), over(s.size_min),
                 s.aspect_min * s.aspect_min);
}

void set_metric(SurfaceMesh& m, const std::vector<Remeshing>& settings, const Clearance& clearance,
                double reach, const ViewField* view) {
  const std::vector<Vec3<double>> normals = vertex_normals(m);
  std::vector<Clearance::Plane> planes(m.positions.size());
  Index last = -1;  // vertices of neighbouring numbers are often neighbours
  for (std::size_t v = 0; v < planes.size(); ++v) {
    if (m.leaving[v] < 0) continue;
    planes[v] = clearance.nearest_obstacle(m.positions[v], reach, last);
    last = planes[v].triangle;
  }
  m.metric.assign(m.material.size(), {});
  std::vector<double> weight(m.material.size(), 0);
  for (std::size_t t = 0; t < m.triangles.size(); ++t) {
    if (m.kind[t] < 0) continue;
    Vec3<double> x[3], y[3], n[3];
    Vec2<double> u[3];
    Clearance::Plane near[3];
    for (int j = 0; j < 3; ++j) {
      const std::size_t v = at(m.triangles[t].v[j]);
      x[j] = m.positions[v];
      y[j] = m.velocities[v];
      n[j] = normals[v];
      near[j] = planes[v];
      u[j] = m.material[at(m.corners[t].v[j])];
    }
    const Remeshing& own = settings[at(m.kinds[at(m.kind[t])].cloth)];
    const double area = m.material_det(m.corners[t]) / 2;
    const FaceShape face{gradient(x, u), gradient(y, u), gradient(n, u),
                         bend_of(m, static_cast<Index>(t), area), obstacle_part(x, u, near)};
    Mat2<double> tensor = sizing_tensor(face, own);
    if (view != nullptr)
      tensor = view_tensor(*view, static_cast<Index>(t), m.triangles[t], u, tensor, own);
    for (const Index c : m.corners[t].v) {
      m.metric[at(c)] += area * tensor;
      weight[at(c)] += area;
    }
  }
  for (std::size_t c = 0; c < weight.size(); ++c)
    if (weight[c] > 0) m.metric[c] *= 1 / weight[c];
}

double edge_size(const SurfaceMesh& m, Index h) {
  const double own = edge_size(m, m.corner_from(h), m.corner_to(h));
  const Index g = m.twin[at(h)];
  if (g < 0 || (m.corner_from(h) == m.corner_to(g) && m.corner_to(h) == m.corner_from(g)))
    return own;
  return (own + edge_size(m, m.corner_from(g), m.corner_to(g))) / 2;
}

}  // namespace weft
