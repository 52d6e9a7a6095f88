#include "weft/kernels/assemble/active_set_update.hpp"

#include "cuda/exec/launch.cuh"

namespace weft {
namespace {

constexpr int active_set_update_threads = 256;
/// Contacts of a reduction block: the shape of the whole depends on their number alone.
constexpr Index update_active_set = 1024;

/// Sum over the block's threads, for thread 0, joined pairwise.
__device__ double sum_block(double value) {
  __shared__ double sums[active_set_update_threads];
  sums[threadIdx.x] = value;
  for (unsigned step = active_set_update_threads / 2; step > 0; step /= 2) {
    __syncthreads();
    if (threadIdx.x < step) sums[threadIdx.x] += sums[threadIdx.x + step];
  }
  return sums[0];
}

__device__ void add_forces(Span<std::int64_t> sums, const ComponentForces& part) {
  for (int k = 0; k < component_sums; ++k)
    if (part.component >= 0 && part.sum[k] != 0)
      atomicAdd(reinterpret_cast<unsigned long long*>(
                    &sums[static_cast<std::size_t>(component_sums * part.component + k)]),
                static_cast<unsigned long long>(part.sum[k]));
}

/// Joins what a thread adds to one component after another, so that neighbours, which mostly lie on
/// the same one, do not all wait for the same numbers.
class ForceSum {
 public:
  __device__ explicit ForceSum(const Span<std::int64_t>& sums) : sums_(sums) {}

  __device__ void add(const ComponentForces& part) {
    if (part.component < 0) return;
    if (part.component != own_.component) {
      add_forces(sums_, own_);
      own_ = part;
      return;
    }
    for (int k = 0; k < component_sums; ++k) own_.sum[k] += part.sum[k];
  }

  /// To be called once, by all threads of a warp at a time.
  __device__ void finish() {
    int same = 0;
    __match_all_sync(~0u, own_.component, &same);
    if (same == 0) {
      add_forces(sums_, own_);
      return;
    }
    for (int step = 16; step > 0; step /= 2)
      for (int k = 0; k < component_sums; ++k)
        own_.sum[k] += __shfl_down_sync(~0u, own_.sum[k], step);
    if (threadIdx.x % 32 == 0) add_forces(sums_, own_);
  }

 private:
  Span<std::int64_t> sums_;
  ComponentForces own_;
};

template <class T>
__global__ void __launch_bounds__(active_set_update_threads)
    active_set_update(const __grid_constant__ AssembleActiveSetUpdate<T> a, double* partial) {
  const Index first = static_cast<Index>(blockIdx.x) * update_active_set;
  const Index last = min(first + update_active_set, static_cast<Index>(a.contacts.size()));
  double sum = 0;
  ForceSum first_side(a.force_sum), second_side(a.force_sum);
  for (Index i = first + static_cast<Index>(threadIdx.x); i < last;
       i += active_set_update_threads) {
    const ActiveSetChange<T> change = assemble_active_set_update(a, i);
    sum += change.mismatch_sq;
    first_side.add(component_forces(a, i, 0, change));
    second_side.add(component_forces(a, i, 1, change));
  }
  first_side.finish();
  second_side.finish();
  sum = sum_block(sum);
  if (threadIdx.x == 0) partial[blockIdx.x] = sum;
}

template <class T>
__global__ void __launch_bounds__(active_set_update_threads)
    sum_partials(const __grid_constant__ AssembleActiveSetUpdate<T> a, const double* partial,
                 Index count) {
  double sum = 0;
  for (Index n = static_cast<Index>(threadIdx.x); n < count; n += active_set_update_threads)
    sum += partial[n];
  sum = sum_block(sum);
  if (threadIdx.x == 0) a.mismatch_sq.data()[0] = sum * static_cast<double>(a.h * a.h);
}

}  // namespace

template <class T>
void run(OnCuda, Queue& queue, const AssembleActiveSetUpdate<T>& args) {
  auto& cuda_queue = static_cast<CudaQueue&>(queue);
  cuda_queue.make_current();
  const auto count = static_cast<Index>((args.contacts.size() + update_active_set - 1) /
                                        static_cast<std::size_t>(update_active_set));
  auto* partial = static_cast<double*>(cuda_queue.scratch(
      sizeof(double) * std::max<std::size_t>(1, static_cast<std::size_t>(count))));
  if (count > 0)
    active_set_update<<<static_cast<unsigned>(count), active_set_update_threads, 0,
                        cuda_queue.stream()>>>(args, partial);
  cuda::check(cudaGetLastError(), "kernel launch", cuda_queue.rank());
  sum_partials<<<1, active_set_update_threads, 0, cuda_queue.stream()>>>(args, partial, count);
  cuda::check(cudaGetLastError(), "kernel launch", cuda_queue.rank());
}

template void run(OnCuda, Queue&, const AssembleActiveSetUpdate<float>&);
template void run(OnCuda, Queue&, const AssembleActiveSetUpdate<double>&);

}  // namespace weft
