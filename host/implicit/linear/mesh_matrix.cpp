#include "host/implicit/linear/mesh_matrix.hpp"

namespace weft {

template <class T>
void MeshMatrix<T>::make(Device& device, const RankRows& own, const MeshRows& rows, bool wind) {
  const MemoryName name("matrix");
  put(device, slice_offset, rows.slice_offset);
  put(device, order, rows.order);
  put(device, column, rows.column);
  put(device, block_source_offset, rows.block_source_offset);
  put(device, block_source, rows.block_source);
  put(device, corner_source_offset, rows.corner_source_offset);
  put(device, corner_source, rows.corner_source);
  const auto count = static_cast<std::size_t>(own.count);
  weft::make(device, value, 9 * rows.column.size());
  weft::make(device, diagonal, count);
  weft::make(device, vertex_mass, count);
  weft::make(device, vertex_drag, wind ? own.block_numbers() : 0);
}

template <class T>
void MeshMatrix<T>::assemble(Queue& queue, const RankRows& own, const RankGeometry<T>& geometry,
                             const ElementBuffers<T>& e, const At& at) {
  launch(queue, AssembleRows<T>{own.begin,
                                {own.count,
                                 own.slice,
                                 slice_offset.span(),
                                 column.span(),
                                 value.span(),
                                 diagonal.span(),
                                 {order.span()}},
                                block_source_offset.span(),
                                block_source.span(),
                                corner_source_offset.span(),
                                corner_source.span(),
                                e.triangle_block.span(),
                                e.triangle_impulse.span(),
                                e.hinge_direction.span(),
                                e.hinge_impulse_scale.span(),
                                e.hinge_curvature.span(),
                                geometry.mass.span(),
                                geometry.damping_mass.span(),
                                at.base_velocities,
                                at.velocities,
                                at.gravity,
                                at.h,
                                at.rhs,
                                vertex_mass.span(),
                                e.corner_drag.span(),
                                {own.block_slice(), vertex_drag.span()}});
}

template struct MeshMatrix<float>;
template struct MeshMatrix<double>;

}  // namespace weft
