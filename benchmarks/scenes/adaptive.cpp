// Adaptive meshes, with and without a camera, against those that a scene was given: faces,
// vertices, seconds a frame, and what of them is remeshing. Also takes scenes of ARCSim; --arcsim
// runs three of those that come with it and says how long ARCSim 0.2.1 took.
#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <ctime>
#include <exception>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "benchmarks/support/provenance.hpp"
#include "host/io/scene_file.hpp"
#include "host/scene/atomic_file.hpp"
#include "weft/devices.hpp"
#include "weft/error.hpp"
#include "weft/simulation.hpp"

namespace {

using Json = nlohmann::ordered_json;
using Clock = std::chrono::steady_clock;

enum ExitCode { done = 0, bad_input = 2, simulation_failed = 4 };

struct Options {
  std::string scene = WEFT_SOURCE_DIR "/scenes/drape.json";
  std::optional<int> frames;
  std::vector<std::string> methods{"implicit", "adaptive", "view"};
  std::string arcsim;  ///< folder of ARCSim's scene files; empty: none
  std::string device = "cpu:1";
  std::vector<std::string> overrides;
  std::string json;
  bool smoke = false;
};

/// Least, greatest and mean over the frames.
struct Range {
  double min = 0, max = 0, mean = 0;
};

Range range_of(const std::vector<double>& values) {
  Range r;
  if (values.empty()) return r;
  const auto [low, high] = std::minmax_element(values.begin(), values.end());
  r.min = *low;
  r.max = *high;
  for (const double value : values) r.mean += value / static_cast<double>(values.size());
  return r;
}

Json to_json(const Range& r) {
  return {{"min", r.min}, {"max", r.max}, {"mean", r.mean}};
}

/// One run of the scene by one method.
struct Result {
  std::string method;
  std::string failure;        ///< empty: none
  std::vector<double> faces;  ///< [frames]
  std::vector<double> vertices;
  std::vector<double> wall;         ///< [s]
  std::vector<double> cpu;          ///< [s] of all threads
  double remeshing = 0;             ///< [s] wall, in all
  double rebuilding = 0;            ///< [s] of these: making the model anew
  std::vector<double> view_factor;  ///< [frames] mean; empty: no camera
  double energy_jump = 0;           ///< [J] the largest
  double peak_kinetic = 0;          ///< [J] at frames
  std::uint64_t state_hash = 0;
};

double cpu_seconds() {
  return static_cast<double>(std::clock()) / CLOCKS_PER_SEC;
}

Result run(const Options& options, const std::string& file, std::optional<int> frame_count,
           const std::string& method) {
  std::vector<std::string> overrides = options.overrides;
  overrides.push_back("method.type=" + method);
  if (frame_count) overrides.push_back(fmt::format("time.frames={}", *frame_count));
  weft::Scene scene = weft::io::read_scene(file, overrides);
  const int frames = scene.time.frames;
  weft::Simulation simulation(std::move(scene), weft::parse_devices(options.device));
  Result result;
  result.method = method;
  while (simulation.frame_number() < frames) {
    const auto start = Clock::now();
    const double cpu = cpu_seconds();
    for (int step = 0; step < simulation.steps_per_frame(); ++step) {
      const weft::StepReport report = simulation.step();
      if (report.failure != weft::Failure::none) {
        result.failure = fmt::format("step {}: {}: {}", report.number, describe(report.failure),
                                     report.failure_detail);
        return result;
      }
      result.remeshing += report.remesh.seconds;
      result.rebuilding += report.remesh.rebuild_seconds;
      if (report.remesh.factor_mean > 0) result.view_factor.push_back(report.remesh.factor_mean);
      result.energy_jump = std::max(result.energy_jump, std::abs(report.remesh.energy_jump));
    }
    result.cpu.push_back(cpu_seconds() - cpu);
    result.wall.push_back(std::chrono::duration<double>(Clock::now() - start).count());
    result.peak_kinetic = std::max(result.peak_kinetic, simulation.energy().kinetic);
    double faces = 0, vertices = 0;
    for (const weft::Cloth& cloth : simulation.scene().cloths) {
      faces += static_cast<double>(cloth.mesh.triangles.size());
      vertices += static_cast<double>(cloth.mesh.positions.size());
    }
    result.faces.push_back(faces);
    result.vertices.push_back(vertices);
  }
  result.state_hash = simulation.state_hash();
  return result;
}

double sum(const std::vector<double>& values) {
  double total = 0;
  for (const double value : values) total += value;
  return total;
}

Json to_json(const Result& r) {
  const double wall = sum(r.wall);
  return {{"method", r.method},
          {"failure", r.failure.empty() ? Json(nullptr) : Json(r.failure)},
          {"frames", r.wall.size()},
          {"faces", to_json(range_of(r.faces))},
          {"vertices", to_json(range_of(r.vertices))},
          {"wall_s_a_frame", to_json(range_of(r.wall))},
          {"cpu_s_a_frame", to_json(range_of(r.cpu))},
          {"wall_s", wall},
          {"cpu_s", sum(r.cpu)},
          {"remeshing_share", wall > 0 ? r.remeshing / wall : 0.0},
          {"rebuilding_share", wall > 0 ? r.rebuilding / wall : 0.0},
          {"view_factor_by_frame", r.view_factor},
          {"energy_jump_share", r.peak_kinetic > 0 ? r.energy_jump / r.peak_kinetic : 0.0},
          {"faces_by_frame", r.faces},
          {"wall_s_by_frame", r.wall},
          {"cpu_s_by_frame", r.cpu},
          {"state_hash", fmt::format("{:016x}", r.state_hash)}};
}

/// A scene of ARCSim's, as far as it was timed: CPU seconds of ARCSim 0.2.1 on one thread.
struct Rival {
  const char* scene;
  int frames;
  double cpu;
};
constexpr Rival rivals[] = {
    {"sphere", 60, 89.3}, {"sphere", 20, 8.1}, {"flag", 13, 80.1}, {"dress-blue", 12, 74.0}};

void print_row(const Result& r, const Json& row) {
  const Range faces = range_of(r.faces), wall = range_of(r.wall);
  fmt::print(
      "{:<10} {:>9.0f} {:>9.0f} {:>9.0f} {:>10.4f} {:>10.4f} {:>10.3f} {:>8.1f}% {:>7.2f}%\n",
      r.method, faces.mean, faces.max, range_of(r.vertices).mean, wall.mean, wall.max, sum(r.cpu),
      100 * row["remeshing_share"].get<double>(), 100 * row["energy_jump_share"].get<double>());
  if (!r.failure.empty()) fmt::print(stderr, "weft_bench_adaptive: {}: {}\n", r.method, r.failure);
  std::fflush(stdout);
}

void print_head() {
  fmt::print("{:<10} {:>9} {:>9} {:>9} {:>10} {:>10} {:>10} {:>9} {:>8}\n", "method", "faces",
             "max", "vertices", "s/frame", "max", "cpu s", "remesh", "jump");
}

/// Rows of one scene, method by method.
Json compare(const Options& options) {
  Json rows = Json::array();
  print_head();
  for (const std::string& method : options.methods) {
    const Result r = run(options, options.scene, options.frames, method);
    rows.push_back(to_json(r));
    print_row(r, rows.back());
  }
  return rows;
}

/// Rows of ARCSim's scenes, by the method adaptive.
Json compare_with_arcsim(const Options& options) {
  Json rows = Json::array();
  print_head();
  for (const Rival& rival : rivals) {
    const std::string file = options.arcsim + "/" + rival.scene + ".json";
    const Result r = run(options, file, rival.frames, "adaptive");
    Json row = to_json(r);
    row["scene"] = rival.scene;
    row["arcsim_cpu_s"] = rival.cpu;
    row["arcsim_over_weft"] = sum(r.cpu) > 0 ? rival.cpu / sum(r.cpu) : 0.0;
    print_row(r, row);
    fmt::print("  {} {} frames: ARCSim {} s, {:.2f} times as long\n", rival.scene, rival.frames,
               rival.cpu, row["arcsim_over_weft"].get<double>());
    rows.push_back(std::move(row));
  }
  return rows;
}

int execute(const Options& options, Json machine, const std::vector<std::string>& command) {
  const Json rows = options.arcsim.empty() ? compare(options) : compare_with_arcsim(options);
  bool failed = false;
  for (const Json& row : rows) failed = failed || !row["failure"].is_null();
  const Json report{{"benchmark", "adaptive"},
                    {"build", weft::bench::build_json()},
                    {"machine", std::move(machine)},
                    {"command", command},
                    {"scene", options.arcsim.empty()
                                  ? Json(std::filesystem::path(options.scene).filename().string())
                                  : Json("ARCSim's")},
                    {"overrides", options.overrides},
                    {"device", options.device},
                    {"runs", rows}};
  if (!options.json.empty()) weft::write_file_atomically(options.json, report.dump(2) + "\n");
  return failed ? simulation_failed : done;
}

}  // namespace

int main(int argc, char** argv) {
  Options options;
  CLI::App app("Adaptive meshes against fixed ones");
  app.add_option("--scene", options.scene, "Scene file, of weft or of ARCSim");
  app.add_option("--frames", options.frames, "Instead of the scene's");
  app.add_option("--methods", options.methods, "implicit, adaptive, view")->delimiter(',');
  app.add_option("--arcsim", options.arcsim,
                 "Folder of ARCSim's conf files: run sphere, flag and dress-blue instead");
  app.add_option("--device", options.device, "As of weft run");
  app.add_option("--set", options.overrides, "Override a value of the scene")
      ->allow_extra_args(false);
  app.add_option("--json", options.json, "Write results to this file");
  app.add_flag("--smoke", options.smoke, "A small scene, a few frames");
  CLI11_PARSE(app, argc, argv);
  Json machine = weft::bench::machine_json();
  if (options.smoke) {
    options.overrides.emplace_back("triangles=800");
    if (!options.frames) options.frames = 6;
  }
  try {
    return execute(options, std::move(machine), weft::bench::command_words(argc, argv));
  } catch (const std::exception& error) {
    fmt::print(stderr, "weft_bench_adaptive: {}\n", error.what());
    return bad_input;
  }
}
