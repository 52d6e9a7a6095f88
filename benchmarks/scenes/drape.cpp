// Whole scenes, wall time: one scene on several sets of devices, by turns, so that whatever else
// the machine does meets all of them alike. Times the steps alone, without set-up and output.
#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "benchmarks/support/bench_main.hpp"
#include "benchmarks/support/scene_settings.hpp"
#include "benchmarks/support/spread.hpp"
#include "host/base/atomic_file.hpp"
#include "host/io/mesh/mesh_file.hpp"
#include "host/io/scene/scene_file.hpp"
#include "host/lab/check/validator.hpp"
#include "weft/devices.hpp"
#include "weft/error.hpp"
#include "weft/simulation.hpp"

namespace {

using Json = nlohmann::ordered_json;
using Clock = std::chrono::steady_clock;
using weft::bench::Spread;
using weft::bench::spread_of;

struct Options {
  std::string scene = WEFT_SOURCE_DIR "/scenes/drape.json";
  std::optional<int> triangles;
  std::optional<int> frames;
  int repeats = 1;
  int check_every = 0;
  int finer = 0;
  std::vector<std::string> devices;
  std::vector<std::string> overrides;
  std::string json;
  bool smoke = false;
};

/// One run of the scene.
struct Sample {
  double setup = 0;                         ///< [s] from the scene in memory to the first step
  double wall = 0;                          ///< [s] of all steps
  double simulated = 0;                     ///< [s]
  weft::StageTimes stages;                  ///< [s] sums
  weft::CollisionTimes resolve_collisions;  ///< [s] sums
  std::int64_t steps = 0;
  std::int64_t solves = 0;
  std::int64_t iterations = 0;
  std::int64_t impacts = 0;
  std::int64_t retries = 0;
  std::int64_t rebuilds = 0;
  std::int64_t allocations = 0;       ///< in the second half of the steps
  std::int64_t synchronisations = 0;  ///< as above
  std::vector<std::size_t> peak_bytes;
  std::vector<std::vector<weft::MemoryUse>> memory;  ///< a rank
  std::uint64_t state_hash = 0;
  double wall_per_simulated() const { return wall / simulated; }
};

/// All runs on one set of devices.
struct Series {
  std::string device;
  weft::Backend backend = weft::Backend::host;
  int ranks = 0;
  std::vector<Sample> samples;                    ///< [repeats]
  std::vector<weft::lab::FrameVerdict> verdicts;  ///< of checked frames, the last one among them
  std::vector<weft::Frame> frames;                ///< checked ones
};

/// How far a run is from the same with shorter steps, at one instant.
struct StepError {
  double time = 0;  ///< [s]
  double mean = 0;  ///< [m] root mean square over the cloths' vertices
  double max = 0;   ///< [m]
};

template <class Value>
Spread spread_of(const Series& series, Value value) {
  std::vector<double> values;
  for (const Sample& sample : series.samples) values.push_back(value(sample));
  return spread_of(std::move(values));
}

/// Wall time of the first series over that of `series`, repeat by repeat.
Spread speed_up(const Series& first, const Series& series) {
  std::vector<double> ratios;
  for (std::size_t k = 0; k < series.samples.size(); ++k)
    ratios.push_back(first.samples[k].wall / series.samples[k].wall);
  return spread_of(std::move(ratios));
}

double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

/// The meshes of a frame's cloths or obstacles as one.
template <class Body>
weft::Mesh joined(const std::vector<Body>& bodies,
                  const std::vector<std::vector<weft::Vec3<double>>>& positions) {
  std::vector<weft::io::NamedMesh> meshes;
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    meshes.push_back({bodies[i].name, bodies[i].mesh});
    meshes.back().mesh.positions = positions[i];
  }
  return weft::io::joined(meshes);
}

weft::lab::FrameVerdict validate_frame(const weft::Scene& scene, const weft::Frame& frame) {
  const weft::Mesh cloth = joined(scene.cloths, frame.cloth_positions);
  weft::Mesh obstacle = joined(scene.obstacles, frame.obstacle_positions);
  obstacle.material.clear();
  obstacle.material_triangles.clear();
  weft::lab::ValidatorOptions options;
  options.sewn = !scene.seams.empty();
  options.threads = static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
  return weft::lab::validate(cloth, scene.obstacles.empty() ? nullptr : &obstacle, options);
}

/// At the end of a frame: checks and keeps it, if it is the last one or `every` divides its number.
void validate_if_due(const weft::Simulation& simulation, Series& series, int every) {
  const int number = simulation.frame_number();
  const bool last = number == simulation.scene().time.frames;
  if (!last && (every == 0 || number % every != 0)) return;
  series.frames.push_back(simulation.frame());
  series.verdicts.push_back(validate_frame(simulation.scene(), series.frames.back()));
}

/// Runs the scene to its last frame.
/// @param checked also checks and keeps the last frame, and those whose number `every` divides
/// @throws SimulationError if a step fails
Sample run_once(const weft::Scene& scene, Series& series, bool judged, int every) {
  weft::DeviceSet devices = weft::parse_devices(series.device);
  series.backend = devices.backend();
  series.ranks = devices.size();
  const auto begin = Clock::now();
  weft::Simulation simulation(scene, std::move(devices));
  Sample sample;
  sample.setup = seconds_since(begin);
  while (simulation.frame_number() < scene.time.frames) {
    const auto start = Clock::now();
    const weft::StepReport report = simulation.step();
    sample.wall += seconds_since(start);
    if (report.failure != weft::Failure::none)
      throw weft::SimulationError(fmt::format("{}: step {}: {}: {}", series.device, report.number,
                                              describe(report.failure), report.failure_detail));
    sample.stages += report.stages;
    sample.resolve_collisions.detection += report.resolve_collisions.detection;
    sample.resolve_collisions.searches += report.resolve_collisions.searches;
    sample.resolve_collisions.solves += report.resolve_collisions.solves;
    sample.resolve_collisions.zones += report.resolve_collisions.zones;
    sample.solves += report.solves;
    sample.iterations += report.iterations;
    sample.impacts += report.impacts;
    sample.retries += report.retries;
    sample.rebuilds += report.rebuilds;
    if (2 * simulation.frame_number() >= scene.time.frames) {
      sample.allocations += report.allocations;
      sample.synchronisations += report.synchronisations;
    }
    if (judged && simulation.at_frame_end()) validate_if_due(simulation, series, every);
  }
  sample.steps = simulation.step_number();
  sample.simulated = simulation.time();
  sample.peak_bytes = simulation.peak_device_bytes();
  sample.memory = simulation.device_memory();
  sample.state_hash = simulation.state_hash();
  return sample;
}

/// All series by turns; each repeat begins with another one.
std::vector<Series> run_all(const weft::Scene& scene, const Options& options) {
  std::vector<Series> all;
  for (const std::string& device : options.devices) {
    all.emplace_back();
    all.back().device = device;
  }
  for (int repeat = 0; repeat < options.repeats; ++repeat)
    for (std::size_t k = 0; k < all.size(); ++k) {
      Series& series = all[(k + static_cast<std::size_t>(repeat)) % all.size()];
      series.samples.push_back(
          run_once(scene, series, repeat + 1 == options.repeats, options.check_every));
      fmt::print("repeat {} of {}, {}: {:.3f} wall s per simulated s\n", repeat + 1,
                 options.repeats, series.device, series.samples.back().wall_per_simulated());
      std::fflush(stdout);
    }
  return all;
}

std::string hash_text(std::uint64_t hash) {
  return fmt::format("{:016x}", hash);
}

/// Every run must end in the bits of the first run on devices of its kind; says which do not.
bool hashes_agree(const std::vector<Series>& all) {
  bool agree = true;
  for (const Series& series : all) {
    const auto first = std::find_if(all.begin(), all.end(), [&](const Series& other) {
      return other.backend == series.backend;
    });
    const std::uint64_t expected = first->samples.front().state_hash;
    for (const Sample& sample : series.samples) {
      if (sample.state_hash == expected) continue;
      agree = false;
      fmt::print(stderr, "weft_bench_drape: state {} on {}, {} on {}\n", hash_text(expected),
                 first->device, hash_text(sample.state_hash), series.device);
    }
  }
  return agree;
}

std::int64_t intersections(const Series& series) {
  std::int64_t count = 0;
  for (const weft::lab::FrameVerdict& v : series.verdicts)
    count += v.cloth_cloth_count + v.cloth_obstacle_count;
  return count;
}

/// Distance of the first series' checked frames from those of steps `finer` times as short.
std::vector<StepError> step_errors(weft::Scene scene, const Series& series,
                                   const Options& options) {
  scene.time.step /= options.finer;
  Series fine;
  fine.device = series.device;
  run_once(scene, fine, true, options.check_every);
  std::vector<StepError> errors;
  for (std::size_t k = 0; k < series.frames.size(); ++k) {
    const weft::Frame& a = series.frames[k];
    const weft::Frame& b = fine.frames[k];
    StepError error;
    error.time = a.time;
    double sum_sq = 0;
    std::size_t count = 0;
    for (std::size_t c = 0; c < a.cloth_positions.size(); ++c)
      for (std::size_t v = 0; v < a.cloth_positions[c].size(); ++v, ++count) {
        const double d = length(a.cloth_positions[c][v] - b.cloth_positions[c][v]);
        sum_sq += d * d;
        error.max = std::max(error.max, d);
      }
    error.mean = std::sqrt(sum_sq / static_cast<double>(std::max<std::size_t>(1, count)));
    errors.push_back(error);
    fmt::print("{:.3f} s: {:.3g} m from steps of 1/{}, at most {:.3g} m\n", error.time, error.mean,
               options.finer, error.max);
  }
  return errors;
}

double per_step(const Sample& sample, std::int64_t count) {
  return sample.steps > 0 ? static_cast<double>(count) / static_cast<double>(sample.steps) : 0;
}

/// Stages summed over all repeats. [s]
weft::StageTimes stages_of(const Series& series) {
  weft::StageTimes stages;
  for (const Sample& sample : series.samples) stages += sample.stages;
  return stages;
}

void print_table(const std::vector<Series>& all) {
  fmt::print("\n{:<10} {:>9} {:>9} {:>9} {:>9}   {:>8} {:>8} {:>8} {:>8} {:>8} {:>11}\n", "device",
             "wall/sim", "min", "max", "speed-up", "contacts", "assemble", "solve", "certify",
             "other", "iter/step");
  for (const Series& series : all) {
    const Spread wall = spread_of(series, [](const Sample& s) { return s.wall_per_simulated(); });
    const weft::StageTimes stages = stages_of(series);
    const auto share = [&](double stage) {
      return stages.total() > 0 ? 100 * stage / stages.total() : 0;
    };
    const Sample& sample = series.samples.front();
    fmt::print(
        "{:<10} {:>9.3f} {:>9.3f} {:>9.3f} {:>9.2f}   {:>7.1f}% {:>7.1f}% {:>7.1f}% "
        "{:>7.1f}% {:>7.1f}% {:>11.1f}\n",
        series.device, wall.median, wall.min, wall.max, speed_up(all.front(), series).median,
        share(stages.contacts), share(stages.assemble), share(stages.solve),
        share(stages.resolve_collisions), share(stages.other), per_step(sample, sample.iterations));
  }
  for (const Series& series : all)
    fmt::print("{}: state {}, {} intersections in {} frames\n", series.device,
               hash_text(series.samples.front().state_hash), intersections(series),
               series.verdicts.size());
}

// ------------------------------------------------------------------------------------ JSON
Json to_json(const weft::StageTimes& stages) {
  return {{"contacts", stages.contacts * 1e3},
          {"assemble", stages.assemble * 1e3},
          {"solve", stages.solve * 1e3},
          {"certify", stages.resolve_collisions * 1e3},
          {"other", stages.other * 1e3}};
}

Json to_json(const weft::CollisionTimes& times) {
  return {{"detection", times.detection * 1e3},
          {"searches", times.searches * 1e3},
          {"solves", times.solves * 1e3},
          {"zones", times.zones * 1e3}};
}

/// A rank an object: what its memory is for, and most bytes of each.
Json memory_json(const Sample& s) {
  Json ranks = Json::array();
  for (const auto& uses : s.memory) {
    Json rank = Json::object();
    for (const weft::MemoryUse& use : uses) rank[use.name] = use.peak_bytes;
    ranks.push_back(rank);
  }
  return ranks;
}

Json to_json(const Sample& s) {
  return {{"setup_s", s.setup},
          {"wall_s", s.wall},
          {"simulated_s", s.simulated},
          {"wall_s_per_simulated_s", s.wall_per_simulated()},
          {"steps", s.steps},
          {"stages_ms", to_json(s.stages)},
          {"certify_ms", to_json(s.resolve_collisions)},
          {"solves", s.solves},
          {"iterations", s.iterations},
          {"iterations_per_step", per_step(s, s.iterations)},
          {"impacts", s.impacts},
          {"retries", s.retries},
          {"rebuilds", s.rebuilds},
          {"allocations_in_second_half", s.allocations},
          {"synchronisations_in_second_half", s.synchronisations},
          {"peak_device_bytes", s.peak_bytes},
          {"peak_device_bytes_by_use", memory_json(s)},
          {"state_hash", hash_text(s.state_hash)}};
}

Json to_json(const Series& series, const Series& first) {
  Json samples = Json::array();
  for (const Sample& sample : series.samples) samples.push_back(to_json(sample));
  const weft::StageTimes stages = stages_of(series);
  Json shares = Json::object();
  const Json sums = to_json(stages);
  for (const auto& [name, ms] : sums.items())
    shares[name] = stages.total() > 0 ? ms.get<double>() / (stages.total() * 1e3) : 0.0;
  Json frames = Json::array();
  for (std::size_t k = 0; k < series.verdicts.size(); ++k) {
    const weft::lab::FrameVerdict& v = series.verdicts[k];
    frames.push_back({{"frame", series.frames[k].number},
                      {"clean", v.clean()},
                      {"intersections", v.cloth_cloth_count + v.cloth_obstacle_count},
                      {"inverted", v.inverted.count},
                      {"degenerate", v.degenerate.count},
                      {"nonfinite", v.nonfinite.count}});
  }
  return {{"device", series.device},
          {"backend", series.backend == weft::Backend::host ? "host" : "cuda"},
          {"ranks", series.ranks},
          {"wall_s_per_simulated_s",
           to_json(spread_of(series, [](const Sample& s) { return s.wall_per_simulated(); }))},
          {"speed_up_over_first", to_json(speed_up(first, series))},
          {"stage_shares", shares},
          {"frames_judged", frames},
          {"samples", samples}};
}

Json make_json(const weft::io::SceneFile& file, const Options& options,
               const std::vector<std::string>& command, const std::vector<Series>& all, bool agree,
               const std::vector<StepError>& errors) {
  std::size_t vertices = 0;
  std::size_t triangles = 0;
  for (const weft::Cloth& cloth : file.scene.cloths) {
    vertices += cloth.mesh.positions.size();
    triangles += cloth.mesh.triangles.size();
  }
  Json series = Json::array();
  for (const Series& s : all) series.push_back(to_json(s, all.front()));
  Json distances = Json::array();
  for (const StepError& e : errors)
    distances.push_back({{"time_s", e.time}, {"rms_m", e.mean}, {"max_m", e.max}});
  return {{"benchmark", "drape"},
          {"build", weft::bench::build_json()},
          {"command", command},
          {"scene", file.scene.name},
          {"vertex_count", vertices},
          {"triangle_count", triangles},
          {"frames", file.scene.time.frames},
          {"repeats", options.repeats},
          {"hashes_agree", agree},
          {"series", series},
          {"finer_steps", options.finer},
          {"distance_from_finer_steps", distances},
          {"resolved_scene", weft::bench::without_folders(file.resolved)}};
}

// ------------------------------------------------------------------------------------ command line
void add_options(CLI::App& app, Options& options) {
  app.add_option("--triangles", options.triangles,
                 "Triangles that the scene's grids aim at; default: 20000, or the scene's own if "
                 "--scene is given")
      ->check(CLI::Range(100, 40000000));
  app.add_option("--frames", options.frames,
                 "Frames to simulate; default: 25, or the scene's own if --scene is given")
      ->check(CLI::Range(1, 1000000));
  app.add_option("--device", options.devices,
                 "cpu:N, cuda:0,1, ...; may be repeated; default: cpu:1 and cpu:2")
      ->allow_extra_args(false);
  app.add_option("--repeats", options.repeats, "Runs on each device, by turns")
      ->check(CLI::Range(1, 1000000));
  app.add_option("--check-every", options.check_every,
                 "Check every so many frames; the last one is checked in any case")
      ->check(CLI::Range(1, 1000000));
  app.add_option(
         "--finer", options.finer,
         "Also run the first device with steps so many times as short, and tell how far the "
         "checked frames are from each other")
      ->check(CLI::Range(2, 64));
  app.add_option("--scene", options.scene, "Scene file; default: scenes/drape.json");
  app.add_option("--set", options.overrides, "Override a value of the scene; may be repeated")
      ->type_name("PATH=VALUE")
      ->allow_extra_args(false);
  app.add_option("--json", options.json, "Write all figures to this file");
  app.add_flag("--smoke", options.smoke, "500 triangles, 2 frames, unless given");
}

int run(const CLI::App& app, Options options, const std::vector<std::string>& command) {
  if (options.devices.empty()) options.devices = {"cpu:1", "cpu:2"};
  if (!options.triangles && options.smoke) options.triangles = 500;
  if (!options.triangles && app.count("--scene") == 0) options.triangles = 20000;
  if (!options.frames && options.smoke) options.frames = 2;
  if (!options.frames && app.count("--scene") == 0) options.frames = 25;
  std::vector<std::string> overrides = options.overrides;
  if (options.triangles) overrides.push_back(fmt::format("triangles={}", *options.triangles));
  if (options.frames) overrides.push_back(fmt::format("time.frames={}", *options.frames));

  const weft::io::SceneFile file = weft::bench::read_scene_file(options.scene, overrides);
  Json machine = weft::bench::machine_json();
  machine["devices"] = weft::describe_devices();
  const std::vector<Series> all = run_all(file.scene, options);
  print_table(all);
  const bool agree = hashes_agree(all);
  std::vector<StepError> errors;
  if (options.finer > 1) errors = step_errors(file.scene, all.front(), options);
  if (!options.json.empty()) {
    Json json = make_json(file, options, command, all, agree, errors);
    json["machine"] = machine;
    weft::write_file_atomically(options.json, json.dump(2) + "\n");
  }
  return agree ? weft::bench::done : weft::bench::wrong_result;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("Wall time of a scene on several sets of devices", "weft_bench_drape");
  Options options;
  add_options(app, options);
  return weft::bench::bench_main(app, argc, argv, [&](const std::vector<std::string>& command) {
    return run(app, options, command);
  });
}
