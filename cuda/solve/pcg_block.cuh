#pragma once

#include "cuda/exec/sums.cuh"
#include "cuda/solve/aggregates.cuh"
#include "cuda/solve/contact_operator.cuh"
#include "cuda/solve/product_row.cuh"

namespace weft::cuda {

/// What a kernel has in its preconditioner. Each kind has an instance of its own, so that none
/// bears the code of another.
enum class Kind { jacobi, aggregates };

/// Rows that a block works on at a time, of whole partial sums. With block Jacobi alone no domain
/// asks for more: then processors get the more alike numbers of rows the fewer these are.
template <Kind kind>
constexpr Index rows_a_tile = kind == Kind::jacobi ? pcg_plain_partial_rows_max : tile_rows;
template <Kind kind>
constexpr int units_a_tile = static_cast<int>(rows_a_tile<kind> / unit_rows);

/// Warps of a unit, each of whose lanes has so many rows.
template <int lane_rows>
constexpr int unit_warps = 3 - lane_rows;
template <Kind kind, int lane_rows>
constexpr int block_threads = 32 * units_a_tile<kind>* unit_warps<lane_rows>;
/// Threads that add up partial sums: the order depends on their number.
inline constexpr int reduce_threads = 512;
/// Tiles whose products wait in shared memory before they become partial sums.
inline constexpr int kept_tiles = 8;
/// Two blocks of 512 threads hide each other's barriers; doubles have no registers for two.
template <class T, Kind kind, int lane_rows>
constexpr int blocks_per_sm = sizeof(T) == sizeof(float) ? 1024 / block_threads<kind, lane_rows>
                                                         : 1;

/// What all threads of a block know alike, in shared memory: it must not take their registers.
struct BlockShare {
  int rank;
  int block, blocks;             ///< of the rank's
  Index begin, rows, tiles;      ///< of the rank
  Index partial_rows, partials;  ///< partial sums of all ranks
};

/// Shared memory that the levels of a block need.
template <class T, Kind kind, int lane_rows>
struct LevelShared {
  AggregateSums<T, lane_rows> aggregates;
};
template <class T, int lane_rows>
struct LevelShared<T, Kind::jacobi, lane_rows> {};

/// Shared memory of a block of a solve.
template <class T, Kind kind, int lane_rows>
struct PcgShared {
  LevelShared<T, kind, lane_rows> levels;
  double product[kept_tiles][units_a_tile<kind>][3];
  /// of a unit's second warp
  double half_product[lane_rows == 1 ? units_a_tile<kind> : 1][32][3];
  double warp_sum[reduce_threads / 32][3];
  BlockShare share;
};

/// Vectors of a tile's rows in the shared memory of the block that works on them: nobody else reads
/// them while a solve runs. With more beside them too little is left of the cache, see
/// benchmarks/journal/2026-11-one-h200.md.
template <class T, Kind kind>
struct ResidentTile {
  Vec3<T> p[rows_a_tile<kind>], s[rows_a_tile<kind>], r[rows_a_tile<kind>], x[rows_a_tile<kind>];
};

/// Which rank a block works for, and which of its blocks it is.
struct BlockPlace {
  int rank;
  int block, blocks;
};

/// w = mesh part of A vector in the rows at 32 own places from `first` on, zero in fixed ones. The
/// whole warp calls it; w may be read after sync_unit().
/// @param begin, rows of the rank
template <class T>
__device__ __forceinline__ void multiply_rows_inline(const SolvePcgPart<T>& part, Index begin,
                                                     Index rows, Index first,
                                                     const Vec3<T>* vector) {
  const Index place = first + static_cast<Index>(threadIdx.x % 32);
  if (place >= rows) return;
  const Index row = part.mesh.order.row(place);
  Vec3<T> sum{};
  if (part.fixed.data()[begin + row] == 0)
    sum = mesh_row<cuda_slice>(part, place, row, begin, vector);
  part.w.data()[row] = sum;
}

/// The same, never inlined: with aggregates, the loops would spill registers of the solve around
/// them.
template <class T>
__device__ __noinline__ void multiply_rows(const SolvePcgPart<T>& part, Index begin, Index rows,
                                           Index first, const Vec3<T>* vector) {
  multiply_rows_inline(part, begin, rows, first, vector);
}

/// Adds the contact part of A vector to w in the same rows. The whole warp calls it.
/// @tparam pulled see contact_row()   @param begin, rows of the rank
template <bool pulled, class T>
__device__ void add_contact_rows(const SolvePcgPart<T>& part, Index begin, Index rows, Index first,
                                 const Vec3<T>* vector) {
  const Index place = first + static_cast<Index>(threadIdx.x % 32);
  if (place >= rows) return;
  const Index row = part.mesh.order.row(place);
  const Index* offset = part.contact.end_offset.data();
  if (offset[row] == offset[row + 1] || part.fixed.data()[begin + row] != 0) return;
  part.w.data()[row] += contact_row<pulled>(part.contact, row, vector);
}

/// The rows of a tile that the calling warp has.
template <Kind kind, int lane_rows>
__device__ WarpRows rows_of_tile(Index tile, Index rows) {
  const int warp = static_cast<int>(threadIdx.x) / 32;
  const int unit = warp / unit_warps<lane_rows>;
  const int half = warp % unit_warps<lane_rows>;
  const Index first = tile * rows_a_tile<kind> + unit * unit_rows;
  return {unit, half, static_cast<int>(threadIdx.x) % 32, first + 32 * half, first < rows};
}

/// What one block computes of a rank's share of a solve, whatever the transport. Tiles of
/// rows_a_tile rows go round the rank's blocks, the same in every phase: what a thread wrote of its
/// own rows it reads itself. A rank is as slow as a lane is with its rows: where these would be one
/// less with one at a time, a lane has one row, and a unit two warps (choose_kernel()).
///
/// Vectors of a block's first tile may stand in its shared memory as long as the kernel runs, see
/// ResidentTile: all of them, if the GPU has a block for each tile.
///
/// An iteration moves, in bytes a row of single precision with b blocks and f far entries in the
/// matrix, the diagonal not included: 40 b + 8 f for the matrix, 4 for the order of rows, 4 for the
/// mass, 12 for w; 36 for the inverse of block Jacobi, 78 + 9 for those of the aggregates; 72 to
/// read and 60 to write p, s, r, x and u, 24 to read r and u for the products, 2 for marks: 40 b +
/// 8 f + 214, with aggregates 301, of which 108 stay on the processor for resident rows; for a link
/// of contacts 96 and for each of its ends 8. Vectors may come from the cache.
///
/// @tparam Transport the class that derives from this one. It has send(row, x), own row of u to the
///                   other ranks, and send_partial(n, sum), number n of all partial sums.
template <class T, Kind kind, int lane_rows, class Transport>
class PcgBlock {
 protected:
  static constexpr int threads = block_threads<kind, lane_rows>;
  static constexpr int units = units_a_tile<kind>;
  static_assert(threads >= reduce_threads);

  /// All are referred to; `part` may be filled in later.
  /// @param resident shared memory for the block's first tile; null: there is none
  __device__ PcgBlock(const SolvePcg<T>& args, const SolvePcgPart<T>& part,
                      PcgShared<T, kind, lane_rows>& shared, const BlockPlace& place,
                      ResidentTile<T, kind>* resident = nullptr)
      : a_(args), part_(part), s_(shared), resident_(resident) {
    if (threadIdx.x == 0) {
      BlockShare& own = shared.share;
      const Span<const Index>& row_begin = args.row_begin;
      own.rank = place.rank;
      own.begin = row_begin.data()[place.rank];
      own.rows = row_begin.data()[place.rank + 1] - own.begin;
      own.tiles = (own.rows + rows_a_tile<kind> - 1) / rows_a_tile<kind>;
      own.block = place.block;
      own.blocks = max(1, min(place.blocks, own.tiles));
      own.partial_rows = min(args.partial_rows, pcg_partial_rows_max);
      own.partials = pcg_partials(row_begin.data()[row_begin.size() - 1], args.partial_rows);
    }
    __syncthreads();
  }

  __device__ static int warp() { return static_cast<int>(threadIdx.x) / 32; }
  __device__ static int lane() { return static_cast<int>(threadIdx.x) % 32; }
  __device__ bool fixed(Index row) const { return part_.fixed.data()[begin_ + row] != 0; }
  __device__ WarpRows rows_of(Index tile) const {
    return rows_of_tile<kind, lane_rows>(tile, rows_);
  }

  /// Own vectors of a tile's rows, wherever they are.
  struct TileVectors {
    Index first;  ///< row that they begin with
    Vec3<T>*p, *s, *r, *x;
  };
  __device__ TileVectors vectors_of(Index tile) const {
    if (resident_ == nullptr || tile != block_) return in_memory(tile);
    return {tile * rows_a_tile<kind>, resident_->p, resident_->s, resident_->r, resident_->x};
  }

  /// Fills the resident tile: with x and, if the solve resumes, with what it has paused with.
  __device__ void fetch_resident() const {
    copy_resident_x(vectors_of(block_), in_memory(block_));
    if (a_.resume) copy_recurrence(vectors_of(block_), in_memory(block_));
  }
  __device__ void store_resident_x() const {
    copy_resident_x(in_memory(block_), vectors_of(block_));
  }
  /// What a solve that has paused needs to resume.
  __device__ void store_recurrence() const {
    copy_recurrence(in_memory(block_), vectors_of(block_));
  }

  __device__ void multiply_tile(const WarpRows& at, const Vec3<T>* vector) {
    for (int j = 0; j < lane_rows; ++j) {
      if constexpr (kind == Kind::jacobi)
        multiply_rows_inline(part_, begin_, rows_, at.first + 32 * j, vector);
      else
        multiply_rows(part_, begin_, rows_, at.first + 32 * j, vector);
    }
    sync_unit<lane_rows>();
  }

  /// r = b - A x in free rows, u = P r.
  /// @tparam multiplied w has A x
  template <bool multiplied>
  __device__ void take_residual() {
    int turn = 0;
    for (Index tile = block_; tile < tiles_; tile += blocks_, turn ^= 1) {
      const WarpRows at = rows_of(tile);
      const TileVectors own = vectors_of(tile);
      if constexpr (!multiplied) multiply_tile(at, part_.x.data());
      Vec3<T> r[lane_rows] = {};
      Vec3<T> u[lane_rows] = {};
      for (int j = 0; j < lane_rows; ++j) {
        const Index row = at.first + 32 * j + at.lane;
        if (row >= rows_) continue;
        if (!fixed(row)) r[j] = part_.rhs.data()[row] - part_.w.data()[row];
        own.r[row - own.first] = r[j];
        u[j] = load_once(part_.inverse, row) * r[j];
      }
      finish_u(at, turn, r, u);
    }
  }

  /// One step along the direction that u gives, then u = P r.
  __device__ void update(T alpha, T beta) {
    int turn = 0;
    for (Index tile = block_; tile < tiles_; tile += blocks_, turn ^= 1) {
      const WarpRows at = rows_of(tile);
      const TileVectors own = vectors_of(tile);
      Vec3<T> r[lane_rows] = {};
      Vec3<T> u[lane_rows] = {};
#pragma unroll
      for (int j = 0; j < lane_rows; ++j) {
        const Index row = at.first + 32 * j + at.lane;
        if (row >= rows_) continue;
        const Index i = row - own.first;
        Vec3<T> p = part_.u.data()[begin_ + row];
        Vec3<T> s = part_.w.data()[row];
        if (beta != T(0)) {
          p += beta * own.p[i];
          s += beta * own.s[i];
        }
        r[j] = own.r[i] - alpha * s;
        own.p[i] = p;
        own.s[i] = s;
        own.r[i] = r[j];
        own.x[i] += alpha * p;
        u[j] = load_once(part_.inverse, row) * r[j];
      }
      finish_u(at, turn, r, u);
    }
  }

  /// Adds the aggregates' corrections to u and stores it.
  __device__ void finish_u(const WarpRows& at, int turn, const Vec3<T>* r, Vec3<T>* u) {
    if constexpr (kind == Kind::aggregates) {
      if (part_.fine.aggregates > 0) {
        sum_aggregates<lane_rows>(at, r, s_.levels.aggregates, turn);
        correct_fine<lane_rows>(at, part_.fine, rows_, s_.levels.aggregates, u);
        if (part_.wide.aggregates > 0)
          correct_wide<lane_rows>(at, part_.wide, turn, s_.levels.aggregates, u);
      }
    }
#pragma unroll
    for (int j = 0; j < lane_rows; ++j) {
      const Index row = at.first + 32 * j + at.lane;
      if (row >= rows_) continue;
      if (fixed(row)) u[j] = {};
      part_.u.data()[begin_ + row] = u[j];
      transport().send(row, u[j]);
    }
  }

  /// w = A u, and partial sums of (r, u), (w, u), (r, r) into a set; or those of magnitude_sq().
  /// @tparam multiplied w has A u
  template <bool multiplied>
  __device__ void sum_products(bool magnitudes, int set) {
    int kept = 0;
    for (Index tile = block_; tile < tiles_; tile += blocks_) {
      const WarpRows at = rows_of(tile);
      const TileVectors own = vectors_of(tile);
      if constexpr (!multiplied)
        if (!magnitudes) multiply_tile(at, part_.u.data());
      double product_sum[3] = {};
#pragma unroll 1
      for (int j = 0; j < lane_rows; ++j) {
        const Index row = at.first + 32 * j + at.lane;
        double d[3] = {};
        Vec3<T> w{};
        if (row < rows_) {
          if (!magnitudes) {
            w = part_.w.data()[row];
            project(row, w, own.r[row - own.first], d);
          } else if (!fixed(row)) {
            d[0] = magnitude_sq(part_, row, part_.x.data()[begin_ + row]);
          }
        }
        if (partial_rows_ < unit_rows)
          store_small_partials(row, d, set);
        else
          for (int k = 0; k < 3; ++k) product_sum[k] += d[k];
      }
      if (partial_rows_ < unit_rows) continue;
      if constexpr (lane_rows == 1) add_half(at, product_sum);
      for (int k = 0; k < 3; ++k) {
        const double sum = sum_lanes(product_sum[k]);
        if (at.lane == 0 && at.half == 0) s_.product[kept][at.unit][k] = sum;
      }
      if (++kept == kept_tiles || tile + blocks_ >= tiles_) {
        store_partials(tile - (kept - 1) * blocks_, kept, set);
        kept = 0;
      }
    }
  }

  /// warp_sum[0] = the partial sums of all ranks in a set, for thread 0. A thread adds some
  /// of them, lanes and warps are then joined pairwise: the shape depends on their number alone.
  __device__ void join_partials(int set) {
    double d[3] = {};
    const double* all = part_.partial.data() + 3 * set * partials_;
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

 private:
  /// The vectors of a tile in the rank's memory.
  __device__ TileVectors in_memory(Index tile) const {
    const Index first = tile * rows_a_tile<kind>;
    return {first, part_.p.data() + first, part_.s.data() + first, part_.r.data() + first,
            part_.x.data() + begin_ + first};
  }
  /// Calls use(i) for the place of each row of the resident tile that the thread has.
  template <class Use>
  __device__ void for_resident_rows(const Use& use) const {
    if (resident_ == nullptr || block_ >= tiles_) return;
    const WarpRows at = rows_of(block_);
    for (int j = 0; j < lane_rows; ++j) {
      const Index row = at.first + 32 * j + at.lane;
      if (row < rows_) use(row - block_ * rows_a_tile<kind>);
    }
  }
  __device__ void copy_resident_x(const TileVectors& to, const TileVectors& from) const {
    for_resident_rows([&](Index i) { to.x[i] = from.x[i]; });
  }
  __device__ void copy_recurrence(const TileVectors& to, const TileVectors& from) const {
    for_resident_rows([&](Index i) {
      to.p[i] = from.p[i];
      to.s[i] = from.s[i];
      to.r[i] = from.r[i];
    });
  }
  __device__ const Transport& transport() const {
    return static_cast<const Transport&>(*this);
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

  __device__ void project(Index row, const Vec3<T>& w, const Vec3<T>& r, double d[3]) const {
    const Vec3<double> u_row = vec_cast<double>(part_.u.data()[begin_ + row]);
    const Vec3<double> r_row = vec_cast<double>(r);
    d[0] = fused_dot(r_row, u_row);
    d[1] = fused_dot(vec_cast<double>(w), u_row);
    d[2] = fused_dot(r_row, r_row);
  }

  /// Place of the partial sums that own row `row` begins.
  __device__ Index partial_of(Index row, int set) const {
    return 3 * (set * partials_ + (begin_ + row) / partial_rows_);
  }

  /// Partial sums of fewer rows than a warp has: groups of lanes.
  __device__ void store_small_partials(Index row, const double d[3], int set) const {
    const int width = min(static_cast<int>(partial_rows_), 32);
    for (int k = 0; k < 3; ++k) {
      const double sum = sum_lanes(d[k], width);
      if (lane() % width == 0 && row < rows_)
        transport().send_partial(partial_of(row, set) + k, sum);
    }
  }

  /// Partial sums of whole warps' rows, for `count` tiles from `tile` on, a stride of blocks apart.
  __device__ void store_partials(Index tile, int count, int set) {
    __syncthreads();
    const int group = static_cast<int>(partial_rows_ / unit_rows);
    for (int n = static_cast<int>(threadIdx.x); n < 3 * count * units / group; n += threads) {
      const int k = n % 3;
      const int first = n / 3 * group;  // warp, counted through all tiles
      const Index row =
          (tile + first / units * blocks_) * rows_a_tile<kind> + first % units * unit_rows;
      if (row >= rows_) continue;
      double sum = 0;
      for (int m = 0; m < group; ++m) sum += s_.product[first / units][first % units + m][k];
      transport().send_partial(partial_of(row, set) + k, sum);
    }
    __syncthreads();
  }

 protected:
  const SolvePcg<T>& a_;
  const SolvePcgPart<T>& part_;
  PcgShared<T, kind, lane_rows>& s_;
  ResidentTile<T, kind>* const resident_;
  const int& rank_ = s_.share.rank;
  const int& block_ = s_.share.block;
  const int& blocks_ = s_.share.blocks;
  const Index& begin_ = s_.share.begin;
  const Index& rows_ = s_.share.rows;
  const Index& tiles_ = s_.share.tiles;
  const Index& partial_rows_ = s_.share.partial_rows;
  const Index& partials_ = s_.share.partials;
};

}  // namespace weft::cuda
