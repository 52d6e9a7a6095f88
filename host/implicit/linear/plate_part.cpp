#include "weft/kernels/assemble/plate.hpp"

#include <type_traits>
#include <utility>

#include "host/implicit/linear/linear_system.hpp"
#include "host/implicit/linear/rest_shape_rows.hpp"
#include "host/implicit/parallel/exchange.hpp"
#include "weft/kernels/assemble/rest_shape_forces.hpp"
#include "weft/kernels/assemble/rest_shape_rows.hpp"

namespace weft {

/// What rank r reads of the plate's matrix.
template <class T>
void LinearSystem<T>::make_plate_part(int r, const MeshRows& rows) {
  const MemoryName name("matrix");
  Device& device = store_.devices()[r];
  Rank& rank = ranks_[static_cast<std::size_t>(r)];
  const auto put = [&](auto& buffer, const auto& values) {
    buffer = std::remove_reference_t<decltype(buffer)>(device);
    upload(device.compute(), buffer, values);
  };
  const PlateRows plate = make_plate_rows(*plate_, rows, store_.partition(), r);
  put(rank.in_pattern_offset, plate.in_pattern_offset);
  put(rank.in_pattern_place, plate.in_pattern_place);
  put(rank.in_pattern_column, plate.in_pattern_column);
  put(rank.in_pattern_stiffness, cast_all<T>(plate.in_pattern_stiffness));
  put(rank.in_pattern_damping, cast_all<T>(plate.in_pattern_damping));
  put(rank.off_pattern_slice_offset, plate.off_pattern_slice_offset);
  put(rank.off_pattern_column, plate.off_pattern_column);
  put(rank.off_pattern_stiffness, cast_all<T>(plate.off_pattern_stiffness));
  put(rank.off_pattern_damping, cast_all<T>(plate.off_pattern_damping));
  put(rank.mesh_ghost, plate.ghost);
  rank.off_pattern_value = Buffer<T>(device, plate.off_pattern_column.size());
  make_shape_part(r);
}

/// What rank r reads of rest shapes that are curved.
template <class T>
void LinearSystem<T>::make_shape_part(int r) {
  Device& device = store_.devices()[r];
  Rank& rank = ranks_[static_cast<std::size_t>(r)];
  const auto put = [&](auto& buffer, const auto& values) {
    buffer = std::remove_reference_t<decltype(buffer)>(device);
    upload(device.compute(), buffer, values);
  };
  const RestShapeRows shape = make_rest_shape_rows(plate_->shape, store_.partition(), r);
  put(rank.shape_corners, shape.corners);
  put(rank.shape_inv_rest, cast_all<T>(shape.inv_rest));
  put(rank.shape_offset, shape.offset);
  put(rank.shape_vertex, shape.vertex);
  put(rank.shape_entry_triangle, shape.entry_triangle);
  put(rank.shape_force, cast_all<T>(shape.force));
  put(rank.shape_entry_offset, shape.entry_offset);
  put(rank.shape_entry, shape.entry);
  put(rank.shape_corner_offset, shape.corner_offset);
  put(rank.shape_corner, shape.corner);
  rank.shape_axes = Buffer<Vec3<T>>(device, 3 * shape.corners.size());
  rank.shape_corner_force = Buffer<Vec3<T>>(device, 3 * shape.corners.size());
}

template <class T>
void LinearSystem<T>::hold(const std::vector<unsigned char>& fixed) {
  note_pins(fixed);
  std::shared_ptr<const PlateMatrix> plate = store_.plate(fixed);
  if (plate == plate_) return;
  plate_ = std::move(plate);
  // The arrays may still be in use by the last solve, on other ranks too.
  sync_ranks(store_.devices());
  for (int r = 0; r < store_.devices().size(); ++r)
    make_plate_part(r, make_mesh_rows(store_.model(), store_.partition(), r));
}

template <class T>
void LinearSystem<T>::assemble_plate(int r, const Linearisation& at) {
  Rank& rank = ranks_[static_cast<std::size_t>(r)];
  Queue& queue = store_.devices()[r].compute();
  const Span<const Vec3<T>> positions = element_positions(r, at);
  const auto h = static_cast<T>(at.h);
  launch(queue,
         AssemblePlate<T>{row_begin(r), row_count(r), store_.partition().slice,
                          rank.in_pattern_offset.span(), rank.in_pattern_place.span(),
                          rank.in_pattern_column.span(), rank.in_pattern_stiffness.span(),
                          rank.in_pattern_damping.span(), rank.off_pattern_slice_offset.span(),
                          rank.off_pattern_column.span(), rank.off_pattern_stiffness.span(),
                          rank.off_pattern_damping.span(), positions, element_rates(r, at), h,
                          rank.value.span(), rank.diagonal.span(), rank.off_pattern_value.span(),
                          rank.mesh_rhs.span()});
  if (rank.shape_corners.size() == 0) return;
  launch(queue, AssembleRestShapeForces<T>{rank.shape_corners.span(), rank.shape_inv_rest.span(),
                                           rank.shape_offset.span(), rank.shape_vertex.span(),
                                           rank.shape_force.span(), positions,
                                           rank.shape_axes.span(), rank.shape_corner_force.span()});
  launch(queue, AssembleRestShapeRows<T>{row_count(r), rank.shape_entry_offset.span(),
                                         rank.shape_entry.span(), rank.shape_entry_triangle.span(),
                                         rank.shape_force.span(), rank.shape_corner_offset.span(),
                                         rank.shape_corner.span(), rank.shape_axes.span(),
                                         rank.shape_corner_force.span(), h, rank.mesh_rhs.span()});
}

template void LinearSystem<float>::make_plate_part(int, const MeshRows&);
template void LinearSystem<double>::make_plate_part(int, const MeshRows&);
template void LinearSystem<float>::hold(const std::vector<unsigned char>&);
template void LinearSystem<double>::hold(const std::vector<unsigned char>&);
template void LinearSystem<float>::assemble_plate(int, const Linearisation&);
template void LinearSystem<double>::assemble_plate(int, const Linearisation&);

}  // namespace weft
