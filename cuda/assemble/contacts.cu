#include "weft/kernels/assemble/contacts.hpp"

#include <cooperative_groups.h>

#include <bit>
#include <cub/device/device_radix_sort.cuh>
#include <cub/device/device_scan.cuh>

#include "cuda/exec/launch.cuh"

namespace weft {
namespace {

namespace cg = cooperative_groups;

/// Threads that add up a row's impulses.
constexpr int row_lanes = 8;

/// What the stages hand on, in the queue's scratch memory. A corner is one of a contact's four or
/// of a spring's two vertices; those in no row of this rank have the key row_count and come last,
/// so that every size is known to the host.
template <class T>
struct ContactWork {
  Index item_count;
  Index corner_count;         ///< capacity: 4 contacts + 2 springs
  Index* key;                 ///< [corners] row
  Index* key_sorted;          ///< [corners]
  Index* code;                ///< [corners] 4 item + corner
  Index* place;               ///< [items + 1] 1: has own corners; then, summed, number of its link
  ContactGather<T>* impulse;  ///< [items] [N s] by link
  void* temporary;            ///< of CUB
  std::size_t temporary_bytes;
};

struct ListCorners {
  template <class T>
  __device__ void operator()(const AssembleContacts<T>& a, const ContactWork<T>& work,
                             Index n) const {
    const auto contacts = static_cast<Index>(a.contacts.size());
    const ContactItem<T> item = contact_item(a, static_cast<std::size_t>(n));
    bool own = false;
    const Index place = n < contacts ? 4 * n : 4 * contacts + 2 * (n - contacts);
    for (int j = 0; j < (n < contacts ? 4 : 2); ++j) {
      const Index row = j < item.corners ? item.v[j] - a.row_begin : -1;
      const bool here = row >= 0 && row < a.row_count;
      work.key[place + j] = here ? row : a.row_count;
      work.code[place + j] = 4 * n + j;
      own = own || here;
    }
    work.place[n] = own ? 1 : 0;
  }
};

/// The links of items with own corners, once their places are known, and their impulses.
struct FillContactOperator {
  template <class T>
  __device__ void operator()(const AssembleContacts<T>& a, const ContactWork<T>& work,
                             Index n) const {
    const Index place = work.place[n];
    const Index next = work.place[n + 1];
    if (n + 1 == work.item_count) a.contact_entry_count.data()[0] = next;
    if (next == place) return;
    const ContactItem<T> item = contact_item(a, static_cast<std::size_t>(n));
    const ContactTerms<T> terms = item_terms(a, static_cast<std::size_t>(n));
    a.link.data()[place] = contact_operator_entry(item, terms.block, a.cloth_vertex_count);
    work.impulse[place].x = terms.impulse;
  }
};

struct ListEnds {
  template <class T>
  __device__ void operator()(const AssembleContacts<T>& a, const ContactWork<T>& work,
                             Index e) const {
    if (work.key_sorted[e] >= a.row_count) return;
    const Index corner = a.row_entry.data()[e];
    const ContactItem<T> item = contact_item(a, static_cast<std::size_t>(corner / 4));
    a.contact_scatter.data()[e] = {work.place[corner / 4], item.w[corner % 4]};
  }
};

/// Where each row's corners begin; behind the last row, how many there are.
struct FindRows {
  template <class T>
  __device__ void operator()(const AssembleContacts<T>& a, const ContactWork<T>& work,
                             Index row) const {
    Index low = 0;
    Index high = work.corner_count;
    while (low < high) {
      const Index middle = low + (high - low) / 2;
      if (work.key_sorted[middle] < row)
        low = middle + 1;
      else
        high = middle;
    }
    a.row_entry_count.data()[row] = low;
  }
};

template <class T, class Body>
struct WorkBody {
  ContactWork<T> work;
  __device__ void operator()(const AssembleContacts<T>& a, Index i) const { Body{}(a, work, i); }
};

/// Adds the impulses of each row's links: a lane those of every eighth, then lanes pairwise, a sum
/// whose shape depends on their number alone.
template <class T>
__global__ void __launch_bounds__(for_each_threads)
    add_impulses(const __grid_constant__ AssembleContacts<T> a, const ContactWork<T> work) {
  const auto group = cg::tiled_partition<row_lanes>(cg::this_thread_block());
  const auto row = static_cast<Index>((blockIdx.x * for_each_threads + threadIdx.x) /
                                      static_cast<unsigned>(row_lanes));
  if (row >= a.row_count) return;
  const auto lane = static_cast<Index>(group.thread_rank());
  const Index begin = a.row_entry_count.data()[row];
  const Index end = a.row_entry_count.data()[row + 1];
  if (begin == end) return;
  Vec3<T> sum{};
#pragma unroll 4
  for (Index e = begin + lane; e < end; e += row_lanes) {
    const ContactScatter<T> own = a.contact_scatter.data()[e];
    sum += own.weight * work.impulse[own.link].x;
  }
  for (int c = 0; c < 3; ++c)
    for (int step = 1; step < row_lanes; step *= 2) sum[c] += group.shfl_xor(sum[c], step);
  if (lane == 0) a.rhs.data()[row] += sum;
}

/// Bits of a number that is at most `largest`.
int bits_of(Index largest) {
  return static_cast<int>(std::bit_width(static_cast<std::uint32_t>(largest)));
}

/// Sorts corners by row, in a stable way. Without memory: says how much it needs.
template <class T>
void sort_corners(const CudaQueue& queue, const AssembleContacts<T>& a, const ContactWork<T>& work,
                  void* memory, std::size_t& bytes) {
  cuda::check(cub::DeviceRadixSort::SortPairs(memory, bytes, work.key, work.key_sorted, work.code,
                                              a.row_entry.data(), work.corner_count, 0,
                                              bits_of(a.row_count), queue.stream()),
              "cub::DeviceRadixSort::SortPairs", queue.rank());
}

/// Exclusive prefix sum, in place, of `count` + 1 numbers. Without memory: says how much it needs.
void scan_before(const CudaQueue& queue, Index* numbers, Index count, void* memory,
                 std::size_t& bytes) {
  cuda::check(
      cub::DeviceScan::ExclusiveSum(memory, bytes, numbers, numbers, count + 1, queue.stream()),
      "cub::DeviceScan::ExclusiveSum", queue.rank());
}

/// Cuts the queue's scratch memory into arrays.
template <class T>
ContactWork<T> make_work(CudaQueue& queue, const AssembleContacts<T>& a) {
  ContactWork<T> work{};
  const std::size_t items = a.contacts.size() + a.springs.size();
  const std::size_t corners = 4 * a.contacts.size() + 2 * a.springs.size();
  work.item_count = static_cast<Index>(items);
  work.corner_count = static_cast<Index>(corners);
  std::size_t bytes[2] = {};
  sort_corners(queue, a, work, nullptr, bytes[0]);
  scan_before(queue, work.place, work.item_count, nullptr, bytes[1]);
  work.temporary_bytes = std::max(bytes[0], bytes[1]);

  std::byte* memory = nullptr;
  std::size_t size = 0;
  const auto place = [&](auto*& array, std::size_t count) {
    if (memory != nullptr) array = reinterpret_cast<std::decay_t<decltype(array)>>(memory + size);
    size += (count * sizeof *array + 255) / 256 * 256;
  };
  const auto place_all = [&] {
    size = 0;
    place(work.key, corners);
    place(work.key_sorted, corners);
    place(work.code, corners);
    place(work.place, items + 1);
    place(work.impulse, items);
    auto* temporary = static_cast<std::byte*>(work.temporary);
    place(temporary, work.temporary_bytes);
    work.temporary = temporary;
  };
  place_all();
  memory = static_cast<std::byte*>(queue.scratch(size));
  place_all();
  return work;
}

}  // namespace

/// Corners are sorted by row, in a stable way, so that each row has its own in global order. No
/// atomics, and no count goes to the host.
template <class T>
void run(OnCuda, Queue& queue, const AssembleContacts<T>& args) {
  auto& cuda_queue = static_cast<CudaQueue&>(queue);
  cuda_queue.make_current();
  ContactWork<T> work = make_work(cuda_queue, args);
  launch_for_each(queue, args, work.item_count, WorkBody<T, ListCorners>{work});
  sort_corners(cuda_queue, args, work, work.temporary, work.temporary_bytes);
  queue.fill(work.place + work.item_count, 0, sizeof(Index));
  scan_before(cuda_queue, work.place, work.item_count, work.temporary, work.temporary_bytes);
  launch_for_each(queue, args, work.item_count, WorkBody<T, FillContactOperator>{work});
  launch_for_each(queue, args, work.corner_count, WorkBody<T, ListEnds>{work});
  launch_for_each(queue, args, args.row_count + 1, WorkBody<T, FindRows>{work});
  constexpr Index rows_a_block = for_each_threads / row_lanes;
  const auto blocks = static_cast<unsigned>((args.row_count + rows_a_block - 1) / rows_a_block);
  if (blocks == 0) return;
  add_impulses<<<blocks, for_each_threads, 0, cuda_queue.stream()>>>(args, work);
  cuda::check(cudaGetLastError(), "kernel launch", cuda_queue.rank());
}

template void run(OnCuda, Queue&, const AssembleContacts<float>&);
template void run(OnCuda, Queue&, const AssembleContacts<double>&);

}  // namespace weft
