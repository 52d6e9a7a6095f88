#pragma once

#include <cstdint>

#include "weft/core/ids.hpp"
#include "weft/core/mat.hpp"
#include "weft/core/vec.hpp"

namespace weft {

/// Candidate of contact: a vertex and a face, or two edges. Numbers count cloth first, then
/// obstacle.
struct Pair {
  Index a;  ///< vertex, or first edge
  Index b;  ///< face, or second edge
};

/// Linearised contact of four vertices. With d = sum_j w[j] x[v[j]] the gap is n . d; n points from
/// the second primitive to the first, and the weights sum to zero.
template <class T>
struct Contact {
  Index v[4];
  T w[4];
  Vec3<T> n;
  T stiffness;  ///< [N/m] repulsion k: energy k/2 (thickness - gap)^2
  T thickness;  ///< [m]
  T friction;   ///< [N] coefficient of friction times lagged normal force
  T slip_inv;   ///< [1/m] friction_scale at the predicted slip, for the first iteration
};

/// Spring that pulls a cloth vertex to another one or to a place. See elements/spring.hpp.
template <class T>
struct Spring {
  Index v[2];      ///< second: -1 for a spring to a place
  Vec3<T> anchor;  ///< [m] that place, else not in use
  T stiffness;     ///< [N/m]
  T rest;          ///< [m] length up to which it is slack
};

/// A collision that continuous detection found within the step.
struct Collision {
  Index v[4];
  double w[4];
  Vec3<double> n;  ///< as in Contact, at the time of impact
  double offset;   ///< [m] gap that the response has to restore along n
  double toi;      ///< share of the step, 0 to 1
  /// How many of the vertices are the first primitive's: 1 of a vertex and a face, 2 of two edges.
  /// The narrow phase leaves it to whoever joins its lists.
  Index first = 1;
};

/// Axis-aligned box, rounded outwards.
struct Box {
  float lo[3];
  float hi[3];
};

}  // namespace weft
