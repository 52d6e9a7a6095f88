#include "weft/kernels/assemble/step_energy.hpp"

#include "cuda/exec/launch.cuh"
#include "cuda/exec/sums.cuh"

namespace weft {
namespace {

constexpr int step_energy_threads = 256;

/// One block a partial sum: a thread adds every 256th row, lanes and warps are then joined
/// pairwise.
template <class T>
__global__ void __launch_bounds__(step_energy_threads)
    step_energy(const __grid_constant__ AssembleStepEnergy<T> a) {
  __shared__ double warp_sum[step_energy_threads / 32][3];
  const Index first = static_cast<Index>(blockIdx.x) * a.partial_rows;
  const Index last = min(a.row_count, first + a.partial_rows);
  double sum[3] = {};
  for (Index i = first + static_cast<Index>(threadIdx.x); i < last; i += step_energy_threads)
    add_step_energy(a, i, sum);
  const int warp = static_cast<int>(threadIdx.x) / 32;
  const int lane = static_cast<int>(threadIdx.x) % 32;
  for (int k = 0; k < 3; ++k) {
    sum[k] = cuda::sum_lanes(sum[k]);
    if (lane == 0) warp_sum[warp][k] = sum[k];
  }
  __syncthreads();
  if (threadIdx.x >= 3) return;
  double all = 0;
  for (int w = 0; w < step_energy_threads / 32; ++w) all += warp_sum[w][threadIdx.x];
  a.partial.data()[3 * blockIdx.x + threadIdx.x] = all;
}

}  // namespace

template <class T>
void run(OnCuda, Queue& queue, const AssembleStepEnergy<T>& args) {
  if (args.row_count <= 0) return;
  const auto& cuda_queue = static_cast<const CudaQueue&>(queue);
  cuda_queue.make_current();
  const auto blocks =
      static_cast<unsigned>((args.row_count + args.partial_rows - 1) / args.partial_rows);
  step_energy<<<blocks, step_energy_threads, 0, cuda_queue.stream()>>>(args);
  cuda::check(cudaGetLastError(), "kernel launch", cuda_queue.rank());
}

template void run(OnCuda, Queue&, const AssembleStepEnergy<float>&);
template void run(OnCuda, Queue&, const AssembleStepEnergy<double>&);

}  // namespace weft
