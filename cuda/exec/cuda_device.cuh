#pragma once

#include <cuda_runtime.h>

#include <atomic>
#include <cstddef>
#include <string>
#include <vector>

#include "weft/exec/device.hpp"

namespace weft {

/// The cards of a DeviceSet.
struct CardSet {
  int count;
  int apart[2];  ///< of two cards of which the first cannot reach the second's memory, or -1
};

/// A stream of one card. Errors of work that was accepted show in sync() or in a later call.
///
/// Host memory need not be pinned, but a copy to or from memory that is not keeps the caller until
/// the copy is under way (from the host) or done (to the host).
class CudaQueue final : public Queue {
 public:
  /// @throws DeviceError if the stream cannot be made
  CudaQueue(int rank, int card, const CardSet& cards);
  ~CudaQueue() override;
  CudaQueue(const CudaQueue&) = delete;
  CudaQueue& operator=(const CudaQueue&) = delete;

  Backend backend() const noexcept override { return Backend::cuda; }
  void copy(void* to, const void* from, std::size_t bytes) override;
  /// `to` is memory of a device.
  void fill(void* to, unsigned char value, std::size_t bytes) override;
  void stamp(double* seconds) override;
  Event record() override;
  void wait(const Event& event) override;
  void sync() override;

  int rank() const noexcept { return rank_; }
  int card() const noexcept { return card_; }
  cudaStream_t stream() const noexcept { return stream_; }
  /// Memory for the work that is submitted next, until the next call. Grows, never shrinks; a call
  /// that asks for no more than one before neither allocates nor waits.
  /// @return aligned to at least 256 bytes
  /// @throws DeviceError if there is not enough memory
  void* scratch(std::size_t bytes);
  /// Makes the queue's card the calling thread's current one, as launching a kernel requires.
  /// @throws DeviceError if the card is lost
  void make_current() const;
  /// Whether kernels of every card reach every other's memory.
  bool reaches_peers() const noexcept { return cards_.apart[0] < 0; }
  /// @throws DeviceError, naming two cards, unless they do
  void require_peers() const;
  /// How often scratch() has allocated.
  std::int64_t scratch_count() const noexcept { return scratch_count_; }
  std::size_t scratch_bytes() const noexcept { return scratch_bytes_; }

 private:
  /// A point in the stream whose time is asked for.
  struct Stamp {
    cudaEvent_t event;
    double* seconds;
  };
  cudaEvent_t timing_event();
  void tell_stamps();

  /// Card whose memory this is, or -1 for host memory.
  int card_of(const void* memory) const;

  int rank_;
  int card_;
  CardSet cards_;
  cudaStream_t stream_ = nullptr;
  void* scratch_ = nullptr;
  std::size_t scratch_bytes_ = 0;
  std::int64_t scratch_count_ = 0;
  cudaEvent_t base_ = nullptr;  ///< times are told from here: elapsed times are of single precision
  double base_seconds_ = 0;     ///< [s] of base_
  std::vector<Stamp> stamps_;   ///< since the last sync()
  std::vector<cudaEvent_t> spare_events_;
};

/// A rank on a card. Ranks on one card have their own streams and share its memory.
class CudaDevice final : public Device {
 public:
  /// @pre card exists
  /// @throws DeviceError if the card cannot be used
  CudaDevice(int rank, int card, const CardSet& cards);

  Backend backend() const noexcept override { return Backend::cuda; }
  std::string name() const override { return name_; }
  Queue& compute() noexcept override { return compute_; }
  Queue& transfer() noexcept override { return transfer_; }
  bool reaches_peers() const noexcept override { return compute_.reaches_peers(); }
  void* allocate(std::size_t bytes) override;
  /// Waits until the card is idle.
  void release(void* memory, std::size_t bytes) noexcept override;
  /// With the scratch memory of its queues, which never shrinks.
  std::size_t peak_bytes() const noexcept override { return peak_bytes_.load() + scratch_bytes(); }
  std::vector<MemoryUse> memory_use() const override;
  std::int64_t allocation_count() const noexcept override {
    return allocation_count_.load() + compute_.scratch_count() + transfer_.scratch_count();
  }

 private:
  std::size_t scratch_bytes() const noexcept {
    return compute_.scratch_bytes() + transfer_.scratch_bytes();
  }

  int rank_;
  int card_;
  std::string name_;
  std::atomic<std::size_t> held_bytes_{0};
  std::atomic<std::size_t> peak_bytes_{0};
  std::atomic<std::int64_t> allocation_count_{0};
  CudaQueue compute_;
  CudaQueue transfer_;
};

}  // namespace weft
