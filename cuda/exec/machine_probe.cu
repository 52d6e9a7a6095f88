#include "weft/exec/machine_probe.hpp"

#include <algorithm>
#include <chrono>
#include <cstddef>

#include "cuda/exec/check.cuh"
#include "cuda/exec/require_architecture.cuh"
#include "weft/exec/describe.hpp"

namespace weft {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::size_t small_bytes = 4096;
constexpr std::size_t large_bytes = std::size_t{32} << 20;
constexpr int chained_copies = 16;
constexpr int few_loads = 64;
constexpr int many_loads = 1088;
constexpr int repeats = 3;

/// `loads` loads of a zero, each of which needs the one before for its address.
__global__ void chase(const int* zero, int loads, int* end) {
  int at = 0;
  for (int n = 0; n < loads; ++n) at = __ldcv(zero + at);
  *end = at;
}

/// Loads everything; stores only what nothing is equal to, so that no load may be left out.
__global__ void read_all(const float4* from, std::size_t count, float* sink) {
  const std::size_t threads = std::size_t{gridDim.x} * blockDim.x;
  float sum = 0;
  for (std::size_t i = std::size_t{blockIdx.x} * blockDim.x + threadIdx.x; i < count;
       i += threads) {
    const float4 v = __ldcs(from + i);
    sum += v.x + v.y + v.z + v.w;
  }
  if (sum == 1.0f) *sink = sum;
}

/// What failed, between which GPUs.
void check(cudaError_t error, const char* api, int from, int to,
           const std::source_location& where = std::source_location::current()) {
  if (error == cudaSuccess) return;
  try {
    cuda::check(error, api, cuda::no_rank, where);
  } catch (const DeviceError& failed) {
    throw DeviceError("measuring GPUs " + std::to_string(from) + " and " + std::to_string(to) +
                      ": " + failed.what());
  }
}

/// Memory on two GPUs and a stream on the one that receives, given back whatever happens.
class LinkTrial {
 public:
  LinkTrial(int from, int to) : from_(from), to_(to) {}
  LinkTrial(const LinkTrial&) = delete;
  LinkTrial& operator=(const LinkTrial&) = delete;
  ~LinkTrial() {
    cudaSetDevice(to_);
    if (stream_ != nullptr) cudaStreamDestroy(stream_);
    cudaFree(target_);
    cudaSetDevice(from_);
    cudaFree(source_);
  }

  LinkFigures figures() {
    open();
    LinkFigures link;
    link.peer = peer_;
    link.copy_latency = best([this] { copy(small_bytes, chained_copies); }) / chained_copies;
    const double whole = best([this] { copy(large_bytes, 1); });
    link.copy_bandwidth = bandwidth(whole, link.copy_latency);
    if (!peer_) return link;
    const double few = best([this] { load_chain(few_loads); });
    const double many = best([this] { load_chain(many_loads); });
    link.load_latency = std::max(0.0, many - few) / (many_loads - few_loads);
    const double nothing = best([this] { read(small_bytes); });
    link.load_bandwidth = bandwidth(best([this] { read(large_bytes); }), nothing);
    return link;
  }

 private:
  void open() {
    check(cudaSetDevice(from_), "cudaSetDevice", from_, to_);
    check(cudaMalloc(&source_, large_bytes), "cudaMalloc", from_, to_);
    check(cudaMemset(source_, 0, large_bytes), "cudaMemset", from_, to_);
    check(cudaDeviceSynchronize(), "cudaDeviceSynchronize", from_, to_);
    peer_ = enable(from_, to_);
    peer_ = enable(to_, from_) && peer_;
    check(cudaSetDevice(to_), "cudaSetDevice", from_, to_);
    check(cudaMalloc(&target_, large_bytes), "cudaMalloc", from_, to_);
    check(cudaStreamCreateWithFlags(&stream_, cudaStreamNonBlocking), "cudaStreamCreateWithFlags",
          from_, to_);
  }

  /// @return whether kernels of `gpu` reach the memory of `other`
  bool enable(int gpu, int other) {
    if (gpu == other) return false;
    int possible = 0;
    check(cudaDeviceCanAccessPeer(&possible, gpu, other), "cudaDeviceCanAccessPeer", from_, to_);
    if (possible == 0) return false;
    check(cudaSetDevice(gpu), "cudaSetDevice", from_, to_);
    const cudaError_t error = cudaDeviceEnablePeerAccess(other, 0);
    if (error == cudaErrorPeerAccessAlreadyEnabled)
      cudaGetLastError();
    else
      check(error, "cudaDeviceEnablePeerAccess", from_, to_);
    return true;
  }

  static double bandwidth(double seconds, double latency) {
    return static_cast<double>(large_bytes) / std::max(seconds - latency, 1e-9);
  }

  void copy(std::size_t bytes, int count) {
    for (int n = 0; n < count; ++n)
      check(cudaMemcpyPeerAsync(target_, to_, source_, from_, bytes, stream_),
            "cudaMemcpyPeerAsync", from_, to_);
  }
  void load_chain(int loads) {
    chase<<<1, 1, 0, stream_>>>(static_cast<const int*>(source_), loads,
                                static_cast<int*>(target_));
    check(cudaGetLastError(), "chase", from_, to_);
  }
  void read(std::size_t bytes) {
    read_all<<<512, 512, 0, stream_>>>(static_cast<const float4*>(source_), bytes / sizeof(float4),
                                       static_cast<float*>(target_));
    check(cudaGetLastError(), "read_all", from_, to_);
  }

  /// Shortest wall time of a few calls, the wait for what they submit included [s]. The first one
  /// warms up and does not count.
  template <class Work>
  double best(const Work& work) {
    double shortest = 1e300;
    for (int n = 0; n <= repeats; ++n) {
      const auto start = Clock::now();
      work();
      check(cudaStreamSynchronize(stream_), "cudaStreamSynchronize", from_, to_);
      if (n > 0)
        shortest = std::min(shortest, std::chrono::duration<double>(Clock::now() - start).count());
    }
    return shortest;
  }

  int from_;
  int to_;
  bool peer_ = false;
  void* source_ = nullptr;
  void* target_ = nullptr;
  cudaStream_t stream_ = nullptr;
};

class CudaMachineProbe final : public MachineProbe {
 public:
  int gpu_count() override {
    ask();
    return count_;
  }
  std::string why_none() override {
    ask();
    return why_none_;
  }
  std::string name(int gpu) override {
    cudaDeviceProp properties;
    cuda::check(cudaGetDeviceProperties(&properties, gpu), "cudaGetDeviceProperties", gpu);
    return properties.name;
  }
  double bandwidth(int gpu) override {
    cuda::require_architecture(gpu, cuda::no_rank);
    try {
      return cuda_copy_bandwidth(gpu);
    } catch (const DeviceError& error) {
      throw DeviceError("measuring GPU " + std::to_string(gpu) + ": " + error.what());
    }
  }
  LinkFigures link(int from, int to) override { return LinkTrial(from, to).figures(); }

 private:
  void ask() {
    if (asked_) return;
    const cudaError_t error = cudaGetDeviceCount(&count_);
    if (error == cudaErrorNoDevice || error == cudaErrorInsufficientDriver) {
      cudaGetLastError();
      count_ = 0;
      why_none_ = std::string("no GPU: ") + cudaGetErrorString(error);
    } else {
      cuda::check(error, "cudaGetDeviceCount", cuda::no_rank);
      if (count_ == 0) why_none_ = "no GPU";
    }
    asked_ = true;
  }

  bool asked_ = false;
  int count_ = 0;
  std::string why_none_;
};

}  // namespace

std::unique_ptr<MachineProbe> cuda_machine_probe() {
  return std::make_unique<CudaMachineProbe>();
}

}  // namespace weft
