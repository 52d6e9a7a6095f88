#pragma once

#include <limits>

#include "weft/core/ids.hpp"
#include "weft/core/span.hpp"
#include "weft/exec/launch.hpp"
#include "weft/kernels/collide/pairs.hpp"
#include "weft/state/contact.hpp"
#include "weft/state/surface.hpp"

namespace weft {

/// Stands in place of a pair's slack if the pair is a contact, or another one stands for it:
/// continuous detection then looks at it in any case, and knows that the system has heard of it.
constexpr float slack_of_contact = -std::numeric_limits<float>::infinity();

/// Contacts that the implicit system has to know of: pairs that are closer than the thickness now,
/// or that would be at the end of the step if nothing but gravity changed any velocity, and pairs
/// that bore something in the last step and still are that close. Only pairs whose closest points
/// are where the two surfaces are closest as well (see elements/normal_cone.hpp), and each pair of
/// features once: of the faces around a vertex or an edge the first one stands for it, and edges
/// meet edges within both. The repulsion of a pair is stiffness * m / dt^2 with m its effective
/// mass; below half of the thickness it grows as the inverse of the gap, up to eightfold, and it
/// grows with the depth that the prediction reaches, so that what is left of it stays below the
/// thickness. Cloth that is closer than the thickness at rest (a fine mesh) repels at nine tenths
/// of its distance at rest only. Two primitives with corners that a seam ties to each other do not
/// repel (P-Cloth section 5.1). The first guess at friction is that of the last step. Reads: pairs,
/// positions, memory. Writes: contacts, slacks, counts. Order: face pairs, then edge pairs, each in
/// their order. Ghosts: all vertices. Flags: counts above capacity.
template <class T>
struct CollideProximity {
  Span<const Pair> face_pairs;  ///< capacity; the number stands in counts
  Span<const Pair> edge_pairs;
  Surface surface;
  Span<const Tri> triangles;
  Span<const Vec3<T>> positions_t0;     ///< [vertices] [m]
  Span<const Vec3<T>> positions_t1;     ///< [vertices] [m] prediction; obstacle: end of the step
  Span<const T> mass;                   ///< [cloth vertices] [kg]
  Span<const unsigned char> fixed;      ///< [cloth vertices]
  Span<const Vec2<T>> material_points;  ///< [cloth vertices] [m]
  Span<const Index> cloth_of_vertex;    ///< [cloth vertices]
  Span<const Index> tied;               ///< [cloth vertices] see Model; empty: no two are
  Span<const T> friction_of_vertex;     ///< [vertices] cloth: cloth on cloth; obstacle: its own
  Index cloth_vertex_count = 0;
  T thickness;                               ///< [m]
  T stiffness;                               ///< in units of m / dt^2
  T step;                                    ///< [s] nominal time step, sets the stiffness
  Span<const ContactMemory<T>> face_memory;  ///< of the last step, in the order of its pairs
  Span<const ContactMemory<T>> edge_memory;
  Span<float> face_slack;  ///< [capacity] [m] lower bound of the pair's gap during the prediction
  Span<float> edge_slack;
  Span<Contact<T>> contacts;   ///< capacity
  Span<CollideCounts> counts;  ///< [1]
};

template <class T>
void run(OnHost, Queue& queue, const CollideProximity<T>& args);

}  // namespace weft
