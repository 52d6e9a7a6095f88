#pragma once

#include <vector>

#include "host/implicit/linear/mesh_rows.hpp"
#include "host/state/store.hpp"
#include "weft/kernels/assemble/membrane.hpp"
#include "weft/kernels/assemble/stretch_error.hpp"

namespace weft {

/// The elements that touch a rank's rows, and the results of their assembly.
template <class T>
struct ElementBuffers {
  Buffer<Tri> triangles;
  Buffer<Mat2<T>> inv_rest;
  Buffer<T> area;
  Buffer<T> pressure;          ///< empty: none
  std::vector<Index> numbers;  ///< of the triangles, in the model
  Buffer<T> compression;       ///< resisted share of compression; empty: 1
  Buffer<Index> material;
  Buffer<MaterialRow<T>> materials;
  Buffer<T> material_tables;
  Buffer<Hinge> hinges;
  Buffer<T> hinge_stiffness, hinge_rest_angle, hinge_damping;
  // Written by assemble()
  Buffer<Vec3<T>> triangle_impulse;
  Buffer<Mat3<T>> triangle_block;
  Buffer<Mat3<T>> corner_drag;  ///< empty: no wind
  Buffer<Vec3<T>> hinge_direction;
  Buffer<T> hinge_impulse_scale, hinge_curvature;

  void make(Device& device, const Scene& scene, const Model& model, const MeshRows& rows);

  /// @param of_model [cloth triangles] as in Model::compression
  void take_compression(Queue& queue, const std::vector<double>& of_model);

  /// Where elements are evaluated. Spans are in the memory of the rank.
  struct At {
    Span<const Vec3<T>> positions;   ///< [cloth vertices] [m]
    Span<const Vec3<T>> rates;       ///< [cloth vertices] [m/s] for strain rates; empty: none
    Span<const Vec3<T>> velocities;  ///< [cloth vertices] [m/s] of the iterate
    T h;                             ///< [s]
    TurnedStart<T> start{};
  };
  /// @param state of the rank, at the start of the step
  void assemble(Queue& queue, const Wind& wind, const RankState<T>& state, const At& at);

  /// See AssembleStretchError.
  void launch_stretch_error(Queue& queue, Span<const Vec3<T>> positions_t0,
                            Span<const Vec3<T>> positions_t1, Span<StretchError<T>> error,
                            const TurnedStart<T>& start) const;
};

/// Whether there is wind, or air that drags.
inline bool blows(const Wind& wind) {
  return wind.density > 0 || wind.drag > 0;
}

}  // namespace weft
