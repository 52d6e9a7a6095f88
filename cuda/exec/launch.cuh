#pragma once

#include <algorithm>
#include <source_location>

#include "cuda/exec/check.cuh"
#include "cuda/exec/cuda_device.cuh"
#include "weft/core/ids.hpp"

namespace weft {

/// Threads of a block of every kernel that launch_for_each starts.
inline constexpr int for_each_threads = 256;
/// Blocks of a launch at most: enough to fill any GPU; beyond it a thread does several items.
inline constexpr Offset for_each_max_blocks = 65536;

template <class Args, class Body>
__global__ void __launch_bounds__(for_each_threads)
    for_each_item(const __grid_constant__ Args args, Index count, Body body) {
  const Offset stride = Offset{gridDim.x} * for_each_threads;
  for (Offset i = Offset{blockIdx.x} * for_each_threads + threadIdx.x; i < count; i += stride)
    body(args, static_cast<Index>(i));
}

/// Submits `body(args, i)` for i = 0 to count - 1, one thread an item, in no order.
/// @param queue a CudaQueue
/// @param args  spans of memory that the queue's GPU can reach
/// @param body  function object of device code; a copy goes to the GPU
/// @throws DeviceError if the GPU does not take the launch; the place named is the caller's
template <class Args, class Body>
void launch_for_each(Queue& queue, const Args& args, Index count, Body body,
                     const std::source_location& where = std::source_location::current()) {
  if (count <= 0) return;
  const auto& cuda_queue = static_cast<const CudaQueue&>(queue);
  cuda_queue.make_current();
  const Offset blocks = (Offset{count} + for_each_threads - 1) / for_each_threads;
  const auto grid = static_cast<unsigned>(std::min(blocks, for_each_max_blocks));
  for_each_item<<<grid, for_each_threads, 0, cuda_queue.stream()>>>(args, count, body);
  cuda::check(cudaGetLastError(), "kernel launch", cuda_queue.rank(), where);
}

}  // namespace weft
