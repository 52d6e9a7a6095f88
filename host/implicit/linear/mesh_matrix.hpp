#pragma once

#include "host/implicit/linear/element_buffers.hpp"
#include "host/implicit/linear/rank_rows.hpp"
#include "host/state/rank_geometry.hpp"
#include "weft/kernels/assemble/rows.hpp"
#include "weft/state/block_ell.hpp"
#include "weft/state/vertex_part.hpp"

namespace weft {

/// The mesh part of the matrix in a rank's rows, which gather it from the elements.
template <class T>
struct MeshMatrix {
  Buffer<Offset> slice_offset;
  Buffer<Index> order;  ///< see RowOrder
  Buffer<Index> column;
  Buffer<T> value;
  Buffer<Mat3<T>> diagonal;
  Buffer<T> vertex_mass;  ///< see VertexPart
  Buffer<T> vertex_drag;  ///< empty: no wind
  Buffer<Offset> block_source_offset;
  Buffer<BlockSource> block_source;
  Buffer<Offset> corner_source_offset;
  Buffer<Index> corner_source;

  void make(Device& device, const RankRows& own, const MeshRows& rows, bool wind);

  /// Input of a rank's rows besides the elements, and their right-hand side.
  struct At {
    Span<const Vec3<T>> base_velocities, velocities;  ///< [cloth vertices] [m/s]
    Vec3<T> gravity;                                  ///< [m/s^2]
    T h;                                              ///< [s]
    Span<Vec3<T>> rhs;                                ///< [rows] [N s]
  };
  void assemble(Queue& queue, const RankRows& own, const RankGeometry<T>& geometry,
                const ElementBuffers<T>& elements, const At& at);

  BlockEll<T> view(const RankRows& own) const {
    return {own.count,    own.slice,       slice_offset.span(), column.span(),
            value.span(), diagonal.span(), {order.span()}};
  }
  VertexPart<T> vertex_part(const RankRows& own) const {
    return {vertex_mass.span(), {own.block_slice(), vertex_drag.span()}};
  }
};

}  // namespace weft
