#pragma once

#include <condition_variable>
#include <cstddef>
#include <deque>
#include <exception>
#include <functional>
#include <mutex>
#include <thread>

namespace weft {

/// Does jobs in their order on another thread, which gives way to all others where cores are few.
class JobQueue {
 public:
  using Job = std::function<void()>;

  /// @param waiting_max jobs that may wait beside the one being done
  explicit JobQueue(std::size_t waiting_max);
  JobQueue(const JobQueue&) = delete;
  JobQueue& operator=(const JobQueue&) = delete;
  /// Does what is still to do. Errors that nobody has asked for are lost.
  ~JobQueue();

  /// Waits for room.
  /// @throws what an earlier job has thrown; all later jobs are dropped
  void add(Job job);

  /// Waits until all is done.
  /// @throws what a job has thrown
  void wait();

 private:
  void work();
  void rethrow() const;

  const std::size_t waiting_max_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<Job> jobs_;  ///< the first may be being done
  std::exception_ptr error_;
  bool ends_ = false;
  std::thread thread_;
};

}  // namespace weft
