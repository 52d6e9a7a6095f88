#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "weft/kernels/collide/pairs.hpp"

namespace weft {

/// Where the ranks' shares of a workload table begin: at equal parts of it (P-Cloth section 4.4)
/// until it is known what such shares come to, then where all would come to equally much. Which
/// rank asks what changes no result.
class WorkCuts {
 public:
  explicit WorkCuts(int ranks);

  WorkShare share(int rank) const;

  /// Moves the cuts so that all ranks would come to equally much, by what the shares of now and of
  /// earlier have told of each place in the table.
  /// @param came_to [ranks] work of the shares of now, >= 0
  void balance(const std::vector<double>& came_to);

 private:
  void learn(const std::vector<double>& came_to);

  std::vector<double> expected_;    ///< [equal parts of the table] over the mean
  std::vector<std::size_t> begin_;  ///< [ranks + 1] of these parts
};

}  // namespace weft
