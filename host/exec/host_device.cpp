#include "host/exec/host_device.hpp"

#include <chrono>
#include <cstring>
#include <new>
#include <utility>

#include "weft/error.hpp"
#include "weft/exec/large_pages.hpp"

namespace weft {
namespace {

constexpr std::align_val_t memory_alignment{256};

struct HostEvent final : Event::State {
  std::mutex mutex;
  std::condition_variable passed_changed;
  bool passed = false;

  void pass() {
    const std::lock_guard lock(mutex);
    passed = true;
    passed_changed.notify_all();
  }
  void block() {
    std::unique_lock lock(mutex);
    passed_changed.wait(lock, [this] { return passed; });
  }
};

/// Steele, Lea & Flood 2014, "Fast splittable pseudorandom number generators" (SplitMix64).
std::uint64_t next_random(std::uint64_t& state) {
  std::uint64_t z = (state += 0x9e3779b97f4a7c15u);
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
  return z ^ (z >> 31);
}

/// @param queue 0 or 1
HostDeviceOptions of_queue(HostDeviceOptions options, int rank, int queue) {
  if (options.delay_seed != 0)
    options.delay_seed += static_cast<std::uint64_t>(2 * rank + queue + 1);
  return options;
}

}  // namespace

HostQueue::HostQueue(bool threaded, const HostDeviceOptions& options)
    : delay_state_(options.delay_seed), threaded_(threaded), executor_(options.executor) {
  if (threaded_ && !executor_) thread_ = std::thread([this] { work_off(); });
}

HostQueue::~HostQueue() {
  {
    std::unique_lock lock(mutex_);
    idle_.wait(lock, [this] { return !asked_; });
    stopping_ = true;
  }
  if (!thread_.joinable()) return;
  arrived_.notify_one();
  thread_.join();
}

void HostQueue::append(Job job) {
  std::unique_lock lock(mutex_);
  jobs_.push_back(std::move(job));
  if (!threaded_) {
    // A piece of work that submits another comes first.
    while (!busy_ && !jobs_.empty()) work_off_first(lock);
    return;
  }
  const bool ask = executor_ && !asked_;
  asked_ = asked_ || ask;
  lock.unlock();
  if (ask) executor_([this] { work_off_present(); });
  if (!executor_) arrived_.notify_one();
}

void HostQueue::submit(std::function<void()> work) {
  append({std::move(work)});
}

void HostQueue::copy(void* to, const void* from, std::size_t bytes) {
  if (bytes == 0) return;
  submit([=] { std::memcpy(to, from, bytes); });
}

void HostQueue::fill(void* to, unsigned char value, std::size_t bytes) {
  if (bytes == 0) return;
  submit([=] { std::memset(to, value, bytes); });
}

void HostQueue::stamp(double* seconds) {
  submit([seconds] {
    *seconds =
        std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
  });
}

Event HostQueue::record() {
  auto state = std::make_shared<HostEvent>();
  append({[state] { state->pass(); }, true});
  return Event(state);
}

void HostQueue::wait(const Event& event) {
  if (event.state() == nullptr) return;
  append({[event] { static_cast<HostEvent*>(event.state())->block(); }, true});
}

void HostQueue::sync() {
  ++sync_count_;
  std::unique_lock lock(mutex_);
  idle_.wait(lock, [this] { return jobs_.empty() && !busy_; });
  if (error_) std::rethrow_exception(std::exchange(error_, nullptr));
}

void HostQueue::work_off() {
  std::unique_lock lock(mutex_);
  while (true) {
    arrived_.wait(lock, [this] { return stopping_ || !jobs_.empty(); });
    if (jobs_.empty()) return;
    work_off_first(lock);
  }
}

/// Until there is none.
void HostQueue::work_off_present() noexcept {
  std::unique_lock lock(mutex_);
  while (!jobs_.empty()) work_off_first(lock);
  asked_ = false;
  // Under the lock: whoever waits may destroy the queue as soon as it is released.
  idle_.notify_all();
}

/// Does the first piece of work that there is.
/// @param lock of mutex_; not held meanwhile
void HostQueue::work_off_first(std::unique_lock<std::mutex>& lock) {
  const Job job = std::move(jobs_.front());
  jobs_.pop_front();
  busy_ = true;
  const bool skipped = error_ != nullptr && !job.always;
  lock.unlock();
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
  lock.lock();
  if (error && !error_) error_ = error;
  busy_ = false;
  if (jobs_.empty()) idle_.notify_all();
}

HostDevice::HostDevice(int rank, bool alone, const HostDeviceOptions& options)
    : rank_(rank),
      poison_(options.poison),
      compute_(!alone || options.delay_seed != 0, of_queue(options, rank, 0)),
      transfer_(!alone || options.delay_seed != 0, of_queue(options, rank, 1)) {}

std::string HostDevice::name() const {
  return "host rank " + std::to_string(rank_);
}

void* HostDevice::allocate(std::size_t bytes) {
  if (bytes == 0) return nullptr;
  void* memory = ::operator new(bytes + readable_beyond, memory_alignment, std::nothrow);
  if (memory == nullptr)
    throw DeviceError("out of memory: " + name() + " asked for " + std::to_string(bytes) +
                      " bytes and holds " + std::to_string(held_bytes_.load()));
  ask_for_large_pages(memory, bytes);
  // All bits set is a quiet NaN in float and double, and an index that no span admits.
  if (poison_) std::memset(memory, 0xff, bytes);
  ++allocation_count_;
  const std::size_t held = held_bytes_ += bytes;
  std::size_t peak = peak_bytes_.load();
  while (held > peak && !peak_bytes_.compare_exchange_weak(peak, held)) {
  }
  return memory;
}

void HostDevice::release(void* memory, std::size_t bytes) noexcept {
  if (memory == nullptr) return;
  ::operator delete(memory, memory_alignment);
  held_bytes_ -= bytes;
}

}  // namespace weft
