#pragma once

#include "host/implicit/linear/mesh_matrix.hpp"
#include "host/implicit/linear/mesh_rows.hpp"
#include "host/implicit/linear/rank_rows.hpp"
#include "host/model/plate.hpp"
#include "host/state/partition.hpp"

namespace weft {

/// Bending as a plate in a rank's rows: entries that it adds to the mesh's matrix, entries between
/// other vertices, and forces of curved rest shapes.
template <class T>
struct PlateOperator {
  Buffer<Offset> in_pattern_offset, in_pattern_place, off_pattern_slice_offset;
  Buffer<Index> in_pattern_column, off_pattern_column;
  Buffer<T> in_pattern_stiffness, in_pattern_damping, off_pattern_stiffness, off_pattern_damping,
      off_pattern_value;
  Buffer<Tri> shape_corners;
  Buffer<Mat2<T>> shape_inv_rest;
  Buffer<Offset> shape_offset, shape_entry_offset, shape_corner_offset;
  Buffer<Index> shape_vertex, shape_entry_triangle, shape_entry, shape_corner;
  Buffer<Vec3<T>> shape_force, shape_axes, shape_corner_force;
  Buffer<Index> ghost;  ///< vertices of other ranks in these rows and in those of the mesh's matrix

  void make(Device& device, const PlateMatrix& plate, const MeshRows& rows,
            const Partition& partition, int rank);

  /// Adds to the assembled matrix of the mesh, and to its right-hand side.
  /// @param positions [cloth vertices] [m]   @param rates [cloth vertices] [m/s]; empty: none
  void assemble(Queue& queue, const RankRows& own, MeshMatrix<T>& mesh,
                Span<const Vec3<T>> positions, Span<const Vec3<T>> rates, T h, Span<Vec3<T>> rhs);

  /// Entries between other vertices than those of the mesh's matrix.
  /// @param order of the mesh's matrix
  ScalarEll<T> view(const RankRows& own, const RowOrder& order) const {
    if (off_pattern_column.size() == 0) return {};
    return {own.count,
            own.slice,
            off_pattern_slice_offset.span(),
            off_pattern_column.span(),
            off_pattern_value.span(),
            order};
  }

 private:
  void make_shape(Device& device, const PlateShape& shape, const Partition& partition, int rank);
};

}  // namespace weft
