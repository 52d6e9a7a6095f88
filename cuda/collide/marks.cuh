#pragma once

#include <algorithm>
#include <cub/block/block_scan.cuh>

#include "cuda/exec/check.cuh"
#include "cuda/exec/cuda_device.cuh"
#include "cuda/exec/sums.cuh"
#include "weft/core/marks.hpp"
#include "weft/kernels/collide/pairs.hpp"

// Marks of items whose number only the device knows: kernels are launched over what a GPU runs at
// a time and go on until the items are done.

namespace weft::cuda {

inline constexpr int count_threads = Marks::tile_words;
inline constexpr int scan_threads = 1024;
/// Blocks of a kernel that goes on until its items are done; as many as a large GPU runs at a
/// time, so that no block waits for another one to end.
inline constexpr unsigned resident_blocks = 1056;

/// How the pairs of both lists are numbered as items: faces first, each list from a word's start.
struct PairItems {
  std::uint32_t faces, edges;       ///< numbers of pairs, within capacity
  std::uint32_t face_words, words;  ///< words of the faces, and of both

  __device__ PairItems(const CollideCounts& counts, std::size_t face_capacity,
                       std::size_t edge_capacity)
      : faces(within(counts.face_pairs, face_capacity)),
        edges(within(counts.edge_pairs, edge_capacity)),
        face_words(static_cast<std::uint32_t>(mark_words(faces))),
        words(face_words + static_cast<std::uint32_t>(mark_words(edges))) {}

  __device__ bool is_face(std::uint32_t item) const {
    return item / Marks::word_items < face_words;
  }
  /// Number in its list; beyond the list's end for items that are no pair.
  __device__ std::uint32_t number(std::uint32_t item) const {
    return is_face(item) ? item : item - face_words * Marks::word_items;
  }
  __device__ bool is_pair(std::uint32_t item) const {
    return number(item) < (is_face(item) ? faces : edges);
  }

 private:
  __device__ static std::uint32_t within(Index count, std::size_t capacity) {
    const auto all = static_cast<std::size_t>(count);
    return static_cast<std::uint32_t>(all < capacity ? all : capacity);
  }
};

/// Marks the items that `decide` says yes to, a warp a word. All threads of the grid call it.
/// @param words  how many hold the items
/// @param decide asked of every item of these words, by all lanes of a warp at once
template <class Decide>
__device__ void mark_items(const Marks& marks, std::uint32_t words, Decide decide) {
  const std::uint32_t first = (blockIdx.x * blockDim.x + threadIdx.x) / Marks::word_items;
  const std::uint32_t stride = gridDim.x * blockDim.x / Marks::word_items;
  const std::uint32_t lane = threadIdx.x % Marks::word_items;
  for (std::uint32_t word = first; word < words; word += stride) {
    const std::uint32_t bits = __ballot_sync(whole_warp, decide(word * Marks::word_items + lane));
    if (lane == 0) marks.words.data()[word] = bits;
  }
  if (blockIdx.x == 0 && threadIdx.x == 0) marks.head.data()[0] = words;
}

/// Counts the marks within each tile, a block a tile at a time.
inline __global__ void __launch_bounds__(count_threads) count_in_tiles(Marks marks) {
  using Scan = cub::BlockScan<std::uint32_t, count_threads>;
  __shared__ typename Scan::TempStorage storage;
  const std::uint32_t words = marks.words_in_use();
  for (std::uint32_t tile = blockIdx.x; tile * Marks::tile_words < words; tile += gridDim.x) {
    const std::uint32_t word = tile * Marks::tile_words + threadIdx.x;
    const std::uint32_t own =
        word < words ? static_cast<std::uint32_t>(__popc(marks.words.data()[word])) : 0;
    std::uint32_t before = 0;
    std::uint32_t total = 0;
    Scan(storage).ExclusiveSum(own, before, total);
    if (word < words) marks.before_word.data()[word] = before;
    if (threadIdx.x == 0) marks.before_tile.data()[tile] = total;
    __syncthreads();
  }
}

/// Sums up the tiles, and with it all marks. One block.
inline __global__ void __launch_bounds__(scan_threads) sum_tiles(Marks marks) {
  using Scan = cub::BlockScan<std::uint32_t, scan_threads>;
  __shared__ typename Scan::TempStorage storage;
  const std::uint32_t words = marks.words_in_use();
  const std::uint32_t tiles = (words + Marks::tile_words - 1) / Marks::tile_words;
  std::uint32_t sum = 0;
  for (std::uint32_t first = 0; first < tiles; first += scan_threads) {
    const std::uint32_t tile = first + threadIdx.x;
    const std::uint32_t own = tile < tiles ? marks.before_tile.data()[tile] : 0;
    std::uint32_t before = 0;
    std::uint32_t total = 0;
    Scan(storage).ExclusiveSum(own, before, total);
    if (tile < tiles) marks.before_tile.data()[tile] = sum + before;
    sum += total;
    __syncthreads();
  }
  if (threadIdx.x == 0) marks.head.data()[1] = sum;
}

/// Counts marks that an earlier kernel of the queue has made.
/// @throws DeviceError if the GPU does not take the launch
inline void count_marks(const CudaQueue& queue, const Marks& marks) {
  const auto tiles = static_cast<unsigned>(std::max<std::size_t>(1, marks.before_tile.size()));
  count_in_tiles<<<std::min(tiles, resident_blocks), count_threads, 0, queue.stream()>>>(marks);
  check(cudaGetLastError(), "kernel launch", queue.rank());
  sum_tiles<<<1, scan_threads, 0, queue.stream()>>>(marks);
  check(cudaGetLastError(), "kernel launch", queue.rank());
}

/// Cuts the marks of several stages off the scratch of a kernel over pairs.
/// @param needed how many numbers of scratch the kernel's header asks for
/// @throws DeviceError if there are fewer
inline void take_pair_marks(const CudaQueue& queue, Span<std::uint32_t> scratch, std::size_t needed,
                            std::size_t pairs, Span<Marks> stages) {
  if (scratch.size() < needed)
    throw DeviceError("rank " + std::to_string(queue.rank()) + ": scratch of " +
                      std::to_string(scratch.size()) +
                      " numbers for the narrow phase, which needs " + std::to_string(needed));
  for (Marks& marks : stages) marks = take_marks(scratch, pairs + 2 * Marks::word_items);
}

}  // namespace weft::cuda
