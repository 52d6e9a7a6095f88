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
  Pair pair;
  Index v[4];
  T w[4];
  Vec3<T> n;
  T stiffness;     ///< [N/m] repulsion k: energy k/2 (thickness - gap)^2
  T hold;          ///< [N/m] stiffness of sticking
  T thickness;     ///< [m] gap below which it repels
  T reach;         ///< [m] the same if it remembered nothing
  T yield;         ///< [N] force beyond which it may be crushed, see is_crushed(): what closes all
                   ///< of `reach` at the stiffness of mass and step, and heavy loads. Infinite if
                   ///< not within a cloth.
  T friction;      ///< coefficient of friction
  T load;          ///< [N] ContactMemory::load of the last step
  Vec3<T> anchor;  ///< [m] tangential displacement that friction holds at the step's start
  // What a single linear solve takes the contact for:
  T push;         ///< [N/m] stiffness, or 0 where it comes apart
  T drag;         ///< [N/m] these three as in FrictionTangent
  T drag_limit;   ///< [N]
  Vec3<T> slide;  ///< unit vector, or zero
};

/// What a contact leaves to the next step. Part of the state.
template <class T>
struct ContactMemory {
  Pair pair;
  T normal_force;    ///< [N] 0: it bore nothing
  T load;            ///< [N] mean of the normal force, see AssembleContactCache::load_share
  T sticking_force;  ///< [N] friction that would have been needed to stick
  Vec3<T> friction;  ///< [N] across n
  Vec3<T> n;
};

/// Spring that pulls a cloth vertex to another one or to a place. See elements/spring.hpp.
template <class T>
struct Spring {
  Index v[2];       ///< second: -1 for a spring to a place
  Vec3<T> anchor;   ///< [m] that place, else not in use
  T stiffness;      ///< [N/m]
  T rest;           ///< [m] length up to which it is slack
  Vec3<T> along{};  ///< unit vector that it acts along; (0, 0, 0): along its own length
  T drag = 0;       ///< [N/m] of a dashpot between two vertices, see spring_drag()
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
template <class T>
struct BoxOf {
  T lo[3];
  T hi[3];
};
using Box = BoxOf<float>;

}  // namespace weft
