#include "host/exec/host_worker.hpp"

#include <chrono>
#include <utility>

#include "weft/exec/spin.hpp"

namespace weft {
namespace {

/// Steele, Lea & Flood 2014, "Fast splittable pseudorandom number generators" (SplitMix64).
std::uint64_t next_random(std::uint64_t& state) {
  std::uint64_t z = (state += 0x9e3779b97f4a7c15u);
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
  return z ^ (z >> 31);
}

}  // namespace

HostWorker::HostWorker(By by, const HostDeviceOptions& options, std::shared_ptr<HostWorker> first)
    : by_(by),
      first_(std::move(first)),
      delay_state_(options.delay_seed),
      executor_(options.executor) {
  if (by_ == By::thread) thread_ = std::thread([this] { serve(); });
}

HostWorker::~HostWorker() {
  if (!thread_.joinable()) return;
  stopping_ = true;
  ++arrived_;
  arrived_.notify_one();
  thread_.join();
}

/// Of mutex_, which is held for some instructions only: sleeping takes longer than these.
std::unique_lock<std::mutex> HostWorker::lock() {
  std::unique_lock lock(mutex_, std::defer_lock);
  for (int look = 0; look < 100; ++look) {
    if (lock.try_lock()) return lock;
    relax();
  }
  lock.lock();
  return lock;
}

void HostWorker::append(HostWork& of, std::function<void()> work, bool always) {
  bool ask = false;
  {
    const auto held = lock();
    jobs_.push_back({&of, std::move(work), always});
    // Only now: where there is no memory for it, nobody must wait for it.
    of.unfinished.fetch_add(1, std::memory_order_relaxed);
    if (by_ == By::executor) ask = asked_.exchange(1) == 0;
  }
  switch (by_) {
    case By::submitter:
      // A piece of work that submits another comes first.
      while (work_off_first()) {
      }
      break;
    case By::waiter:
      wake_waiters();
      break;
    case By::thread:
      ++arrived_;
      arrived_.notify_one();
      break;
    case By::executor:
      if (ask) executor_([self = shared_from_this()] { self->work_off_present(); });
      break;
  }
}

void HostWorker::wait_for(const HostWork& of) {
  HostWorker& at = first();
  while (true) {
    const std::uint32_t seen = at.changed_.load(std::memory_order_acquire);
    if (of.unfinished.load(std::memory_order_acquire) == 0) return;
    if (at.by_ == By::waiter && at.work_off_first()) continue;
    wait_for_change(at.changed_, seen);
  }
}

std::exception_ptr HostWorker::take_error(HostWork& of) {
  const auto held = lock();
  return std::exchange(of.error, nullptr);
}

void HostWorker::wait_for_executor() const {
  while (asked_.load(std::memory_order_acquire) != 0) wait_for_change(asked_, 1);
}

void HostWorker::wake_waiters() {
  changed_.fetch_add(1, std::memory_order_acq_rel);
  changed_.notify_all();
}

void HostWorker::serve() {
  while (true) {
    const std::uint32_t seen = arrived_.load(std::memory_order_acquire);
    if (work_off_first()) continue;
    if (stopping_) return;
    wait_for_change(arrived_, seen);
  }
}

/// Until there is none.
void HostWorker::work_off_present() noexcept {
  while (true) {
    if (work_off_first()) continue;
    const auto held = lock();
    if (!jobs_.empty()) continue;
    asked_ = 0;
    break;
  }
  asked_.notify_all();
}

/// @return whether there was a piece of work that nobody was busy with
bool HostWorker::work_off_first() {
  auto held = lock();
  if (busy_ || jobs_.empty()) return false;
  Job job = std::move(jobs_.front());
  jobs_.pop_front();
  busy_ = true;
  const bool skipped = job.of->error != nullptr && !job.always;
  held.unlock();
  if (delay_state_ != 0)
    std::this_thread::sleep_for(std::chrono::microseconds(next_random(delay_state_) % 200));
  std::exception_ptr error;
  if (!skipped) {
    try {
      job.work();
    } catch (...) {
      error = std::current_exception();
    }
  }
  // What it refers to may be gone once it counts as done.
  job.work = nullptr;
  held = lock();
  if (error && !job.of->error) job.of->error = std::move(error);
  busy_ = false;
  held.unlock();
  // The queue may be gone as soon as it has no work. Whoever waits for another one may take over.
  const bool idle = job.of->unfinished.fetch_sub(1, std::memory_order_acq_rel) == 1;
  if (idle || by_ == By::waiter) first().wake_waiters();
  return true;
}

}  // namespace weft
