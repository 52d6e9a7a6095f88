// Conjugate gradients on the first system of a wavy sheet, on the first 1, 2, 4, ... ranks of a
// device set: time of an iteration, memory of a rank, and whether the solution has the same bits.
// By three ways of exchanging vectors, all of them or those that --transport names:
//   peer       kernels reach each other's memory; only the halo moves
//   pipelined  whole sub-vectors by work queues, products meanwhile (P-Cloth section 3.1, eq. (7))
//   gathered   the same copies, then the product (P-Cloth Fig. 3(a) and 5, eq. (6))
#include <algorithm>
#include <cstddef>
#include <cstdio>
#include <iterator>
#include <map>
#include <optional>
#include <string_view>

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

struct Way {
  const char* name;
  Transport transport;
  bool gather;
};

constexpr Way ways[] = {{"peer", Transport::peer, false},
                        {"pipelined", Transport::pipelined, false},
                        {"gathered", Transport::pipelined, true}};

/// Bytes of each use, most of any rank.
Json memory_json(const std::vector<std::vector<MemoryUse>>& ranks) {
  std::map<std::string, double> most;
  for (const auto& uses : ranks)
    for (const MemoryUse& use : uses)
      most[use.name] = std::max(most[use.name], static_cast<double>(use.peak_bytes));
  Json json;
  for (const auto& [name, bytes] : most) json.add(name, bytes);
  return json;
}

Measured measure_ranks(const Options& options, Scene scene, const Way& way, int ranks, bool folded,
                       Json& result) {
  DeviceSet devices = parse_devices(first_devices(options.device, ranks));
  scene.solver.transport = way.transport;
  FirstSystem<float> system(scene, std::move(devices), folded);
  system.gather_before_products(way.gather);
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
  result.add("ranks", ranks).add("transport", way.name).add("iteration_us", 1e6 * m.seconds);
  result.add("iteration_us_min", 1e6 * differences.front());
  result.add("iteration_us_max", 1e6 * differences.back());
  result.add("to_0.001_iterations", system.status().iterations).add("to_0.001_ms", 1e3 * seconds);
  result.add("peak_bytes_a_rank", static_cast<double>(system.peak_bytes()));
  result.add("peak_bytes_by_use", memory_json(system.memory_use()));
  result.add("solution_hash", m.hash);
  return m;
}

/// One sheet on 1, 2, 4, ... ranks by every way; the results so far are written after each.
void measure_sheet(const Options& options, const std::vector<Way>& chosen, Index cells, bool folded,
                   Json& results) {
  const int all = parse_devices(options.device).size();
  Scene scene = wavy_sheet(cells);
  scene.solver.preconditioner = Preconditioner::block_jacobi;
  std::optional<Measured> first;
  for (const Way& way : chosen)
    for (int ranks = 1; ranks <= all; ranks *= 2) {
      // One rank has nothing to exchange: what all ways are compared with is its one kernel.
      if (ranks == 1 && first) continue;
      Json result;
      result.add("triangles", 2.0 * cells * cells).add("folded", folded ? 1 : 0);
      const Measured found = measure_ranks(options, scene, way, ranks, folded, result);
      if (!first) first = found;
      result.add("speed_up", first->seconds / found.seconds);
      result.add("same_bits", first->hash == found.hash ? 1 : 0);
      std::cout << result.text() << std::endl;
      results.add(result);
      write(options, "scaling", results);
    }
}

void measure_scaling(const Options& options, const std::vector<Way>& chosen) {
  Json results('[');
  for (const int vertices : options.vertices)
    for (const bool folded : {false, true})
      measure_sheet(options, chosen,
                    static_cast<Index>(std::lround(std::sqrt(double(vertices)))) - 1, folded,
                    results);
}

/// Takes every `--transport T` out of the arguments.
/// @throws SceneError if there is no such way
std::vector<Way> take_trajectories(std::vector<char*>& arguments) {
  std::vector<Way> chosen;
  for (std::size_t i = 1; i + 1 < arguments.size();) {
    if (std::string_view(arguments[i]) != "--transport") {
      ++i;
      continue;
    }
    const std::string name = arguments[i + 1];
    const auto* const way = std::find_if(std::begin(ways), std::end(ways),
                                         [&](const Way& w) { return w.name == name; });
    if (way == std::end(ways))
      throw SceneError("", "--transport", name, "peer, pipelined, gathered");
    chosen.push_back(*way);
    arguments.erase(arguments.begin() + static_cast<std::ptrdiff_t>(i),
                    arguments.begin() + static_cast<std::ptrdiff_t>(i) + 2);
  }
  if (chosen.empty()) chosen.assign(std::begin(ways), std::end(ways));
  return chosen;
}

}  // namespace
}  // namespace weft::bench

int main(int argc, char** argv) {
  std::vector<char*> arguments(argv, argv + argc);
  std::vector<weft::bench::Way> chosen;
  try {
    chosen = weft::bench::take_trajectories(arguments);
  } catch (const weft::SceneError& error) {
    std::cerr << argv[0] << ": " << error.what() << "\n";
    return 2;
  }
  return weft::bench::run(
      static_cast<int>(arguments.size()), arguments.data(),
      [&](const weft::bench::Options& options) { weft::bench::measure_scaling(options, chosen); });
}
