#pragma once

#include "host/state/progress_board.hpp"
#include "weft/report.hpp"

namespace weft {

/// A method of simulation: advances the state of a store step by step. The methods adaptive and
/// view are the implicit one, with remeshing between steps; time_parallel runs any of the others in
/// slices.
class StepMethod {
 public:
  virtual ~StepMethod() = default;

  /// Advances the store's state by `dt`. On failure report.failure says why, and the state is
  /// unchanged.
  virtual void advance(double dt, StepReport& report) = 0;

  /// Publishes the progress of later steps on this board. Results do not depend on it.
  /// @param board must outlive the steps; its owner begins and ends each step on it
  virtual void publish_on(ProgressBoard& board) = 0;
};

}  // namespace weft
