#pragma once

#include "host/asynchronous/window.hpp"
#include "host/state/store.hpp"

namespace weft {

/// The asynchronous method over the state of a store.
class AsynchronousStep {
 public:
  /// @param store must outlive this; its scene and model do not change meanwhile
  /// @throws SceneError as Windows
  explicit AsynchronousStep(Store<double>& store);
  AsynchronousStep(const AsynchronousStep&) = delete;
  AsynchronousStep& operator=(const AsynchronousStep&) = delete;
  ~AsynchronousStep();

  /// Advances the store's state to report.number times `dt`. If that fails report.failure says why,
  /// and the state is that of before.
  void advance(double dt, StepReport& report);

  Windows& windows() { return windows_; }

 private:
  void book_memory();

  Store<double>& store_;
  Windows windows_;
  Windows::Memory booked_;  ///< with the first rank
};

}  // namespace weft
