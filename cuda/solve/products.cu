#include "weft/kernels/solve/products.hpp"

#include "cuda/exec/launch.cuh"
#include "cuda/exec/sums.cuh"

namespace weft {
namespace {

constexpr int products_threads = 256;

/// One block a partial sum: a thread adds every 256th row, lanes and warps are then joined
/// pairwise.
template <class T>
__global__ void __launch_bounds__(products_threads)
    solve_products(const __grid_constant__ SolveProducts<T> a) {
  __shared__ double warp_sum[products_threads / 32][2];
  const Index first = static_cast<Index>(blockIdx.x) * a.partial_rows;
  const Index last = min(a.row_count, first + a.partial_rows);
  double sum[2] = {};
  for (Index i = first + static_cast<Index>(threadIdx.x); i < last; i += products_threads) {
    if (a.fixed.data()[a.row_begin + i] != 0) continue;
    const Vec3<double> r = vec_cast<double>(a.residual.data()[i]);
    sum[0] += dot(r, vec_cast<double>(a.direction.data()[a.row_begin + i]));
    sum[1] += dot(r, r);
  }
  const int warp = static_cast<int>(threadIdx.x) / 32;
  const int lane = static_cast<int>(threadIdx.x) % 32;
  for (int k = 0; k < 2; ++k) {
    sum[k] = cuda::sum_lanes(sum[k]);
    if (lane == 0) warp_sum[warp][k] = sum[k];
  }
  __syncthreads();
  if (threadIdx.x >= 2) return;
  double all = 0;
  for (int w = 0; w < products_threads / 32; ++w) all += warp_sum[w][threadIdx.x];
  a.partial.data()[2 * blockIdx.x + threadIdx.x] = all;
}

}  // namespace

template <class T>
void run(OnCuda, Queue& queue, const SolveProducts<T>& args) {
  if (args.row_count <= 0) return;
  const auto& cuda_queue = static_cast<const CudaQueue&>(queue);
  cuda_queue.make_current();
  const auto blocks =
      static_cast<unsigned>((args.row_count + args.partial_rows - 1) / args.partial_rows);
  solve_products<<<blocks, products_threads, 0, cuda_queue.stream()>>>(args);
  cuda::check(cudaGetLastError(), "kernel launch", cuda_queue.rank());
}

template void run(OnCuda, Queue&, const SolveProducts<float>&);
template void run(OnCuda, Queue&, const SolveProducts<double>&);

}  // namespace weft
