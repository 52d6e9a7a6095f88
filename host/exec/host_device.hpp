#pragma once

#include <atomic>
#include <condition_variable>
#include <deque>
#include <exception>
#include <functional>
#include <mutex>
#include <thread>

#include "host/exec/host_devices.hpp"

namespace weft {

/// A queue that one thread of its own works off, or a thread of an executor; or whoever submits to
/// it, at once, where nothing that it waits for comes later: waking a thread for each of many small
/// pieces of work takes longer than some of these. The first exception that a piece of work throws
/// is kept for sync(); later work is then skipped, but events still pass, so that nobody hangs.
class HostQueue final : public Queue {
 public:
  /// @param threaded false: whoever submits does the work
  HostQueue(bool threaded, const HostDeviceOptions& options);
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
  struct Job {
    std::function<void()> work;
    bool always = false;  ///< runs even after an error
  };
  void append(Job job);
  void work_off();
  void work_off_present() noexcept;
  void work_off_first(std::unique_lock<std::mutex>& lock);

  std::mutex mutex_;
  std::condition_variable arrived_;
  std::condition_variable idle_;
  std::deque<Job> jobs_;
  std::exception_ptr error_;
  std::uint64_t delay_state_;
  bool busy_ = false;
  bool stopping_ = false;
  bool threaded_;       ///< false: whoever submits does the work
  Executor executor_;   ///< runs work_off_present(); empty: thread_ does the work
  bool asked_ = false;  ///< the executor has a piece of work that has not returned
  std::thread thread_;
};

/// Runs `work` on the host queue that `queue` is.
inline void submit_host(Queue& queue, std::function<void()> work) {
  static_cast<HostQueue&>(queue).submit(std::move(work));
}

/// A rank on the processor: one thread for computing, one for transfers, memory of its own. A rank
/// that is alone waits for no other and has no threads, unless its work is delayed.
class HostDevice final : public Device {
 public:
  HostDevice(int rank, bool alone, const HostDeviceOptions& options);

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
  HostQueue compute_;
  HostQueue transfer_;
};

}  // namespace weft
