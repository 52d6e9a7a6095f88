#pragma once

#include <string>

#include "host/io/pattern/garment.hpp"
#include "host/io/pattern/inner_layers.hpp"

namespace weft::io {

/// Sews a garment where its panels stand: vertices that a seam makes one go to their mean, and the
/// cloth around them follows over a distance of some 15 cm, whatever the mesh. Panels stand far
/// from each other, so that a simulation would else begin with edges ten times as long as at rest.
/// Cloth farther away stays where its panel stands. Triangles do not enter the body on the way, see
/// BodyGuard.
/// @param garment positions change
/// @param edge    [m] that the garment was made with
/// @param body    [m] y up; may be empty
/// @param inner   what the garment is worn over, which triangles do not enter either
void relax_start(Garment& garment, double edge, const Mesh& body, const InnerLayers& inner);
/// The same without inner layers.
void relax_start(Garment& garment, double edge, const Mesh& body);

/// Contracts a sewn garment once more, after what began within the body or within inner layers has
/// been moved out: relax_start() leaves cloth there as long as seams have drawn it.
void tighten_start(Garment& garment, double edge, const Mesh& body, const InnerLayers& inner);

/// @param body [m] y up; empty: nothing is refused
/// @param file of the pattern, for messages
/// @throws SceneError naming a panel that stands farther than most_panel_distance from the body's
///         bounding box
void refuse_far_panels(const Garment& garment, const Mesh& body, const std::string& file);

inline constexpr double most_panel_distance = 0.5;  ///< [m]

/// Largest length of an edge over its length at rest.
double largest_stretch(const Garment& garment);

}  // namespace weft::io
