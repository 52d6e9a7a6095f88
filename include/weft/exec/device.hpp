#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "weft/exec/memory_book.hpp"

namespace weft {

enum class Backend { host, cuda };

/// A point in a queue's work. Copies refer to the same point. Default-constructed: already passed.
class Event {
 public:
  struct State {
    virtual ~State() = default;
  };
  Event() = default;
  explicit Event(std::shared_ptr<State> state) : state_(std::move(state)) {}
  State* state() const noexcept { return state_.get(); }

 private:
  std::shared_ptr<State> state_;
};

/// Work of one device, done in the order of submission. Work in different queues is unordered, and
/// its effects are not visible to each other, unless an Event joins them.
class Queue {
 public:
  virtual ~Queue() = default;
  virtual Backend backend() const noexcept = 0;
  /// Copies between memories of any two devices of the set; neither range may be touched by other
  /// work until an event after the copy has passed.
  virtual void copy(void* to, const void* from, std::size_t bytes) = 0;
  /// Sets `bytes` bytes to `value`.
  virtual void fill(void* to, unsigned char value, std::size_t bytes) = 0;
  /// Stores the time [s], from a start of the queue's own, at which all work submitted so far was
  /// done. `seconds` is host memory and valid after sync().
  virtual void stamp(double* seconds) = 0;
  /// An event that passes once all work submitted so far is done.
  virtual Event record() = 0;
  /// Later work of this queue starts after `event` has passed.
  virtual void wait(const Event& event) = 0;
  /// Later work of this queue starts after what a stream of the program has so far.
  /// @param stream cudaStream_t on the queue's GPU; without meaning on the host
  virtual void wait_for_stream(void* stream) = 0;
  /// Later work of the stream starts after what this queue has so far. On the host: sync().
  virtual void let_stream_wait(void* stream) = 0;
  /// Blocks the caller until the queue is empty.
  /// @throws DeviceError or std::exception that a piece of work ended with
  virtual void sync() = 0;
  /// How often sync() has been called.
  std::int64_t sync_count() const noexcept { return sync_count_; }

 protected:
  std::int64_t sync_count_ = 0;
};

/// One rank: memory of its own, a compute queue and a transfer queue.
class Device {
 public:
  virtual ~Device() = default;
  virtual Backend backend() const noexcept = 0;
  virtual std::string name() const = 0;
  /// Number of the GPU; -1: the host.
  virtual int gpu() const noexcept { return -1; }
  virtual Queue& compute() noexcept = 0;
  virtual Queue& transfer() noexcept = 0;
  /// Whether kernels of all devices of the set reach each other's memory.
  virtual bool reaches_peers() const noexcept = 0;
  /// @return memory aligned to at least 256 bytes
  /// @throws DeviceError with the rank if there is not enough
  virtual void* allocate(std::size_t bytes) = 0;
  virtual void release(void* memory, std::size_t bytes) noexcept = 0;
  virtual std::size_t peak_bytes() const noexcept = 0;
  /// How often memory has been allocated.
  virtual std::int64_t allocation_count() const noexcept = 0;
  /// What buffers hold, by MemoryName, and what kernels keep to work with.
  virtual std::vector<MemoryUse> memory_use() const { return memory_.uses(); }
  /// Where buffers book what they hold.
  MemoryBook& memory() noexcept { return memory_; }

 private:
  MemoryBook memory_;
};

/// The ranks of a run, in order. All of one backend.
class DeviceSet {
 public:
  explicit DeviceSet(std::vector<std::unique_ptr<Device>> devices) : devices_(std::move(devices)) {}
  int size() const noexcept { return static_cast<int>(devices_.size()); }
  Device& operator[](int rank) const noexcept { return *devices_[static_cast<std::size_t>(rank)]; }
  Backend backend() const noexcept { return devices_.front()->backend(); }

  /// What runs on these devices ends at its next safe point once `flag` is true: a step with
  /// Failure::stopped, whatever is being set up with StoppedError. A signal handler may set it.
  /// @param flag must outlive the devices; null: nothing stops them
  void stop_on(const std::atomic<bool>* flag) noexcept { stop_ = flag; }
  const std::atomic<bool>* stop_flag() const noexcept { return stop_; }
  bool stop_requested() const noexcept {
    return stop_ != nullptr && stop_->load(std::memory_order_relaxed);
  }

 private:
  std::vector<std::unique_ptr<Device>> devices_;
  const std::atomic<bool>* stop_ = nullptr;
};

}  // namespace weft
