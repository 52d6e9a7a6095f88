#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "weft/kernels/collide/pairs.hpp"

namespace weft {

/// Where the ranks' shares of a workload table begin: at equal parts of it (P-Cloth section 4.4)
/// until it is known what came of such shares, then where each rank would have found equally much.
/// Which rank asks what changes no result.
class WorkCuts {
 public:
  explicit WorkCuts(int ranks);

  WorkShare share(int rank) const {
    const auto r = static_cast<std::size_t>(rank);
    return {begin_[r], begin_[r + 1]};
  }

  /// Moves the cuts so that all ranks would find equally much, if within each of the shares so far
  /// what was found goes with what stands in the cells.
  /// @param found [ranks] what the shares so far came to, such as pairs; >= 0
  void balance(const std::vector<double>& found);

 private:
  std::vector<std::uint32_t> begin_;  ///< [ranks + 1], see WorkShare
};

}  // namespace weft
