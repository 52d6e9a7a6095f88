#include "weft/kernels/collide/work.hpp"

#include "cuda/collide/grid_scan.cuh"
#include "cuda/collide/walk.cuh"

namespace weft {
namespace {

/// Sums of the blocks, a scan each. [scan_blocks]
struct WorkSums {
  Offset* face;
  Offset* edge;
};

/// This lane's part of the box tests that a query takes, see query_tests() of the host.
/// @param lowest number of the first box that counts
__device__ Offset tests_of_lane(const Grid& grid, std::size_t boxes, const Box& box, Index lowest,
                                int lane) {
  const CoveredCells cells(grid, box);
  if (cells.too_many(boxes)) return lane == 0 ? static_cast<Offset>(boxes) - lowest : 0;
  Offset count = 0;
  for (std::int32_t n = 0; n < cells.count(); n += 32) {
    const CoveredCells::Cell cell = cells(n + lane);
    if (!cell.is_one) continue;
    const Index end = grid.bucket_offset.data()[cell.bucket + 1];
    Index low = grid.bucket_offset.data()[cell.bucket];
    Index high = end;
    while (lowest > 0 && low < high) {
      const Index middle = low + (high - low) / 2;
      if (grid.entries.data()[middle].number < lowest)
        low = middle + 1;
      else
        high = middle;
    }
    count += end - low;
  }
  return count;
}

template <class T>
__device__ Offset tests_of_lane(const CollideWork<T>& a, ClusterKind kind, const Box& box,
                                Index lowest, int lane) {
  return tests_of_lane(a.grids[kind], a.lists[kind].hulls.size(), box, lowest, lane);
}

/// What group g of the vertices, cloth then obstacle, or behind them of the cloth's edges, asks.
template <class T>
__device__ Offset count_tests(const CollideWork<T>& a, Index g, int lane) {
  const Index cloth = a.lists[cloth_vertices].group_count();
  const auto vertices = static_cast<Index>(a.face_work.size()) - 1;
  Offset tests = 0;
  if (g >= vertices) {
    const Box box = a.lists[cloth_edges].hulls.data()[g - vertices];
    tests = tests_of_lane(a, obstacle_edges, box, 0, lane);
    if (a.self) tests += tests_of_lane(a, cloth_edges, box, g - vertices, lane);
  } else if (g >= cloth) {
    const Box box = a.lists[obstacle_vertices].hulls.data()[g - cloth];
    tests = tests_of_lane(a, cloth_faces, box, 0, lane);
  } else {
    const Box box = a.lists[cloth_vertices].hulls.data()[g];
    tests = tests_of_lane(a, obstacle_faces, box, 0, lane);
    if (a.self) tests += tests_of_lane(a, cloth_faces, box, 0, lane);
  }
  return cuda::sum_lanes(tests);
}

__device__ void scan_table(Span<Offset> table, Offset* block_sum) {
  scan_together(
      static_cast<Offset>(table.size()) - 1, block_sum, [&](Offset g) { return table.data()[g]; },
      [&](Offset g, Offset sum) { table.data()[g] = sum; });
}

template <class T>
__global__ void __launch_bounds__(scan_threads)
    make_tables(const __grid_constant__ CollideWork<T> a, const WorkSums sums) {
  const auto vertices = static_cast<Index>(a.face_work.size()) - 1;
  const Index groups = vertices + static_cast<Index>(a.edge_work.size()) - 1;
  const auto lane = static_cast<int>(threadIdx.x % 32);
  constexpr Index warps = scan_threads / 32;
  const auto warp = static_cast<Index>(blockIdx.x * warps + threadIdx.x / 32);
  for (Index g = warp; g < groups; g += static_cast<Index>(gridDim.x) * warps) {
    const Offset tests = 1 + count_tests(a, g, lane);
    if (lane == 0)
      (g < vertices ? a.face_work.data()[g] : a.edge_work.data()[g - vertices]) = tests;
  }
  cooperative_groups::this_grid().sync();
  scan_table(a.face_work, sums.face);
  scan_table(a.edge_work, sums.edge);
}

}  // namespace

/// A warp a group, a lane a cell; then the sums, all in one launch whose blocks wait for each
/// other.
template <class T>
void run(OnCuda, Queue& queue, const CollideWork<T>& args) {
  auto& cuda_queue = static_cast<CudaQueue&>(queue);
  ScratchLayout layout;
  const std::size_t face = layout.add<Offset>(scan_blocks);
  const std::size_t edge = layout.add<Offset>(scan_blocks);
  auto* memory = static_cast<std::byte*>(cuda_queue.scratch(layout.bytes()));
  const WorkSums sums{reinterpret_cast<Offset*>(memory + face),
                      reinterpret_cast<Offset*>(memory + edge)};
  const auto groups = static_cast<Offset>(args.face_work.size() + args.edge_work.size()) - 2;
  launch_together({cuda_queue, 32 * groups}, make_tables<T>, args, sums);
}

template void run(OnCuda, Queue&, const CollideWork<float>&);
template void run(OnCuda, Queue&, const CollideWork<double>&);

}  // namespace weft
