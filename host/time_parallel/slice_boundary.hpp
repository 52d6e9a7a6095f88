#pragma once

#include <vector>

#include "weft/frame.hpp"
#include "weft/scene.hpp"

namespace weft {

/// How the end of a slice and the start of the next one differ: what would pop in the frames.
struct BoundaryJump {
  double position = 0;      ///< [m] largest of a vertex
  double position_rms = 0;  ///< [m]
  double velocity = 0;      ///< [m/s] largest
  double curvature = 0;     ///< curvature_error() of the start against the end
};

/// @param before, after two states of one time of one scene
BoundaryJump boundary_jump(const Scene& scene, const Frame& before, const Frame& after);

/// Difference of the angles at inner edges, over those of the reference (Liang & Lin 2018, eq. 17):
///   sum |angle - angle'| / sum |angle|
/// @return 0 if the reference is flat and the other is too, infinity if only the reference is
double curvature_error(const Scene& scene, const Frame& reference, const Frame& other);

/// The same by dihedral angles, pi where an edge is flat. What the paper's curvature is it does not
/// say; by the angle that an edge turns, linear subdivision of chords r edges long is 2 (r - 1) / r
/// off wherever cloth bends smoothly, more than any value of its Table 4.
/// @return 0 if there is no inner edge
double dihedral_error(const Scene& scene, const Frame& reference, const Frame& other);

/// By how much inner edges turn in all, either way: how much detail there is, wherever it lies.
/// [rad]
double angle_sum(const Scene& scene, const Frame& frame);

/// Largest distance that a vertex of a cloth has moved. [m]
double largest_move(const Frame& from, const Frame& to);

/// A frame after a seam with a share of the seam's jump taken back, so that it goes on from where
/// the slice before has ended.
/// @param before, after the two states at the seam
Frame blended(const Frame& frame, const Frame& before, const Frame& after, double share);

/// Whether a frame could be the start of a scene, see refuse_intersecting_start().
bool free_of_intersections(const Scene& scene, const Frame& frame);

}  // namespace weft
