#include "weft/exec/describe.hpp"

#include <algorithm>
#include <cstddef>
#include <iomanip>
#include <sstream>

#include "cuda/exec/check.cuh"

namespace weft {
namespace {

constexpr std::size_t copied_bytes = std::size_t{256} << 20;
constexpr int timed_copies = 5;

/// Two arrays and two events of the current GPU, given back whatever happens.
struct CopyTrial {
  void* to = nullptr;
  void* from = nullptr;
  cudaEvent_t start = nullptr;
  cudaEvent_t end = nullptr;

  CopyTrial() = default;
  CopyTrial(const CopyTrial&) = delete;
  CopyTrial& operator=(const CopyTrial&) = delete;
  ~CopyTrial() {
    cudaFree(to);
    cudaFree(from);
    if (start != nullptr) cudaEventDestroy(start);
    if (end != nullptr) cudaEventDestroy(end);
  }
};

void check(cudaError_t error, const char* api,
           const std::source_location& where = std::source_location::current()) {
  cuda::check(error, api, cuda::no_rank, where);
}

}  // namespace

double cuda_copy_bandwidth(int gpu) {
  check(cudaSetDevice(gpu), "cudaSetDevice");
  CopyTrial trial;
  check(cudaMalloc(&trial.to, copied_bytes), "cudaMalloc");
  check(cudaMalloc(&trial.from, copied_bytes), "cudaMalloc");
  check(cudaEventCreate(&trial.start), "cudaEventCreate");
  check(cudaEventCreate(&trial.end), "cudaEventCreate");
  check(cudaMemsetAsync(trial.from, 1, copied_bytes), "cudaMemsetAsync");
  float best_ms = 0;
  // The first copy warms up and does not count.
  for (int i = 0; i <= timed_copies; ++i) {
    check(cudaEventRecord(trial.start), "cudaEventRecord");
    check(cudaMemcpyAsync(trial.to, trial.from, copied_bytes, cudaMemcpyDeviceToDevice),
          "cudaMemcpyAsync");
    check(cudaEventRecord(trial.end), "cudaEventRecord");
    check(cudaEventSynchronize(trial.end), "cudaEventSynchronize");
    float ms = 0;
    check(cudaEventElapsedTime(&ms, trial.start, trial.end), "cudaEventElapsedTime");
    if (i == 1 || (i > 1 && ms < best_ms)) best_ms = ms;
  }
  return 2.0 * static_cast<double>(copied_bytes) / (static_cast<double>(best_ms) * 1e-3);
}

namespace {

/// "copies at 2.61 TB/s", or why that could not be measured.
std::string describe_copies(int gpu) {
  std::ostringstream text;
  try {
    text << "copies at " << std::fixed << std::setprecision(2) << cuda_copy_bandwidth(gpu) * 1e-12
         << " TB/s";
  } catch (const DeviceError& error) {
    text << "copies not measured: " << error.what();
  }
  return text.str();
}

std::string describe_peers(int gpu, int count) {
  std::string reached;
  for (int other = 0; other < count; ++other) {
    int possible = 0;
    if (other == gpu || cudaDeviceCanAccessPeer(&possible, gpu, other) != cudaSuccess) continue;
    if (possible != 0) reached.append(" ").append(std::to_string(other));
  }
  if (count == 1) return "no other GPU";
  return reached.empty() ? "reaches no other GPU" : "reaches GPUs" + reached;
}

}  // namespace

std::vector<std::string> describe_cuda_devices() {
  int count = 0;
  if (const cudaError_t error = cudaGetDeviceCount(&count); error != cudaSuccess) {
    cudaGetLastError();
    return {std::string("cuda: no GPU: ") + cudaGetErrorString(error)};
  }
  if (count == 0) return {"cuda: no GPU"};
  std::vector<std::string> lines;
  for (int gpu = 0; gpu < count; ++gpu) {
    cudaDeviceProp properties;
    std::ostringstream line;
    line << "cuda:" << gpu << ": ";
    if (const cudaError_t error = cudaGetDeviceProperties(&properties, gpu); error != cudaSuccess) {
      cudaGetLastError();
      line << "cannot be used: " << cudaGetErrorString(error);
    } else {
      line << properties.name << ", " << (properties.totalGlobalMem >> 30)
           << " GiB, compute capability " << properties.major << '.' << properties.minor << ", "
           << describe_copies(gpu) << ", " << describe_peers(gpu, count);
    }
    lines.push_back(line.str());
  }
  return lines;
}

}  // namespace weft
