#pragma once

#include <cstddef>

#include "host/base/short_list.hpp"
#include "weft/core/mat.hpp"

namespace weft {

/// Symmetric 2x2 matrix as its eigenvalues and the direction of the first.
struct Eigen2 {
  double value[2];    ///< the larger first
  Vec2<double> axis;  ///< unit, of value[0]; of value[1] is its quarter turn
};

/// @param m symmetric; the mean of both sides of the diagonal counts
Eigen2 eigen(const Mat2<double>& m);
Mat2<double> compose(const Eigen2& e);

/// What a face may ask for at once: curvature twice, velocity, compression and obstacles.
inline constexpr std::size_t tensors_max = 5;
using Tensors = ShortList<Mat2<double>, tensors_max>;

/// The smallest symmetric matrix that is nowhere below any of these. As disks - centre
/// ((m00 - m11) / 2, (m01 + m10) / 2), radius (m00 + m11) / 2 - it is the smallest disk around them
/// all (Narain, Samii and O'Brien 2012, section 4.1).
/// @param tensors at least one
Mat2<double> tensor_above(const Tensors& tensors);

/// Eigenvalues clamped to [low, high], then the smaller raised to aspect_sq times the larger.
Mat2<double> clamped(const Mat2<double>& m, double low, double high, double aspect_sq);

/// What of a compression would buckle, per square metre: with e = F^T F - I, K = S^T S,
///   pos(-e + ssqrt(e^T e - 4 c^2 perp(K))) / (2 c^2)
/// pos drops negative eigenvalues, ssqrt keeps the sign of each, perp([a b; d f]) = [f -b; -d a].
/// @param green      F^T F - I   @param curvature_sq [1/m^2] K
/// @param compression [m] c > 0
Mat2<double> compression_tensor(const Mat2<double>& green, const Mat2<double>& curvature_sq,
                                double compression);

}  // namespace weft
