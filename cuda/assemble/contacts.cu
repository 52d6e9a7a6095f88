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
/// so that every size is known to the host. Corner e of the sorted list has the entries 4 e to 4 e
/// + 3 of its row, one for each corner of its item. The key of an entry is its row and, in the
/// lower bits, its column; of one that the matrix does not have, row row_count and column 0. A run
/// are the sorted entries of one key.
template <class T>
struct ContactWork {
  Index item_count;
  Index corner_count;         ///< capacity: 4 contacts + 2 springs
  Index entry_count;          ///< capacity: 4 a corner
  int column_bits;            ///< of an entry's key
  Index* key;                 ///< [corners] row
  Index* key_sorted;          ///< [corners]
  Index* code;                ///< [corners] 4 item + corner
  Index* place;               ///< [items + 1] 1: has own corners; then, summed, number of its link
  LinkPull<T>* impulse;       ///< [items] [N s] by link
  std::uint64_t* entry_key;   ///< [entries]
  std::uint32_t* entry_code;  ///< [entries] 16 link + 4 corner of the row + corner of the column
  Index* run;                 ///< [entries + 1] 1: begins one; then, summed, how many did before
  Index* run_begin;           ///< [entries + 1]
  void* temporary;            ///< of CUB
  std::size_t temporary_bytes;

  __device__ std::uint64_t first_key(Index row) const {
    return static_cast<std::uint64_t>(row) << column_bits;
  }
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
struct FillLinks {
  template <class T>
  __device__ void operator()(const AssembleContacts<T>& a, const ContactWork<T>& work,
                             Index n) const {
    const Index place = work.place[n];
    const Index next = work.place[n + 1];
    if (n + 1 == work.item_count) a.link_count.data()[0] = next;
    if (next == place) return;
    const ContactItem<T> item = contact_item(a, static_cast<std::size_t>(n));
    const ContactTerms<T> terms = item_terms(a, static_cast<std::size_t>(n));
    ContactLink<T> link{};
    Index some = 0;
    for (int j = 0; j < item.corners; ++j)
      if (item.v[j] < a.cloth_vertex_count) some = item.v[j];
    for (int j = 0; j < 4; ++j) {
      const bool real = j < item.corners && item.v[j] < a.cloth_vertex_count;
      link.v[j] = real ? item.v[j] : some;
      link.w[j] = real ? item.w[j] : T(0);
    }
    const Mat3<T>& b = terms.block;
    const T upper[6] = {b(0, 0), b(0, 1), b(0, 2), b(1, 1), b(1, 2), b(2, 2)};
    for (int k = 0; k < 6; ++k) link.block[k] = upper[k];
    a.link.data()[place] = link;
    work.impulse[place].x = terms.impulse;
  }
};

/// Ends of links, and the entries of their corners.
struct ListEntries {
  template <class T>
  __device__ void operator()(const AssembleContacts<T>& a, const ContactWork<T>& work,
                             Index e) const {
    const Index row = work.key_sorted[e];
    ContactItem<T> item{};
    std::uint32_t code = 0;
    if (row < a.row_count) {
      const Index corner = a.row_entry.data()[e];
      const Index link = work.place[corner / 4];
      item = contact_item(a, static_cast<std::size_t>(corner / 4));
      a.link_end.data()[e] = {link, item.w[corner % 4]};
      code = 16 * static_cast<std::uint32_t>(link) + 4 * static_cast<std::uint32_t>(corner % 4);
    }
    for (int j = 0; j < 4; ++j) {
      const bool real = j < item.corners && item.v[j] < a.cloth_vertex_count;
      work.entry_key[4 * e + j] = real ? work.first_key(row) + static_cast<unsigned>(item.v[j])
                                       : work.first_key(a.row_count);
      work.entry_code[4 * e + j] = code + static_cast<std::uint32_t>(j);
    }
  }
};

struct MarkRuns {
  template <class T>
  __device__ void operator()(const AssembleContacts<T>&, const ContactWork<T>& work,
                             Index e) const {
    work.run[e] = e == 0 || work.entry_key[e - 1] != work.entry_key[e] ? 1 : 0;
  }
};

/// Where runs begin; behind the last one, where it ends.
struct FindRuns {
  template <class T>
  __device__ void operator()(const AssembleContacts<T>&, const ContactWork<T>& work,
                             Index e) const {
    if (e == work.entry_count || work.run[e] != work.run[e + 1]) work.run_begin[work.run[e]] = e;
  }
};

/// How many of `count` ascending keys are below `bound`.
template <class Key>
__device__ Index keys_below(const Key* keys, Index count, Key bound) {
  Index low = 0;
  Index high = count;
  while (low < high) {
    const Index middle = low + (high - low) / 2;
    if (keys[middle] < bound)
      low = middle + 1;
    else
      high = middle;
  }
  return low;
}

/// Where each row's corners and runs begin; behind the last row, how many there are.
struct FindRows {
  template <class T>
  __device__ void operator()(const AssembleContacts<T>& a, const ContactWork<T>& work,
                             Index row) const {
    a.row_entry_count.data()[row] = keys_below(work.key_sorted, work.corner_count, row);
    a.matrix_slice_offset.data()[row] =
        work.run[keys_below(work.entry_key, work.entry_count, work.first_key(row))];
  }
};

/// The sum of a run's entries, in their order. Runs are the matrix, but for one of what is none.
struct SumRuns {
  template <class T>
  __device__ void operator()(const AssembleContacts<T>& a, const ContactWork<T>& work,
                             Index n) const {
    if (n >= a.matrix_slice_offset.data()[a.row_count]) return;
    const Index begin = work.run_begin[n];
    const Index end = work.run_begin[n + 1];
    T sum[6] = {};
#pragma unroll 4
    for (Index e = begin; e < end; ++e) {
      const std::uint32_t code = work.entry_code[e];
      const ContactLink<T> link = a.link.data()[code / 16];
      const T weight = weight_of(link, code / 4 % 4) * weight_of(link, code % 4);
      for (int k = 0; k < 6; ++k) sum[k] += weight * link.block[k];
    }
    const std::uint64_t column = work.entry_key[begin] & (work.first_key(1) - 1);
    a.matrix_column.data()[n] = static_cast<Index>(column);
    constexpr int upper[9] = {0, 1, 2, 1, 3, 4, 2, 4, 5};
    for (int k = 0; k < 9; ++k) a.matrix_value.data()[Offset{9} * n + k] = sum[upper[k]];
  }

 private:
  /// Without an address of what is in registers.
  template <class T>
  __device__ static T weight_of(const ContactLink<T>& link, std::uint32_t corner) {
    const T low = corner == 0 ? link.w[0] : link.w[1];
    const T high = corner == 2 ? link.w[2] : link.w[3];
    return corner < 2 ? low : high;
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
    const LinkEnd<T> own = a.link_end.data()[e];
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

/// The same of entries by row and column, into either of two arrays each.
template <class T>
void sort_entries(const CudaQueue& queue, const AssembleContacts<T>& a, const ContactWork<T>& work,
                  cub::DoubleBuffer<std::uint64_t>& keys, cub::DoubleBuffer<std::uint32_t>& codes,
                  void* memory, std::size_t& bytes) {
  cuda::check(
      cub::DeviceRadixSort::SortPairs(memory, bytes, keys, codes, work.entry_count, 0,
                                      work.column_bits + bits_of(a.row_count), queue.stream()),
      "cub::DeviceRadixSort::SortPairs", queue.rank());
}

/// Replaces `count` numbers and one more by the sums over those before. Likewise.
void sum_before(const CudaQueue& queue, Index* numbers, Index count, void* memory,
                std::size_t& bytes) {
  cuda::check(
      cub::DeviceScan::ExclusiveSum(memory, bytes, numbers, numbers, count + 1, queue.stream()),
      "cub::DeviceScan::ExclusiveSum", queue.rank());
}

/// The work, and both sets of arrays that entries are sorted in.
template <class T>
struct WorkMemory {
  ContactWork<T> work{};
  cub::DoubleBuffer<std::uint64_t> keys;
  cub::DoubleBuffer<std::uint32_t> codes;
};

/// Cuts the queue's scratch memory into arrays.
template <class T>
WorkMemory<T> make_work(CudaQueue& queue, const AssembleContacts<T>& a) {
  WorkMemory<T> all;
  ContactWork<T>& work = all.work;
  const std::size_t items = a.contacts.size() + a.springs.size();
  const std::size_t corners = 4 * a.contacts.size() + 2 * a.springs.size();
  work.item_count = static_cast<Index>(items);
  work.corner_count = static_cast<Index>(corners);
  work.entry_count = static_cast<Index>(4 * corners);
  work.column_bits = bits_of(a.cloth_vertex_count);
  std::size_t bytes[4] = {};
  sort_corners(queue, a, work, nullptr, bytes[0]);
  sort_entries(queue, a, work, all.keys, all.codes, nullptr, bytes[1]);
  sum_before(queue, work.run, work.entry_count, nullptr, bytes[2]);
  sum_before(queue, work.place, work.item_count, nullptr, bytes[3]);
  work.temporary_bytes = *std::max_element(bytes, bytes + 4);

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
    for (auto*& keys : all.keys.d_buffers) place(keys, 4 * corners + 1);
    for (auto*& codes : all.codes.d_buffers) place(codes, 4 * corners + 1);
    auto* temporary = static_cast<std::byte*>(work.temporary);
    place(temporary, work.temporary_bytes);
    work.temporary = temporary;
  };
  place_all();
  memory = static_cast<std::byte*>(queue.scratch(size));
  place_all();
  work.entry_key = all.keys.Current();
  work.entry_code = all.codes.Current();
  return all;
}

}  // namespace

/// Corners are sorted by row and entries by row and column, in a stable way, so that each row and
/// each entry has its own in global order. No atomics, and no count goes to the host.
template <class T>
void run(OnCuda, Queue& queue, const AssembleContacts<T>& args) {
  auto& cuda_queue = static_cast<CudaQueue&>(queue);
  cuda_queue.make_current();
  WorkMemory<T> memory = make_work(cuda_queue, args);
  ContactWork<T>& work = memory.work;
  launch_for_each(queue, args, work.item_count, WorkBody<T, ListCorners>{work});
  sort_corners(cuda_queue, args, work, work.temporary, work.temporary_bytes);
  queue.fill(work.place + work.item_count, 0, sizeof(Index));
  sum_before(cuda_queue, work.place, work.item_count, work.temporary, work.temporary_bytes);
  launch_for_each(queue, args, work.item_count, WorkBody<T, FillLinks>{work});
  launch_for_each(queue, args, work.corner_count, WorkBody<T, ListEntries>{work});
  sort_entries(cuda_queue, args, work, memory.keys, memory.codes, work.temporary,
               work.temporary_bytes);
  work.entry_key = memory.keys.Current();
  work.entry_code = memory.codes.Current();
  // Of what was sorted from, nothing is needed any more.
  work.run = reinterpret_cast<Index*>(memory.codes.Alternate());
  work.run_begin = reinterpret_cast<Index*>(memory.keys.Alternate());
  launch_for_each(queue, args, work.entry_count, WorkBody<T, MarkRuns>{work});
  queue.fill(work.run + work.entry_count, 0, sizeof(Index));
  sum_before(cuda_queue, work.run, work.entry_count, work.temporary, work.temporary_bytes);
  launch_for_each(queue, args, work.entry_count + 1, WorkBody<T, FindRuns>{work});
  launch_for_each(queue, args, args.row_count + 1, WorkBody<T, FindRows>{work});
  launch_for_each(queue, args, work.entry_count, WorkBody<T, SumRuns>{work});
  constexpr Index rows_a_block = for_each_threads / row_lanes;
  const auto blocks = static_cast<unsigned>((args.row_count + rows_a_block - 1) / rows_a_block);
  if (blocks == 0) return;
  add_impulses<<<blocks, for_each_threads, 0, cuda_queue.stream()>>>(args, work);
  cuda::check(cudaGetLastError(), "kernel launch", cuda_queue.rank());
}

template void run(OnCuda, Queue&, const AssembleContacts<float>&);
template void run(OnCuda, Queue&, const AssembleContacts<double>&);

}  // namespace weft
