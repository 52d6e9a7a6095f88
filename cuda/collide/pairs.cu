#include "weft/kernels/collide/pairs.hpp"

#include <algorithm>
#include <limits>

#include "cuda/collide/ask.cuh"

namespace weft {
namespace {

/// Parts that the work of a rank is cut into, besides where groups end anyway; and met groups of a
/// part at least. Many to a processor, so that none waits long for the last.
constexpr Offset parts = 65536;
constexpr Offset part_min = 16;
/// Met groups to each asking group that there is room for. In bundles nearly all of them meet: so
/// many, 64 MiB, are listed there; what is not listed has to be searched again for each item.
constexpr std::size_t met_room = 128;
constexpr std::size_t met_in_bundles = std::size_t{1} << 24;
/// Warps of a block that lists met groups, a group each at a time.
constexpr int hull_warps = 4;
/// Warps of a block that writes pairs, an item each.
constexpr int write_warps = 8;

/// This rank's share of the groups.
struct Share {
  Index begin[2], end[2];  ///< of faces' and edges' groups

  __device__ bool has(const PairWork& work, Index group) const {
    const int of = group >= work.face_groups ? 1 : 0;
    const Index g = group - (of == 0 ? 0 : work.face_groups);
    return g >= begin[of] && g < end[of];
  }
};

template <class T>
__device__ Share share_of(const CollidePairs<T>& a) {
  Share share;
  for (int of = 0; of < 2; ++of) {
    const Span<const Offset> table = of == 0 ? a.face_work : a.edge_work;
    const WorkShare& own = of == 0 ? a.face_share : a.edge_share;
    share.begin[of] = share_begin(table, own.begin);
    share.end[of] = share_begin(table, own.end);
  }
  return share;
}

__global__ void begin_search(PairWork work, CollideCounts* counts) {
  *counts = CollideCounts{};
  *work.meeting_count = 0;
  *work.met_total = 0;
  *work.next_group = 0;
  *work.next_item = 0;
}

/// Every warp takes one group after the other, since hulls are of uneven size.
template <class T>
__global__ void __launch_bounds__(32 * hull_warps)
    list_met_groups(const __grid_constant__ CollidePairs<T> a,
                    const __grid_constant__ PairWork work) {
  extern __shared__ std::uint32_t hull_masks[];
  __shared__ Share share;
  if (threadIdx.x == 0) share = share_of(a);
  __syncthreads();
  HullAsker<T> asker(a, work, hull_masks + static_cast<int>(threadIdx.x) / 32 * work.mask_words);
  while (true) {
    Index group = 0;
    if (threadIdx.x % 32 == 0) group = atomicAdd(work.next_group, 1);
    group = __shfl_sync(cuda::whole_warp, group, 0);
    if (group >= work.group_count) break;
    if (share.has(work, group))
      asker.ask(group);
    else if (threadIdx.x % 32 == 0)
      work.met_count[group] = 0;
  }
}

/// Cuts the lists of met groups into items of even length.
__global__ void __launch_bounds__(scan_threads) cut_items(const __grid_constant__ PairWork work) {
  const auto total = static_cast<Offset>(*work.met_total);
  const Offset part = max(part_min, (total + parts - 1) / parts);
  auto* sums = reinterpret_cast<Index*>(work.block_sum);
  scan_together(
      work.group_count, sums,
      [&](Offset g) { return static_cast<Index>((work.met_count[g] + part - 1) / part); },
      [&](Offset g, Index sum) { work.first_item[g] = sum; });
  cooperative_groups::this_grid().sync();
  const Index items = work.first_item[work.group_count];
  const auto stride = static_cast<Index>(gridDim.x) * scan_threads;
  for (auto item = static_cast<Index>(blockIdx.x * scan_threads + threadIdx.x); item < items;
       item += stride) {
    // The last group that begins at or before the item: one without items begins where the next
    // does.
    Index low = 0;
    Index high = work.group_count;
    while (high - low > 1) {
      const Index middle = low + (high - low) / 2;
      if (work.first_item[middle] <= item)
        low = middle;
      else
        high = middle;
    }
    work.item_group[item] = low;
  }
}

/// Places of the pairs in their lists, and how many there are.
__global__ void __launch_bounds__(scan_threads)
    place_pairs(const __grid_constant__ PairWork work, CollideCounts* counts) {
  const Offset all = Offset{group_size} * work.first_item[work.group_count];
  scan_together(
      all, work.block_sum, [&](Offset n) { return Offset{work.count[n]}; },
      [&](Offset n, Offset sum) { work.place[n] = sum; });
  cooperative_groups::this_grid().sync();
  if (blockIdx.x > 0 || threadIdx.x > 0) return;
  const auto most = Offset{std::numeric_limits<Index>::max()};
  const Offset faces = work.place[Offset{group_size} * work.first_item[work.face_groups]];
  counts->face_pairs = static_cast<Index>(min(faces, most));
  counts->edge_pairs = static_cast<Index>(min(work.place[all] - faces, most));
}

/// Bits in each byte.
__device__ std::uint64_t bits_of_bytes(std::uint64_t x) {
  x -= x >> 1 & 0x5555555555555555u;
  x = (x & 0x3333333333333333u) + (x >> 2 & 0x3333333333333333u);
  return (x + (x >> 4)) & 0x0f0f0f0f0f0f0f0fu;
}

__device__ Index byte_of(std::uint64_t x, int j) {
  return static_cast<Index>(x >> 8 * j & 255u);
}

/// Shared memory of a warp that writes.
struct WriteMemory {
  Offset place[group_size];  ///< of each asking primitive's next pair
  std::uint32_t source[32];
};

/// Up to 32 meetings, one to a lane, in the order of the asking clusters, those of one in the order
/// in which they came.
struct SortedMeeting {
  std::uint64_t rows;  ///< as in Meeting, 0 for a lane without
  std::uint32_t clusters;
  int first;  ///< lane of the first one with the same asking cluster
};

__device__ SortedMeeting sort_meetings(std::uint64_t rows, std::uint32_t clusters, bool is_one,
                                       std::uint32_t* source) {
  const auto lane = static_cast<int>(threadIdx.x % 32);
  const std::uint32_t key = is_one ? clusters % cluster_size : cluster_size;
  // Bit by bit from the highest one: which lanes have a lesser key, and which the same.
  unsigned lesser = 0;
  unsigned same = cuda::whole_warp;
#pragma unroll
  for (int bit = 3; bit >= 0; --bit) {
    const bool own = (key >> bit & 1u) != 0;
    const unsigned set = __ballot_sync(cuda::whole_warp, own);
    if (own) lesser |= same & ~set;
    same &= own ? set : ~set;
  }
  __syncwarp();
  source[__popc(lesser) + __popc(same & ((1u << lane) - 1u))] = static_cast<std::uint32_t>(lane);
  __syncwarp();
  const auto from = static_cast<int>(source[lane]);
  return {__shfl_sync(cuda::whole_warp, rows, from), __shfl_sync(cuda::whole_warp, clusters, from),
          __shfl_sync(cuda::whole_warp, __popc(lesser), from)};
}

/// Writes the pairs of up to 32 meetings, one to a lane.
/// @param number first primitive of the asked cluster
/// @param asker  first primitive of the asking group
__device__ void write_meetings(const SortedMeeting& meeting, Index number, Index asker,
                               Offset* place, Pair* list) {
  const auto lane = static_cast<int>(threadIdx.x % 32);
  const std::uint64_t own = bits_of_bytes(meeting.rows);
  // All eight sums at once: those over the lanes before this one are 248 at most.
  std::uint64_t sum = __shfl_up_sync(cuda::whole_warp, own, 1);
  if (lane == meeting.first) sum = 0;
  for (int step = 1; step < 32; step *= 2) {
    const std::uint64_t left = __shfl_up_sync(cuda::whole_warp, sum, step);
    if (lane - step >= meeting.first) sum += left;
  }
  const auto cluster = static_cast<int>(meeting.clusters % cluster_size) * cluster_size;
#pragma unroll
  for (int j = 0; j < cluster_size; ++j) {
    Pair* out = list + place[cluster + j] + byte_of(sum, j);
    for (auto bits = static_cast<std::uint32_t>(byte_of(meeting.rows, j)); bits != 0;
         bits &= bits - 1)
      *out++ = {asker + cluster + j, number + lowest_bit(bits)};
  }
  const int next = __shfl_down_sync(cuda::whole_warp, meeting.first, 1);
  __syncwarp();
  if (meeting.rows != 0 && (lane == 31 || next != meeting.first))
    for (int j = 0; j < cluster_size; ++j) place[cluster + j] += byte_of(sum, j) + byte_of(own, j);
  __syncwarp();
}

/// A warp an item.
template <class T>
__global__ void __launch_bounds__(32 * write_warps)
    write_pairs(const __grid_constant__ CollidePairs<T> a, const __grid_constant__ PairWork work) {
  __shared__ WriteMemory memory[write_warps];
  const auto warp = static_cast<Index>(threadIdx.x) / 32;
  const auto lane = static_cast<Index>(threadIdx.x) % 32;
  const Index item = static_cast<Index>(blockIdx.x) * write_warps + warp;
  if (item >= work.first_item[work.group_count]) return;
  Offset segment = work.segment[item];
  if (segment == no_segment) return;
  if (*work.meeting_count > static_cast<unsigned long long>(work.meeting_capacity)) return;
  const Question q = question_of(a, work, item);
  const Span<Pair> list = q.edges() ? a.edge_pairs : a.face_pairs;
  const Index found = q.edges() ? a.counts.data()->edge_pairs : a.counts.data()->face_pairs;
  if (static_cast<std::size_t>(found) > list.size()) return;
  Offset* place = memory[warp].place;
  const Offset* from = work.place + Offset{group_size} * (item - q.chunk) + q.chunk;
  const Offset faces =
      q.edges() ? work.place[Offset{group_size} * work.first_item[work.face_groups]] : 0;
  for (Index p = lane; p < group_size; p += 32) place[p] = from[Offset{p} * q.chunks] - faces;
  const Index asker = a.lists[q.asking].first + q.group * group_size;
  const Index cloth_clusters = q.cloth_groups * cluster_size;
  while (segment != no_segment) {
    const Meeting head = work.meeting[segment];
    const auto length = static_cast<Index>(head.clusters);
    for (Index begin = 0; begin < length; begin += 32) {
      Meeting meeting{};
      const bool is_one = begin + lane < length;
      if (is_one) meeting = work.meeting[segment + 1 + begin + lane];
      const SortedMeeting sorted =
          sort_meetings(meeting.rows[0] | std::uint64_t{meeting.rows[1]} << 32, meeting.clusters,
                        is_one, memory[warp].source);
      const auto cluster = static_cast<Index>(sorted.clusters / cluster_size);
      const Index number =
          cluster < cloth_clusters
              ? a.lists[q.cloth].first + cluster * cluster_size
              : a.lists[q.obstacle].first + (cluster - cloth_clusters) * cluster_size;
      write_meetings(sorted, number, asker, place, list.data());
    }
    segment = static_cast<Offset>(head.rows[0] | std::uint64_t{head.rows[1]} << 32);
  }
}

/// Room for what the stages hand on. Every meeting that is kept stands for a pair at least, so that
/// its list is long enough if those of the pairs are.
template <class T>
PairWork make_work(CudaQueue& queue, const CollidePairs<T>& a, Index items) {
  PairWork work{};
  work.face_groups = static_cast<Index>(a.face_work.size()) - 1;
  work.group_count = work.face_groups + static_cast<Index>(a.edge_work.size()) - 1;
  const auto count = static_cast<std::size_t>(items);
  const std::size_t pairs = a.face_pairs.size() + a.edge_pairs.size();
  const std::size_t meetings = pairs + pairs / (meetings_held - 4) + count + 1;
  work.meeting_capacity = static_cast<Offset>(meetings);
  const auto group_count = static_cast<std::size_t>(work.group_count);
  const double share = static_cast<double>(a.edge_share.end - a.edge_share.begin) / whole_table;
  const std::size_t met_all = std::min(group_count * group_count, met_in_bundles);
  const std::size_t met_most = std::max(
      met_room * group_count, static_cast<std::size_t>(share * static_cast<double>(met_all)));
  work.met_capacity = static_cast<Offset>(met_most);
  ScratchLayout layout;
  const std::size_t met_count = layout.add<Index>(group_count);
  const std::size_t met_begin = layout.add<Offset>(group_count);
  const std::size_t met = layout.add<Index>(met_most);
  const std::size_t met_total = layout.add<unsigned long long>(1);
  const std::size_t next_group = layout.add<Index>(1);
  const std::size_t first_item = layout.add<Index>(group_count + 1);
  const std::size_t item_group = layout.add<Index>(count);
  const std::size_t next_item = layout.add<Index>(1);
  const std::size_t counts = layout.add<Index>(count * group_size);
  const std::size_t place = layout.add<Offset>(count * group_size + 1);
  const std::size_t segment = layout.add<Offset>(count);
  const std::size_t meeting = layout.add<Meeting>(meetings);
  const std::size_t meeting_count = layout.add<unsigned long long>(1);
  const std::size_t block_sum = layout.add<Offset>(scan_blocks);
  auto* memory = static_cast<std::byte*>(queue.scratch(layout.bytes()));
  work.met_count = reinterpret_cast<Index*>(memory + met_count);
  work.met_begin = reinterpret_cast<Offset*>(memory + met_begin);
  work.met = reinterpret_cast<Index*>(memory + met);
  work.met_total = reinterpret_cast<unsigned long long*>(memory + met_total);
  work.next_group = reinterpret_cast<Index*>(memory + next_group);
  work.first_item = reinterpret_cast<Index*>(memory + first_item);
  work.item_group = reinterpret_cast<Index*>(memory + item_group);
  work.next_item = reinterpret_cast<Index*>(memory + next_item);
  work.count = reinterpret_cast<Index*>(memory + counts);
  work.place = reinterpret_cast<Offset*>(memory + place);
  work.segment = reinterpret_cast<Offset*>(memory + segment);
  work.meeting = reinterpret_cast<Meeting*>(memory + meeting);
  work.meeting_count = reinterpret_cast<unsigned long long*>(memory + meeting_count);
  work.block_sum = reinterpret_cast<Offset*>(memory + block_sum);
  const auto groups = [&](int kind) {
    return a.lists[kind].group_count() + a.lists[kind + 1].group_count();
  };
  const Index asked = std::max(groups(cloth_faces), groups(cloth_edges));
  work.mask_words = std::clamp(static_cast<int>((asked + 31) / 32), 1, mask_words_max);
  work.ask_mask_words = std::min(work.mask_words, ask_mask_words_max);
  return work;
}

/// Submits as many warps as the GPU runs at a time.
/// @param kernel of `warps` warps a block, each with a mask of mask_words
template <class T>
void launch_warps(const CudaQueue& queue, void (*kernel)(CollidePairs<T>, PairWork), int warps,
                  int mask_words, Index items, const CollidePairs<T>& args, const PairWork& work) {
  int processors = 0;
  cuda::check(cudaDeviceGetAttribute(&processors, cudaDevAttrMultiProcessorCount, queue.gpu()),
              "cudaDeviceGetAttribute", queue.rank());
  const std::size_t mask_bytes =
      static_cast<std::size_t>(warps * mask_words) * sizeof(std::uint32_t);
  int resident = 0;
  cuda::check(
      cudaOccupancyMaxActiveBlocksPerMultiprocessor(&resident, kernel, 32 * warps, mask_bytes),
      "cudaOccupancyMaxActiveBlocksPerMultiprocessor", queue.rank());
  const Index blocks =
      std::clamp((items + warps - 1) / warps, 1, std::max(1, resident * processors));
  kernel<<<static_cast<unsigned>(blocks), 32 * static_cast<unsigned>(warps), mask_bytes,
           queue.stream()>>>(args, work);
  cuda::check(cudaGetLastError(), "kernel launch", queue.rank());
}

}  // namespace

/// The hulls of groups are compared first, and items made of what meets, so that all are of one
/// length. Boxes are compared once: what meets is kept as a bit matrix for each two clusters, 12
/// bytes, and counted; the sums of the counts then tell where the pairs belong, and another kernel
/// unpacks the matrices there.
template <class T>
void run(OnCuda, Queue& queue, const CollidePairs<T>& args) {
  auto& cuda_queue = static_cast<CudaQueue&>(queue);
  const auto groups = static_cast<Index>(args.face_work.size() + args.edge_work.size()) - 2;
  // A group has one item for each part of its work, the last of which may be short.
  const Index items = groups + static_cast<Index>(parts);
  const PairWork work = make_work(cuda_queue, args, items);
  cuda_queue.make_current();
  begin_search<<<1, 1, 0, cuda_queue.stream()>>>(work, args.counts.data());
  cuda::check(cudaGetLastError(), "kernel launch", cuda_queue.rank());
  launch_warps(cuda_queue, list_met_groups<T>, hull_warps, work.mask_words, groups, args, work);
  launch_together({cuda_queue, items}, cut_items, work);
  launch_warps(cuda_queue, find_meetings<T, false>, ask_warps<T>, work.ask_mask_words, items, args,
               work);
  if (!args.split.empty())
    launch_warps(cuda_queue, find_meetings<T, true>, ask_warps<T>, work.ask_mask_words, items, args,
                 work);
  launch_together({cuda_queue, Offset{group_size} * items}, place_pairs, work, args.counts.data());
  const auto blocks = static_cast<unsigned>((items + write_warps - 1) / write_warps);
  write_pairs<<<blocks, 32 * write_warps, 0, cuda_queue.stream()>>>(args, work);
  cuda::check(cudaGetLastError(), "kernel launch", cuda_queue.rank());
}

template void run(OnCuda, Queue&, const CollidePairs<float>&);
template void run(OnCuda, Queue&, const CollidePairs<double>&);

}  // namespace weft
