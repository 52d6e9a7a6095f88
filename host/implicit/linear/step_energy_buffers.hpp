#pragma once

#include <vector>

#include "host/implicit/linear/mesh_matrix.hpp"
#include "weft/kernels/assemble/step_energy.hpp"

namespace weft {

/// Buffers of a rank for the energies of a step, allocated on first use.
template <class T>
struct StepEnergyBuffers {
  Buffer<StretchError<T>> stretch_error;
  Buffer<double> partial;
  Buffer<Vec3<T>> no_velocities;  ///< [cloth vertices] zeros

  /// Submits the partial sums, see AssembleStepEnergy, and their copy.
  /// @param positions, velocities at the start [m], [m/s]   @param positions_t1 [m] at the end
  /// @param start see AssembleStretchError
  void launch_sums(Device& device, const RankRows& own, Index partial_rows,
                   const RankGeometry<T>& geometry, const ElementBuffers<T>& elements,
                   const MeshMatrix<T>& mesh, Span<const Vec3<T>> positions,
                   Span<const Vec3<T>> velocities, Span<const Vec3<T>> positions_t1,
                   const TurnedStart<T>& start, std::vector<double>& out) {
    Queue& queue = device.compute();
    if (partial.size() == 0) {
      const MemoryName name("solver");
      make(device, stretch_error, elements.triangles.size());
      make(device, partial,
           3 * static_cast<std::size_t>((own.count + partial_rows - 1) / partial_rows));
    }
    elements.launch_stretch_error(queue, positions, positions_t1, stretch_error.span(), start);
    launch(queue,
           AssembleStepEnergy<T>{own.begin, own.count, partial_rows, geometry.mass.span(),
                                 velocities, mesh.corner_source_offset.span(),
                                 mesh.corner_source.span(), stretch_error.span(), partial.span()});
    out.resize(partial.size());
    queue.copy(out.data(), partial.data(), out.size() * sizeof(double));
  }

  Span<const Vec3<T>> zeros(Device& device, std::size_t vertices) {
    if (no_velocities.size() != vertices) {
      const MemoryName name("solver");
      make(device, no_velocities, vertices);
      device.compute().fill(no_velocities.data(), 0, vertices * sizeof(Vec3<T>));
    }
    return no_velocities.span();
  }
};

}  // namespace weft
