#pragma once

#include <array>
#include <limits>
#include <vector>

#include "host/model/model.hpp"
#include "weft/state/contact.hpp"

namespace weft {

/// The springs of handles and seams at one instant: those of handles first, each kind in the order
/// of the scene. A spring of a seam that welds has no length. One of a seam that never does is
/// slack within half of the thickness: closer than that, contact would have to hold it open. Of a
/// part of a model (ModelPart) those of what is in it.
/// @param time [s]
/// @param step [s] in which the ends move, for the drag of seams
std::vector<Spring<double>> springs_at(const Scene& scene, const Model& model, double time,
                                       double step = std::numeric_limits<double>::infinity());

/// Those of one handle, see springs_at().
std::vector<Spring<double>> springs_of(const Scene& scene, const Model& model, const Handle& handle,
                                       double time);

/// [ramp times] how long the springs of a seam that must weld grow stiffer. A gathered edge resists
/// with its stretch stiffness: at 2 to 1 it stays open by millimetres under the stiffness that sews
/// edges of one length.
inline constexpr double longest_pull = 4;

/// Share of its stiffness that a handle's springs have at `time`, 0 to 1.
double handle_strength(const Handle& handle, double time);

/// The same for a seam: the cube of the share of ramp_time that has passed, up to 1. Of a seam that
/// must weld it grows on to 64, at four ramp times: only pairs that are still open have springs.
double seam_strength(const Seam& seam, double time);

/// Whether seams pull at different vertices, now or later.
bool any_seam_open(const Scene& scene, const Model& model);

}  // namespace weft
