#pragma once

#include <cstdint>
#include <vector>

#include "host/state/rank_geometry.hpp"
#include "host/state/store.hpp"

namespace weft {

/// The error of the step that the state has just taken, see IntegrateStepError. Rank 0 does all of
/// it, so the result is the same for any number of ranks.
template <class T>
class StepError {
 public:
  explicit StepError(Store<T>& store);

  /// @param geometry of rank 0
  /// @return root mean square over the free vertices of a component of cloth, over the tolerance:
  ///         the largest of all components. Waits for rank 0
  double measure(const RankGeometry<T>& geometry);

 private:
  Store<T>& store_;
  Buffer<std::int64_t> rank_sums_;
};

}  // namespace weft
