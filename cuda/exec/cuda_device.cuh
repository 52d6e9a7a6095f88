#pragma once

#include <cuda_runtime.h>

#include <atomic>
#include <cstddef>
#include <string>
#include <vector>

#include "weft/exec/device.hpp"

namespace weft {

/// The GPUs of a DeviceSet.
struct GpuSet {
  int count;
  int apart[2];  ///< of two GPUs of which the first cannot reach the second's memory, or -1
};

/// A stream of one GPU. Errors of work that was accepted show in sync() or in a later call.
///
/// Host memory need not be pinned, but a copy to or from memory that is not keeps the caller until
/// the copy is under way (from the host) or done (to the host).
class CudaQueue final : public Queue {
 public:
  /// @throws DeviceError if the stream cannot be made
  CudaQueue(int rank, int gpu, const GpuSet& gpus);
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
  void wait_for_stream(void* stream) override;
  void let_stream_wait(void* stream) override;
  void sync() override;

  int rank() const noexcept { return rank_; }
  int gpu() const noexcept { return gpu_; }
  cudaStream_t stream() const noexcept { return stream_; }
  /// Memory for the work that is submitted next, until the next call. Grows, never shrinks; a call
  /// that asks for no more than one before neither allocates nor waits.
  /// @return aligned to at least 256 bytes
  /// @throws DeviceError if there is not enough memory
  void* scratch(std::size_t bytes);
  /// Makes the queue's GPU the calling thread's current one, as launching a kernel requires.
  /// @throws DeviceError if the GPU is lost
  void make_current() const;
  /// Whether kernels of every GPU reach every other's memory.
  bool reaches_peers() const noexcept { return gpus_.apart[0] < 0; }
  /// @throws DeviceError, naming two GPUs, unless they do
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
  Event record_in(cudaStream_t stream) const;
  cudaEvent_t timing_event();
  void tell_stamps();

  /// GPU whose memory this is, or -1 for host memory.
  int gpu_of(const void* memory) const;

  int rank_;
  int gpu_;
  GpuSet gpus_;
  cudaStream_t stream_ = nullptr;
  void* scratch_ = nullptr;
  std::size_t scratch_bytes_ = 0;
  std::int64_t scratch_count_ = 0;
  cudaEvent_t base_ = nullptr;  ///< times are told from here: elapsed times are of single precision
  double base_seconds_ = 0;     ///< [s] of base_
  std::vector<Stamp> stamps_;   ///< since the last sync()
  std::vector<cudaEvent_t> spare_events_;
};

/// A rank on a GPU. Ranks on one GPU have their own streams and share its memory.
class CudaDevice final : public Device {
 public:
  /// @pre GPU exists
  /// @throws DeviceError if the GPU cannot be used
  CudaDevice(int rank, int gpu, const GpuSet& gpus);

  Backend backend() const noexcept override { return Backend::cuda; }
  std::string name() const override { return name_; }
  int gpu() const noexcept override { return gpu_; }
  Queue& compute() noexcept override { return compute_; }
  Queue& transfer() noexcept override { return transfer_; }
  bool reaches_peers() const noexcept override { return compute_.reaches_peers(); }
  void* allocate(std::size_t bytes) override;
  /// Waits until the GPU is idle.
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
  int gpu_;
  std::string name_;
  std::atomic<std::size_t> held_bytes_{0};
  std::atomic<std::size_t> peak_bytes_{0};
  std::atomic<std::int64_t> allocation_count_{0};
  CudaQueue compute_;
  CudaQueue transfer_;
};

}  // namespace weft
