#include "host/base/job_queue.hpp"

#include <sys/resource.h>
#include <unistd.h>

#include <utility>

namespace weft {

JobQueue::JobQueue(std::size_t waiting_max)
    : waiting_max_(waiting_max), thread_([this] { work(); }) {}

JobQueue::~JobQueue() {
  {
    const std::lock_guard lock(mutex_);
    ends_ = true;
  }
  changed_.notify_all();
  thread_.join();
}

void JobQueue::add(Job job) {
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [this] { return jobs_.size() <= waiting_max_; });
  rethrow();
  jobs_.push_back(std::move(job));
  changed_.notify_all();
}

void JobQueue::wait() {
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [this] { return jobs_.empty(); });
  rethrow();
}

void JobQueue::rethrow() const {
  if (error_) std::rethrow_exception(error_);
}

void JobQueue::work() {
  // Of this thread alone, on Linux. If it fails, only times differ.
  constexpr int niceness = 10;
  ::setpriority(PRIO_PROCESS, static_cast<id_t>(::gettid()), niceness);
  std::unique_lock lock(mutex_);
  for (;;) {
    changed_.wait(lock, [this] { return ends_ || !jobs_.empty(); });
    if (jobs_.empty()) return;
    if (!error_) {
      Job job = std::move(jobs_.front());  // its place is taken until it is done
      lock.unlock();
      std::exception_ptr error;
      try {
        job();
      } catch (...) {
        error = std::current_exception();
      }
      job = nullptr;
      lock.lock();
      error_ = error;
    }
    jobs_.pop_front();
    changed_.notify_all();
  }
}

}  // namespace weft
