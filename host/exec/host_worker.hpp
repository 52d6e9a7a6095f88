#pragma once

#include <atomic>
#include <cstdint>
#include <deque>
#include <exception>
#include <functional>
#include <memory>
#include <mutex>
#include <thread>

#include "host/exec/host_devices.hpp"

namespace weft {

/// What has become of a queue's work.
struct HostWork {
  std::atomic<std::uint32_t> unfinished{0};
  std::exception_ptr error;  ///< the first; under the lock of the worker
};

/// Does pieces of work in the order in which they arrive, for one queue or for several.
class HostWorker final : public std::enable_shared_from_this<HostWorker> {
 public:
  /// Who lends the processor.
  enum class By {
    submitter,  ///< whoever brings a piece, at once. For work that waits for nothing that is later
    waiter,     ///< whoever waits for any work of the set of devices, which else would only sleep
    thread,     ///< a thread of the worker's
    executor,   ///< pieces of work of an executor
  };

  /// @param first worker of the set of devices, if this is another that waits for its work; or null
  HostWorker(By by, const HostDeviceOptions& options, std::shared_ptr<HostWorker> first = nullptr);
  ~HostWorker();
  HostWorker(const HostWorker&) = delete;
  HostWorker& operator=(const HostWorker&) = delete;

  /// @param always even after an error of the same queue
  void append(HostWork& of, std::function<void()> work, bool always);

  /// Blocks until all work of a queue of this worker is done. If the first worker of the set is
  /// By::waiter, its work is done meanwhile.
  void wait_for(const HostWork& of);

  /// The first error of a queue since the last call; null if there is none.
  std::exception_ptr take_error(HostWork& of);

  /// Blocks until no piece of work that an executor was given is left.
  void wait_for_executor() const;

 private:
  struct Job {
    HostWork* of;
    std::function<void()> work;
    bool always;
  };
  std::unique_lock<std::mutex> lock();
  bool work_off_first();
  void serve();
  void work_off_present() noexcept;
  HostWorker& first() noexcept { return first_ ? *first_ : *this; }
  void wake_waiters();

  const By by_;
  const std::shared_ptr<HostWorker> first_;  ///< where all of the set are waited for; null: here
  std::mutex mutex_;
  std::deque<Job> jobs_;
  bool busy_ = false;
  std::uint64_t delay_state_;
  Executor executor_;
  std::atomic<std::uint32_t> asked_{0};    ///< 1: the executor has a piece that has not returned
  std::atomic<std::uint32_t> arrived_{0};  ///< counts what the thread waits for
  std::atomic<std::uint32_t> changed_{0};  ///< counts what wait_for() waits for
  std::atomic<bool> stopping_{false};
  std::thread thread_;
};

}  // namespace weft
