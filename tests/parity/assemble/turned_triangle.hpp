#pragma once

#include <Eigen/Dense>
#include <cmath>

namespace weft::parity {

using TriangleColumns = Eigen::Matrix<double, 3, 2>;

/// Columns of a deformation gradient, turned as TurnedStart does.
/// @param change of the columns in the step   @param allowed, resisted [J/m^2] energies, by the
/// angle to the power of 0 and 4
inline TriangleColumns turned_columns(const TriangleColumns& f, const TriangleColumns& change,
                                      double allowed, double resisted) {
  const Eigen::Vector3d normal = f.col(0).cross(f.col(1)).normalized();
  // The angular velocity that moves the columns along the normal as they move, and does not turn
  // them about it; then their mean rotation about the normal.
  Eigen::Matrix3d equations;
  Eigen::Vector3d right;
  for (int k = 0; k < 2; ++k) {
    equations.row(k) = f.col(k).cross(normal).transpose();
    right[k] = normal.dot(change.col(k));
  }
  equations.row(2) = normal.transpose();
  right[2] =
      normal.dot(f.col(0).cross(change.col(0)) + f.col(1).cross(change.col(1))) / f.squaredNorm();
  const Eigen::Vector3d rotation = equations.inverse() * right;
  const double angle = rotation.norm();
  if (!(angle > 1e-3)) return f;
  const double share = allowed / (allowed + resisted * std::pow(angle, 4));
  const Eigen::AngleAxisd turn(2 * std::atan(share * angle / 2), rotation / angle);
  return turn.toRotationMatrix() * f;
}

}  // namespace weft::parity
