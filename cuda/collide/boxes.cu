#include "weft/kernels/collide/boxes.hpp"

#include <algorithm>
#include <cstdint>

#include "cuda/collide/clusters.cuh"
#include "cuda/collide/grid_scan.cuh"

namespace weft {
namespace {

constexpr int box_threads = 256;
constexpr int box_warps = box_threads / 32;
constexpr int motion_blocks = 1024;

/// What the stages hand on, in the queue's scratch memory. Blocks of make_clusters take box_warps
/// groups of one kind each, kind after kind.
struct BoxWork {
  unsigned long long* motion;  ///< [1] bits of the largest displacement, which order as it does
  double* extent;              ///< [blocks] [m] sum over a block's groups
  Index first_block[cluster_kinds + 1];
};

__device__ unsigned long long bits_of(float x) {
  return __float_as_uint(x);
}
__device__ unsigned long long bits_of(double x) {
  return static_cast<unsigned long long>(__double_as_longlong(x));
}
__device__ void from_bits(unsigned long long bits, float& x) {
  x = __uint_as_float(static_cast<unsigned>(bits));
}
__device__ void from_bits(unsigned long long bits, double& x) {
  x = __longlong_as_double(static_cast<long long>(bits));
}

template <class T>
__global__ void __launch_bounds__(box_threads)
    find_largest_motion(const __grid_constant__ CollideBoxes<T> a, unsigned long long* motion) {
  T most = T(0);
  const std::size_t stride = std::size_t{gridDim.x} * box_threads;
  for (std::size_t v = std::size_t{blockIdx.x} * box_threads + threadIdx.x;
       v < a.positions_t0.size(); v += stride) {
    const T own = largest_motion(a, v);
    if (most < own) most = own;
  }
  for (int step = 16; step > 0; step /= 2) {
    const T other = __shfl_xor_sync(cuda::whole_warp, most, step);
    if (most < other) most = other;
  }
  __shared__ T warp_most[box_warps];
  if (threadIdx.x % 32 == 0) warp_most[threadIdx.x / 32] = most;
  __syncthreads();
  if (threadIdx.x > 0) return;
  for (int w = 1; w < box_warps; ++w)
    if (most < warp_most[w]) most = warp_most[w];
  // Displacements are not negative, so that their bits order as integers. A maximum has no order.
  atomicMax(motion, bits_of(most));
}

/// Swept AABBs; marks obstacles_made where an obstacle's changes. The first one says whether the
/// motion is split.
struct MakeSweptAabb {
  const unsigned long long* motion;
  template <class T>
  __device__ void operator()(const CollideBoxes<T>& a, Index v) const {
    T most;
    from_bits(*motion, most);
    const bool split = most > a.split_motion;
    if (v == 0) a.split.data()[0] = split ? 1 : 0;
    const auto vertex = static_cast<std::size_t>(v);
    const BoxOf<T> box = make_swept_aabb(a, vertex, motion_margin(a, most), split);
    if (v >= a.cloth_vertex_count) {
      const bool moves = split && !stands_still(a, vertex);
      // Whoever writes, writes this.
      if (moves) a.obstacles_moved.data()[0] = 1;
      if (moves || differ(box, a.swept_aabb.data()[v])) a.obstacles_made.data()[0] = 1;
    }
    a.swept_aabb.data()[v] = box;
  }
};

template <class T>
__device__ BoxOf<T> box_of_lane(const BoxOf<T>& box, int step) {
  BoxOf<T> other;
  for (int c = 0; c < 3; ++c) {
    other.lo[c] = __shfl_xor_sync(cuda::whole_warp, box.lo[c], step);
    other.hi[c] = __shfl_xor_sync(cuda::whole_warp, box.hi[c], step);
  }
  return other;
}

/// Writes the boxes of four clusters, one to a lane, and those around them.
/// @param k this lane's cluster, up to past the last
/// @return the box around it
template <class T>
__device__ Box write_boxes(BoxOf<T> box, Index k, Index clusters, Span<Cluster<T>> out,
                           Span<Cluster<float>> around_out) {
  const auto lane = static_cast<Index>(threadIdx.x % cluster_size);
  if (k < clusters) set_lane(out.data()[k], lane, box);
  for (int step = 1; step < cluster_size; step *= 2) box = hull(box, box_of_lane(box, step));
  const Box whole = k < clusters ? around(box) : empty_box<float>();
  if (lane == 0) set_lane(around_out.data()[k / cluster_size], k % cluster_size, whole);
  return whole;
}

/// Boxes of half a group, one to a lane, and those around its four clusters.
/// @param half 0 or 1
/// @return the box around all that this lane's cluster has
template <class T>
__device__ Box make_half(const CollideBoxes<T>& a, int kind, Index g, Index half, bool split) {
  const ClusterList<T>& list = a.lists[kind];
  const auto lane = static_cast<Index>(threadIdx.x % 32);
  const Index k = g * cluster_size + half * (cluster_size / 2) + lane / cluster_size;
  const Index number = k * cluster_size + lane % cluster_size;
  const bool is_one = number < list.count;
  BoxOf<T> box = empty_box<T>();
  if (is_one) box = primitive_box(a, kind, list.first + number);
  Box whole = empty_box<float>();
  // Those of obstacles may serve when a later motion is split.
  if (split || kind % 2 == obstacle_vertices)
    whole = write_boxes(box, k, list.size(), list.ends, list.group_ends);
  if (split && is_one) box = start_box(a, kind, list.first + number);
  return hull(whole, write_boxes(box, k, list.size(), list.clusters, list.groups));
}

/// A warp a group: boxes of its primitives, around its clusters and around itself.
template <class T>
__global__ void __launch_bounds__(box_threads)
    make_clusters(const __grid_constant__ CollideBoxes<T> a, const __grid_constant__ BoxWork work) {
  int kind = 0;
  while (static_cast<Index>(blockIdx.x) >= work.first_block[kind + 1]) ++kind;
  if (kind % 2 == 1 && a.obstacles_made.data()[0] == 0) return;
  const auto warp = static_cast<Index>(threadIdx.x) / 32;
  const Index g = (static_cast<Index>(blockIdx.x) - work.first_block[kind]) * box_warps + warp;
  __shared__ double sum[box_warps];
  double size = 0;
  const bool split = a.split.data()[0] != 0;
  if (g < a.lists[kind].group_count()) {
    Box whole = make_half(a, kind, g, 0, split);
    whole = hull(whole, make_half(a, kind, g, 1, split));
    whole = hull(whole, box_of_lane(whole, cluster_size));
    whole = hull(whole, box_of_lane(whole, 2 * cluster_size));
    if (threadIdx.x % 32 == 0) a.lists[kind].hulls.data()[g] = whole;
    size = static_cast<double>(extent(whole));
  }
  if (threadIdx.x % 32 == 0) sum[warp] = size;
  __syncthreads();
  if (threadIdx.x > 0) return;
  double total = 0;
  for (int w = 0; w < box_warps; ++w) total += sum[w];
  work.extent[blockIdx.x] = total;
}

/// A block a kind: the mean over its groups, always in the same order.
template <class T>
__global__ void __launch_bounds__(box_threads)
    average_extents(const __grid_constant__ CollideBoxes<T> a,
                    const __grid_constant__ BoxWork work) {
  const auto kind = static_cast<int>(blockIdx.x);
  if (kind % 2 == 1 && a.obstacles_made.data()[0] == 0) return;
  __shared__ double sum[box_threads];
  const auto thread = static_cast<Index>(threadIdx.x);
  double own = 0;
  for (Index b = work.first_block[kind] + thread; b < work.first_block[kind + 1]; b += box_threads)
    own += work.extent[b];
  sum[thread] = own;
  for (int half = box_threads / 2; half > 0; half /= 2) {
    __syncthreads();
    if (thread < half) sum[thread] += sum[thread + half];
  }
  const Index groups = a.lists[kind].group_count();
  if (thread == 0)
    a.mean_extent.data()[kind] = groups > 0 ? static_cast<float>(sum[0] / groups) : 0.0f;
}

template <class T>
BoxWork make_work(CudaQueue& queue, const CollideBoxes<T>& a) {
  BoxWork work{};
  for (int kind = 0; kind < cluster_kinds; ++kind)
    work.first_block[kind + 1] =
        work.first_block[kind] + (a.lists[kind].group_count() + box_warps - 1) / box_warps;
  ScratchLayout layout;
  const std::size_t motion = layout.add<unsigned long long>(1);
  const std::size_t extent =
      layout.add<double>(static_cast<std::size_t>(work.first_block[cluster_kinds]));
  auto* memory = static_cast<std::byte*>(queue.scratch(layout.bytes()));
  work.motion = reinterpret_cast<unsigned long long*>(memory + motion);
  work.extent = reinterpret_cast<double*>(memory + extent);
  return work;
}

template <class T>
void launch_clusters(const CudaQueue& queue, const CollideBoxes<T>& a, const BoxWork& work) {
  const Index blocks = work.first_block[cluster_kinds];
  if (blocks == 0) return;
  make_clusters<<<static_cast<unsigned>(blocks), box_threads, 0, queue.stream()>>>(a, work);
  cuda::check(cudaGetLastError(), "kernel launch", queue.rank());
}

}  // namespace

/// Compiled without fused multiply-add, so that boxes have the bits that the header promises, which
/// are the host's.
template <class T>
void run(OnCuda, Queue& queue, const CollideBoxes<T>& args) {
  auto& cuda_queue = static_cast<CudaQueue&>(queue);
  cuda_queue.make_current();
  const BoxWork work = make_work(cuda_queue, args);
  queue.fill(work.motion, 0, sizeof(unsigned long long));
  if (args.make_obstacles)
    queue.fill(args.obstacles_made.data(), 1, 1);
  else
    queue.copy(args.obstacles_made.data(), args.obstacles_moved.data(), 1);
  queue.fill(args.obstacles_moved.data(), 0, 1);
  find_largest_motion<<<motion_blocks, box_threads, 0, cuda_queue.stream()>>>(args, work.motion);
  cuda::check(cudaGetLastError(), "kernel launch", cuda_queue.rank());
  launch_for_each(queue, args, static_cast<Index>(args.positions_t0.size()),
                  MakeSweptAabb{work.motion});
  launch_clusters(cuda_queue, args, work);
  average_extents<<<cluster_kinds, box_threads, 0, cuda_queue.stream()>>>(args, work);
  cuda::check(cudaGetLastError(), "kernel launch", cuda_queue.rank());
}

template <class T>
void remake_clusters(Queue& queue, const CollideBoxes<T>& boxes) {
  auto& cuda_queue = static_cast<CudaQueue&>(queue);
  cuda_queue.make_current();
  launch_clusters(cuda_queue, boxes, make_work(cuda_queue, boxes));
}

template void run(OnCuda, Queue&, const CollideBoxes<float>&);
template void run(OnCuda, Queue&, const CollideBoxes<double>&);
template void remake_clusters(Queue&, const CollideBoxes<float>&);
template void remake_clusters(Queue&, const CollideBoxes<double>&);

}  // namespace weft
