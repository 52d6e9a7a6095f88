// Conjugate gradients on the first system of a wavy sheet: time and bytes of an iteration, and
// iterations and time to three tolerances, for all preconditioners.
#include "weft/kernels/solve/pcg.hpp"

#include <algorithm>

#include "benchmarks/support/grid_system.hpp"
#include "benchmarks/support/kernel_bench.hpp"

namespace weft::bench {
namespace {

/// Neighbouring lanes whose numbers are loaded together: 32 bytes in single precision.
constexpr Index sector = 8;

/// Entries that a product loads: on hosts all slots, on CUDA the sectors that are not all padding.
/// @param column [slots * slice] padding has the row itself
double loaded(const std::vector<Offset>& slice_offset, const std::vector<Index>& column,
              const MeshRows& mesh, const Partition& partition, Index rows) {
  if (mesh.order.empty()) return static_cast<double>(column.size());
  const RowOrder order{mesh.order};
  const Index slice = partition.slice;
  double entries = 0;
  for (std::size_t s = 0; s + 1 < slice_offset.size(); ++s)
    for (Offset slot = slice_offset[s]; slot < slice_offset[s + 1]; ++slot)
      for (Index lane = 0; lane < slice; lane += sector) {
        bool any = false;
        for (Index l = lane; l < lane + sector; ++l) {
          const Index place = static_cast<Index>(s) * slice + l;
          any = any || (place < rows &&
                        column[static_cast<std::size_t>(slot * slice + l)] != order.row(place));
        }
        entries += any ? sector : 0;
      }
  return entries;
}

/// Bytes that an iteration moves if every number that it needs is read once a phase: see the
/// kernel's comment, which counts the same in single precision.
template <class T>
double iteration_bytes(const Scene& scene, const Model& model, const Partition& partition,
                       Preconditioner preconditioner) {
  const MeshRows mesh = make_mesh_rows(model, partition, 0);
  const std::vector<unsigned char> held(static_cast<std::size_t>(model.cloth_triangle_count), 0);
  const PlateRows plate = make_plate_rows(make_plate(scene, model, held), mesh, partition, 0);
  const double number = sizeof(T);
  const auto rows = static_cast<double>(model.cloth_vertex_count);
  const Index all = model.cloth_vertex_count;
  // Padding of the plate is recognised by its columns, so all of them are loaded.
  const double matrix =
      loaded(mesh.slice_offset, mesh.column, mesh, partition, all) * (9 * number + sizeof(Index)) +
      loaded(plate.off_pattern_slice_offset, plate.off_pattern_column, mesh, partition, all) *
          number +
      static_cast<double>(plate.off_pattern_column.size() * sizeof(Index));
  const double order = mesh.order.empty() ? 0 : sizeof(Index);
  double row = order + number            // order, mass
               + 3 * number              // w
               + 9 * number              // block Jacobi
               + (18 + 15 + 6) * number  // p, s, r, x, u of the update and of the products
               + 2;                      // marks
  if (preconditioner == Preconditioner::multilevel)
    row += number * (SymmetricBlocks::size(schwarz_aggregates_max) / 64.0 + 48 * 48 / 1024.0);
  return matrix + rows * row;
}

template <class T>
Json measure(const Options& options, int vertices, Preconditioner preconditioner,
             bool folded = false) {
  const auto cells = static_cast<Index>(std::lround(std::sqrt(double(vertices)))) - 1;
  Scene scene = wavy_sheet(cells);
  scene.solver.preconditioner = preconditioner;
  FirstSystem<T> system(scene, parse_devices(options.device), folded);
  const Model& model = system.store().model();
  const auto solve = [&](double tolerance, int iterations) {
    system.settings().tolerance = tolerance;
    system.settings().max_iterations = iterations;
    system.assemble();
    system.sync();
    return shortest(1, [&] {
      system.solve();
      system.sync();
    });
  };
  Json result;
  result.add("vertices", model.cloth_vertex_count).add("triangles", model.cloth_triangle_count);
  result.add("precision", sizeof(T) == 4 ? "float" : "double");
  constexpr const char* names[] = {"block_jacobi", "multilevel"};
  result.add("preconditioner", names[static_cast<int>(preconditioner)]);
  result.add("contacts", folded ? (model.cloth_vertex_count + 2) / 3 : 0);
  system.assemble();
  system.sync();
  result.add("assemble_ms", 1e3 * shortest(3, [&] {
                              system.assemble();
                              system.sync();
                            }));
  // Two counts of iterations, so that what surrounds them drops out.
  const int few = options.smoke ? 2 : 50, many = options.smoke ? 4 : 250;
  double a = 1e300, b = 1e300;
  for (int repeat = 0; repeat < 3; ++repeat) {
    a = std::min(a, solve(1e-300, few));
    b = std::min(b, solve(1e-300, many));
  }
  const double iteration = (b - a) / (many - few);
  double bytes = iteration_bytes<T>(scene, model, system.store().partition(), preconditioner);
  if (folded) bytes += model.cloth_vertex_count / 3.0 * (4 * end_bytes<T> + link_bytes<T>);
  result.add("iteration_us", 1e6 * iteration).add("iteration_bytes", bytes);
  result.add("iteration_bytes_per_row", bytes / model.cloth_vertex_count);
  result.add("iteration_tb_per_s", 1e-12 * bytes / iteration);
  for (const double tolerance : {1e-1, 1e-2, 1e-3}) {
    const double seconds = solve(tolerance, 5000);
    const SolveStatus status = system.status();
    std::ostringstream name;
    name << "to_" << tolerance;
    Json reached;
    reached.add("iterations", status.iterations).add("ms", 1e3 * seconds);
    reached.add("residual", status.residual).add("converged", status.converged);
    result.add(name.str(), reached);
  }
  std::cout << result.text() << std::endl;
  return result;
}

void measure_all(const Options& options) {
  Json results('[');
  for (const int vertices : options.vertices) {
    for (const auto p : {Preconditioner::block_jacobi, Preconditioner::multilevel})
      results.add(measure<float>(options, vertices, p));
    results.add(measure<float>(options, vertices, Preconditioner::multilevel, true));
    if (options.smoke || vertices <= 200'000)
      results.add(measure<double>(options, vertices, Preconditioner::multilevel));
  }
  write(options, "pcg", results);
}

}  // namespace
}  // namespace weft::bench

int main(int argc, char** argv) {
  return weft::bench::run(argc, argv, weft::bench::measure_all);
}
