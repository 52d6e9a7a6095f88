#include "weft/kernels/collide/grid.hpp"

#include "cuda/collide/grid_scan.cuh"

namespace weft {
namespace {

/// What the stages hand on, in the queue's scratch memory. A code is that of a box in a cell:
/// cells_a_box times the box's number, and which of its cells it is.
struct GridWork {
  Index* count;      ///< [buckets] entries, later those still without a place
  Index* code;       ///< [cells_a_box boxes] by bucket, within one in no order
  Index* block_sum;  ///< [scan_blocks]
};

/// A box in one of its cells.
struct Placed {
  PlacesOf places;
  GridPlace at;
  bool real;  ///< false: the box is in fewer cells
};

__device__ Placed place_of_code(const CollideGrid& a, float cell, Offset code) {
  Placed placed;
  placed.places = places_of(a.boxes.data()[code / cells_a_box], cell);
  const int n = static_cast<int>(code % cells_a_box);
  placed.real = n < placed.places.count;
  const auto buckets = static_cast<std::uint32_t>(a.bucket_offset.size() - 1);
  if (placed.real) placed.at = placed.places(n, buckets);
  return placed;
}

/// Writes an entry where it comes in the order of codes: behind all smaller ones of its bucket.
__device__ void write_entry(const CollideGrid& a, const GridWork& work, const Placed& placed,
                            Index code) {
  const Index begin = a.bucket_offset.data()[placed.at.bucket];
  const Index end = a.bucket_offset.data()[placed.at.bucket + 1];
  Index place = begin;
  for (Index e = begin; e < end; ++e) place += work.code[e] < code ? 1 : 0;
  const Index number = code / cells_a_box;
  a.entries.data()[place] = {placed.at.tag, number, a.boxes.data()[number]};
}

__global__ void __launch_bounds__(scan_threads)
    build_grid(const __grid_constant__ CollideGrid a, const GridWork work) {
  if (!a.wanted.empty() && a.wanted.data()[0] == 0) return;
  const auto grid = cooperative_groups::this_grid();
  const Offset start = Offset{blockIdx.x} * scan_threads + threadIdx.x;
  const Offset stride = Offset{gridDim.x} * scan_threads;
  const auto buckets = static_cast<Offset>(a.bucket_offset.size()) - 1;
  const Offset codes = static_cast<Offset>(a.boxes.size()) * cells_a_box;
  const float cell = level_0_cell(a);
  for (Offset b = start; b < buckets; b += stride) work.count[b] = 0;
  if (start == 0) {
    a.levels.data()[0] = 0;
    a.cell.data()[0] = cell;
  }
  grid.sync();
  std::uint32_t levels = 0;
  for (Offset c = start; c < codes; c += stride) {
    const Placed placed = place_of_code(a, cell, c);
    if (!placed.real) continue;
    atomicAdd(&work.count[placed.at.bucket], 1);
    levels |= 1u << placed.places.level;
  }
  levels = __reduce_or_sync(cuda::whole_warp, levels);
  if (threadIdx.x % 32 == 0 && levels != 0) atomicOr(a.levels.data(), levels);
  grid.sync();
  scan_together(
      buckets, work.block_sum, [&](Offset b) { return work.count[b]; },
      [&](Offset b, Index sum) { a.bucket_offset.data()[b] = sum; });
  grid.sync();
  for (Offset c = start; c < codes; c += stride) {
    const Placed placed = place_of_code(a, cell, c);
    if (!placed.real) continue;
    const Index left = atomicSub(&work.count[placed.at.bucket], 1);
    work.code[a.bucket_offset.data()[placed.at.bucket] + left - 1] = static_cast<Index>(c);
  }
  grid.sync();
  for (Offset c = start; c < codes; c += stride) {
    const Placed placed = place_of_code(a, cell, c);
    if (placed.real) write_entry(a, work, placed, static_cast<Index>(c));
  }
}

}  // namespace

/// One launch, whose blocks wait for each other between the stages. Entries get a place in their
/// bucket in whatever order they come, and then their own by how many of the bucket come before
/// them: buckets are short, and no sort is needed. Comparing all entries of one bucket with each
/// other is quadratic where everything is in one cell; at the size of groups that costs less than a
/// sort of all entries does every time.
void run(OnCuda, Queue& queue, const CollideGrid& args) {
  auto& cuda_queue = static_cast<CudaQueue&>(queue);
  const std::size_t codes = args.boxes.size() * cells_a_box;
  const std::size_t buckets = args.bucket_offset.size() - 1;
  ScratchLayout layout;
  const std::size_t count = layout.add<Index>(buckets);
  const std::size_t code = layout.add<Index>(codes);
  const std::size_t block_sum = layout.add<Index>(scan_blocks);
  auto* memory = static_cast<std::byte*>(cuda_queue.scratch(layout.bytes()));
  const GridWork work{reinterpret_cast<Index*>(memory + count),
                      reinterpret_cast<Index*>(memory + code),
                      reinterpret_cast<Index*>(memory + block_sum)};
  launch_together({cuda_queue, static_cast<Offset>(std::max(codes, buckets))}, build_grid, args,
                  work);
}

}  // namespace weft
