#include "weft/kernels/solve/pcg.hpp"

#include "cuda/exec/check.cuh"
#include "cuda/exec/cuda_device.cuh"
#include "cuda/solve/pcg_block.cuh"
#include "cuda/solve/peers.cuh"

namespace weft {
namespace {

using namespace cuda;

/// One launch: the ranks of one GPU, which share its blocks.
template <class T>
struct PcgLaunch {
  SolvePcg<T> solve;          ///< as the first of these ranks has it
  bool several_gpus = false;  ///< other ranks are on other GPUs
  bool resident = false;      ///< blocks have memory for a ResidentTile
  int rank_count = 0;
  int rank[ranks_max] = {};
};

template <class T, Kind kind, int lane_rows>
struct CollectiveShared {
  SolvePcgPart<T> part;
  PcgScalars<T> scalars;
  PcgShared<T, kind, lane_rows> block;
  int over;
};

/// Shared memory of a block whose first tile is resident; of another, what comes first.
template <class T, Kind kind, int lane_rows>
struct ResidentShared {
  CollectiveShared<T, kind, lane_rows> collective;
  ResidentTile<T, kind> tile;
};

/// w = A vector in the rows of a block, where there are contacts. Pulls of links are shared out
/// evenly over the rank's blocks, however rows share the links, and are under way while the mesh's
/// part is computed. Never inlined, as multiply_rows().
/// @param epoch see Peers::own_barrier()
template <Kind kind, int lane_rows, class T>
__device__ __noinline__ void multiply_contact_operator(const SolvePcg<T>& args,
                                                       const SolvePcgPart<T>& part,
                                                       const BlockShare& share,
                                                       const Vec3<T>* vector, std::uint32_t epoch) {
  const auto for_rows = [&share](const auto& work) {
#pragma unroll 1
    for (Index tile = share.block; tile < share.tiles; tile += share.blocks)
#pragma unroll 1
      for (int j = 0; j < lane_rows; ++j)
        work(rows_of_tile<kind, lane_rows>(tile, share.rows).first + 32 * j);
  };
  const Peers<T> own(args, part, false, share.rank, share.begin, share.block, share.blocks);
  gather_contacts(part.contact, share.block, share.blocks, vector);
  own.arrive(epoch);
  for_rows([&](Index first) { multiply_rows(part, share.begin, share.rows, first, vector); });
  own.wait_for_own(epoch);
  for_rows(
      [&](Index first) { add_contact_rows<true>(part, share.begin, share.rows, first, vector); });
  sync_unit<lane_rows>();
}

/// What one block does in a solve whose ranks reach each other's memory.
/// @tparam has_contacts there are contacts. What multiplies them takes registers that solves
/// without
///                   any would have to do without.
template <class T, Kind kind, int lane_rows, bool has_contacts>
class CollectiveBlock
    : PcgBlock<T, kind, lane_rows, CollectiveBlock<T, kind, lane_rows, has_contacts>> {
  using Base = PcgBlock<T, kind, lane_rows, CollectiveBlock<T, kind, lane_rows, has_contacts>>;
  friend Base;

 public:
  __device__ CollectiveBlock(const PcgLaunch<T>& launch, ResidentShared<T, kind, lane_rows>& shared)
      : Base(launch.solve, shared.collective.part, shared.collective.block, place(launch),
             launch.resident ? &shared.tile : nullptr),
        s_(shared.collective),
        several_gpus_(launch.several_gpus),
        vector_epoch_(a_.epoch),
        partial_epoch_(a_.epoch),
        own_epoch_(a_.epoch) {
    if (threadIdx.x == 0) {
      s_.part = a_.parts.data()[rank_];
      s_.scalars = {};
      if (a_.resume) s_.scalars.resume(a_, s_.part.status.data()[0]);
    }
    __syncthreads();
  }

  /// More blocks than tiles: nothing to do, and nobody waits for it.
  __device__ bool idle() const { return block_ >= blocks_; }

  __device__ void solve() {
    if (ranks() > 1) {
      peers().find_receivers(own_epoch_ + 1);
      own_epoch_ += 2;
    }
    Base::fetch_resident();
    while (s_.scalars.status.paused == 0) {
      if (!s_.scalars.running) {
        if (s_.scalars.asks_for_magnitude()) magnitude();
        true_residual();
        reduce();
        if (threadIdx.x == 0) s_.over = s_.scalars.restart(a_, s_.block.warp_sum[0]) ? 0 : 1;
        __syncthreads();
        if (s_.over != 0) break;
      }
      while (s_.scalars.running) {
        Base::update(static_cast<T>(s_.scalars.alpha), static_cast<T>(s_.scalars.beta));
        exchange();
        sum_products(false);
        reduce();
        if (threadIdx.x == 0) s_.scalars.advance(a_, s_.block.warp_sum[0]);
        __syncthreads();
      }
    }
    Base::store_resident_x();
    if (s_.scalars.status.paused != 0) Base::store_recurrence();
    if (block_ == 0 && threadIdx.x == 0) s_.part.status.data()[0] = s_.scalars.status;
  }

 private:
  using Base::a_;
  using Base::begin_;
  using Base::block_;
  using Base::blocks_;
  using Base::rank_;
  using Base::rows_;
  using Base::tiles_;

  /// Blocks of a launch go to its ranks in equal shares.
  __device__ static BlockPlace place(const PcgLaunch<T>& launch) {
    const int mine = static_cast<int>(blockIdx.x);
    const auto first_block = [&](int n) {
      return static_cast<int>(Offset{gridDim.x} * n / launch.rank_count);
    };
    int n = 0;
    while (n + 1 < launch.rank_count && mine >= first_block(n + 1)) ++n;
    return {launch.rank[n], mine - first_block(n), first_block(n + 1) - first_block(n)};
  }

  __device__ int ranks() const { return static_cast<int>(a_.parts.size()); }
  __device__ Peers<T> peers() const {
    return {a_, s_.part, several_gpus_, rank_, begin_, block_, blocks_};
  }
  __device__ void send(Index row, const Vec3<T>& x) const {
    peers().send(&SolvePcgPart<T>::u, row, x);
  }
  __device__ void send_partial(Index n, double sum) const { peers().send_partial(n, sum); }

  /// Waits for what all ranks whose rows are multiplied here, this one included, have sent of a
  /// vector. Own rows may be written and sent again once a reduction has passed: by then every peer
  /// has multiplied them.
  __device__ void exchange() {
    ++vector_epoch_;
    const Peers<T> p = peers();
    p.publish(Flag::vector, vector_epoch_);
    const Index* offset = s_.part.ghost_offset.data();
    for (int peer = static_cast<int>(threadIdx.x); peer < ranks(); peer += Base::threads)
      if (peer == rank_ || offset[peer] < offset[peer + 1])
        p.wait_for(Flag::vector, peer, vector_epoch_);
    __syncthreads();
  }

  /// The same for x, which is not sent as it changes.
  __device__ void exchange_x() {
    Base::store_resident_x();
    if (ranks() > 1)
      for (Index tile = block_; tile < tiles_; tile += blocks_) {
        const WarpRows at = Base::rows_of(tile);
        for (Index row = at.first + at.lane; row < min(rows_, at.first + 32 * lane_rows); row += 32)
          peers().send(&SolvePcgPart<T>::x, row, s_.part.x.data()[begin_ + row]);
      }
    exchange();
  }

  /// w = A vector in own rows, where there are contacts: else it is computed where it is used. The
  /// vector's ghosts are there, and pulls of the last product have been read: a reduction or an
  /// exchange has passed.
  __device__ void multiply(const Vec3<T>* vector) {
    if constexpr (has_contacts)
      multiply_contact_operator<kind, lane_rows>(a_, s_.part, s_.block.share, vector, ++own_epoch_);
  }

  /// r = b - A x in free rows, u = P r, w = A u, and their products.
  __device__ void true_residual() {
    exchange_x();
    multiply(s_.part.x.data());
    Base::template take_residual<has_contacts>();
    exchange();
    sum_products(false);
  }

  /// Leaves the 2-norm of |A| |x| + |b| in free rows to the scalars.
  __device__ void magnitude() {
    exchange_x();
    sum_products(true);
    reduce();
    if (threadIdx.x == 0) s_.scalars.magnitude = sqrt(s_.block.warp_sum[0][0]);
  }
  __device__ int parity() const { return static_cast<int>((partial_epoch_ - a_.epoch) % 2); }

  /// In another epoch of partial sums.
  __device__ void sum_products(bool magnitudes) {
    if (!magnitudes) multiply(s_.part.u.data());
    ++partial_epoch_;
    Base::template sum_products<has_contacts>(magnitudes, parity());
  }

  __device__ void wait_for_partials() {
    const Peers<T> p = peers();
    p.publish(Flag::partials, partial_epoch_);
    for (int peer = static_cast<int>(threadIdx.x); peer < ranks(); peer += Base::threads)
      p.wait_for(Flag::partials, peer, partial_epoch_);
    __syncthreads();
  }

  /// warp_sum[0] = the partial sums of all ranks, for thread 0.
  __device__ void reduce() {
    wait_for_partials();
    Base::join_partials(parity());
  }

  CollectiveShared<T, kind, lane_rows>& s_;
  bool several_gpus_;
  std::uint32_t vector_epoch_, partial_epoch_, own_epoch_;
};

template <class T, Kind kind, int lane_rows, bool linked>
__global__ void __launch_bounds__(block_threads<kind, lane_rows>, blocks_per_sm<T, kind, lane_rows>)
    solve_pcg(const __grid_constant__ PcgLaunch<T> launch) {
  extern __shared__ uint4 memory[];  // aligned for all that it holds
  CollectiveBlock<T, kind, lane_rows, linked> block(
      launch, *reinterpret_cast<ResidentShared<T, kind, lane_rows>*>(memory));
  if (!block.idle()) block.solve();
}

/// A launch and where it goes.
template <class T>
struct GpuLaunch {
  CudaQueue* queue = nullptr;  ///< of the first of the GPU's ranks
  PcgLaunch<T> launch;
  void (*kernel)(PcgLaunch<T>) = nullptr;
  dim3 blocks = {};
  dim3 threads = {};
  std::size_t shared_bytes = 0;  ///< of a block
  Offset tiles = 0;              ///< of the GPU's ranks
};

/// Blocks of a launch's kernel that fit on a processor, each with so much shared memory; 0 if the
/// GPU has none for that.
template <class T>
int blocks_that_fit(const GpuLaunch<T>& l, std::size_t shared_bytes) {
  int most = 0;
  check(cudaDeviceGetAttribute(&most, cudaDevAttrMaxSharedMemoryPerBlockOptin, l.queue->gpu()),
        "cudaDeviceGetAttribute", l.queue->rank());
  if (shared_bytes > static_cast<std::size_t>(most)) return 0;
  check(cudaFuncSetAttribute(reinterpret_cast<const void*>(l.kernel),
                             cudaFuncAttributeMaxDynamicSharedMemorySize,
                             static_cast<int>(shared_bytes)),
        "cudaFuncSetAttribute", l.queue->rank());
  // Asking for this loads the kernel, which must not happen while another GPU's waits for it.
  int blocks = 0;
  check(cudaOccupancyMaxActiveBlocksPerMultiprocessor(&blocks, l.kernel,
                                                      static_cast<int>(l.threads.x), shared_bytes),
        "cudaOccupancyMaxActiveBlocksPerMultiprocessor", l.queue->rank());
  return blocks;
}

template <class T, Kind kind, int lane_rows>
void choose(GpuLaunch<T>& l, int processors) {
  constexpr int wanted = blocks_per_sm<T, kind, lane_rows>;
  l.kernel = l.launch.solve.linked ? &solve_pcg<T, kind, lane_rows, true>
                                   : &solve_pcg<T, kind, lane_rows, false>;
  l.threads = block_threads<kind, lane_rows>;
  l.shared_bytes = sizeof(ResidentShared<T, kind, lane_rows>);
  l.launch.resident = blocks_that_fit(l, l.shared_bytes) >= wanted;
  if (!l.launch.resident) l.shared_bytes = sizeof(CollectiveShared<T, kind, lane_rows>);
  const int blocks = std::min(blocks_that_fit(l, l.shared_bytes), wanted) * processors;
  if (blocks < l.launch.rank_count)
    throw DeviceError("cannot solve with " + std::to_string(l.launch.rank_count) +
                      " ranks on one GPU, which runs " + std::to_string(blocks) +
                      " blocks at a time");
  l.blocks = static_cast<unsigned>(blocks);
}

/// Chooses the kernel and as many blocks as fill the GPU.
template <class T>
void choose_kernel(GpuLaunch<T>& l) {
  l.queue->make_current();
  int processors = 0;
  check(cudaDeviceGetAttribute(&processors, cudaDevAttrMultiProcessorCount, l.queue->gpu()),
        "cudaDeviceGetAttribute", l.queue->rank());
  if constexpr (std::is_same_v<T, float>)
    if (!l.launch.solve.levelled && l.launch.solve.partial_rows <= pcg_plain_partial_rows_max)
      return choose<T, Kind::jacobi, 1>(l, processors);
  // A processor has the lanes for a tile at a time. With two rows each they take as long for one
  // tile as for two; where the last turn has one, a row each is faster.
  const Offset turns = (l.tiles + processors - 1) / processors;
  if constexpr (std::is_same_v<T, float>)
    if (turns % 2 == 1) return choose<T, Kind::aggregates, 1>(l, processors);
  choose<T, Kind::aggregates, 2>(l, processors);
}

/// One launch a GPU. Each begins when the earlier work of all of its GPU's ranks is done.
template <class T>
std::vector<GpuLaunch<T>> make_launches(DeviceSet& devices, const std::vector<SolvePcg<T>>& args) {
  std::vector<GpuLaunch<T>> launches;
  for (int r = 0; r < devices.size(); ++r) {
    const SolvePcg<T>& own = args[static_cast<std::size_t>(r)];
    auto& queue = static_cast<CudaQueue&>(devices[r].compute());
    auto place = std::find_if(launches.begin(), launches.end(),
                              [&](const auto& l) { return l.queue->gpu() == queue.gpu(); });
    if (place == launches.end()) {
      launches.push_back({&queue, {own}});
      place = launches.end() - 1;
    } else {
      place->queue->wait(queue.record());
    }
    place->launch.rank[place->launch.rank_count++] = r;
    place->tiles += (own.rows + tile_rows - 1) / tile_rows;
  }
  for (GpuLaunch<T>& l : launches) {
    l.launch.several_gpus = launches.size() > 1;
    if (l.launch.several_gpus) l.queue->require_peers();
    choose_kernel(l);
  }
  return launches;
}

}  // namespace

template <class T>
void run(OnCuda, DeviceSet& devices, const std::vector<SolvePcg<T>>& args) {
  if (devices.size() > ranks_max)
    throw DeviceError("cannot solve over " + std::to_string(devices.size()) +
                      " CUDA ranks; allowed: 1 to " + std::to_string(ranks_max));
  std::vector<GpuLaunch<T>> launches = make_launches(devices, args);
  for (GpuLaunch<T>& l : launches) {
    l.queue->make_current();
    void* arguments[] = {&l.launch};
    check(cudaLaunchCooperativeKernel(reinterpret_cast<const void*>(l.kernel), l.blocks, l.threads,
                                      arguments, l.shared_bytes, l.queue->stream()),
          "cudaLaunchCooperativeKernel", l.queue->rank());
  }
  if (devices.size() == 1) return;
  std::vector<Event> solved;
  for (const GpuLaunch<T>& l : launches) solved.push_back(l.queue->record());
  for (int r = 0; r < devices.size(); ++r)
    for (const Event& event : solved) devices[r].compute().wait(event);
}

template void run(OnCuda, DeviceSet&, const std::vector<SolvePcg<float>>&);
template void run(OnCuda, DeviceSet&, const std::vector<SolvePcg<double>>&);

}  // namespace weft
