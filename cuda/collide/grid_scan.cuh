#pragma once

#include <cooperative_groups.h>

#include <algorithm>
#include <cstddef>
#include <source_location>
#include <type_traits>

#include "cuda/exec/launch.cuh"
#include "cuda/exec/sums.cuh"
#include "weft/core/ids.hpp"

namespace weft {

/// Threads of a block of every kernel of which all blocks wait for each other.
inline constexpr int scan_threads = 512;
/// Its blocks at most.
inline constexpr int scan_blocks = 2048;

/// Arrays side by side in a queue's scratch memory.
class ScratchLayout {
 public:
  /// @return where an array of `count` T begins. [bytes]
  template <class T>
  std::size_t add(std::size_t count) {
    const std::size_t begin = bytes_;
    bytes_ += (count * sizeof(T) + 255) / 256 * 256;
    return begin;
  }
  std::size_t bytes() const noexcept { return bytes_; }

 private:
  std::size_t bytes_ = 0;
};

/// What a kernel whose blocks wait for each other runs on.
struct Together {
  const CudaQueue& queue;
  Offset items;  ///< that its threads share: no more blocks than these keep busy
  std::source_location where = std::source_location::current();
};

/// Submits a kernel whose blocks wait for each other.
/// @param kernel of scan_threads threads a block
/// @throws DeviceError if the GPU does not take the launch; the place named is the caller's
template <class... Parameters>
void launch_together(const Together& on, void (*kernel)(Parameters...),
                     std::type_identity_t<Parameters>... parameters) {
  const CudaQueue& queue = on.queue;
  queue.make_current();
  int processors = 0;
  cuda::check(cudaDeviceGetAttribute(&processors, cudaDevAttrMultiProcessorCount, queue.gpu()),
              "cudaDeviceGetAttribute", queue.rank(), on.where);
  int resident = 0;
  cuda::check(cudaOccupancyMaxActiveBlocksPerMultiprocessor(&resident, kernel, scan_threads, 0),
              "cudaOccupancyMaxActiveBlocksPerMultiprocessor", queue.rank(), on.where);
  const Offset wanted = (on.items + scan_threads - 1) / scan_threads;
  const Offset most = std::min(Offset{resident} * processors, Offset{scan_blocks});
  const auto blocks = static_cast<unsigned>(std::clamp(wanted, Offset{1}, most));
  void* arguments[] = {&parameters...};
  cuda::check(cudaLaunchCooperativeKernel(reinterpret_cast<const void*>(kernel), dim3(blocks),
                                          dim3(scan_threads), arguments, 0, queue.stream()),
              "cudaLaunchCooperativeKernel", queue.rank(), on.where);
}

/// Calls put(i, sum of value(j) over all j < i) for i = 0 to count, by all blocks of a launch
/// together. put(i) may overwrite what value(i) reads, and nothing else that value() reads.
/// @param block_sum [blocks] scratch of this scan alone
template <class S, class Value, class Put>
__device__ void scan_together(Offset count, S* block_sum, Value value, Put put) {
  __shared__ S warp_sum[scan_threads / 32];
  const Offset tiles = (count + scan_threads - 1) / scan_threads;
  const Offset share = (tiles + gridDim.x - 1) / gridDim.x * scan_threads;
  const Offset begin = min(count, share * blockIdx.x);
  const Offset end = min(count, begin + share);
  S own = 0;
  for (Offset i = begin + threadIdx.x; i < end; i += scan_threads) own += value(i);
  S total;
  cuda::sum_before<scan_threads>(own, warp_sum, total);
  if (threadIdx.x == 0) block_sum[blockIdx.x] = total;
  cooperative_groups::this_grid().sync();
  own = 0;
  for (unsigned b = threadIdx.x; b < blockIdx.x; b += scan_threads) own += block_sum[b];
  S before;
  cuda::sum_before<scan_threads>(own, warp_sum, before);
  for (Offset first = begin; first < end; first += scan_threads) {
    const Offset i = first + threadIdx.x;
    const S sum =
        before + cuda::sum_before<scan_threads>(i < end ? value(i) : S(0), warp_sum, total);
    if (i < end) put(i, sum);
    before += total;
  }
  if (blockIdx.x == gridDim.x - 1 && threadIdx.x == 0) put(count, before);
}

}  // namespace weft
