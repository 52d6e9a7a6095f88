#pragma once

#include <cstdint>

#include "cuda/collide/meetings.cuh"
#include "cuda/exec/sums.cuh"

namespace weft {

/// Warps of a block, each of which asks items by itself, and such blocks that a processor holds at
/// least.
template <class T>
inline constexpr int ask_warps = sizeof(T) == sizeof(float) ? 4 : 2;
template <class T>
inline constexpr int ask_blocks = sizeof(T) == sizeof(float) ? 7 : 10;
/// Clusters that a warp has found to be met before it compares their boxes; and as many as four
/// groups can add to them.
inline constexpr int clusters_wanted = 64;
inline constexpr int clusters_held = clusters_wanted + 4 * group_size;
/// Ring of groups that were met: three, and 32 more.
inline constexpr unsigned groups_held = 64;
/// Words of a mask that is seldom needed.
inline constexpr int ask_mask_words_max = 64;

/// Shared memory of a warp, besides the mask.
template <class T, bool split>
struct AskMemory {
  /// An asking box and the corners of its primitive; first corner -1: there is none. The box is of
  /// the start where the motion is split.
  struct alignas(16) AskingBox {
    BoxOf<T> box;
    Index corner[2];
  };
  /// Read in few and wide pieces.
  template <class S>
  struct alignas(16) Wide {
    BoxOf<S> box;
  };
  AskingBox asker[group_size];
  Wide<T> end[split ? group_size : 1];  ///< of the motion, where it is split
  Wide<float> whole[cluster_size];      ///< around the asking clusters
  Wide<float> whole_end[split ? cluster_size : 1];
  Meeting held[meetings_held];
  std::uint32_t queue[clusters_held];  ///< to be compared: as Meeting::clusters
  Index list[groups_held];             ///< groups to be compared
  Offset first_segment, last_segment;
  Index count[group_size];  ///< pairs
  Question question;
};

/// Finds what the clusters of one group meet. All lanes of a warp call everything together, and no
/// other warp has to wait for them.
template <class T, bool split>
class Asker {
 public:
  /// @param mask [work.ask_mask_words] of the warp alone
  __device__ Asker(const CollidePairs<T>& a, const PairWork& work, AskMemory<T, split>& memory,
                   std::uint32_t* mask)
      : a_(a),
        work_(work),
        q_(memory.question),
        memory_(memory),
        mask_(a, mask, work.ask_mask_words),
        lane_(static_cast<int>(threadIdx.x) % 32) {}

  /// Those of an item among the groups that the asking group's hull meets; then their clusters;
  /// then box by box.
  __device__ void ask(Index item) {
    begin(item);
    const auto from = static_cast<Index>(Offset{q_.met_count} * q_.chunk / q_.chunks);
    const auto to = static_cast<Index>(Offset{q_.met_count} * (q_.chunk + 1) / q_.chunks);
    if (q_.met_begin >= 0)
      meet_listed(work_.met + q_.met_begin + from, to - from);
    else
      meet_unlisted(from, to);
    finish();
  }

  /// What the items of this warp took. By one lane.
  __device__ void report_tests() const {
    if (lane_ == 0 && tests_ > 0)
      atomicAdd(reinterpret_cast<unsigned long long*>(&a_.counts.data()->tests),
                static_cast<unsigned long long>(tests_));
  }

 private:
  __device__ unsigned before() const { return (1u << lane_) - 1u; }

  /// The asking boxes to shared memory.
  __device__ void begin(Index item) {
    __syncwarp();
    if (lane_ == 0) memory_.question = question_of(a_, work_, item);
    __syncwarp();
    const ClusterList<T>& list = a_.lists[q_.asking];
    clusters_ = min(cluster_size, list.size() - q_.group * cluster_size);
    list_head_ = list_tail_ = 0;
    met_ = 0;
    held_ = 0;
    if (lane_ == 0) memory_.first_segment = memory_.last_segment = no_segment;
    if (lane_ < cluster_size) {
      memory_.whole[lane_].box = lane_of<float>(list.groups.data()[q_.group], lane_);
      if constexpr (split)
        memory_.whole_end[lane_].box = lane_of<float>(list.group_ends.data()[q_.group], lane_);
    }
    for (Index p = lane_; p < group_size; p += 32) {
      memory_.count[p] = 0;
      auto& asker = memory_.asker[p];
      asker.corner[0] = -1;
      const Index n = q_.group * group_size + p;
      if (n / cluster_size >= list.size()) continue;
      asker.box = lane_of<T>(list.clusters.data()[n / cluster_size], n % cluster_size);
      if constexpr (split)
        memory_.end[p].box = lane_of<T>(list.ends.data()[n / cluster_size], n % cluster_size);
      if (n >= list.count) continue;
      asker.corner[0] = list.first + n;
      if (q_.edges()) {
        asker.corner[1] = a_.edges.data()[list.first + n].v[1];
        asker.corner[0] = a_.edges.data()[list.first + n].v[0];
      }
    }
    __syncwarp();
  }

  /// Compares with `count` groups, ascending.
  __device__ void meet_listed(const Index* groups, Index count) {
#pragma unroll 1
    for (Index n = 0; n < count; n += 32) {
      const Index listed = min(Index{32}, count - n);
      if (lane_ < listed)
        memory_.list[(list_tail_ + static_cast<unsigned>(lane_)) % groups_held] = groups[n + lane_];
      list_tail_ += static_cast<unsigned>(listed);
      meet_list(n + 32 >= count);
    }
  }

  /// Compares with the groups numbered `from` to `to` of those that are met, which there was no
  /// room to list.
  __device__ void meet_unlisted(Index from, Index to) {
    Index seen = 0;
    for (Index first = mask_.origin(q_); first < q_.groups; first += mask_.window()) {
      mask_.mark(q_, first);
      seen = meet_marked(first, seen, from, to);
    }
  }

  /// Compares with the marked groups, ascending, of which those numbered `from` to `to` count.
  /// @param seen marks before this window
  /// @return marks up to its end
  __device__ Index meet_marked(Index first, Index seen, Index from, Index to) {
    const int words = mask_.words_from(q_, first);
#pragma unroll 1
    for (int block = 0; block < words; block += 32) {
      const std::uint32_t own = block + lane_ < words ? mask_.word(block + lane_) : 0;
      unsigned some = __ballot_sync(cuda::whole_warp, own != 0);
      const bool last_block = block + 32 >= words;
      if (some == 0 && !last_block) continue;
#pragma unroll 1
      do {
        // The last of the window may have no bits, and only sees to what is left over.
        const int word = some != 0 ? lowest_bit(some) : 0;
        const std::uint32_t bits = some != 0 ? __shfl_sync(cuda::whole_warp, own, word) : 0;
        const Index number = seen + __popc(bits & before());
        const bool counts = (bits >> lane_ & 1u) != 0 && number >= from && number < to;
        const unsigned listed = __ballot_sync(cuda::whole_warp, counts);
        if (counts)
          memory_.list[(list_tail_ + __popc(listed & before())) % groups_held] =
              first + 32 * (block + word) + lane_;
        list_tail_ += __popc(listed);
        seen += __popc(bits);
        some &= some - 1;
        meet_list(last_block && some == 0);
      } while (some != 0);
    }
    return seen;
  }

  /// Compares with the clusters of the groups in the list, four at a time, and then with those that
  /// were met.
  /// @param last of the window: leaves nothing over
  __device__ void meet_list(bool last) {
    __syncwarp();
    const unsigned count = list_tail_ - list_head_;
    const unsigned end = last ? list_tail_ : list_head_ + count / 4 * 4;
    tests_ += Offset{cluster_size} * clusters_ * static_cast<Index>(end - list_head_);
#pragma unroll 1
    while (true) {
      if (list_head_ < end) meet_groups(end);
      list_head_ += 4;
      const bool done = last && list_head_ >= end;
      if (met_ > clusters_wanted || done) meet_queue(done ? met_ : met_ / 4 * 4);
      if (list_head_ >= end) break;
    }
    list_head_ = end;
    __syncwarp();
  }

  /// Compares the asking clusters with those of four groups, one to a lane.
  /// @param end of the list
  __device__ void meet_groups(unsigned end) {
    const unsigned place = list_head_ + static_cast<unsigned>(lane_) / cluster_size;
    const Index g = place < end ? memory_.list[place % groups_held] : -1;
    const bool cloth = g < q_.cloth_groups;
    const ClusterList<T>& list = a_.lists[cloth ? q_.cloth : q_.obstacle];
    const Index group = cloth ? g : g - q_.cloth_groups;
    const Index own = group * cluster_size + lane_ % cluster_size;
    SplitBox<float> box{empty_box<float>(), empty_box<float>()};
    Index askers = 0;  // those from the group's first on that ask this cluster
    if (g >= 0 && own < list.size()) {
      box.start = lane_of<float>(list.groups.data()[group], lane_ % cluster_size);
      if constexpr (split)
        box.end = lane_of<float>(list.group_ends.data()[group], lane_ % cluster_size);
      askers = q_.edges() && cloth ? min(clusters_, own - q_.group * cluster_size + 1) : clusters_;
    }
    const auto cluster = static_cast<std::uint32_t>(g * cluster_size + lane_ % cluster_size);
#pragma unroll 2
    for (int j = 0; j < clusters_; ++j) {
      const bool meets = j < askers && whole_meets(j, box);
      const unsigned bits = __ballot_sync(cuda::whole_warp, meets);
      if (meets)
        memory_.queue[met_ + __popc(bits & before())] =
            cluster * cluster_size + static_cast<unsigned>(j);
      met_ += __popc(bits);
    }
  }

  __device__ bool whole_meets(int j, const SplitBox<float>& box) const {
    if constexpr (split)
      return may_meet(SplitBox<float>{memory_.whole[j].box, memory_.whole_end[j].box}, box);
    else
      return boxes_meet(memory_.whole[j].box, box.start);
  }

  /// A box that is asked.
  struct Asked {
    Index number;     ///< of the primitive; -1: there is none
    int asker;        ///< first of the asking cluster's boxes
    SplitBox<T> box;  ///< the end is in use where the motion is split
  };

  /// This lane's box of the four clusters from place `at` of the queue on.
  /// @param end of the queue
  __device__ Asked asked_box(int at, int end) const {
    Asked asked{-1, 0, {empty_box<T>(), empty_box<T>()}};
    at += lane_ / cluster_size;
    if (at >= end) return asked;
    const std::uint32_t entry = memory_.queue[at];
    asked.asker = static_cast<int>(entry % cluster_size) * cluster_size;
    const auto cluster = static_cast<Index>(entry / cluster_size);
    const bool cloth = cluster < q_.cloth_groups * cluster_size;
    const ClusterList<T>& list = a_.lists[cloth ? q_.cloth : q_.obstacle];
    const Index own = cloth ? cluster : cluster - q_.cloth_groups * cluster_size;
    const Index n = own * cluster_size + lane_ % cluster_size;
    asked.box.start = lane_of<T>(list.clusters.data()[own], lane_ % cluster_size);
    if constexpr (split) asked.box.end = lane_of<T>(list.ends.data()[own], lane_ % cluster_size);
    if (n < list.count) asked.number = list.first + n;
    return asked;
  }

  /// Compares the first `count` clusters of the queue with those that ask them, four at a time.
  __device__ void meet_queue(int count) {
    __syncwarp();
#pragma unroll 1
    for (int at = 0; at < count; at += 4) meet_clusters(asked_box(at, count), at);
    tests_ += Offset{group_size} * count;
    met_ -= count;
    __syncwarp();
    if (lane_ < met_) memory_.queue[lane_] = memory_.queue[count + lane_];  // three at most
    __syncwarp();
  }

  /// Compares all boxes of the asking clusters with one box a lane.
  /// @param at place in the queue of the first lane's cluster
  __device__ void meet_clusters(const Asked& asked, int at) {
    unsigned row[cluster_size];
    unsigned any = 0;
#pragma unroll
    for (int j = 0; j < cluster_size; ++j) {
      const int p = asked.asker + j;
      bool meets = false;
      if constexpr (split)
        meets = may_meet(SplitBox<T>{memory_.asker[p].box, memory_.end[p].box}, asked.box);
      else
        meets = boxes_meet(memory_.asker[p].box, asked.box.start);
      row[j] = __ballot_sync(cuda::whole_warp, meets);
      any |= row[j];
    }
    if (any != 0) keep_pairs(asked, at, row);
  }

  /// Whether asking primitive and asked one are a pair, if their boxes meet.
  __device__ bool is_pair(const typename AskMemory<T, split>::AskingBox& asker,
                          const Tri& corners) const {
    if (asker.corner[0] < 0) return false;
    if (!q_.edges()) return shares_no_vertex(asker.corner[0], corners);
    return shares_no_vertex(Edge{{asker.corner[0], asker.corner[1]}},
                            Edge{{corners.v[0], corners.v[1]}});
  }

  /// Of the meetings in `row`, one for each box of the asking clusters, keeps those that are pairs.
  __device__ void keep_pairs(const Asked& asked, int at, unsigned (&row)[cluster_size]) {
    Tri corners{};
    if (asked.number >= 0) {
      if (q_.edges()) {
        const Edge edge = a_.edges.data()[asked.number];
        corners = {{edge.v[0], edge.v[1], -1}};
      } else {
        corners = a_.triangles.data()[asked.number];
      }
    }
    // Within one cluster, and in no other, some edges that are asked come before the asking one.
    const Index first = a_.lists[q_.asking].first + q_.group * group_size + asked.asker;
    unsigned any = 0;
    unsigned own = 0;
#pragma unroll
    for (int j = 0; j < cluster_size; ++j) {
      if (row[j] == 0) continue;
      const bool keep = (row[j] >> lane_ & 1u) != 0 && asked.number >= 0 &&
                        (!q_.edges() || asked.number > first + j) &&
                        is_pair(memory_.asker[asked.asker + j], corners);
      row[j] = __ballot_sync(cuda::whole_warp, keep);
      any |= row[j];
      if (lane_ % cluster_size == j) own = row[j];
    }
    if (any == 0) return;
    // Byte lane / 8 of row lane % 8. Two clusters may be asked by one: whole numbers have no order.
    const int pairs = __popc(own >> lane_ / cluster_size * cluster_size & 255u);
    if (pairs > 0) atomicAdd(&memory_.count[asked.asker + lane_ % cluster_size], pairs);
    hold(at, row);
  }

  /// Appends the meetings of up to four asked clusters, one to a lane.
  __device__ void hold(int at, const unsigned (&row)[cluster_size]) {
    // Byte `lane` of each row, four rows to a word.
    const unsigned two = static_cast<unsigned>(lane_ % 4) * 0x11u + 0x40u;
    Meeting meeting;
#pragma unroll
    for (int half = 0; half < 2; ++half)
      meeting.rows[half] =
          __byte_perm(__byte_perm(row[4 * half], row[4 * half + 1], two),
                      __byte_perm(row[4 * half + 2], row[4 * half + 3], two), 0x5410);
    meeting.clusters = memory_.queue[at + lane_ % 4];
    const bool wanted = lane_ < 4 && (meeting.rows[0] | meeting.rows[1]) != 0;
    const unsigned bits = __ballot_sync(cuda::whole_warp, wanted);
    if (wanted) memory_.held[held_ + __popc(bits & before())] = meeting;
    held_ += __popc(bits);
    if (held_ + 4 > meetings_held) flush();
  }

  /// Writes what is held as a segment, if there is room, and links it to the one before.
  __device__ void flush() {
    __syncwarp();
    const Offset length = held_ + 1;
    unsigned long long at = 0;
    if (lane_ == 0) at = atomicAdd(work_.meeting_count, static_cast<unsigned long long>(length));
    const auto begin = static_cast<Offset>(__shfl_sync(cuda::whole_warp, at, 0));
    if (begin + length <= work_.meeting_capacity) {
      if (lane_ == 0) {
        work_.meeting[begin] = {static_cast<std::uint32_t>(held_), {~0u, ~0u}};
        const Offset last = memory_.last_segment;
        if (last == no_segment) {
          memory_.first_segment = begin;
        } else {
          work_.meeting[last].rows[0] = static_cast<std::uint32_t>(begin);
          work_.meeting[last].rows[1] = static_cast<std::uint32_t>(begin >> 32);
        }
        memory_.last_segment = begin;
      }
      for (int n = lane_; n < held_; n += 32) work_.meeting[begin + 1 + n] = memory_.held[n];
    }
    held_ = 0;
    __syncwarp();
  }

  /// What was found to memory.
  __device__ void finish() {
    if (held_ > 0) flush();
    if (lane_ == 0) work_.segment[q_.item] = memory_.first_segment;
    __syncwarp();
    Index* count = work_.count + Offset{group_size} * (q_.item - q_.chunk) + q_.chunk;
    for (Index p = lane_; p < group_size; p += 32) count[Offset{p} * q_.chunks] = memory_.count[p];
  }

  const CollidePairs<T>& a_;
  const PairWork& work_;
  const Question& q_;
  AskMemory<T, split>& memory_;
  MeetingMask<T> mask_;
  int lane_;
  Index clusters_ = 0;                      ///< that ask
  unsigned list_head_ = 0, list_tail_ = 0;  ///< of the groups, as they come
  int met_ = 0;                             ///< clusters in the queue
  int held_ = 0;                            ///< meetings not written yet
  Offset tests_ = 0;                        ///< with the boxes around clusters
};

/// Every warp by itself takes one item after the other, which are of uneven length. Two kernels are
/// launched, for motions that are split and such that are not, and one of them has nothing to do.
template <class T, bool split>
__global__ void __launch_bounds__(32 * ask_warps<T>, ask_blocks<T>)
    find_meetings(const __grid_constant__ CollidePairs<T> a,
                  const __grid_constant__ PairWork work) {
  extern __shared__ std::uint32_t masks[];
  __shared__ AskMemory<T, split> memory[ask_warps<T>];
  static_assert(sizeof memory + ask_warps<T> * ask_mask_words_max * sizeof masks[0] <= 48 * 1024);
  if ((!a.split.empty() && a.split.data()[0] != 0) != split) return;
  const auto warp = static_cast<int>(threadIdx.x) / 32;
  const Index items = work.first_item[work.group_count];
  Asker<T, split> asker(a, work, memory[warp], masks + warp * work.ask_mask_words);
  while (true) {
    Index item = 0;
    if (threadIdx.x % 32 == 0) item = atomicAdd(work.next_item, 1);
    item = __shfl_sync(cuda::whole_warp, item, 0);
    if (item >= items) break;
    asker.ask(item);
  }
  asker.report_tests();
}

}  // namespace weft
