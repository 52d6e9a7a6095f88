#include "weft/kernels/respond/zones.hpp"

#include <algorithm>

#include "cuda/exec/launch.cuh"
#include "weft/kernels/respond/zone/solver.hpp"

namespace weft {
namespace {

constexpr int zone_threads = 256;
constexpr int zone_warps = zone_threads / 32;
/// Most blocks that wait for large zones, and that share the small ones out to their warps.
constexpr std::size_t large_blocks_max = 512;
constexpr std::size_t small_blocks_max = 4096;

constexpr unsigned whole_warp = 0xffffffffu;

/// The lanes of a warp.
struct WarpTeam {
  static constexpr bool alone = false;
  static constexpr bool in_order = true;

  __device__ Index rank() const { return static_cast<Index>(threadIdx.x % 32); }
  __device__ static constexpr Index size() { return 32; }
  __device__ void sync() { __syncwarp(); }
  __device__ double sum(double value) {
    __syncwarp();
    for (int step = 1; step < 32; step *= 2) value += __shfl_xor_sync(whole_warp, value, step);
    return value;
  }
  __device__ double largest(double value) {
    __syncwarp();
    for (int step = 1; step < 32; step *= 2)
      value = greater(value, __shfl_xor_sync(whole_warp, value, step));
    return value;
  }
  __device__ bool any(bool value) {
    __syncwarp();
    return __any_sync(whole_warp, value) != 0;
  }
  __device__ Index before(Index value, Index& total) {
    __syncwarp();
    Index sum = value;
    for (int step = 1; step < 32; step *= 2) {
      const Index left = __shfl_up_sync(whole_warp, sum, step);
      if (rank() >= step) sum += left;
    }
    total = __shfl_sync(whole_warp, sum, 31);
    return sum - value;
  }
  __device__ void sort(Offset* keys, Index count) { sort_bitonic(*this, keys, count); }
};

/// The threads of a block. What the warps come to goes through shared memory, by turns in one half
/// of it and the other, so that a warp may write its next part while another still reads the last.
class BlockTeam {
 public:
  static constexpr bool alone = false;
  static constexpr bool in_order = false;

  /// @param parts [2 zone_warps] shared memory
  __device__ explicit BlockTeam(double* parts) : parts_(parts) {}
  __device__ Index rank() const { return static_cast<Index>(threadIdx.x); }
  __device__ static constexpr Index size() { return zone_threads; }
  __device__ void sync() { __syncthreads(); }
  __device__ double sum(double value) {
    const double* part = share(WarpTeam{}.sum(value));
    double sum = 0;
    for (int w = 0; w < zone_warps; ++w) sum += part[w];
    return sum;
  }
  __device__ double largest(double value) {
    const double* part = share(WarpTeam{}.largest(value));
    double largest = part[0];
    for (int w = 1; w < zone_warps; ++w) largest = greater(largest, part[w]);
    return largest;
  }
  __device__ bool any(bool value) { return __syncthreads_or(value ? 1 : 0) != 0; }
  __device__ Index before(Index value, Index& total) {
    Index of_warp;
    Index sum = WarpTeam{}.before(value, of_warp);
    const double* part = share(of_warp);  // a double holds every Index
    total = 0;
    for (int w = 0; w < zone_warps; ++w) {
      if (w < rank() / 32) sum += static_cast<Index>(part[w]);
      total += static_cast<Index>(part[w]);
    }
    return sum;
  }
  __device__ void sort(Offset* keys, Index count) { sort_bitonic(*this, keys, count); }

 private:
  /// @return [zone_warps] the warps' values
  __device__ const double* share(double of_warp) {
    double* part = parts_ + turn_ * zone_warps;
    turn_ = 1 - turn_;
    if (threadIdx.x % 32 == 0) part[threadIdx.x / 32] = of_warp;
    __syncthreads();
    return part;
  }

  double* parts_;
  int turn_ = 0;
};

template <class T>
__device__ Index collisions_of(const RespondZones<T>& a, Index zone) {
  return a.zone_begin.data()[zone + 1] - a.zone_begin.data()[zone];
}

template <class T>
__device__ std::byte* memory_of(const RespondZones<T>& a, Index zone) {
  const auto before = static_cast<std::size_t>(a.zone_begin.data()[zone]);
  return a.scratch.data() + zone_scratch_bytes(before, static_cast<std::size_t>(zone));
}

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
    for (Index zone = block; zone < zones; zone += large_blocks)
      if (collisions_of(a, zone) > zone_warp_collisions) solver.solve(zone, memory_of(a, zone));
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

/// How many of the zones are large is known on the card alone; their number has a bound.
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
}

template void run(OnCuda, Queue&, const RespondZones<float>&);
template void run(OnCuda, Queue&, const RespondZones<double>&);

}  // namespace weft
