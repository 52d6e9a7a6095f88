#pragma once

#include "host/view/view_factor.hpp"
#include "weft/core/mat.hpp"

namespace weft {

/// A sizing tensor that asks for no edge shorter than so many pixels: taken to the picture, its
/// eigenvalues are cut at 1 / pixel_min^2, and it is taken back (koh2015, eq. (5) to (8)). Both
/// tensors are made diagonal at once instead, so that a view along the cloth, whose Jacobian has no
/// inverse, is like any other: with L L^T = tensor and L^-1 (S^T S / pixel_min^2) L^-T = Q m Q^T
/// the result is L Q min(m, 1) Q^T L^T.
/// @param tensor    [1/m^2] positive definite
/// @param screen    [pixels/m] S, see screen_jacobian()
/// @param pixel_min [pixels] 0: as it is
Mat2<double> pixel_bounded(const Mat2<double>& tensor, const Mat2<double>& screen,
                           double pixel_min);

/// What a view makes of the sizing tensor of a triangle: times its view factor squared (koh2015,
/// eq. (2)), bounded by pixels where it is in front of the camera, for each instant; what is above
/// all of these, within the sizes and the aspect of the settings.
/// @param tensor   [1/m^2] as made without a view
/// @param material [3] [m] of the triangle's corners
Mat2<double> view_tensor(const ViewField& field, Index triangle, const Tri& corners,
                         const Vec2<double> material[3], const Mat2<double>& tensor,
                         const Remeshing& sizes);

}  // namespace weft
