#include "host/exec/host_device.hpp"

#include <chrono>
#include <cstring>
#include <new>
#include <utility>

#include "weft/error.hpp"
#include "weft/exec/large_pages.hpp"
#include "weft/exec/spin.hpp"

namespace weft {
namespace {

constexpr std::align_val_t memory_alignment{256};

struct HostEvent final : Event::State {
  std::atomic<std::uint32_t> passed{0};

  void pass() {
    passed.store(1, std::memory_order_release);
    passed.notify_all();
  }
  void block() const {
    while (passed.load(std::memory_order_acquire) == 0) wait_for_change(passed, 0);
  }
};

HostWorker::By worked_off_by(bool alone, bool first, const HostDeviceOptions& options) {
  if (alone && options.delay_seed == 0) return HostWorker::By::submitter;
  if (options.executor) return HostWorker::By::executor;
  return first && options.delay_seed == 0 ? HostWorker::By::waiter : HostWorker::By::thread;
}

/// Whether each queue has another worker, so that their order is left to chance.
bool apart(const HostDeviceOptions& options) {
  return options.delay_seed != 0 || options.executor;
}

/// @param queue 0 or 1
std::shared_ptr<HostWorker> make_worker(int rank, int queue, bool alone, HostDeviceOptions options,
                                        std::shared_ptr<HostWorker> first) {
  if (options.delay_seed != 0)
    options.delay_seed += static_cast<std::uint64_t>(2 * rank + queue + 1);
  return std::make_shared<HostWorker>(worked_off_by(alone, first == nullptr, options), options,
                                      std::move(first));
}

}  // namespace

HostQueue::~HostQueue() {
  worker_->wait_for(work_);
  worker_->wait_for_executor();
}

void HostQueue::submit(std::function<void()> work) {
  worker_->append(work_, std::move(work), false);
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
  worker_->append(
      work_, [state] { state->pass(); }, true);
  return Event(state);
}

void HostQueue::wait(const Event& event) {
  if (event.state() == nullptr) return;
  worker_->append(
      work_, [event] { static_cast<HostEvent*>(event.state())->block(); }, true);
}

void HostQueue::sync() {
  ++sync_count_;
  worker_->wait_for(work_);
  if (const std::exception_ptr error = worker_->take_error(work_)) std::rethrow_exception(error);
}

HostDevice::HostDevice(int rank, bool alone, const HostDeviceOptions& options,
                       const HostDevice* first)
    : rank_(rank),
      poison_(options.poison),
      worker_(make_worker(rank, 0, alone, options, first == nullptr ? nullptr : first->worker_)),
      compute_(worker_),
      transfer_(apart(options) ? make_worker(rank, 1, alone, options, worker_) : worker_) {}

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
