#pragma once

#include "host/implicit/linear/rank_rows.hpp"
#include "weft/kernels/solve/pcg.hpp"

namespace weft {

/// A rank's vectors of conjugate gradients, its buffers for exchange with other ranks, and the
/// status of its solve.
template <class T>
struct KrylovVectors {
  Buffer<Vec3<T>> mesh_rhs;               ///< without contacts
  Buffer<Vec3<T>> rhs, x, u, r, w, p, s;  ///< see SolvePcgPart
  Buffer<Index> stamp, ghost, ghost_offset;
  Buffer<double> partial;
  Buffer<std::uint32_t> ready, receivers;
  Buffer<SolveStatus> status;
  Buffer<SolvePcgPart<T>> parts;

  /// Waits for the device.
  /// @param vertices of the cloth   @param partial_rows as in SolvePcg
  void make(Device& device, const RankRows& own, Index vertices, int ranks, Index partial_rows);

  /// Sets the spans of a part that are these.
  void fill(SolvePcgPart<T>& part) const;
};

}  // namespace weft
