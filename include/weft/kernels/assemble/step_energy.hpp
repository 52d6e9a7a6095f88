#pragma once

#include "weft/core/ids.hpp"
#include "weft/core/span.hpp"
#include "weft/core/vec.hpp"
#include "weft/exec/launch.hpp"
#include "weft/kernels/assemble/stretch_error.hpp"

namespace weft {

/// Sums of a step over rows, in double, a partial for each partial_rows rows: its energy at the
/// start, kinetic and of stretching, and the two errors of AssembleStretchError. A row has a third
/// of each triangle around it. Partials added in order give the same bits for any number of ranks.
/// Reads: velocities, masses, errors. Writes: partials. Order: fixed within a partial. Ghosts:
/// none.
template <class T>
struct AssembleStepEnergy {
  Index row_begin = 0;  ///< a multiple of partial_rows
  Index row_count = 0;
  Index partial_rows = 1024;
  Span<const T> mass;                       ///< [vertices] [kg]
  Span<const Vec3<T>> velocities;           ///< [vertices] [m/s] at the start
  Span<const Offset> corner_source_offset;  ///< [rows + 1] these two as in AssembleRows
  Span<const Index> corner_source;
  Span<const StretchError<T>> error;  ///< [triangles]
  Span<double> partial;  ///< [3 * partials of these rows] energy, turned, limited by turns [J]
};

/// What a row adds to the three sums.
template <class T>
WEFT_HD void add_step_energy(const AssembleStepEnergy<T>& a, Index row, double sum[3]) noexcept {
  const Index vertex = a.row_begin + row;
  const Vec3<double> v = vec_cast<double>(a.velocities.data()[vertex]);
  double third[3] = {};
  for (Offset s = a.corner_source_offset.data()[row]; s < a.corner_source_offset.data()[row + 1];
       ++s) {
    const Index source = a.corner_source.data()[s];
    if (source < 0) continue;  // a hinge
    const StretchError<T>& e = a.error.data()[source / 3];
    third[0] += static_cast<double>(e.elastic);
    third[1] += static_cast<double>(e.turned);
    third[2] += static_cast<double>(e.limited);
  }
  sum[0] += 0.5 * static_cast<double>(a.mass.data()[vertex]) * dot(v, v);
  for (int k = 0; k < 3; ++k) sum[k] += third[k] / 3;
}

template <class T>
void run(OnHost, Queue& queue, const AssembleStepEnergy<T>& args);
template <class T>
void run(OnCuda, Queue& queue, const AssembleStepEnergy<T>& args);

}  // namespace weft
