#pragma once

#include <vector>

#include "host/state/store.hpp"
#include "weft/state/surface.hpp"

namespace weft {

/// Data that the stages of a step read and, but for `fixed` and `row_begin`, never write. Each rank
/// has a copy.
template <class T>
struct RankGeometry {
  Buffer<Edge> edges;                     ///< cloth, then obstacle
  Buffer<Tri> triangles;                  ///< cloth, then obstacle
  Buffer<T> mass;                         ///< [cloth vertices] [kg]
  Buffer<T> damping_mass;                 ///< [cloth vertices] [1/s]
  Buffer<unsigned char> fixed;            ///< [vertices] 1 where the position is prescribed
  Buffer<Vec2<T>> material_points;        ///< [cloth vertices] [m]
  Buffer<Index> cloth_of_vertex;          ///< [cloth vertices]
  Buffer<Index> component_of_vertex;      ///< [cloth vertices] see cloth_components()
  Buffer<double> component_inverse_mass;  ///< [components] [1/kg]
  Buffer<Index> moving_frame_sample;      ///< [moving_frame_samples * components] vertices, see
                                          ///< IntegrateMovingFrame
  Buffer<Index> tied;            ///< [cloth vertices] as in Model; empty if no vertices are tied
  Buffer<T> friction_of_vertex;  ///< [vertices]
  Buffer<T> start_thickness;     ///< [cloth vertices] [m] as in Model, may be empty
  Buffer<unsigned char> cut;     ///< [cloth edges] as in Model, may be empty
  Buffer<Index> row_begin;       ///< [ranks + 1]
  Buffer<EdgeWings> wings;       ///< this and the next four as in Surface
  Buffer<Tri> edges_of_face;
  Buffer<Offset> ring_offset;
  Buffer<Index> ring;
  Buffer<Index> face_of_vertex;

  Surface surface() const {
    return {edges.span(),       wings.span(), edges_of_face.span(),
            ring_offset.span(), ring.span(),  face_of_vertex.span()};
  }
};

/// Working arrays of one attempt at a step. Each rank has a copy.
template <class T>
struct RankMotion {
  /// [vertices] [m] End of the attempt, in turn: targets of obstacles and pins, and the prediction
  /// of free cloth; each iterate of the solve; what zones make of it; where motions are cut off.
  Buffer<Vec3<T>> positions_t1;
  Buffer<Vec3<T>> velocities_t1;           ///< [cloth vertices] [m/s]
  Buffer<Vec3<T>> base_positions;          ///< [cloth vertices] [m] x~ of BDF2
  Buffer<Vec3<T>> base_velocities;         ///< [cloth vertices] [m/s] v~ of BDF2
  Buffer<unsigned char> moved_now;         ///< [vertices] moved by a zone in this round
  Buffer<unsigned char> moved_in_attempt;  ///< [vertices] the same in any round
  Buffer<unsigned char> crushed;           ///< [vertices] this and the next: see RespondRemember
  Buffer<unsigned char> crushed_in_jam;
  Buffer<ContactMemory<T>> contacts;  ///< contact cache for the next step
  std::int64_t face_contacts = 0;     ///< how many of them are of faces
};

/// @return [ranks]
template <class T>
std::vector<RankGeometry<T>> make_geometry(const Store<T>& store);

template <class T>
RankMotion<T> make_motion(const Store<T>& store, int rank);

/// 1 for every vertex that a pin holds at `time`, and for obstacles. [vertices]
std::vector<unsigned char> fixed_vertices(const Scene& scene, const Model& model, double time);

}  // namespace weft
