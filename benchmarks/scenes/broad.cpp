// The broad phase alone, over the motion between two frames of a mesh: boxes, spatial hash, pairs.
// Beside it, in one thread and code of its own, sweep-and-prune, or all pairs where that is small.
#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <numeric>
#include <optional>
#include <string>
#include <vector>

#include "benchmarks/support/bench_main.hpp"
#include "host/base/atomic_file.hpp"
#include "host/implicit/contact/swept_mesh.hpp"
#include "host/io/mesh/mesh_file.hpp"
#include "weft/devices.hpp"
#include "weft/error.hpp"
#include "weft/shapes.hpp"

namespace {

using Json = nlohmann::ordered_json;
using Clock = std::chrono::steady_clock;
using weft::Index;
using weft::SweptMesh;

/// Primitives up to which all pairs are compared; beyond it, up to the next, sweep-and-prune runs.
constexpr std::size_t all_pairs_most = 2000;
constexpr std::size_t sweep_most = 400000;

struct Options {
  std::string from, to;
  double inflate = 0;
  std::string precision = "double";
  int ranks = 1;
  int repeats = 5;
  std::string json;
  bool smoke = false;
};

struct Result {
  std::int64_t vf_pairs = 0;
  std::int64_t ee_pairs = 0;
  std::int64_t cells = 0;
  double seconds = 0;                    ///< [s] median of the repeats
  double processor_seconds = 0;          ///< [s] the same, summed over all threads
  std::vector<double> samples;           ///< [s]
  std::vector<std::int64_t> rank_tests;  ///< [ranks] box tests
};

struct Reference {
  std::string method;
  std::int64_t vf_pairs = 0;
  std::int64_t ee_pairs = 0;
  double seconds = 0;  ///< [s]
};

double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

/// @pre values is not empty
double median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  const std::size_t n = values.size();
  return (values[(n - 1) / 2] + values[n / 2]) / 2;
}

// ------------------------------------------------------------------------------------ reference
struct Extent {
  double lo[3], hi[3];
  const Index* corners;
  int corner_count;
};

Extent extent_of(const SweptMesh& mesh, const Index* corners, int count, double inflate) {
  Extent e{{}, {}, corners, count};
  for (int c = 0; c < 3; ++c) {
    e.lo[c] = e.hi[c] = mesh.positions_t0[static_cast<std::size_t>(corners[0])][c];
    for (int j = 0; j < count; ++j)
      for (const auto* x : {&mesh.positions_t0, &mesh.positions_t1}) {
        const double at = (*x)[static_cast<std::size_t>(corners[j])][c];
        e.lo[c] = std::min(e.lo[c], at);
        e.hi[c] = std::max(e.hi[c], at);
      }
    e.lo[c] -= inflate;
    e.hi[c] += inflate;
  }
  return e;
}

bool meet(const Extent& a, const Extent& b) {
  for (int c = 0; c < 3; ++c)
    if (a.hi[c] < b.lo[c] || b.hi[c] < a.lo[c]) return false;
  for (int i = 0; i < a.corner_count; ++i)
    for (int j = 0; j < b.corner_count; ++j)
      if (a.corners[i] == b.corners[j]) return false;
  return true;
}

/// Counts pairs of a and b; where they are one list, each pair once.
std::int64_t count_all(const std::vector<Extent>& a, const std::vector<Extent>& b) {
  std::int64_t count = 0;
  for (std::size_t i = 0; i < a.size(); ++i)
    for (std::size_t j = &a == &b ? i + 1 : 0; j < b.size(); ++j)
      if (meet(a[i], b[j])) ++count;
  return count;
}

/// Axis along which the boxes' centres are spread most.
int sweep_axis(const std::vector<Extent>& boxes) {
  int best = 0;
  double most = -1;
  for (int c = 0; c < 3; ++c) {
    double sum = 0;
    double squares = 0;
    for (const Extent& e : boxes) {
      const double x = (e.lo[c] + e.hi[c]) / 2;
      sum += x;
      squares += x * x;
    }
    const double n = static_cast<double>(boxes.size());
    if (const double spread = squares / n - sum / n * sum / n; spread > most) {
      most = spread;
      best = c;
    }
  }
  return best;
}

/// As count_all, along the axis on which both lists are sorted by their lower ends: each pair is
/// met from the box that begins first.
std::int64_t sweep(const std::vector<Extent>& a, const std::vector<Extent>& b, int axis,
                   bool also_equal) {
  std::int64_t count = 0;
  std::size_t start = 0;
  for (const Extent& e : a) {
    while (start < b.size() &&
           (b[start].lo[axis] < e.lo[axis] || (!also_equal && b[start].lo[axis] == e.lo[axis])))
      ++start;
    for (std::size_t j = start; j < b.size() && b[j].lo[axis] <= e.hi[axis]; ++j)
      if (meet(e, b[j])) ++count;
  }
  return count;
}

std::int64_t sweep_self(const std::vector<Extent>& a, int axis) {
  std::int64_t count = 0;
  for (std::size_t i = 0; i < a.size(); ++i)
    for (std::size_t j = i + 1; j < a.size() && a[j].lo[axis] <= a[i].hi[axis]; ++j)
      if (meet(a[i], a[j])) ++count;
  return count;
}

std::optional<Reference> reference(const SweptMesh& mesh, double inflate) {
  if (mesh.edges.size() > sweep_most) return std::nullopt;
  const auto start = Clock::now();
  std::vector<Index> numbers(mesh.positions_t0.size());
  std::iota(numbers.begin(), numbers.end(), 0);
  std::vector<Extent> vertices, faces, edges;
  for (const Index& v : numbers) vertices.push_back(extent_of(mesh, &v, 1, inflate));
  for (const weft::Tri& t : mesh.triangles) faces.push_back(extent_of(mesh, t.v, 3, inflate));
  for (const weft::Edge& e : mesh.edges) edges.push_back(extent_of(mesh, e.v, 2, inflate));
  Reference r;
  if (mesh.edges.size() <= all_pairs_most) {
    r.method = "all pairs";
    r.vf_pairs = count_all(vertices, faces);
    r.ee_pairs = count_all(edges, edges);
  } else {
    r.method = "sweep and prune";
    const int axis = sweep_axis(vertices);
    for (std::vector<Extent>* list : {&vertices, &faces, &edges})
      std::sort(list->begin(), list->end(),
                [axis](const Extent& a, const Extent& b) { return a.lo[axis] < b.lo[axis]; });
    r.vf_pairs = sweep(vertices, faces, axis, true) + sweep(faces, vertices, axis, false);
    r.ee_pairs = sweep_self(edges, axis);
  }
  r.seconds = seconds_since(start);
  return r;
}

// ------------------------------------------------------------------------------------ search
template <class T>
Result measure(const SweptMesh& mesh, const Options& options) {
  weft::DeviceSet devices = weft::host_devices(options.ranks);
  weft::SweptSearch<T> search(devices, mesh, options.inflate);
  search.run();  // lists grow to their size
  Result r;
  std::vector<double> processor;
  for (int k = 0; k < options.repeats; ++k) {
    const auto start = Clock::now();
    const std::clock_t used = std::clock();
    search.run();
    processor.push_back(static_cast<double>(std::clock() - used) / CLOCKS_PER_SEC);
    r.samples.push_back(seconds_since(start));
  }
  r.seconds = median(r.samples);
  r.processor_seconds = median(processor);
  r.vf_pairs = search.face_pair_count();
  r.ee_pairs = search.edge_pair_count();
  r.cells = search.cell_count();
  r.rank_tests = search.tests();
  return r;
}

/// Most tests of a rank over their mean.
double imbalance(const Result& r) {
  const double sum =
      static_cast<double>(std::accumulate(r.rank_tests.begin(), r.rank_tests.end(), 0.0));
  const auto most = *std::max_element(r.rank_tests.begin(), r.rank_tests.end());
  return sum > 0 ? static_cast<double>(most) * static_cast<double>(r.rank_tests.size()) / sum : 1;
}

/// In double exactly the reference, unless boxes are grown, which rounds; in float no fewer.
bool agree(const Result& result, const Reference& reference, const Options& options) {
  if (options.precision == "double" && !(options.inflate > 0))
    return result.vf_pairs == reference.vf_pairs && result.ee_pairs == reference.ee_pairs;
  return result.vf_pairs >= reference.vf_pairs && result.ee_pairs >= reference.ee_pairs;
}

// ------------------------------------------------------------------------------------ input
/// A sheet folded like a bellows, and the same a moment later, folded further.
SweptMesh own_frames() {
  const weft::Mesh grid = weft::make_grid({1, 1}, {60, 60}, weft::Diagonals::alternating);
  const auto folded = [&](double fold) {
    std::vector<weft::Vec3<double>> x;
    for (const auto& p : grid.positions)
      x.push_back({p[0] * (1 - fold), p[1], 0.05 * std::sin(40 * p[0]) + 0.01 * fold * p[1]});
    return x;
  };
  return weft::make_swept_mesh(folded(0.8), folded(0.83), grid.triangles);
}

SweptMesh read_frames(const Options& options) {
  const weft::Mesh from = weft::io::read_mesh(options.from, weft::io::Uv::ignore);
  const weft::Mesh to = weft::io::read_mesh(options.to, weft::io::Uv::ignore);
  if (to.positions.size() != from.positions.size())
    throw weft::SceneError(options.to, "vertices", std::to_string(to.positions.size()),
                           fmt::format("{}, as in {}", from.positions.size(), options.from));
  const bool same = std::equal(
      from.triangles.begin(), from.triangles.end(), to.triangles.begin(), to.triangles.end(),
      [](const weft::Tri& a, const weft::Tri& b) { return std::equal(a.v, a.v + 3, b.v); });
  if (!same)
    throw weft::SceneError(options.to, "triangles", std::to_string(to.triangles.size()),
                           "the triangles of " + options.from);
  return weft::make_swept_mesh(from.positions, to.positions, from.triangles);
}

// ------------------------------------------------------------------------------------ output
Json make_json(const Options& options, const SweptMesh& mesh, const Result& result,
               const std::optional<Reference>& reference, const std::vector<std::string>& command) {
  Json beside = nullptr;
  if (reference)
    beside = {{"method", reference->method},
              {"vf_pairs", reference->vf_pairs},
              {"ee_pairs", reference->ee_pairs},
              {"seconds", reference->seconds}};
  return {{"benchmark", "broad"},
          {"build", weft::bench::build_json()},
          {"command", command},
          {"vertex_count", mesh.positions_t0.size()},
          {"triangle_count", mesh.triangles.size()},
          {"edge_count", mesh.edges.size()},
          {"inflate", options.inflate},
          {"precision", options.precision},
          {"ranks", options.ranks},
          {"vf_pairs", result.vf_pairs},
          {"ee_pairs", result.ee_pairs},
          {"cells", result.cells},
          {"seconds", result.seconds},
          {"processor_seconds", result.processor_seconds},
          {"samples_s", result.samples},
          {"box_tests_of_ranks", result.rank_tests},
          {"imbalance", imbalance(result)},
          {"brute_force", beside}};
}

void print(const Result& result, const std::optional<Reference>& reference) {
  fmt::print("{:<16} {:>10} {:>10} {:>9} {:>10}\n", "", "vf_pairs", "ee_pairs", "cells", "seconds");
  fmt::print("{:<16} {:>10} {:>10} {:>9} {:>10.5f}\n", "spatial hash", result.vf_pairs,
             result.ee_pairs, result.cells, result.seconds);
  if (reference)
    fmt::print("{:<16} {:>10} {:>10} {:>9} {:>10.5f}\n", reference->method, reference->vf_pairs,
               reference->ee_pairs, "", reference->seconds);
  fmt::print("box tests of the busiest rank over the mean: {:.3f}\n", imbalance(result));
}

// ------------------------------------------------------------------------------------ command line
void add_options(CLI::App& app, Options& options) {
  app.add_option("T0", options.from, "Mesh at the start of the motion");
  app.add_option("T1", options.to, "The same mesh at its end");
  app.add_option("--inflate", options.inflate, "Grow every box by this on all sides [m]")
      ->check(CLI::Range(0.0, 1e30));
  app.add_option("--precision", options.precision, "float or double; default: double")
      ->check(CLI::IsMember({"float", "double"}));
  app.add_option("--ranks", options.ranks, "Threads that share the queries; default: 1")
      ->check(CLI::Range(1, 64));
  app.add_option("--repeats", options.repeats, "Searches that are timed; default: 5")
      ->check(CLI::Range(1, 1000000));
  app.add_option("--json", options.json, "Write all figures to this file");
  app.add_flag("--smoke", options.smoke, "Frames of its own instead of T0 and T1");
}

int run(const Options& options, const std::vector<std::string>& command) {
  if (!options.smoke && (options.from.empty() || options.to.empty()))
    throw weft::SceneError("", "T0 T1", "one frame or none", "two meshes, or --smoke");
  const SweptMesh mesh = options.smoke ? own_frames() : read_frames(options);
  const Json machine = weft::bench::machine_json();
  const Result result =
      options.precision == "float" ? measure<float>(mesh, options) : measure<double>(mesh, options);
  const std::optional<Reference> beside = reference(mesh, options.inflate);
  print(result, beside);
  if (!options.json.empty()) {
    Json json = make_json(options, mesh, result, beside, command);
    json["machine"] = machine;
    weft::write_file_atomically(options.json, json.dump(2) + "\n");
  }
  if (beside && !agree(result, *beside, options)) {
    fmt::print(stderr, "weft_bench_broad: the counts differ\n");
    return weft::bench::wrong_result;
  }
  return weft::bench::done;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("Pairs of swept boxes between two frames of a mesh", "weft_bench_broad");
  Options options;
  add_options(app, options);
  return weft::bench::bench_main(app, argc, argv, [&](const std::vector<std::string>& command) {
    return run(options, command);
  });
}
