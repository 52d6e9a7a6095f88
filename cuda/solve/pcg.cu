#include "weft/kernels/solve/pcg.hpp"

#include "cuda/exec/check.cuh"
#include "cuda/exec/cuda_device.cuh"
#include "cuda/solve/aggregates.cuh"
#include "cuda/solve/mode_moves.cuh"
#include "cuda/solve/peers.cuh"
#include "cuda/solve/product_row.cuh"
#include "cuda/solve/reduce.cuh"

namespace weft {
namespace {

using namespace cuda;

/// Threads that add up partial sums: the order depends on their number.
constexpr int reduce_threads = 512;
/// Tiles whose products wait in shared memory before they become partial sums.
constexpr int kept_tiles = 8;
/// Two blocks hide each other's barriers; doubles have no registers for two. Blocks of two warps a
/// unit fill a processor.
template <class T, int lane_rows>
constexpr int blocks_a_processor = sizeof(T) == sizeof(float) && lane_rows == 2 ? 2 : 1;

/// One launch: the ranks of one card, which share its blocks.
template <class T>
struct PcgLaunch {
  SolvePcg<T> solve;           ///< as the first of these ranks has it
  bool several_cards = false;  ///< other ranks are on other cards
  int rank_count = 0;
  int rank[ranks_max] = {};
};

template <class T, int lane_rows>
struct PcgShared {
  SolvePcgPart<T> part;
  PcgScalars<T> scalars;
  /// Of the two kinds of levels one at most is in use.
  union {
    AggregateSums<T> aggregates;
    struct {
      ModeSums<T> sums;
      double product[kept_tiles][tile_units][mode_numbers];
    } modes;
  };
  double product[kept_tiles][tile_units][3];
  double half_product[lane_rows == 1 ? tile_units : 1][32][3];  ///< of a unit's second warp
  double warp_sum[reduce_threads / 32][3];
  int over;
};

/// What one block does of a rank's share of the collective solve. Tiles of 1,024 rows go round the
/// rank's blocks, the same in every phase: what a thread wrote of its own rows it reads itself.
///
/// An iteration moves, in bytes a row of single precision with b blocks and f far entries in the
/// matrix, padding included: 40 b + 8 f for the matrix, 12 for w; 36 for the inverse of block
/// Jacobi, 144 + 9 for those of the aggregates, or 81 + 5 with 8 for places where these have linear
/// modes; 72 to read and 60 to write p, s, r, x and u, 24 to
/// read r and u for the products, 2 for marks: 40 b + 8 f + 206, with aggregates 359 or 300; 40 for
/// each block of contacts. Vectors may come from the cache.
/// With few rows a rank is as slow as a thread is with its rows. Then a lane has one row instead of
/// two, and a unit two warps.
template <class T, bool linear, int lane_rows>
class PcgBlock {
 public:
  static constexpr int unit_warps = 3 - lane_rows;
  static constexpr int block_threads = 32 * tile_units * unit_warps;

  __device__ PcgBlock(const PcgLaunch<T>& launch, PcgShared<T, lane_rows>& shared)
      : a_(launch.solve),
        s_(shared),
        several_cards_(launch.several_cards),
        vector_epoch_(a_.epoch),
        partial_epoch_(a_.epoch) {
    const int mine = static_cast<int>(blockIdx.x);
    const auto first_block = [&](int n) {
      return static_cast<int>(Offset{gridDim.x} * n / launch.rank_count);
    };
    int n = 0;
    while (n + 1 < launch.rank_count && mine >= first_block(n + 1)) ++n;
    rank_ = launch.rank[n];
    begin_ = a_.row_begin.data()[rank_];
    rows_ = a_.row_begin.data()[rank_ + 1] - begin_;
    tiles_ = (rows_ + tile_rows - 1) / tile_rows;
    block_ = mine - first_block(n);
    blocks_ = max(1, min(first_block(n + 1) - first_block(n), tiles_));
    partial_rows_ = min(a_.partial_rows, pcg_partial_rows_max);
    partials_ = pcg_partials(a_.row_begin.data()[ranks()], a_.partial_rows);
    if (threadIdx.x == 0) {
      s_.part = a_.parts.data()[rank_];
      s_.scalars = {};
    }
    __syncthreads();
  }

  /// More blocks than tiles: nothing to do, and nobody waits for it.
  __device__ bool idle() const { return block_ >= blocks_; }

  __device__ void solve() {
    if (ranks() > 1) {
      peers().find_receivers(vector_epoch_ + 1);
      vector_epoch_ += 2;
    }
    while (true) {
      if (s_.scalars.asks_for_magnitude()) magnitude();
      true_residual();
      reduce();
      if (threadIdx.x == 0) s_.over = s_.scalars.restart(a_, s_.warp_sum[0]) ? 0 : 1;
      __syncthreads();
      if (s_.over != 0) break;
      while (s_.scalars.running) {
        update(static_cast<T>(s_.scalars.alpha), static_cast<T>(s_.scalars.beta));
        exchange();
        multiply_and_project();
        reduce();
        if (threadIdx.x == 0) s_.scalars.advance(a_, s_.warp_sum[0]);
        __syncthreads();
      }
    }
    if (block_ == 0 && threadIdx.x == 0) s_.part.status.data()[0] = s_.scalars.status;
  }

 private:
  __device__ int ranks() const { return static_cast<int>(a_.parts.size()); }
  __device__ static int warp() { return static_cast<int>(threadIdx.x) / 32; }
  __device__ static int lane() { return static_cast<int>(threadIdx.x) % 32; }
  __device__ bool fixed(Index row) const { return s_.part.fixed.data()[begin_ + row] != 0; }
  __device__ WarpRows rows_of(Index tile) const {
    const int unit = warp() / unit_warps;
    const int half = warp() % unit_warps;
    const Index first = tile * tile_rows + unit * unit_rows;
    return {unit, half, lane(), first + 32 * half, first < rows_};
  }

  __device__ Peers<T> peers() const {
    return {a_, s_.part, several_cards_, rank_, begin_, block_, blocks_};
  }

  /// Waits for what all ranks whose rows are multiplied here, this one included, have sent of a
  /// vector. Own rows may be written and sent again once a reduction has passed: by then every peer
  /// has multiplied them.
  __device__ void exchange() {
    ++vector_epoch_;
    const Peers<T> p = peers();
    p.publish(Flag::vector, vector_epoch_);
    const Index* offset = s_.part.ghost_offset.data();
    for (int peer = static_cast<int>(threadIdx.x); peer < ranks(); peer += block_threads)
      if (peer == rank_ || offset[peer] < offset[peer + 1])
        p.wait_for(Flag::vector, peer, vector_epoch_);
    __syncthreads();
  }

  /// The same for x, which is not sent as it changes.
  __device__ void exchange_x() {
    if (ranks() > 1)
      for (Index tile = block_; tile < tiles_; tile += blocks_) {
        const WarpRows at = rows_of(tile);
        for (Index row = at.first + at.lane; row < min(rows_, at.first + 32 * lane_rows); row += 32)
          peers().send(&SolvePcgPart<T>::x, row, s_.part.x.data()[begin_ + row]);
      }
    exchange();
  }

  /// Lane's row of A vector, of 32 rows from `first` on; zero in fixed rows. The whole warp calls.
  __device__ Vec3<T> product(Index first, const Vec3<T>* vector) {
    const Index row = first + lane();
    const bool free = row < rows_ && !fixed(row);
    Vec3<T> sum{};
    if (free) sum = mesh_row<cuda_slice>(s_.part, row, vector);
    if (s_.part.contact.row_count > 0 && first < rows_) {
      T* products = linear
                        ? s_.modes.sums.touching[warp()]
                        : s_.aggregates.piece[warp() / unit_warps] + 3 * 32 * (warp() % unit_warps);
      const Vec3<T> touching = contact_row(s_.part.contact, first, vector, products);
      if (free) sum += touching;
    }
    return sum;
  }

  /// r = b - A x in free rows, u = P r, w = A u, and their products.
  __device__ void true_residual() {
    exchange_x();
    int parity = 0;
    for (Index tile = block_; tile < tiles_; tile += blocks_, parity ^= 1) {
      const WarpRows at = rows_of(tile);
      Vec3<T> r[lane_rows] = {};
      Vec3<T> u[lane_rows] = {};
      for (int j = 0; j < lane_rows; ++j) {
        const Index row = at.first + 32 * j + at.lane;
        const Vec3<T> ax = product(at.first + 32 * j, s_.part.x.data());
        if (row >= rows_) continue;
        if (!fixed(row)) r[j] = s_.part.rhs.data()[row] - ax;
        s_.part.r.data()[row] = r[j];
        u[j] = s_.part.inverse.data()[row] * r[j];
      }
      if constexpr (linear)
        modes().store_tile(at, tile, r, next_parity());
      else
        finish_u(at, parity, r, u);
    }
    if constexpr (linear) begin_modes();
    exchange();
    multiply_and_project();
  }

  /// Leaves the 2-norm of |A| |x| + |b| in free rows to the scalars.
  __device__ void magnitude() {
    exchange_x();
    sum_products(true);
    reduce();
    if (threadIdx.x == 0) s_.scalars.magnitude = sqrt(s_.warp_sum[0][0]);
  }
  __device__ ModeBlock<T> modes() { return {a_, s_.part, s_.modes.sums, rank_, block_, blocks_}; }
  __device__ int parity() const { return static_cast<int>((partial_epoch_ - a_.epoch) % 2); }
  __device__ int next_parity() const { return 1 - parity(); }

  /// Levels with linear modes, once sums of r are stored: moves of r, and u = P r.
  __device__ void begin_modes() {
    ++partial_epoch_;
    wait_for_partials();
    modes().solve(parity());
    modes().advance(0, 0, true);
    int turn = 0;
    for (Index tile = block_; tile < tiles_; tile += blocks_, turn ^= 1) {
      const WarpRows at = rows_of(tile);
      Vec3<T> r[lane_rows] = {};
      Vec3<T> u[lane_rows] = {};
      for (int j = 0; j < lane_rows; ++j) {
        const Index row = at.first + 32 * j + at.lane;
        if (row >= rows_) continue;
        r[j] = s_.part.r.data()[row];
        u[j] = s_.part.inverse.data()[row] * r[j];
      }
      finish_u(at, turn, r, u);
    }
  }

  /// One step along the direction that u gives, then u = P r.
  __device__ void update(T alpha, T beta) {
    if constexpr (linear)
      modes().advance(static_cast<double>(alpha), static_cast<double>(beta), false);
    int parity = 0;
    for (Index tile = block_; tile < tiles_; tile += blocks_, parity ^= 1) {
      const WarpRows at = rows_of(tile);
      Vec3<T> r[lane_rows] = {};
      Vec3<T> u[lane_rows] = {};
#pragma unroll
      for (int j = 0; j < lane_rows; ++j) {
        const Index row = at.first + 32 * j + at.lane;
        if (row >= rows_) continue;
        Vec3<T> p = s_.part.u.data()[begin_ + row];
        Vec3<T> s = s_.part.w.data()[row];
        if (beta != T(0)) {
          p += beta * s_.part.p.data()[row];
          s += beta * s_.part.s.data()[row];
        }
        r[j] = s_.part.r.data()[row] - alpha * s;
        s_.part.p.data()[row] = p;
        s_.part.s.data()[row] = s;
        s_.part.r.data()[row] = r[j];
        s_.part.x.data()[begin_ + row] += alpha * p;
        u[j] = s_.part.inverse.data()[row] * r[j];
      }
      finish_u(at, parity, r, u);
    }
  }

  /// Adds the aggregates' corrections to u and stores it.
  __device__ void finish_u(const WarpRows& at, int parity, const Vec3<T>* r, Vec3<T>* u) {
    if constexpr (linear) {
      modes().correct(at, parity, r, u);
    } else {
      const CoarseLevel<T>& fine = s_.part.coarse[0];
      const CoarseLevel<T>& wide = s_.part.coarse[1];
      if (fine.aggregates >= 2) {
        sum_aggregates<lane_rows>(at, r, s_.aggregates, parity);
        correct_fine<lane_rows>(at, fine, rows_, s_.aggregates, u);
        if (wide.aggregates >= 2) correct_wide<lane_rows>(at, wide, parity, s_.aggregates, u);
      }
    }
#pragma unroll
    for (int j = 0; j < lane_rows; ++j) {
      const Index row = at.first + 32 * j + at.lane;
      if (row >= rows_) continue;
      if (fixed(row)) u[j] = {};
      s_.part.u.data()[begin_ + row] = u[j];
      peers().send(&SolvePcgPart<T>::u, row, u[j]);
    }
  }

  /// w = A u, and partial sums of (r, u), (w, u), (r, r).
  __device__ void multiply_and_project() {
    sum_products(false);
  }

  /// The same, or partial sums of magnitude_sq() alone.
  __device__ void sum_products(bool magnitudes) {
    ++partial_epoch_;
    int kept = 0;
    for (Index tile = block_; tile < tiles_; tile += blocks_) {
      const WarpRows at = rows_of(tile);
      double product_sum[3] = {};
      T mode_sum[mode_numbers] = {};
#pragma unroll 1
      for (int j = 0; j < lane_rows; ++j) {
        const Index row = at.first + 32 * j + at.lane;
        double d[3] = {};
        if (magnitudes && row < rows_ && !fixed(row)) d[0] = magnitude_sq(s_.part, row);
        Vec3<T> w{};
        if (!magnitudes) w = product(at.first + 32 * j, s_.part.u.data());
        if (!magnitudes && row < rows_) project(row, w, d);
        if constexpr (linear) {
          if (row < rows_) modes().add(row, w, mode_sum);
          if (partial_rows_ < unit_rows) {
            modes().store_small(row, mode_sum, parity());
            for (T& x : mode_sum) x = 0;
          }
        }
        if (partial_rows_ < unit_rows)
          store_small_partials(row, d);
        else
          for (int k = 0; k < 3; ++k) product_sum[k] += d[k];
      }
      if (partial_rows_ < unit_rows) continue;
      if constexpr (unit_warps == 2) add_half(at, product_sum);
      for (int k = 0; k < 3; ++k) {
        const double sum = sum_lanes(product_sum[k]);
        if (at.lane == 0 && at.half == 0) s_.product[kept][at.unit][k] = sum;
      }
      if constexpr (linear) modes().join(at, mode_sum, s_.modes.product[kept][at.unit]);
      if (++kept == kept_tiles || tile + blocks_ >= tiles_) {
        store_partials(tile - (kept - 1) * blocks_, kept);
        kept = 0;
      }
    }
  }

  /// Adds what a lane of the unit's second warp has to that of the first.
  __device__ void add_half(const WarpRows& at, double d[3]) {
    double* other = s_.half_product[at.unit][at.lane];
    __syncthreads();
    if (at.half == 1)
      for (int k = 0; k < 3; ++k) other[k] = d[k];
    __syncthreads();
    if (at.half == 0)
      for (int k = 0; k < 3; ++k) d[k] += other[k];
  }

  __device__ void project(Index row, const Vec3<T>& w, double d[3]) {
    s_.part.w.data()[row] = w;
    const Vec3<double> u_row = vec_cast<double>(s_.part.u.data()[begin_ + row]);
    const Vec3<double> r_row = vec_cast<double>(s_.part.r.data()[row]);
    d[0] = dot(r_row, u_row);
    d[1] = dot(vec_cast<double>(w), u_row);
    d[2] = dot(r_row, r_row);
  }

  /// Place of the partial sums that own row `row` begins.
  __device__ Index partial_of(Index row) const {
    return 3 * (parity() * partials_ + (begin_ + row) / partial_rows_);
  }

  /// Partial sums of fewer rows than a warp has: groups of lanes.
  __device__ void store_small_partials(Index row, const double d[3]) {
    const int width = min(static_cast<int>(partial_rows_), 32);
    for (int k = 0; k < 3; ++k) {
      const double sum = sum_lanes(d[k], width);
      if (lane() % width == 0 && row < rows_) peers().send_partial(partial_of(row) + k, sum);
    }
  }

  /// Partial sums of whole warps' rows, for `count` tiles from `tile` on, a stride of blocks apart.
  __device__ void store_partials(Index tile, int count) {
    __syncthreads();
    const int group = static_cast<int>(partial_rows_ / unit_rows);
    for (int n = static_cast<int>(threadIdx.x); n < 3 * count * tile_units / group;
         n += block_threads) {
      const int k = n % 3;
      const int first = n / 3 * group;  // warp, counted through all tiles
      const Index row =
          (tile + first / tile_units * blocks_) * tile_rows + first % tile_units * unit_rows;
      if (row >= rows_) continue;
      double sum = 0;
      for (int m = 0; m < group; ++m)
        sum += s_.product[first / tile_units][first % tile_units + m][k];
      peers().send_partial(partial_of(row) + k, sum);
    }
    if constexpr (linear) store_mode_sums(tile, count, group);
    __syncthreads();
  }

  /// The same for the sums over modes.
  __device__ void store_mode_sums(Index tile, int count, int group) {
    for (int n = static_cast<int>(threadIdx.x); n < mode_numbers * count * tile_units / group;
         n += block_threads) {
      const int k = n % mode_numbers;
      const int first = n / mode_numbers * group;  // warp, counted through all tiles
      const Index row =
          (tile + first / tile_units * blocks_) * tile_rows + first % tile_units * unit_rows;
      if (row >= rows_) continue;
      double sum = 0;
      for (int m = 0; m < group; ++m)
        sum += s_.modes.product[first / tile_units][first % tile_units + m][k];
      modes().own_sum(row, parity())[k] = sum;
    }
  }

  __device__ void wait_for_partials() {
    const Peers<T> p = peers();
    p.publish(Flag::partials, partial_epoch_);
    for (int peer = static_cast<int>(threadIdx.x); peer < ranks(); peer += block_threads)
      p.wait_for(Flag::partials, peer, partial_epoch_);
    __syncthreads();
  }

  /// warp_sum[0] = the partial sums of all ranks, for thread 0. A thread adds some of them,
  /// lanes and warps are then joined pairwise: the shape depends on their number alone.
  __device__ void reduce() {
    wait_for_partials();
    if constexpr (linear) modes().solve(parity());
    double d[3] = {};
    const double* all = s_.part.partial.data() + 3 * parity() * partials_;
    if (warp() < reduce_threads / 32) {
      for (auto n = static_cast<Index>(threadIdx.x); n < partials_; n += reduce_threads)
        for (int k = 0; k < 3; ++k) d[k] += all[3 * n + k];
      for (int k = 0; k < 3; ++k) {
        const double sum = sum_lanes(d[k]);
        if (lane() == 0) s_.warp_sum[warp()][k] = sum;
      }
    }
    __syncthreads();
    if (warp() != 0) return;
    for (int k = 0; k < 3; ++k) {
      const double sum = sum_lanes(lane() < reduce_threads / 32 ? s_.warp_sum[lane()][k] : 0.0);
      if (lane() == 0) s_.warp_sum[0][k] = sum;
    }
  }

  const SolvePcg<T>& a_;
  PcgShared<T, lane_rows>& s_;
  bool several_cards_;
  int rank_;
  Index begin_, rows_, tiles_;
  int block_, blocks_;  ///< of this rank
  Index partial_rows_, partials_;
  std::uint32_t vector_epoch_, partial_epoch_;
};

template <class T, bool linear, int lane_rows>
__global__ void __launch_bounds__(PcgBlock<T, linear, lane_rows>::block_threads,
                                  blocks_a_processor<T, lane_rows>)
    solve_pcg(const __grid_constant__ PcgLaunch<T> launch) {
  __shared__ alignas(16) unsigned char memory[sizeof(PcgShared<T, lane_rows>)];
  PcgBlock<T, linear, lane_rows> block(launch, *reinterpret_cast<PcgShared<T, lane_rows>*>(memory));
  if (!block.idle()) block.solve();
}

/// A launch and where it goes.
template <class T>
struct CardLaunch {
  CudaQueue* queue = nullptr;  ///< of the first of the card's ranks
  PcgLaunch<T> launch;
  void (*kernel)(PcgLaunch<T>) = nullptr;
  dim3 blocks = {};
  dim3 threads = {};
  Offset tiles = 0;  ///< of the card's ranks
};

template <class T, bool linear, int lane_rows>
void choose(CardLaunch<T>& l, int processors) {
  l.kernel = &solve_pcg<T, linear, lane_rows>;
  l.threads = PcgBlock<T, linear, lane_rows>::block_threads;
  // Asking for this loads the kernel, which must not happen while another card's waits for it.
  int resident = 0;
  check(cudaOccupancyMaxActiveBlocksPerMultiprocessor(&resident, l.kernel,
                                                      static_cast<int>(l.threads.x), 0),
        "cudaOccupancyMaxActiveBlocksPerMultiprocessor", l.queue->rank());
  l.blocks =
      static_cast<unsigned>(std::min(resident, blocks_a_processor<T, lane_rows>) * processors);
}

/// Chooses the kernel and as many blocks as fill the card.
template <class T>
void choose_kernel(CardLaunch<T>& l) {
  l.queue->make_current();
  int processors = 0;
  check(cudaDeviceGetAttribute(&processors, cudaDevAttrMultiProcessorCount, l.queue->card()),
        "cudaDeviceGetAttribute", l.queue->rank());
  if (l.launch.solve.linear) return choose<T, true, 2>(l, processors);
  if constexpr (std::is_same_v<T, float>)
    if (l.tiles <= processors) return choose<T, false, 1>(l, processors);
  choose<T, false, 2>(l, processors);
}

/// One launch a card. Each begins when the earlier work of all of its card's ranks is done.
template <class T>
std::vector<CardLaunch<T>> make_launches(DeviceSet& devices, const std::vector<SolvePcg<T>>& args) {
  std::vector<CardLaunch<T>> launches;
  for (int r = 0; r < devices.size(); ++r) {
    const SolvePcg<T>& own = args[static_cast<std::size_t>(r)];
    auto& queue = static_cast<CudaQueue&>(devices[r].compute());
    auto place = std::find_if(launches.begin(), launches.end(),
                              [&](const auto& l) { return l.queue->card() == queue.card(); });
    if (place == launches.end()) {
      launches.push_back({&queue, {own}});
      place = launches.end() - 1;
    } else {
      place->queue->wait(queue.record());
    }
    place->launch.rank[place->launch.rank_count++] = r;
    place->tiles += (own.rows + tile_rows - 1) / tile_rows;
  }
  for (CardLaunch<T>& l : launches) {
    l.launch.several_cards = launches.size() > 1;
    if (l.launch.several_cards) l.queue->require_peers();
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
  std::vector<CardLaunch<T>> launches = make_launches(devices, args);
  for (CardLaunch<T>& l : launches) {
    l.queue->make_current();
    void* arguments[] = {&l.launch};
    check(cudaLaunchCooperativeKernel(reinterpret_cast<const void*>(l.kernel), l.blocks, l.threads,
                                      arguments, 0, l.queue->stream()),
          "cudaLaunchCooperativeKernel", l.queue->rank());
  }
  if (devices.size() == 1) return;
  std::vector<Event> solved;
  for (const CardLaunch<T>& l : launches) solved.push_back(l.queue->record());
  for (int r = 0; r < devices.size(); ++r)
    for (const Event& event : solved) devices[r].compute().wait(event);
}

template void run(OnCuda, DeviceSet&, const std::vector<SolvePcg<float>>&);
template void run(OnCuda, DeviceSet&, const std::vector<SolvePcg<double>>&);

}  // namespace weft
