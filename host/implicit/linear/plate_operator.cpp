#include "host/implicit/linear/plate_operator.hpp"

#include "host/implicit/linear/rest_shape_rows.hpp"
#include "weft/kernels/assemble/plate.hpp"
#include "weft/kernels/assemble/rest_shape_forces.hpp"
#include "weft/kernels/assemble/rest_shape_rows.hpp"

namespace weft {

template <class T>
void PlateOperator<T>::make(Device& device, const PlateMatrix& matrix, const MeshRows& rows,
                            const Partition& partition, int rank) {
  const MemoryName name("matrix");
  const PlateRows plate = make_plate_rows(matrix, rows, partition, rank);
  put(device, in_pattern_offset, plate.in_pattern_offset);
  put(device, in_pattern_place, plate.in_pattern_place);
  put(device, in_pattern_column, plate.in_pattern_column);
  put(device, in_pattern_stiffness, cast_all<T>(plate.in_pattern_stiffness));
  put(device, in_pattern_damping, cast_all<T>(plate.in_pattern_damping));
  put(device, off_pattern_slice_offset, plate.off_pattern_slice_offset);
  put(device, off_pattern_column, plate.off_pattern_column);
  put(device, off_pattern_stiffness, cast_all<T>(plate.off_pattern_stiffness));
  put(device, off_pattern_damping, cast_all<T>(plate.off_pattern_damping));
  put(device, ghost, plate.ghost);
  weft::make(device, off_pattern_value, plate.off_pattern_column.size());
  make_shape(device, matrix.shape, partition, rank);
}

template <class T>
void PlateOperator<T>::make_shape(Device& device, const PlateShape& all, const Partition& partition,
                                  int rank) {
  const RestShapeRows shape = make_rest_shape_rows(all, partition, rank);
  put(device, shape_corners, shape.corners);
  put(device, shape_inv_rest, cast_all<T>(shape.inv_rest));
  put(device, shape_offset, shape.offset);
  put(device, shape_vertex, shape.vertex);
  put(device, shape_entry_triangle, shape.entry_triangle);
  put(device, shape_force, cast_all<T>(shape.force));
  put(device, shape_entry_offset, shape.entry_offset);
  put(device, shape_entry, shape.entry);
  put(device, shape_corner_offset, shape.corner_offset);
  put(device, shape_corner, shape.corner);
  weft::make(device, shape_axes, 3 * shape.corners.size());
  weft::make(device, shape_corner_force, 3 * shape.corners.size());
}

template <class T>
void PlateOperator<T>::assemble(Queue& queue, const RankRows& own, MeshMatrix<T>& mesh,
                                Span<const Vec3<T>> positions, Span<const Vec3<T>> rates, T h,
                                Span<Vec3<T>> rhs) {
  if (in_pattern_offset.size() == 0) return;
  launch(queue, AssemblePlate<T>{own.begin,
                                 own.count,
                                 own.slice,
                                 in_pattern_offset.span(),
                                 in_pattern_place.span(),
                                 in_pattern_column.span(),
                                 in_pattern_stiffness.span(),
                                 in_pattern_damping.span(),
                                 off_pattern_slice_offset.span(),
                                 off_pattern_column.span(),
                                 off_pattern_stiffness.span(),
                                 off_pattern_damping.span(),
                                 positions,
                                 rates,
                                 h,
                                 mesh.value.span(),
                                 mesh.diagonal.span(),
                                 off_pattern_value.span(),
                                 rhs,
                                 {mesh.order.span()}});
  if (shape_corners.size() == 0) return;
  launch(queue,
         AssembleRestShapeForces<T>{shape_corners.span(), shape_inv_rest.span(),
                                    shape_offset.span(), shape_vertex.span(), shape_force.span(),
                                    positions, shape_axes.span(), shape_corner_force.span()});
  launch(queue, AssembleRestShapeRows<T>{own.count, shape_entry_offset.span(), shape_entry.span(),
                                         shape_entry_triangle.span(), shape_force.span(),
                                         shape_corner_offset.span(), shape_corner.span(),
                                         shape_axes.span(), shape_corner_force.span(), h, rhs});
}

template struct PlateOperator<float>;
template struct PlateOperator<double>;

}  // namespace weft
