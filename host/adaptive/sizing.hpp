#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

#include "host/adaptive/clearance.hpp"
#include "host/adaptive/surface_mesh.hpp"
#include "weft/scene.hpp"

namespace weft {

struct ViewField;

/// The quantities that decide how fine a triangle must be. All in material space.
struct FaceShape {
  Mat<double, 3, 2> deformation;  ///< F
  Mat<double, 3, 2> velocity;     ///< [1/s] gradient of the velocity
  Mat<double, 3, 2> normals;      ///< [1/m] gradient of the vertices' normals
  Mat2<double> bend;              ///< [1/m] from the angles to its neighbours
  Mat2<double> obstacle;          ///< [1/m^2] tensor that nearby obstacles ask for
};

/// The sizing tensor M of a triangle (Narain, Samii and O'Brien 2012, section 4.1). Curvature,
/// velocity, compression and obstacles each give a tensor, scaled by the limit in the settings. M
/// is the smallest tensor above all of these. An edge u of material space is too long if
/// u^T M u > 1.
/// @return [1/m^2] eigenvalues within [1 / size_max^2, 1 / size_min^2]; the smaller one is at least
///         aspect_min^2 times the larger one
Mat2<double> sizing_tensor(const FaceShape& face, const Remeshing& settings);

/// Sets the metric of every material point: the mean, by area, of the tensors around it.
/// @param settings  [cloths]
/// @param clearance knows the obstacles
/// @param reach     [m] obstacles farther away do not count
/// @param view      of the same triangles, see view_tensor(); null: none
void set_metric(SurfaceMesh& mesh, const std::vector<Remeshing>& settings,
                const Clearance& clearance, double reach, const ViewField* view = nullptr);

/// Length of an edge in the metric: the root of the mean of u^T M u at both ends, averaged over the
/// sides of a seam. The edge is fine enough if this is at most 1.
double edge_size(const SurfaceMesh& mesh, Index h);

/// The same for the straight line between two material points.
inline double edge_size(const SurfaceMesh& mesh, Index from_corner, Index to_corner) {
  const auto from = static_cast<std::size_t>(from_corner), to = static_cast<std::size_t>(to_corner);
  const Vec2<double> u = mesh.material[to] - mesh.material[from];
  const Mat2<double> sum = mesh.metric[from] + mesh.metric[to];
  return std::sqrt(std::max(0.0, dot(u, sum * u) / 2));
}

}  // namespace weft
