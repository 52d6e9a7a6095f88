#pragma once

#include <cuda/atomic>

#include "weft/kernels/solve/pcg.hpp"

namespace weft::cuda {

/// Ranks of a solve at most: bits of a word of SolvePcgPart::receivers.
constexpr int ranks_max = 32;

/// Words of SolvePcgPart::ready: of each flag the epochs that the ranks have reached, by rank and
/// written by them, and the count of own blocks on a line of its own. Of `own` no other rank hears.
enum class Flag { vector, partials, own };
constexpr int flag_stride = 64;
constexpr int count_place = 32;
/// After the flags: halves of the sums of a reduction, each with the epoch in the word behind it.
constexpr int sums_place = 3 * flag_stride;
static_assert(ranks_max <= count_place && pcg_flags >= sums_place + 12);

/// What a block of a collective solve does to reach the other ranks. Flags, rows of vectors and
/// partial sums are written into the memory of those who need them, so that nobody waits for an
/// answer from another GPU: stores are under way while the next rows are computed.
template <class T>
class Peers {
 public:
  /// @param begin first row of the rank   @param block, blocks of the rank
  /// @param several_gpus the ranks are on more than one GPU
  __device__ Peers(const SolvePcg<T>& args, const SolvePcgPart<T>& part, bool several_gpus,
                   int rank, Index begin, int block, int blocks)
      : a_(args),
        part_(part),
        several_gpus_(several_gpus),
        rank_(rank),
        begin_(begin),
        block_(block),
        blocks_(blocks) {}

  __device__ int ranks() const { return static_cast<int>(a_.parts.size()); }

  /// Tells all ranks that this one has reached `epoch`, once all of its blocks have: what any of
  /// their threads wrote before, here or on another GPU, is visible to whoever has seen it. The
  /// block calls it.
  __device__ void publish(Flag flag, std::uint32_t epoch) const {
    __syncthreads();
    if (threadIdx.x == 0 && last_to_come(flag)) publish_last(flag, epoch);
  }
  /// The halves of publish(), for thread 0. Whether all other blocks of the rank have come before:
  /// what they wrote is visible to a fence after this.
  __device__ bool last_to_come(Flag flag) const {
    const auto last = static_cast<unsigned>(blocks_ - 1);
    ::cuda::atomic_thread_fence(::cuda::std::memory_order_release, ::cuda::thread_scope_device);
    // Begins again by itself.
    return atomicInc(&word(part_, flag, count_place), last) == last;
  }
  __device__ void publish_last(Flag flag, std::uint32_t epoch) const {
    if (several_gpus_)
      store_epoch<::cuda::thread_scope_system>(flag, epoch, 0, ranks());
    else
      store_epoch<::cuda::thread_scope_device>(flag, epoch, 0, ranks());
  }

  /// The three sums of a reduction to the other blocks of the rank, in halves, each stored together
  /// with the epoch, so that they need neither a flag nor a fence.
  __device__ void hand_out_sums(std::uint32_t epoch, const double* sums) const {
    for (int k = 0; k < 6; ++k) {
      const auto bits = static_cast<std::uint64_t>(__double_as_longlong(sums[k / 2]));
      half(k).store(std::uint64_t{epoch} << 32 | (k % 2 == 0 ? bits & low : bits >> 32),
                    ::cuda::std::memory_order_relaxed);
    }
  }
  __device__ void take_sums(std::uint32_t epoch, double* sums) const {
    std::uint64_t halves[6];
    bool there = false;
    while (!there) {
      there = true;
#pragma unroll
      for (int k = 0; k < 6; ++k) halves[k] = half(k).load(::cuda::std::memory_order_relaxed);
#pragma unroll
      for (int k = 0; k < 6; ++k) there = there && halves[k] >> 32 == epoch;
    }
    for (int k = 0; k < 3; ++k)
      sums[k] = __longlong_as_double(
          static_cast<long long>((halves[2 * k] & low) | halves[2 * k + 1] << 32));
  }

  /// Until `peer` has published `epoch`. The waiting is on own memory.
  __device__ void wait_for(Flag flag, int peer, std::uint32_t epoch) const {
    if (several_gpus_)
      wait_within<::cuda::thread_scope_system>(flag, peer, epoch);
    else
      wait_within<::cuda::thread_scope_device>(flag, peer, epoch);
  }

  /// Until all blocks of the rank have come here: what any of their threads wrote before is visible
  /// to all of them. The block calls it.
  /// @param epoch above those of all own barriers before, the same in all blocks
  __device__ void own_barrier(std::uint32_t epoch) const {
    arrive(epoch);
    wait_for_own(epoch);
  }
  /// The halves of own_barrier(), between which a block may do what waits for no other.
  __device__ void arrive(std::uint32_t epoch) const {
    __syncthreads();
    if (threadIdx.x == 0 && last_to_come(Flag::own))
      store_epoch<::cuda::thread_scope_device>(Flag::own, epoch, rank_, rank_ + 1);
  }
  __device__ void wait_for_own(std::uint32_t epoch) const {
    if (threadIdx.x == 0) wait_within<::cuda::thread_scope_device>(Flag::own, rank_, epoch);
    __syncthreads();
  }

  /// Notes which ranks multiply which own rows, from their lists of ghosts. The block calls it, and
  /// takes two epochs of own_barrier(), `epoch` the first.
  __device__ void find_receivers(std::uint32_t epoch) const {
    const Index first = block_ * static_cast<Index>(blockDim.x) + static_cast<Index>(threadIdx.x);
    const Index stride = blocks_ * static_cast<Index>(blockDim.x);
    std::uint32_t* receivers = part_.receivers.data();
    const Index rows = a_.row_begin.data()[rank_ + 1] - begin_;
    for (Index row = first; row < rows; row += stride) receivers[row] = 0;
    own_barrier(epoch);
    for (int peer = 0; peer < ranks(); ++peer) {
      if (peer == rank_) continue;
      const SolvePcgPart<T>& theirs = a_.parts.data()[peer];
      const Index end = theirs.ghost_offset.data()[rank_ + 1];
      for (Index g = theirs.ghost_offset.data()[rank_] + first; g < end; g += stride)
        atomicOr(receivers + (theirs.ghost.data()[g] - begin_), 1u << peer);
    }
    own_barrier(epoch + 1);
  }

  /// Own row `row` of `vector`, whose value is `x`, to the ranks that multiply it. They see it once
  /// they have waited for what is published next.
  __device__ void send(Span<Vec3<T>> SolvePcgPart<T>::*vector, Index row, const Vec3<T>& x) const {
    if (ranks() == 1) return;
    for (std::uint32_t left = part_.receivers.data()[row]; left != 0; left &= left - 1)
      (a_.parts.data()[__ffs(static_cast<int>(left)) - 1].*vector).data()[begin_ + row] = x;
  }

  /// Number n of the partial sums of a solve, to all ranks.
  __device__ void send_partial(Index n, double sum) const {
    for (int peer = 0; peer < ranks(); ++peer) a_.parts.data()[peer].partial.data()[n] = sum;
  }

 private:
  template <::cuda::thread_scope scope>
  using Word = ::cuda::atomic_ref<std::uint32_t, scope>;
  using Half = ::cuda::atomic_ref<std::uint64_t, ::cuda::thread_scope_device>;
  static constexpr std::uint64_t low = 0xffffffffu;

  __device__ static std::uint32_t& word(const SolvePcgPart<T>& part, Flag flag, int place) {
    return part.ready.data()[static_cast<int>(flag) * flag_stride + place];
  }
  /// One fence serves the stores to all ranks, and what other blocks wrote: it comes after the
  /// count, through which this thread has seen theirs.
  template <::cuda::thread_scope scope>
  __device__ void store_epoch(Flag flag, std::uint32_t epoch, int first, int last) const {
    ::cuda::atomic_thread_fence(::cuda::std::memory_order_acq_rel, scope);
    for (int peer = first; peer < last; ++peer)
      Word<scope>(word(a_.parts.data()[peer], flag, rank_))
          .store(epoch, ::cuda::std::memory_order_relaxed);
  }
  __device__ Half half(int k) const {
    return Half(reinterpret_cast<std::uint64_t*>(part_.ready.data() + sums_place)[k]);
  }
  template <::cuda::thread_scope scope>
  __device__ void wait_within(Flag flag, int peer, std::uint32_t epoch) const {
    const Word<scope> seen(word(part_, flag, peer));
    while (static_cast<std::int32_t>(seen.load(::cuda::std::memory_order_acquire) - epoch) < 0) {
    }
  }

  const SolvePcg<T>& a_;
  const SolvePcgPart<T>& part_;
  bool several_gpus_;
  int rank_;
  Index begin_;
  int block_, blocks_;  ///< of the rank
};

}  // namespace weft::cuda
