#include "weft/kernels/respond/zones.hpp"

#include <algorithm>

#include "cuda/exec/launch.cuh"
#include "cuda/respond/zone_teams.cuh"
#include "weft/kernels/respond/zone/solver.hpp"

namespace weft {
namespace {

/// Most blocks that wait for large zones, and that share the small ones out to their warps.
constexpr std::size_t large_blocks_max = 512;
constexpr std::size_t small_blocks_max = 4096;

/// The first blocks look for large zones, so that these start early, and the warps of the others
/// for small ones.
template <class T>
__global__ void __launch_bounds__(zone_threads)
    solve_zones(const __grid_constant__ RespondZones<T> a, Index large_blocks) {
  __shared__ double parts[2 * zone_warps];
  const auto zones = static_cast<Index>(a.outcomes.size());
  const auto block = static_cast<Index>(blockIdx.x);
  if (block < large_blocks) {
    BlockTeam team(parts);
    ZoneSolver<T, BlockTeam> solver(a, team);
    for (Index zone = block; zone < zones; zone += large_blocks) {
      const Index collisions = collisions_of(a, zone);
      if (collisions > zone_warp_collisions && collisions <= zone_block_collisions)
        solver.solve(zone, memory_of(a, zone));
    }
    return;
  }
  WarpTeam team;
  ZoneSolver<T, WarpTeam> solver(a, team);
  const Index stride = (static_cast<Index>(gridDim.x) - large_blocks) * zone_warps;
  const Index first = (block - large_blocks) * zone_warps + static_cast<Index>(threadIdx.x) / 32;
  for (Index zone = first; zone < zones; zone += stride)
    if (collisions_of(a, zone) <= zone_warp_collisions) solver.solve(zone, memory_of(a, zone));
}

}  // namespace

/// How many of the zones are large is known on the GPU alone; their number has a bound.
template <class T>
void run(OnCuda, Queue& queue, const RespondZones<T>& args) {
  const std::size_t zones = args.outcomes.size();
  if (zones == 0) return;
  const auto& cuda_queue = static_cast<const CudaQueue&>(queue);
  cuda_queue.make_current();
  const std::size_t large =
      std::min({zones, large_blocks_max, args.collisions.size() / (zone_warp_collisions + 1)});
  const std::size_t small = std::min((zones + zone_warps - 1) / zone_warps, small_blocks_max);
  solve_zones<<<static_cast<unsigned>(large + small), zone_threads, 0, cuda_queue.stream()>>>(
      args, static_cast<Index>(large));
  cuda::check(cudaGetLastError(), "kernel launch", cuda_queue.rank());
  if (args.collisions.size() > static_cast<std::size_t>(zone_block_collisions))
    solve_largest_zones(queue, args);
}

template void run(OnCuda, Queue&, const RespondZones<float>&);
template void run(OnCuda, Queue&, const RespondZones<double>&);

}  // namespace weft
