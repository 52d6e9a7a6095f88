#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <utility>

#include "host/exec/host_devices.hpp"
#include "host/exec/host_worker.hpp"

namespace weft {

/// A queue of a HostWorker's. The first exception that a piece of work throws is kept for sync();
/// later work is then skipped, but events still pass, so that nobody hangs.
class HostQueue final : public Queue {
 public:
  explicit HostQueue(std::shared_ptr<HostWorker> worker) : worker_(std::move(worker)) {}
  ~HostQueue() override;
  HostQueue(const HostQueue&) = delete;
  HostQueue& operator=(const HostQueue&) = delete;

  Backend backend() const noexcept override { return Backend::host; }
  void copy(void* to, const void* from, std::size_t bytes) override;
  void fill(void* to, unsigned char value, std::size_t bytes) override;
  void stamp(double* seconds) override;
  Event record() override;
  void wait(const Event& event) override;
  void wait_for_stream(void*) override {}
  void let_stream_wait(void*) override { sync(); }
  void sync() override;

  /// Appends a piece of work. Host kernels call this from run(OnHost, ...).
  void submit(std::function<void()> work);

 private:
  std::shared_ptr<HostWorker> worker_;
  HostWork work_;
};

/// Runs `work` on the host queue that `queue` is.
inline void submit_host(Queue& queue, std::function<void()> work) {
  static_cast<HostQueue&>(queue).submit(std::move(work));
}

/// A rank on the processor, which has its own memory. The work of both queues is done in the order
/// of submission, unless it is delayed or an executor does it.
class HostDevice final : public Device {
 public:
  /// @param first rank of the set; null: this
  HostDevice(int rank, bool alone, const HostDeviceOptions& options,
             const HostDevice* first = nullptr);

  Backend backend() const noexcept override { return Backend::host; }
  std::string name() const override;
  Queue& compute() noexcept override { return compute_; }
  Queue& transfer() noexcept override { return transfer_; }
  bool reaches_peers() const noexcept override { return true; }
  /// Bytes beyond the end of an allocation that may be read; their values mean nothing.
  static constexpr std::size_t readable_beyond = sizeof(double);
  void* allocate(std::size_t bytes) override;
  void release(void* memory, std::size_t bytes) noexcept override;
  std::size_t peak_bytes() const noexcept override { return peak_bytes_.load(); }
  std::int64_t allocation_count() const noexcept override { return allocation_count_.load(); }

 private:
  int rank_;
  bool poison_;
  std::atomic<std::size_t> held_bytes_{0};
  std::atomic<std::size_t> peak_bytes_{0};
  std::atomic<std::int64_t> allocation_count_{0};
  std::shared_ptr<HostWorker> worker_;
  HostQueue compute_;
  HostQueue transfer_;
};

}  // namespace weft
