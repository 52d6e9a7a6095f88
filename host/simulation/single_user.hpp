#pragma once

#include <atomic>
#include <stdexcept>
#include <thread>

namespace weft {

/// Notices if two threads use one thing at the same time. A thread that uses it may begin again.
class SingleUser {
 public:
  /// A thread's use, while it lives.
  class Use {
   public:
    /// @throws std::logic_error if another thread uses it now
    explicit Use(SingleUser& of) : of_(of) {
      const std::thread::id self = std::this_thread::get_id();
      std::thread::id user;
      first_ = of_.user_.compare_exchange_strong(user, self);
      if (!first_ && user != self)
        throw std::logic_error(
            "the simulation is in use by another thread; allowed: one thread at a time");
    }
    Use(const Use&) = delete;
    Use& operator=(const Use&) = delete;
    ~Use() {
      if (first_) of_.user_ = std::thread::id();
    }

   private:
    SingleUser& of_;
    bool first_;
  };

 private:
  std::atomic<std::thread::id> user_{};  ///< the default: none
};

}  // namespace weft
