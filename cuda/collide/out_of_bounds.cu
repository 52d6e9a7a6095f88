#include "weft/kernels/collide/out_of_bounds.hpp"

#include "cuda/exec/launch.cuh"

namespace weft {
namespace {

template <class T>
__global__ void __launch_bounds__(for_each_threads)
    count_out_of_bounds(const __grid_constant__ CollideOutOfBounds<T> a) {
  const Offset v = a.vertex_begin + Offset{blockIdx.x} * for_each_threads + threadIdx.x;
  const bool outside = v < a.vertex_end && !keeps_to_its_box(a, static_cast<Index>(v));
  const int count = __syncthreads_count(outside);
  if (threadIdx.x == 0 && count > 0) atomicAdd(&a.counts.data()->out_of_bounds, count);
}

}  // namespace

template <class T>
void run(OnCuda, Queue& queue, const CollideOutOfBounds<T>& args) {
  queue.fill(&args.counts.data()->out_of_bounds, 0, sizeof(Index));
  if (args.vertex_end <= args.vertex_begin) return;
  const auto& cuda_queue = static_cast<const CudaQueue&>(queue);
  cuda_queue.make_current();
  const Index count = args.vertex_end - args.vertex_begin;
  const auto blocks = static_cast<unsigned>((count + for_each_threads - 1) / for_each_threads);
  count_out_of_bounds<<<blocks, for_each_threads, 0, cuda_queue.stream()>>>(args);
  cuda::check(cudaGetLastError(), "kernel launch", cuda_queue.rank());
}

template void run(OnCuda, Queue&, const CollideOutOfBounds<float>&);
template void run(OnCuda, Queue&, const CollideOutOfBounds<double>&);

}  // namespace weft
