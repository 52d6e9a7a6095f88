#pragma once

#include <atomic>

#include "host/asynchronous/workers.hpp"

namespace weft {

/// The threads of one of two pieces of work that go on side by side: a team of its own, and all
/// threads once the other one is done.
struct WorkerGroup {
  Workers& own;
  Workers& all;
  const std::atomic<bool>* other_is_done = nullptr;  ///< null: there is no other one
  const std::atomic<bool>* stop = nullptr;           ///< null: nobody stops it

  Workers& workers() const {
    const bool alone = other_is_done != nullptr && other_is_done->load(std::memory_order_acquire);
    return alone ? all : own;
  }
  bool stopped() const { return stop != nullptr && stop->load(std::memory_order_relaxed); }
};

}  // namespace weft
