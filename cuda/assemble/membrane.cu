#include "weft/kernels/assemble/membrane.hpp"

#include "cuda/exec/launch.cuh"

namespace weft {
namespace {

/// What the triangles of a warp write, side by side as they do in memory.
template <class T>
struct Staged {
  Mat3<T> block[32 * 6];
  Vec3<T> impulse[32 * 3];
};

template <class T>
constexpr int warps = sizeof(T) == sizeof(float) ? 4 : 2;

/// Copies `count` blocks or vectors, neighbouring lanes neighbouring numbers.
template <class T, class Of>
__device__ void copy_out(const Of* from, Of* to, Index count) {
  const auto* source = reinterpret_cast<const T*>(from);
  auto* target = reinterpret_cast<T*>(to);
  const auto numbers = count * static_cast<Index>(sizeof(Of) / sizeof(T));
  for (auto n = static_cast<Index>(threadIdx.x % 32); n < numbers; n += 32) target[n] = source[n];
}

/// A lane a triangle. What it writes is 252 bytes apart from its neighbour's, so that stores of
/// single numbers would each move whole sectors: it goes through shared memory.
template <class T>
__global__ void __launch_bounds__(32 * warps<T>)
    assemble_triangles(const __grid_constant__ AssembleMembrane<T> a, Index count) {
  __shared__ Staged<T> staged[warps<T>];
  Staged<T>& own = staged[threadIdx.x / 32];
  const auto lane = static_cast<Index>(threadIdx.x % 32);
  const Index i = static_cast<Index>(blockIdx.x * 32 * warps<T> + threadIdx.x);
  if (i < count) membrane_terms(a, i, own.impulse + 3 * lane, own.block + 6 * lane);
  __syncwarp();
  const Index triangles = min(Index{32}, count - (i - lane));
  const auto first = static_cast<std::size_t>(i - lane);
  copy_out<T>(own.block, a.block.data() + 6 * first, 6 * triangles);
  copy_out<T>(own.impulse, a.impulse.data() + 3 * first, 3 * triangles);
}

}  // namespace

template <class T>
void run(OnCuda, Queue& queue, const AssembleMembrane<T>& args) {
  const auto count = static_cast<Index>(args.triangles.size());
  if (count <= 0) return;
  const auto& cuda_queue = static_cast<const CudaQueue&>(queue);
  cuda_queue.make_current();
  constexpr int threads = 32 * warps<T>;
  const auto blocks = static_cast<unsigned>((count + threads - 1) / threads);
  assemble_triangles<<<blocks, threads, 0, cuda_queue.stream()>>>(args, count);
  cuda::check(cudaGetLastError(), "kernel launch", cuda_queue.rank());
}

template void run(OnCuda, Queue&, const AssembleMembrane<float>&);
template void run(OnCuda, Queue&, const AssembleMembrane<double>&);

}  // namespace weft
