#pragma once

#include <cstdint>

#include "host/asynchronous/window.hpp"
#include "host/state/store.hpp"

namespace weft {

/// The asynchronous method. Advances the state of a store.
class AsynchronousStep {
 public:
  /// @param store must outlive this; its scene and model must not change
  /// @throws SceneError see Windows
  explicit AsynchronousStep(Store<double>& store);
  AsynchronousStep(const AsynchronousStep&) = delete;
  AsynchronousStep& operator=(const AsynchronousStep&) = delete;
  ~AsynchronousStep();

  /// Advances the store's state to the time report.number * `dt`. On failure, report.failure gives
  /// the reason, and the state does not change.
  void advance(double dt, StepReport& report);

  Windows& windows() { return windows_; }

 private:
  void book_memory();

  Store<double>& store_;
  Windows windows_;
  Windows::Memory booked_;         ///< booked as memory of the first rank
  std::int64_t own_restore_ = -1;  ///< of the state that the last step has left; -1: it failed
};

}  // namespace weft
