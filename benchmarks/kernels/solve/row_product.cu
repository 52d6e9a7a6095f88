// The matrix-vector product of conjugate gradients alone, on the pattern of a sheet: bytes a second
// against a copy's, for both heights of slices.
#include <cuda_runtime.h>

#include "benchmarks/support/grid_system.hpp"
#include "benchmarks/support/kernel_bench.hpp"
#include "cuda/exec/check.cuh"
#include "cuda/exec/cuda_device.cuh"
#include "cuda/solve/product_row.cuh"

namespace weft::bench {
namespace {

constexpr int product_threads = 256;

template <int slice, class T>
__global__ void __launch_bounds__(product_threads)
    multiply(const __grid_constant__ SolvePcgPart<T> part) {
  const Index row = static_cast<Index>(blockIdx.x * product_threads + threadIdx.x);
  if (row < part.mesh.row_count)
    part.w.data()[row] = cuda::mesh_row<slice>(part, row, part.u.data(), part.u.data()[row]);
}

/// Columns of one row, without the row's own and padding.
using Columns = std::vector<std::vector<Index>>;

Columns columns_of(const std::vector<Offset>& slice_offset, const std::vector<Index>& column,
                   Index rows) {
  Columns result(static_cast<std::size_t>(rows));
  for (Index row = 0; row < rows; ++row)
    for (Offset slot = slice_offset[static_cast<std::size_t>(row / host_slice)];
         slot < slice_offset[static_cast<std::size_t>(row / host_slice) + 1]; ++slot) {
      auto& own = result[static_cast<std::size_t>(row)];
      const Index c = column[static_cast<std::size_t>(slot * host_slice + row % host_slice)];
      if (c != row) own.push_back(c);
    }
  return result;
}

template <class T>
struct Matrix {
  Buffer<Offset> slice_offset;
  Buffer<Index> column;
  Buffer<T> value;

  Matrix(Device& device, const Columns& rows, Index slice, std::size_t components)
      : slice_offset(device), column(device), value(device) {
    std::vector<Offset> offset{0};
    std::vector<Index> columns;
    const auto width = static_cast<std::size_t>(slice);
    for (std::size_t first = 0; first < rows.size(); first += width) {
      std::size_t slots = 0;
      for (std::size_t r = first; r < std::min(rows.size(), first + width); ++r)
        slots = std::max(slots, rows[r].size());
      for (std::size_t slot = 0; slot < slots; ++slot)
        for (std::size_t r = first; r < first + width; ++r) {
          const auto& own = rows[std::min(r, rows.size() - 1)];
          columns.push_back(slot < own.size() ? own[slot] : own.back());
        }
      offset.push_back(offset.back() + static_cast<Offset>(slots));
    }
    std::vector<T> values(components * columns.size());
    for (std::size_t k = 0; k < values.size(); ++k) values[k] = T(0.001) * static_cast<T>(k % 997);
    upload(device.compute(), slice_offset, offset);
    upload(device.compute(), column, columns);
    upload(device.compute(), value, values);
  }
  double bytes() const {
    return static_cast<double>(column.size() * sizeof(Index) + value.size() * sizeof(T));
  }
};

/// Median time of a launch [s].
template <class Launch>
double time_of(cudaStream_t stream, const Launch& launch) {
  cudaEvent_t start, end;
  cuda::check(cudaEventCreate(&start), "cudaEventCreate", 0);
  cuda::check(cudaEventCreate(&end), "cudaEventCreate", 0);
  std::vector<double> times;
  for (int repeat = 0; repeat < 24; ++repeat) {
    cudaEventRecord(start, stream);
    launch();
    cudaEventRecord(end, stream);
    cuda::check(cudaEventSynchronize(end), "cudaEventSynchronize", 0);
    float ms = 0;
    cudaEventElapsedTime(&ms, start, end);
    if (repeat >= 4) times.push_back(1e-3 * double(ms));
  }
  cudaEventDestroy(start);
  cudaEventDestroy(end);
  std::sort(times.begin(), times.end());
  return times[times.size() / 2];
}

template <int slice, class T>
Json measure(Device& device, const Columns& mesh, const Columns& far, double copy) {
  const auto rows = static_cast<Index>(mesh.size());
  const Matrix<T> mesh_matrix(device, mesh, slice, 9);
  const Matrix<T> off_pattern_matrix(device, far, slice, 1);
  Buffer<Vec3<T>> u(device), w(device, mesh.size());
  upload(device.compute(), u, std::vector<Vec3<T>>(mesh.size(), {T(1), T(-0.5), T(0.25)}));
  Buffer<T> mass(device);
  upload(device.compute(), mass, std::vector<T>(mesh.size(), T(0.5)));
  SolvePcgPart<T> part;
  part.mesh = {rows, slice, mesh_matrix.slice_offset.span(), mesh_matrix.column.span(),
               mesh_matrix.value.span()};
  part.vertex = {mass.span(), {}};
  part.u = u.span();
  part.w = w.span();
  const auto stream = static_cast<CudaQueue&>(device.compute()).stream();
  const auto blocks = static_cast<unsigned>((rows + product_threads - 1) / product_threads);
  Json result;
  result.add("vertices", rows).add("precision", sizeof(T) == 4 ? "float" : "double");
  result.add("slice", slice);
  const auto book = [&](const char* name, double bytes) {
    const double seconds =
        time_of(stream, [&] { multiply<slice><<<blocks, product_threads, 0, stream>>>(part); });
    cuda::check(cudaGetLastError(), "kernel launch", 0);
    Json figures;
    figures.add("us", 1e6 * seconds).add("bytes", bytes).add("tb_per_s", 1e-12 * bytes / seconds);
    figures.add("share_of_copy", bytes / seconds / copy);
    result.add(name, figures);
  };
  const double vectors = 7.0 * sizeof(T) * rows;
  book("blocks", mesh_matrix.bytes() + vectors);
  part.far = {rows, slice, off_pattern_matrix.slice_offset.span(), off_pattern_matrix.column.span(),
              off_pattern_matrix.value.span()};
  book("blocks_and_far", mesh_matrix.bytes() + off_pattern_matrix.bytes() + vectors);
  std::cout << result.text() << std::endl;
  return result;
}

void measure_all(const Options& options) {
  DeviceSet devices = parse_devices(options.device);
  if (devices.backend() == Backend::host) {
    std::cout << "runs on CUDA alone; name a GPU with --device cuda\n";
    return;
  }
  const double copy = cuda_copy_bandwidth(0);
  std::cout << "copy: " << 1e-12 * copy << " TB/s" << std::endl;
  Json results('[');
  results.add(Json().add("copy_tb_per_s", 1e-12 * copy));
  for (const int vertices : options.vertices) {
    const auto cells = static_cast<Index>(std::lround(std::sqrt(double(vertices)))) - 1;
    for (const Bending bending : {Bending::plate, Bending::hinge}) {
      Scene scene = wavy_sheet(cells);
      scene.bending = bending;
      const Model model = make_model(scene);
      const Partition partition = make_partition(model.cloth_vertex_count, 1, 0);
      const MeshRows rows = make_mesh_rows(model, partition, 0);
      const std::vector<unsigned char> held(static_cast<std::size_t>(model.cloth_triangle_count),
                                            0);
      const PlateRows plate = make_plate_rows(make_plate(scene, model, held), rows, partition, 0);
      const Columns mesh = columns_of(rows.slice_offset, rows.column, model.cloth_vertex_count);
      Columns far(mesh.size());
      if (!plate.off_pattern_column.empty())
        far = columns_of(plate.off_pattern_slice_offset, plate.off_pattern_column,
                         model.cloth_vertex_count);
      for (std::size_t r = 0; r < far.size(); ++r)
        if (far[r].empty()) far[r].push_back(static_cast<Index>(r));
      results.add(measure<host_slice, float>(devices[0], mesh, far, copy));
      results.add(measure<cuda_slice, float>(devices[0], mesh, far, copy));
      results.add(measure<cuda_slice, double>(devices[0], mesh, far, copy));
    }
  }
  write(options, "row_product", results);
}

}  // namespace
}  // namespace weft::bench

int main(int argc, char** argv) {
  return weft::bench::run(argc, argv, weft::bench::measure_all);
}
