#pragma once

#include "weft/core/ids.hpp"
#include "weft/core/span.hpp"
#include "weft/core/vec.hpp"
#include "weft/exec/launch.hpp"

namespace weft {

/// What a line search asks of the residual b and the direction dv: their product and |b|^2 over
/// free rows, in double, a partial for each partial_rows rows. Partials added in order give the
/// same bits for any number of ranks. Reads: residual, direction. Writes: partials. Order: fixed
/// within a partial. Ghosts: none.
template <class T>
struct SolveProducts {
  Index row_begin = 0;  ///< a multiple of partial_rows
  Index row_count = 0;
  Index partial_rows = 1024;
  Span<const Vec3<T>> residual;     ///< [rows] [N s]
  Span<const Vec3<T>> direction;    ///< [vertices] [m/s]
  Span<const unsigned char> fixed;  ///< [vertices]
  Span<double> partial;             ///< [2 * partials of these rows] product and square by turns
};

template <class T>
void run(OnHost, Queue& queue, const SolveProducts<T>& args);
template <class T>
void run(OnCuda, Queue& queue, const SolveProducts<T>& args);

}  // namespace weft
