#include "weft/kernels/assemble/external_work.hpp"

#include "cuda/exec/launch.cuh"
#include "cuda/exec/sums.cuh"

namespace weft {
namespace {

constexpr int external_work_threads = 256;

/// One block a partial sum: a thread adds every 256th item, lanes and warps are then joined
/// pairwise.
template <class T>
__global__ void __launch_bounds__(external_work_threads)
    external_work(const __grid_constant__ AssembleExternalWork<T> a, Index items) {
  __shared__ double warp_sum[external_work_threads / 32];
  const Index first = static_cast<Index>(blockIdx.x) * a.partial_items;
  const Index last = min(items, first + a.partial_items);
  double sum = 0;
  for (Index i = first + static_cast<Index>(threadIdx.x); i < last; i += external_work_threads)
    sum += assemble_external_work(a, i);
  sum = cuda::sum_lanes(sum);
  if (threadIdx.x % 32 == 0) warp_sum[threadIdx.x / 32] = sum;
  __syncthreads();
  if (threadIdx.x > 0) return;
  double all = 0;
  for (double of_warp : warp_sum) all += of_warp;
  a.partial.data()[blockIdx.x] = all;
}

}  // namespace

template <class T>
void run(OnCuda, Queue& queue, const AssembleExternalWork<T>& args) {
  if (args.items() <= 0) return;
  const auto& cuda_queue = static_cast<const CudaQueue&>(queue);
  cuda_queue.make_current();
  external_work<<<static_cast<unsigned>(args.partials()), external_work_threads, 0,
                  cuda_queue.stream()>>>(args, args.items());
  cuda::check(cudaGetLastError(), "kernel launch", cuda_queue.rank());
}

template void run(OnCuda, Queue&, const AssembleExternalWork<float>&);
template void run(OnCuda, Queue&, const AssembleExternalWork<double>&);

}  // namespace weft
