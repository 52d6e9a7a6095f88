#include "weft/kernels/solve/halo.hpp"

#include "cuda/exec/launch.cuh"
#include "cuda/exec/sums.cuh"

namespace weft {
namespace {

constexpr int mark_threads = 256;
constexpr int mark_blocks = 512;
constexpr int list_threads = 1024;
/// Vertices that a thread of list_ghosts looks at in a round.
constexpr Index run_length = 8;

/// Stamps the ghosts. Several threads may stamp one vertex, all with the same number.
template <class T>
__global__ void __launch_bounds__(mark_threads)
    mark_ghosts(const __grid_constant__ SolveHalo<T> a) {
  const Offset start = Offset{blockIdx.x} * mark_threads + threadIdx.x;
  const Offset stride = Offset{gridDim.x} * mark_threads;
  for (Offset n = start; n < static_cast<Offset>(a.mesh_ghost.size()); n += stride)
    a.stamp.data()[a.mesh_ghost.data()[n]] = a.epoch;
  const ContactOperator<T>& links = a.contact;
  if (links.count.empty()) return;
  const Index begin = a.row_begin.data()[a.rank];
  const Index end = a.row_begin.data()[a.rank + 1];
  const Offset corners = 4 * Offset{links.count.data()[0]};
  for (Offset n = start; n < corners; n += stride) {
    const Index vertex = links.link.data()[n / 4].v[n % 4];
    if (vertex < begin || vertex >= end) a.stamp.data()[vertex] = a.epoch;
  }
}

/// Lists stamped vertices in ascending order: one block, runs of vertices that follow each other.
template <class T>
__global__ void __launch_bounds__(list_threads)
    list_ghosts(const __grid_constant__ SolveHalo<T> a) {
  __shared__ Index warp_sum[list_threads / 32];
  const auto ranks = static_cast<Index>(a.row_begin.size()) - 1;
  const Index vertices = a.row_begin.data()[ranks];
  const Index* stamp = a.stamp.data();
  Index count = 0;
  for (Index base = 0; base < vertices; base += list_threads * run_length) {
    const Index first = base + static_cast<Index>(threadIdx.x) * run_length;
    const Index last = min(vertices, first + run_length);
    Index found = 0;
    for (Index v = first; v < last; ++v) found += stamp[v] == a.epoch ? 1 : 0;
    Index total;
    Index place = count + cuda::sum_before<list_threads>(found, warp_sum, total);
    for (Index v = first; v < last; ++v)
      if (stamp[v] == a.epoch) a.ghost.data()[place++] = v;
    count += total;
  }
  __syncthreads();
  for (Index owner = static_cast<Index>(threadIdx.x); owner <= ranks; owner += list_threads) {
    // Ghosts below the owner's first row, by halving.
    const Index bound = a.row_begin.data()[owner];
    Index low = 0;
    Index high = count;
    while (low < high) {
      const Index middle = low + (high - low) / 2;
      if (a.ghost.data()[middle] < bound)
        low = middle + 1;
      else
        high = middle;
    }
    a.ghost_offset.data()[owner] = low;
  }
}

}  // namespace

template <class T>
void run(OnCuda, Queue& queue, const SolveHalo<T>& args) {
  if (args.row_begin.size() <= 2) {  // one rank has no ghosts
    queue.fill(args.ghost_offset.data(), 0, args.ghost_offset.size() * sizeof(Index));
    return;
  }
  const auto& cuda_queue = static_cast<const CudaQueue&>(queue);
  cuda_queue.make_current();
  mark_ghosts<<<mark_blocks, mark_threads, 0, cuda_queue.stream()>>>(args);
  cuda::check(cudaGetLastError(), "kernel launch", cuda_queue.rank());
  list_ghosts<<<1, list_threads, 0, cuda_queue.stream()>>>(args);
  cuda::check(cudaGetLastError(), "kernel launch", cuda_queue.rank());
}

template void run(OnCuda, Queue&, const SolveHalo<float>&);
template void run(OnCuda, Queue&, const SolveHalo<double>&);

}  // namespace weft
