#include "benchmarks/support/delay.hpp"

#include <algorithm>

#include "cuda/exec/check.cuh"
#include "cuda/exec/cuda_device.cuh"

namespace weft::bench {
namespace {

__global__ void sleep_for(int microseconds) {
  for (int i = 0; i < microseconds; ++i) __nanosleep(1000);
}

}  // namespace

void delay(Queue& queue, int microseconds) {
  const auto& cuda_queue = static_cast<const CudaQueue&>(queue);
  cuda_queue.make_current();
  sleep_for<<<1, 1, 0, cuda_queue.stream()>>>(std::clamp(microseconds, 0, 1000));
  cuda::check(cudaGetLastError(), "kernel launch", cuda_queue.rank());
}

}  // namespace weft::bench
