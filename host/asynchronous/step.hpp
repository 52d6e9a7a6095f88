#pragma once

#include <cstdint>

#include "host/asynchronous/window.hpp"
#include "host/state/step_method.hpp"
#include "host/state/store.hpp"

namespace weft {

/// The asynchronous method. Advances the state of a store.
class AsynchronousStep final : public StepMethod {
 public:
  /// @param store must outlive this; its scene and model must not change
  /// @throws SceneError see Windows
  explicit AsynchronousStep(Store<double>& store);
  AsynchronousStep(const AsynchronousStep&) = delete;
  AsynchronousStep& operator=(const AsynchronousStep&) = delete;
  ~AsynchronousStep() override;

  /// To the time report.number * `dt`.
  void advance(double dt, StepReport& report) override;
  void publish_on(ProgressBoard& board) override { board_ = &board; }

  Windows& windows() { return windows_; }

 private:
  void book_memory();

  Store<double>& store_;
  ProgressBoard* board_ = nullptr;  ///< null: progress is not published
  Windows windows_;
  Windows::Memory booked_;         ///< booked as memory of the first rank
  std::int64_t own_restore_ = -1;  ///< of the state that the last step has left; -1: it failed
};

}  // namespace weft
