#include "weft/kernels/assemble/contacts.hpp"

#include <cooperative_groups.h>

#include <bit>
#include <cub/device/device_radix_sort.cuh>
#include <cub/device/device_scan.cuh>

#include "cuda/exec/launch.cuh"

namespace weft {
namespace {

namespace cg = cooperative_groups;

/// Threads that work on a row together.
constexpr int row_lanes = 8;

/// What the stages hand on, in the queue's scratch memory. A corner is one of a contact's four or
/// of a spring's two vertices; those in no row of this rank have the key row_count and come last,
/// so that every size is known to the host. Corner e of the sorted list has the entries 4 e to 4 e
/// + 3 of its row, one for each corner of its item.
template <class T>
struct ContactWork {
  Index corner_count;      ///< capacity: 4 contacts + 2 springs
  Index* key;              ///< [corners] row
  Index* code;             ///< [corners] 4 item + corner
  Index* key_sorted;       ///< [corners]
  ContactTerms<T>* terms;  ///< [items]
  Index* place;            ///< [items + 1] 1: has own corners; then, summed, number of its link
  Index* column;           ///< [4 corners] -1: no entry
  Index* first_column;     ///< [4 corners] the same, but -1 where the row has it already
  T* weight;               ///< [4 corners]
  void* temporary;         ///< of CUB
  std::size_t temporary_bytes;
};

struct ListCorners {
  template <class T>
  __device__ void operator()(const AssembleContacts<T>& a, const ContactWork<T>& work,
                             Index n) const {
    const auto item_number = static_cast<std::size_t>(n);
    const auto contacts = static_cast<Index>(a.contacts.size());
    const ContactItem<T> item = contact_item(a, item_number);
    work.terms[n] = item_terms(a, item_number);
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

/// The links of items with own corners, once their places are known.
struct FillLinks {
  template <class T>
  __device__ void operator()(const AssembleContacts<T>& a, const ContactWork<T>& work,
                             Index n) const {
    const Index place = work.place[n];
    const Index next = work.place[n + 1];
    if (static_cast<std::size_t>(n) + 1 == a.contacts.size() + a.springs.size())
      a.link_count.data()[0] = next;
    if (next == place) return;
    const ContactItem<T> item = contact_item(a, static_cast<std::size_t>(n));
    ContactLink<T> link{};
    Index some = 0;
    for (int j = 0; j < item.corners; ++j)
      if (item.v[j] < a.cloth_vertex_count) some = item.v[j];
    for (int j = 0; j < 4; ++j) {
      const bool real = j < item.corners && item.v[j] < a.cloth_vertex_count;
      link.v[j] = real ? item.v[j] : some;
      link.w[j] = real ? item.w[j] : T(0);
    }
    const Mat3<T>& b = work.terms[n].block;
    const T upper[6] = {b(0, 0), b(0, 1), b(0, 2), b(1, 1), b(1, 2), b(2, 2)};
    for (int k = 0; k < 6; ++k) link.block[k] = upper[k];
    a.link.data()[place] = link;
  }
};

struct ListEntries {
  template <class T>
  __device__ void operator()(const AssembleContacts<T>& a, const ContactWork<T>& work,
                             Index e) const {
    if (e >= a.row_entry_count.data()[a.row_count]) return;
    const Index code = a.row_entry.data()[e];
    const ContactItem<T> item = contact_item(a, static_cast<std::size_t>(code / 4));
    a.link_end.data()[e] = {work.place[code / 4], item.w[code % 4]};
    for (int j = 0; j < 4; ++j) {
      const bool real = j < item.corners && item.v[j] < a.cloth_vertex_count;
      work.column[Offset{4} * e + j] = real ? item.v[j] : -1;
      work.weight[Offset{4} * e + j] = real ? item.w[code % 4] * item.w[j] : T(0);
    }
  }
};

template <class T, class Body>
struct WorkBody {
  ContactWork<T> work;
  __device__ void operator()(const AssembleContacts<T>& a, Index i) const { Body{}(a, work, i); }
};

using RowGroup = cg::thread_block_tile<row_lanes>;

/// The row that the calling threads work on together; there may be no such row.
__device__ Index row_of_group() {
  return static_cast<Index>((blockIdx.x * for_each_threads + threadIdx.x) /
                            static_cast<unsigned>(row_lanes));
}

/// Marks the first entry of each column, counts them, and adds the row's impulses.
template <class T>
__global__ void __launch_bounds__(for_each_threads)
    count_columns(const __grid_constant__ AssembleContacts<T> a, const ContactWork<T> work) {
  const RowGroup group = cg::tiled_partition<row_lanes>(cg::this_thread_block());
  const Index row = row_of_group();
  if (row >= a.row_count) return;
  const auto lane = static_cast<Index>(group.thread_rank());
  const Offset begin = Offset{4} * a.row_entry_count.data()[row];
  const Offset end = Offset{4} * a.row_entry_count.data()[row + 1];
  Index count = 0;
  for (Offset e = begin + lane; e < end; e += row_lanes) {
    const Index column = work.column[e];
    bool first = column >= 0;
    for (Offset f = begin; first && f < e; ++f) first = work.column[f] != column;
    work.first_column[e] = first ? column : -1;
    count += first ? 1 : 0;
  }
  for (int step = row_lanes / 2; step > 0; step /= 2) count += group.shfl_xor(count, step);
  if (lane == 0) a.matrix_slice_offset.data()[row] = count;
  if (begin == end || lane >= 3) return;
  T sum = a.rhs.data()[row][lane];
  for (Offset e = begin / 4; e < end / 4; ++e) {
    const Index code = a.row_entry.data()[e];
    const ContactItem<T> item = contact_item(a, static_cast<std::size_t>(code / 4));
    sum += item.w[code % 4] * work.terms[code / 4].impulse[lane];
  }
  a.rhs.data()[row][lane] = sum;
}

/// Writes the row's columns, ascending, and the sum of each one's entries, in their order.
template <class T>
__global__ void __launch_bounds__(for_each_threads)
    sum_entries(const __grid_constant__ AssembleContacts<T> a, const ContactWork<T> work) {
  const RowGroup group = cg::tiled_partition<row_lanes>(cg::this_thread_block());
  const Index row = row_of_group();
  if (row >= a.row_count) return;
  const Offset begin = Offset{4} * a.row_entry_count.data()[row];
  const Offset end = Offset{4} * a.row_entry_count.data()[row + 1];
  for (Offset e = begin + static_cast<Index>(group.thread_rank()); e < end; e += row_lanes) {
    const Index column = work.first_column[e];
    if (column < 0) continue;
    Offset slot = a.matrix_slice_offset.data()[row];
    for (Offset f = begin; f < end; ++f)
      slot += work.first_column[f] >= 0 && work.first_column[f] < column ? 1 : 0;
    Mat3<T> sum{};
    for (Offset f = e; f < end; ++f)
      if (work.column[f] == column)
        sum += work.weight[f] * work.terms[a.row_entry.data()[f / 4] / 4].block;
    a.matrix_column.data()[slot] = column;
    for (int k = 0; k < 9; ++k) a.matrix_value.data()[slot * 9 + k] = sum.e[k];
  }
}

/// Bits of the largest key.
template <class T>
int key_bits(const AssembleContacts<T>& a) {
  return static_cast<int>(std::bit_width(static_cast<std::uint32_t>(a.row_count)));
}

/// Cuts the queue's scratch memory into the work's arrays.
template <class T>
ContactWork<T> make_work(CudaQueue& queue, const AssembleContacts<T>& a) {
  const std::size_t items = a.contacts.size() + a.springs.size();
  const std::size_t corners = 4 * a.contacts.size() + 2 * a.springs.size();
  ContactWork<T> work{};
  work.corner_count = static_cast<Index>(corners);
  std::size_t sort_bytes = 0;
  std::size_t scan_bytes = 0;
  cuda::check(cub::DeviceRadixSort::SortPairs(nullptr, sort_bytes, work.key, work.key_sorted,
                                              work.code, a.row_entry.data(), work.corner_count, 0,
                                              key_bits(a), queue.stream()),
              "cub::DeviceRadixSort::SortPairs", queue.rank());
  cuda::check(
      cub::DeviceScan::ExclusiveSum(nullptr, scan_bytes, a.matrix_slice_offset.data(),
                                    a.matrix_slice_offset.data(), a.row_count + 1, queue.stream()),
      "cub::DeviceScan::ExclusiveSum", queue.rank());
  std::size_t place_bytes = 0;
  cuda::check(cub::DeviceScan::ExclusiveSum(nullptr, place_bytes, work.place, work.place,
                                            static_cast<Index>(items) + 1, queue.stream()),
              "cub::DeviceScan::ExclusiveSum", queue.rank());
  work.temporary_bytes = std::max({sort_bytes, scan_bytes, place_bytes});
  std::size_t size = 0;
  const auto place = [&size](std::size_t bytes) {
    const std::size_t begin = size;
    size += (bytes + 255) / 256 * 256;
    return begin;
  };
  const std::size_t key = place(corners * sizeof(Index)), code = place(corners * sizeof(Index));
  const std::size_t sorted = place(corners * sizeof(Index));
  const std::size_t terms = place(items * sizeof(ContactTerms<T>));
  const std::size_t link_place = place((items + 1) * sizeof(Index));
  const std::size_t column = place(4 * corners * sizeof(Index));
  const std::size_t first_column = place(4 * corners * sizeof(Index));
  const std::size_t weight = place(4 * corners * sizeof(T));
  const std::size_t temporary = place(work.temporary_bytes);
  auto* memory = static_cast<std::byte*>(queue.scratch(size));
  work.key = reinterpret_cast<Index*>(memory + key);
  work.code = reinterpret_cast<Index*>(memory + code);
  work.key_sorted = reinterpret_cast<Index*>(memory + sorted);
  work.terms = reinterpret_cast<ContactTerms<T>*>(memory + terms);
  work.place = reinterpret_cast<Index*>(memory + link_place);
  work.column = reinterpret_cast<Index*>(memory + column);
  work.first_column = reinterpret_cast<Index*>(memory + first_column);
  work.weight = reinterpret_cast<T*>(memory + weight);
  work.temporary = memory + temporary;
  return work;
}

}  // namespace

/// Corners are sorted by row, in a stable way, so that each row has its own in global order; a few
/// threads a row then find its columns and sum their entries. No atomics, and no count goes to the
/// host.
template <class T>
void run(OnCuda, Queue& queue, const AssembleContacts<T>& args) {
  auto& cuda_queue = static_cast<CudaQueue&>(queue);
  cuda_queue.make_current();
  const cudaStream_t stream = cuda_queue.stream();
  ContactWork<T> work = make_work(cuda_queue, args);
  const auto items = static_cast<Index>(args.contacts.size() + args.springs.size());
  launch_for_each(queue, args, items, WorkBody<T, ListCorners>{work});
  cuda::check(cub::DeviceRadixSort::SortPairs(work.temporary, work.temporary_bytes, work.key,
                                              work.key_sorted, work.code, args.row_entry.data(),
                                              work.corner_count, 0, key_bits(args), stream),
              "cub::DeviceRadixSort::SortPairs", cuda_queue.rank());
  queue.fill(work.place + items, 0, sizeof(Index));
  cuda::check(cub::DeviceScan::ExclusiveSum(work.temporary, work.temporary_bytes, work.place,
                                            work.place, items + 1, stream),
              "cub::DeviceScan::ExclusiveSum", cuda_queue.rank());
  launch_for_each(queue, args, items, WorkBody<T, FillLinks>{work});
  launch_for_each(queue, args, args.row_count + 1, WorkBody<T, FindRows>{work});
  launch_for_each(queue, args, work.corner_count, WorkBody<T, ListEntries>{work});
  constexpr Index rows_a_block = for_each_threads / row_lanes;
  const auto blocks = static_cast<unsigned>((args.row_count + rows_a_block - 1) / rows_a_block);
  if (blocks > 0) count_columns<<<blocks, for_each_threads, 0, stream>>>(args, work);
  cuda::check(cudaGetLastError(), "kernel launch", cuda_queue.rank());
  queue.fill(args.matrix_slice_offset.data() + args.row_count, 0, sizeof(Offset));
  cuda::check(cub::DeviceScan::ExclusiveSum(
                  work.temporary, work.temporary_bytes, args.matrix_slice_offset.data(),
                  args.matrix_slice_offset.data(), args.row_count + 1, stream),
              "cub::DeviceScan::ExclusiveSum", cuda_queue.rank());
  if (blocks > 0) sum_entries<<<blocks, for_each_threads, 0, stream>>>(args, work);
  cuda::check(cudaGetLastError(), "kernel launch", cuda_queue.rank());
}

template void run(OnCuda, Queue&, const AssembleContacts<float>&);
template void run(OnCuda, Queue&, const AssembleContacts<double>&);

}  // namespace weft
