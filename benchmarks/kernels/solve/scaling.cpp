// Conjugate gradients on the first system of a wavy sheet, on the first 1, 2, 4, ... ranks of a
// device set: time of an iteration, memory of a rank, and whether the solution has the same bits.
#include <algorithm>
#include <cstdio>

#include "benchmarks/support/grid_system.hpp"
#include "benchmarks/support/kernel_bench.hpp"

namespace weft::bench {
namespace {

/// The first `count` of the devices that `text` names: of "cuda:0,1,2" or "cpu:3".
std::string first_devices(const std::string& text, int count) {
  if (text.starts_with("cpu")) return "cpu:" + std::to_string(count);
  std::size_t end = text.find(':');
  for (int n = 0; n < count; ++n) end = text.find(',', end + 1);
  return text.substr(0, end);
}

/// FNV-1a of the bytes of an array.
template <class V>
std::string hash_of(const std::vector<V>& values) {
  std::uint64_t hash = 14695981039346656037ull;
  const auto* bytes = reinterpret_cast<const unsigned char*>(values.data());
  for (std::size_t i = 0; i < values.size() * sizeof(V); ++i)
    hash = (hash ^ bytes[i]) * 1099511628211ull;
  char text[17];
  std::snprintf(text, sizeof text, "%016llx", static_cast<unsigned long long>(hash));
  return text;
}

struct Measured {
  double seconds = 0;  ///< an iteration
  std::string hash;    ///< of the velocities after a solve
};

Measured measure_ranks(const Options& options, const Scene& scene, int ranks, bool folded,
                       Json& result) {
  DeviceSet devices = parse_devices(first_devices(options.device, ranks));
  FirstSystem<float> system(scene, std::move(devices), folded);
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
  // Two counts of iterations, so that what surrounds them drops out.
  const int few = options.smoke ? 2 : 50, many = options.smoke ? 4 : 250;
  std::vector<double> differences;
  solve(1e-300, few);
  for (int repeat = 0; repeat < 5; ++repeat) {
    const double a = solve(1e-300, few);
    differences.push_back((solve(1e-300, many) - a) / (many - few));
  }
  std::sort(differences.begin(), differences.end());
  Measured m{differences[2], {}};
  const double seconds = solve(1e-3, 5000);
  m.hash = hash_of(system.velocities());
  result.add("ranks", ranks).add("iteration_us", 1e6 * m.seconds);
  result.add("iteration_us_min", 1e6 * differences.front());
  result.add("iteration_us_max", 1e6 * differences.back());
  result.add("to_0.001_iterations", system.status().iterations).add("to_0.001_ms", 1e3 * seconds);
  result.add("peak_bytes_a_rank", static_cast<double>(system.peak_bytes()));
  result.add("solution_hash", m.hash);
  return m;
}

void measure_scaling(const Options& options) {
  const int all = parse_devices(options.device).size();
  Json results('[');
  for (const int vertices : options.vertices)
    for (const bool folded : {false, true}) {
      const auto cells = static_cast<Index>(std::lround(std::sqrt(double(vertices)))) - 1;
      Scene scene = wavy_sheet(cells);
      scene.solver.preconditioner = Preconditioner::block_jacobi;
      std::vector<Measured> found;
      for (int ranks = 1; ranks <= all; ranks *= 2) {
        Json result;
        result.add("triangles", 2.0 * cells * cells).add("folded", folded ? 1 : 0);
        found.push_back(measure_ranks(options, scene, ranks, folded, result));
        result.add("speed_up", found.front().seconds / found.back().seconds);
        result.add("same_bits", found.front().hash == found.back().hash ? 1 : 0);
        std::cout << result.text() << std::endl;
        results.add(result);
      }
    }
  write(options, "scaling", results);
}

}  // namespace
}  // namespace weft::bench

int main(int argc, char** argv) {
  return weft::bench::run(argc, argv, weft::bench::measure_scaling);
}
