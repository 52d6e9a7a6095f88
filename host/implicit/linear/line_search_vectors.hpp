#pragma once

#include "host/implicit/linear/rank_rows.hpp"
#include "weft/kernels/integrate/update.hpp"
#include "weft/kernels/solve/products.hpp"

namespace weft {

/// Start and direction of a rank's line search, allocated on first use.
template <class T>
struct LineSearchVectors {
  Buffer<Vec3<T>> start, direction;  ///< [cloth vertices] [m/s]
  Buffer<double> partial;            ///< see SolveProducts

  /// @param velocities, solution [cloth vertices] [m/s] iterate and dv
  void begin(Device& device, const RankRows& own, Index partial_rows,
             const Buffer<Vec3<T>>& velocities, const Buffer<Vec3<T>>& solution) {
    Queue& queue = device.compute();
    if (start.size() == 0) {
      const MemoryName name("solver");
      make(device, start, solution.size());
      make(device, direction, solution.size());
      make(device, partial,
           2 * static_cast<std::size_t>((own.count + partial_rows - 1) / partial_rows));
    }
    queue.copy(start.data(), velocities.data(), solution.size() * sizeof(Vec3<T>));
    queue.copy(direction.data(), solution.data(), solution.size() * sizeof(Vec3<T>));
  }

  /// velocities of own rows = start + share direction
  void move_along(Queue& queue, const RankRows& own, T share, Span<Vec3<T>> velocities) const {
    launch(queue, IntegrateUpdate<T>{own.begin, own.count, start.span(), direction.span(), share,
                                     velocities});
  }

  /// Submits the partial sums of products of the right-hand side, and their copy.
  void launch_products(Queue& queue, const RankRows& own, Index partial_rows,
                       Span<const Vec3<T>> rhs, Span<const unsigned char> fixed,
                       std::vector<double>& out) const {
    launch(queue, SolveProducts<T>{own.begin, own.count, partial_rows, rhs, direction.span(), fixed,
                                   partial.span()});
    out.resize(partial.size());
    queue.copy(out.data(), partial.data(), out.size() * sizeof(double));
  }
};

}  // namespace weft
