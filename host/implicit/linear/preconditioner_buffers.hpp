#pragma once

#include "host/implicit/linear/rank_rows.hpp"
#include "weft/kernels/solve/schwarz_levels.hpp"
#include "weft/scene.hpp"
#include "weft/state/contact_operator.hpp"

namespace weft {

/// Block Jacobi and the levels of aggregates in a rank's rows.
template <class T>
class PreconditionerBuffers {
 public:
  void make(Device& device, const RankRows& own, Preconditioner chosen, Index partial_rows);

  /// The matrix that is inverted, and which vertices are held. In the memory of the rank.
  struct Of {
    BlockEll<T> mesh;
    ScalarEll<T> far;
    ContactOperator<T> contact;
    Span<const unsigned char> fixed;
  };
  void launch_blocks(Queue& queue, const RankRows& own, const Of& of);
  void launch_levels(Queue& queue, const RankRows& own, const Of& of);

  RowBlocks<const T> blocks(const RankRows& own) const {
    return {own.block_slice(), inverse_.span()};
  }
  const FineLevel<T>& fine() const { return fine_; }
  const WideLevel<T>& wide() const { return wide_; }

 private:
  Buffer<T> inverse_, fine_inverse_, wide_inverse_;
  Buffer<double> wide_sum_;
  FineLevel<T> fine_;
  WideLevel<T> wide_;
};

}  // namespace weft
