#pragma once

#include <typeinfo>

#include "weft/exec/device.hpp"

namespace weft {

/// Sees every launch of the thread that asks for it, before and after it is submitted. For
/// benchmarks: it may submit work of its own and wait, but changes no result.
class LaunchObserver {
 public:
  virtual ~LaunchObserver() = default;
  /// @param queue that the launch goes to; all earlier work of it has been submitted
  virtual void before(Queue& queue) = 0;
  /// @param kernel type of the argument struct
  /// @param args   the struct; of a collective kernel rank 0's
  virtual void after(Queue& queue, const std::type_info& kernel, const void* args) = 0;

  /// Of this thread; null: none.
  inline static thread_local LaunchObserver* current = nullptr;
};

}  // namespace weft
