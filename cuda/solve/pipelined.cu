#include "weft/kernels/solve/pipelined.hpp"

#include "cuda/exec/check.cuh"
#include "cuda/exec/cuda_device.cuh"
#include "cuda/solve/pcg_block.cuh"

namespace weft {
namespace {

using namespace cuda;

static_assert(pipelined_group_rows % 32 == 0, "warps multiply a group");
constexpr int lane_rows = 2;
constexpr int threads = block_threads<Kind::aggregates, lane_rows>;
template <class T>
using Shared = PcgShared<T, Kind::aggregates, lane_rows>;

/// What one block does in a solve that the host drives. Blocks of one launch do not wait for each
/// other.
template <class T>
class PipelinedBlock : PcgBlock<T, Kind::aggregates, lane_rows, PipelinedBlock<T>> {
  using Base = PcgBlock<T, Kind::aggregates, lane_rows, PipelinedBlock<T>>;
  friend Base;

 public:
  __device__ PipelinedBlock(const SolvePipelined<T>& args, Shared<T>& shared)
      : Base(args.solve, args.part, shared,
             {args.solve.rank, static_cast<int>(blockIdx.x), static_cast<int>(gridDim.x)}),
        args_(args) {}

  __device__ bool skipped() const {
    return args_.only_if_running && !args_.state.data()->scalars.running;
  }

  /// Stages of own groups; the state is cleared by the first block, of which there is always one.
  __device__ void begin() {
    if (blockIdx.x == 0 && threadIdx.x == 0) {
      PipelinedState<T>& state = args_.state.data()[0];
      state = {};
      if (args_.solve.resume) state.scalars.resume(args_.solve, args_.part.status.data()[0]);
    }
    for (Index tile = Base::block_; tile < Base::tiles_; tile += Base::blocks_) {
      const WarpRows at = Base::rows_of(tile);
      for (int j = 0; j < lane_rows; ++j) {
        const Index first = at.first + 32 * j;
        if (first % pipelined_group_rows != 0 || first >= Base::rows_) continue;
        int own = 0;
        for (Index row = first + at.lane; row < min(Base::rows_, first + pipelined_group_rows);
             row += 32)
          own = max(own, last_arrival(args_, row));
        const int last = __reduce_max_sync(whole_warp, own);
        if (at.lane == 0)
          args_.group_stage.data()[first / pipelined_group_rows] = static_cast<unsigned char>(last);
      }
    }
  }

  /// w = A vector in the groups of the stage.
  __device__ void multiply(const Vec3<T>* vector) {
    for (Index tile = Base::block_; tile < Base::tiles_; tile += Base::blocks_) {
      const WarpRows at = Base::rows_of(tile);
#pragma unroll 1
      for (int j = 0; j < lane_rows; ++j) {
        const Index first = at.first + 32 * j;
        if (first >= Base::rows_) continue;
        if (args_.group_stage.data()[first / pipelined_group_rows] != args_.stage) continue;
        multiply_rows(Base::part_, Base::begin_, Base::rows_, first, vector);
        // Vectors come stage by stage, and with them the links that can be pulled.
        if (args_.solve.linked)
          add_contact_rows<false>(Base::part_, Base::begin_, Base::rows_, first, vector);
      }
    }
  }

  __device__ void take_residual() {
    Base::template take_residual<true>();
  }

  __device__ void update() {
    const PcgScalars<T>& scalars = args_.state.data()->scalars;
    Base::update(static_cast<T>(scalars.alpha), static_cast<T>(scalars.beta));
  }

  __device__ void sum_products(bool magnitudes) {
    Base::template sum_products<true>(magnitudes, 0);
  }

  /// One block alone.
  __device__ void take_sums() {
    Base::join_partials(0);
    if (threadIdx.x != 0) return;
    PipelinedState<T>& state = args_.state.data()[0];
    const double* d = Base::s_.warp_sum[0];
    if (state.take(args_, d)) Base::part_.status.data()[0] = state.scalars.status;
  }

 private:
  /// Copies take u and partial sums to others.
  __device__ void send(Index, const Vec3<T>&) const {}
  __device__ void send_partial(Index n, double sum) const {
    Base::part_.partial.data()[n] = sum;
  }

  const SolvePipelined<T>& args_;
};

/// Work of one kind: each is a kernel of its own, with the registers that it needs.
template <class T, PipelinedWork work>
__global__ void __launch_bounds__(threads, blocks_per_sm<T, Kind::aggregates, lane_rows>)
    solve_pipelined(const __grid_constant__ SolvePipelined<T> args) {
  __shared__ alignas(16) unsigned char memory[sizeof(Shared<T>)];
  PipelinedBlock<T> block(args, *reinterpret_cast<Shared<T>*>(memory));
  if (block.skipped()) return;
  if constexpr (work == PipelinedWork::begin) block.begin();
  if constexpr (work == PipelinedWork::multiply_x) block.multiply(args.part.x.data());
  if constexpr (work == PipelinedWork::multiply_u) block.multiply(args.part.u.data());
  if constexpr (work == PipelinedWork::residual) block.take_residual();
  if constexpr (work == PipelinedWork::update) block.update();
  if constexpr (work == PipelinedWork::products) block.sum_products(false);
  if constexpr (work == PipelinedWork::magnitudes) block.sum_products(true);
  if constexpr (work == PipelinedWork::restart) block.take_sums();
}

/// @param one_block also where there are no rows
template <class T, PipelinedWork work>
void launch_work(const CudaQueue& queue, const SolvePipelined<T>& args, bool one_block = false) {
  const Index rows = args.part.mesh.row_count;
  const Index tiles = (rows + tile_rows - 1) / tile_rows;
  if (tiles == 0 && !one_block && work != PipelinedWork::begin) return;
  queue.make_current();
  const auto blocks = static_cast<unsigned>(one_block ? 1 : std::max<Index>(tiles, 1));
  solve_pipelined<T, work><<<blocks, threads, 0, queue.stream()>>>(args);
  check(cudaGetLastError(), "solve_pipelined", queue.rank());
}

}  // namespace

template <class T>
void run(OnCuda, Queue& q, const SolvePipelined<T>& args) {
  const auto& queue = static_cast<const CudaQueue&>(q);
  switch (args.work) {
    case PipelinedWork::begin:
      return launch_work<T, PipelinedWork::begin>(queue, args);
    case PipelinedWork::multiply_x:
      return launch_work<T, PipelinedWork::multiply_x>(queue, args);
    case PipelinedWork::multiply_u:
      return launch_work<T, PipelinedWork::multiply_u>(queue, args);
    case PipelinedWork::residual:
      return launch_work<T, PipelinedWork::residual>(queue, args);
    case PipelinedWork::update:
      return launch_work<T, PipelinedWork::update>(queue, args);
    case PipelinedWork::products:
      return launch_work<T, PipelinedWork::products>(queue, args);
    case PipelinedWork::magnitudes:
      return launch_work<T, PipelinedWork::magnitudes>(queue, args);
    case PipelinedWork::take_magnitude:
    case PipelinedWork::restart:
    case PipelinedWork::advance:
      // One kernel for the three, which differ in a few numbers at the end.
      return launch_work<T, PipelinedWork::restart>(queue, args, true);
  }
}

template void run(OnCuda, Queue&, const SolvePipelined<float>&);
template void run(OnCuda, Queue&, const SolvePipelined<double>&);

}  // namespace weft
