#include "cuda/exec/launch.cuh"
#include "cuda/respond/zone_teams.cuh"
#include "weft/kernels/respond/zone/solver.hpp"

namespace weft {
namespace {

/// Blocks look for the zones side by side, each through all of them.
template <class T>
__global__ void __launch_bounds__(zone_threads)
    solve_zones_together(const __grid_constant__ RespondZones<T> a, double* of_blocks) {
  __shared__ double parts[2 * zone_warps];
  GridTeam team(parts, of_blocks);
  ZoneSolver<T, GridTeam> solver(a, team);
  const auto zones = static_cast<Index>(a.outcomes.size());
  for (Index first = 0; first < zones; first += zone_threads) {
    const Index last = first + zone_threads < zones ? first + zone_threads : zones;
    const Index own = first + static_cast<Index>(threadIdx.x);
    if (__syncthreads_or(own < last && collisions_of(a, own) > zone_block_collisions) == 0)
      continue;
    for (Index zone = first; zone < last; ++zone)
      if (collisions_of(a, zone) > zone_block_collisions) solver.solve(zone, memory_of(a, zone));
  }
}

}  // namespace

/// As many blocks as the GPU has processors, whatever there is to do: sums go by their number.
template <class T>
void solve_largest_zones(Queue& queue, const RespondZones<T>& args) {
  auto& cuda_queue = static_cast<CudaQueue&>(queue);
  cuda_queue.make_current();
  int processors = 0;
  cuda::check(cudaDeviceGetAttribute(&processors, cudaDevAttrMultiProcessorCount, cuda_queue.gpu()),
              "cudaDeviceGetAttribute", cuda_queue.rank());
  const auto blocks = static_cast<unsigned>(processors);
  auto* of_blocks = static_cast<double*>(cuda_queue.scratch(2 * blocks * sizeof(double)));
  RespondZones<T> copy = args;
  void* arguments[] = {&copy, &of_blocks};
  cuda::check(cudaLaunchCooperativeKernel(reinterpret_cast<const void*>(solve_zones_together<T>),
                                          dim3(blocks), dim3(zone_threads), arguments, 0,
                                          cuda_queue.stream()),
              "cudaLaunchCooperativeKernel", cuda_queue.rank());
}

template void solve_largest_zones(Queue&, const RespondZones<float>&);
template void solve_largest_zones(Queue&, const RespondZones<double>&);

}  // namespace weft
