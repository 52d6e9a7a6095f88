#include "weft/kernels/integrate/step_error.hpp"

#include "cuda/exec/launch.cuh"
#include "cuda/exec/sums.cuh"

namespace weft {
namespace {

constexpr int step_error_threads = 256;
/// Vertices of a thread: it joins those of one component before it adds them.
constexpr Index step_error_items = 8;

__device__ void add(const Span<std::int64_t>& sums, const VertexStepError& e) {
  if (e.component < 0) return;
  for (std::size_t k = 0; k < 2; ++k)
    atomicAdd(
        reinterpret_cast<unsigned long long*>(&sums[2 * static_cast<std::size_t>(e.component) + k]),
        static_cast<unsigned long long>(e.sum[k]));
}

template <class T>
__global__ void __launch_bounds__(step_error_threads)
    step_error(const __grid_constant__ IntegrateStepError<T> a, Index count) {
  const Offset first =
      Offset{blockIdx.x} * step_error_threads * step_error_items + Offset{threadIdx.x};
  VertexStepError own;
  for (Index k = 0; k < step_error_items; ++k) {
    const Offset i = first + Offset{k} * step_error_threads;
    if (i >= count) break;
    const VertexStepError e = integrate_step_error(a, static_cast<Index>(i));
    if (e.component < 0) continue;
    if (e.component != own.component) {
      add(a.sums, own);
      own = e;
      continue;
    }
    for (int s = 0; s < 2; ++s) own.sum[s] += e.sum[s];
  }
  int same = 0;
  __match_all_sync(cuda::whole_warp, own.component, &same);
  if (same == 0) {
    add(a.sums, own);
    return;
  }
  for (auto& sum : own.sum) sum = cuda::sum_lanes(sum);
  if (threadIdx.x % 32 == 0) add(a.sums, own);
}

}  // namespace

template <class T>
void run(OnCuda, Queue& queue, const IntegrateStepError<T>& args) {
  const auto count = static_cast<Index>(args.component_of_vertex.size());
  if (count <= 0) return;
  const auto& cuda_queue = static_cast<const CudaQueue&>(queue);
  cuda_queue.make_current();
  constexpr Offset block = Offset{step_error_threads} * step_error_items;
  const auto blocks = static_cast<unsigned>((Offset{count} + block - 1) / block);
  step_error<<<blocks, step_error_threads, 0, cuda_queue.stream()>>>(args, count);
  cuda::check(cudaGetLastError(), "kernel launch", cuda_queue.rank());
}

template void run(OnCuda, Queue&, const IntegrateStepError<float>&);
template void run(OnCuda, Queue&, const IntegrateStepError<double>&);

}  // namespace weft
