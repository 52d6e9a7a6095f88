#include "cuda/exec/cuda_device.cuh"

#include <algorithm>
#include <memory>
#include <vector>

#include "cuda/exec/check.cuh"
#include "cuda/exec/require_architecture.cuh"
#include "weft/devices.hpp"

namespace weft {
namespace {

struct CudaEvent final : Event::State {
  cudaEvent_t event = nullptr;
  CudaEvent() = default;
  CudaEvent(const CudaEvent&) = delete;
  CudaEvent& operator=(const CudaEvent&) = delete;
  ~CudaEvent() override {
    if (event != nullptr) cudaEventDestroy(event);
  }
};

/// Lets kernels and copies of either GPU reach the other's memory.
/// @return whether the machine can do that
bool enable_peer_access(int from, int to) {
  int possible = 0;
  cuda::check(cudaDeviceCanAccessPeer(&possible, from, to), "cudaDeviceCanAccessPeer",
              cuda::no_rank);
  if (possible == 0) return false;
  cuda::check(cudaSetDevice(from), "cudaSetDevice", cuda::no_rank);
  const cudaError_t error = cudaDeviceEnablePeerAccess(to, 0);
  if (error == cudaErrorPeerAccessAlreadyEnabled) {
    cudaGetLastError();
    return true;
  }
  cuda::check(error, "cudaDeviceEnablePeerAccess", cuda::no_rank);
  return true;
}

std::string device_name(int rank, int gpu) {
  cudaDeviceProp properties;
  cuda::check(cudaGetDeviceProperties(&properties, gpu), "cudaGetDeviceProperties", rank);
  return "cuda rank " + std::to_string(rank) + ", GPU " + std::to_string(gpu) + ", " +
         properties.name;
}

}  // namespace

CudaQueue::CudaQueue(int rank, int gpu, const GpuSet& gpus) : rank_(rank), gpu_(gpu), gpus_(gpus) {
  make_current();
  // Streams of the default kind would wait for work that other code gives to the default stream.
  cuda::check(cudaStreamCreateWithFlags(&stream_, cudaStreamNonBlocking),
              "cudaStreamCreateWithFlags", rank_);
}

CudaQueue::~CudaQueue() {
  cudaSetDevice(gpu_);
  cudaStreamSynchronize(stream_);
  cudaStreamDestroy(stream_);
  cudaFree(scratch_);
  for (const Stamp& stamp : stamps_) cudaEventDestroy(stamp.event);
  for (cudaEvent_t event : spare_events_) cudaEventDestroy(event);
  if (base_ != nullptr) cudaEventDestroy(base_);
}

void* CudaQueue::scratch(std::size_t bytes) {
  if (bytes <= scratch_bytes_) return scratch_;
  sync();
  cuda::check(cudaFree(scratch_), "cudaFree", rank_);
  scratch_ = nullptr;
  scratch_bytes_ = 0;
  const std::size_t size = bytes + bytes / 4;
  cuda::check(cudaMalloc(&scratch_, size), "cudaMalloc", rank_);
  scratch_bytes_ = size;
  ++scratch_count_;
  return scratch_;
}

void CudaQueue::make_current() const {
  cuda::check(cudaSetDevice(gpu_), "cudaSetDevice", rank_);
}

void CudaQueue::require_peers() const {
  if (!reaches_peers())
    throw DeviceError("rank " + std::to_string(rank_) + ": GPU " + std::to_string(gpus_.apart[0]) +
                      " cannot reach the memory of GPU " + std::to_string(gpus_.apart[1]) +
                      ", as the transport peer requires; see solver.transport");
}

int CudaQueue::gpu_of(const void* memory) const {
  cudaPointerAttributes attributes;
  cuda::check(cudaPointerGetAttributes(&attributes, memory), "cudaPointerGetAttributes", rank_);
  return attributes.type == cudaMemoryTypeDevice ? attributes.device : -1;
}

void CudaQueue::copy(void* to, const void* from, std::size_t bytes) {
  if (bytes == 0) return;
  make_current();
  if (gpus_.count > 1) {
    const int to_gpu = gpu_of(to);
    const int from_gpu = gpu_of(from);
    if (to_gpu >= 0 && from_gpu >= 0 && to_gpu != from_gpu) {
      cuda::check(cudaMemcpyPeerAsync(to, to_gpu, from, from_gpu, bytes, stream_),
                  "cudaMemcpyPeerAsync", rank_);
      return;
    }
  }
  cuda::check(cudaMemcpyAsync(to, from, bytes, cudaMemcpyDefault, stream_), "cudaMemcpyAsync",
              rank_);
}

void CudaQueue::fill(void* to, unsigned char value, std::size_t bytes) {
  if (bytes == 0) return;
  make_current();
  cuda::check(cudaMemsetAsync(to, value, bytes, stream_), "cudaMemsetAsync", rank_);
}

cudaEvent_t CudaQueue::timing_event() {
  cudaEvent_t event = nullptr;
  if (spare_events_.empty()) {
    cuda::check(cudaEventCreate(&event), "cudaEventCreate", rank_);
  } else {
    event = spare_events_.back();
    spare_events_.pop_back();
  }
  cuda::check(cudaEventRecord(event, stream_), "cudaEventRecord", rank_);
  return event;
}

void CudaQueue::stamp(double* seconds) {
  make_current();
  if (base_ == nullptr) base_ = timing_event();
  stamps_.push_back({timing_event(), seconds});
}

/// @pre the stream is empty
void CudaQueue::tell_stamps() {
  if (stamps_.empty()) return;
  for (const Stamp& stamp : stamps_) {
    float milliseconds = 0;
    cuda::check(cudaEventElapsedTime(&milliseconds, base_, stamp.event), "cudaEventElapsedTime",
                rank_);
    *stamp.seconds = base_seconds_ + static_cast<double>(milliseconds) * 1e-3;
    spare_events_.push_back(stamp.event);
  }
  // Later times are told from the last one.
  base_seconds_ = *stamps_.back().seconds;
  std::swap(base_, spare_events_.back());
  stamps_.clear();
}

Event CudaQueue::record_in(cudaStream_t stream) const {
  make_current();
  auto state = std::make_shared<CudaEvent>();
  cuda::check(cudaEventCreateWithFlags(&state->event, cudaEventDisableTiming),
              "cudaEventCreateWithFlags", rank_);
  cuda::check(cudaEventRecord(state->event, stream), "cudaEventRecord", rank_);
  return Event(state);
}

Event CudaQueue::record() {
  return record_in(stream_);
}

void CudaQueue::wait_for_stream(void* stream) {
  wait(record_in(static_cast<cudaStream_t>(stream)));
}

void CudaQueue::let_stream_wait(void* stream) {
  const Event here = record();
  cuda::check(cudaStreamWaitEvent(static_cast<cudaStream_t>(stream),
                                  static_cast<const CudaEvent*>(here.state())->event, 0),
              "cudaStreamWaitEvent", rank_);
}

void CudaQueue::wait(const Event& event) {
  if (event.state() == nullptr) return;
  const auto* state = dynamic_cast<const CudaEvent*>(event.state());
  if (state == nullptr)
    throw DeviceError("rank " + std::to_string(rank_) +
                      ": a CUDA queue cannot wait for another backend's event");
  make_current();
  cuda::check(cudaStreamWaitEvent(stream_, state->event, 0), "cudaStreamWaitEvent", rank_);
}

void CudaQueue::sync() {
  ++sync_count_;
  make_current();
  cuda::check(cudaStreamSynchronize(stream_), "cudaStreamSynchronize", rank_);
  tell_stamps();
}

CudaDevice::CudaDevice(int rank, int gpu, const GpuSet& gpus)
    : rank_(rank),
      gpu_(gpu),
      name_(device_name(rank, gpu)),
      compute_(rank, gpu, gpus),
      transfer_(rank, gpu, gpus) {}

void* CudaDevice::allocate(std::size_t bytes) {
  if (bytes == 0) return nullptr;
  compute_.make_current();
  void* memory = nullptr;
  const cudaError_t error = cudaMalloc(&memory, bytes);
  if (error == cudaErrorMemoryAllocation) {
    cudaGetLastError();
    throw DeviceError("out of memory: " + name_ + " asked for " + std::to_string(bytes) +
                      " bytes and holds " + std::to_string(held_bytes_.load()) +
                      "; cudaMalloc at " + cuda::place(std::source_location::current()));
  }
  cuda::check(error, "cudaMalloc", rank_);
  ++allocation_count_;
  const std::size_t held = held_bytes_ += bytes;
  std::size_t peak = peak_bytes_.load();
  while (held > peak && !peak_bytes_.compare_exchange_weak(peak, held)) {
  }
  return memory;
}

void CudaDevice::release(void* memory, std::size_t bytes) noexcept {
  if (memory == nullptr) return;
  cudaSetDevice(gpu_);
  cudaFree(memory);
  held_bytes_ -= bytes;
}

std::vector<MemoryUse> CudaDevice::memory_use() const {
  std::vector<MemoryUse> uses = Device::memory_use();
  if (scratch_bytes() > 0) uses.push_back({"scratch", scratch_bytes(), scratch_bytes()});
  return uses;
}

DeviceSet cuda_devices(const std::vector<int>& gpus) {
  if (gpus.empty()) throw DeviceError("cannot make 0 CUDA devices; name at least one GPU");
  int count = 0;
  cuda::check(cudaGetDeviceCount(&count), "cudaGetDeviceCount", cuda::no_rank);
  for (std::size_t rank = 0; rank < gpus.size(); ++rank)
    if (gpus[rank] < 0 || gpus[rank] >= count)
      throw DeviceError("rank " + std::to_string(rank) + ": CUDA GPU " +
                        std::to_string(gpus[rank]) + " is missing; this machine has " +
                        std::to_string(count));
  for (std::size_t rank = 0; rank < gpus.size(); ++rank)
    cuda::require_architecture(gpus[rank], static_cast<int>(rank));

  std::vector<int> distinct = gpus;
  std::sort(distinct.begin(), distinct.end());
  distinct.erase(std::unique(distinct.begin(), distinct.end()), distinct.end());
  GpuSet set{static_cast<int>(distinct.size()), {-1, -1}};
  for (const int from : distinct)
    for (const int to : distinct)
      if (from != to && !enable_peer_access(from, to)) {
        set.apart[0] = from;
        set.apart[1] = to;
      }

  std::vector<std::unique_ptr<Device>> devices;
  for (const int gpu : gpus)
    devices.push_back(std::make_unique<CudaDevice>(static_cast<int>(devices.size()), gpu, set));
  return DeviceSet(std::move(devices));
}

}  // namespace weft
