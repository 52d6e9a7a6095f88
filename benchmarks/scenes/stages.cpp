// Stages of the implicit step alone, on several sets of devices: assembly (P-Cloth Fig. 7), and
// what finds collisions (Fig. 10) and parts them. A scene goes to some state once, or a checkpoint
// has it; every set then does the step from that very state over and over, and no stage begins
// before all ranks are through with the one before. Each of these steps searches pairs again.
#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include <chrono>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "benchmarks/support/bench_main.hpp"
#include "benchmarks/support/scene_settings.hpp"
#include "benchmarks/support/spread.hpp"
#include "host/base/atomic_file.hpp"
#include "host/base/scratch_folder.hpp"
#include "host/implicit/step.hpp"
#include "host/io/scene/scene_file.hpp"
#include "host/scene/frame_steps.hpp"
#include "host/scene/seams/sewing.hpp"
#include "host/state/checkpoint.hpp"
#include "host/state/store.hpp"
#include "host/untangle/untangle_scene.hpp"
#include "weft/devices.hpp"
#include "weft/error.hpp"
#include "weft/simulation.hpp"

namespace {

using Json = nlohmann::ordered_json;
using Clock = std::chrono::steady_clock;
using weft::bench::Spread;
using weft::bench::spread_of;
using weft::bench::to_json;

struct Options {
  std::string scene = WEFT_SOURCE_DIR "/scenes/sphere.json";
  std::vector<std::string> overrides;
  std::vector<std::string> devices;
  std::string state_device;  ///< empty: the first of `devices`
  std::optional<int> steps;  ///< to the state
  std::string resume;        ///< checkpoint of the state; empty: none
  std::string save;          ///< where the state's checkpoint is kept; empty: nowhere
  std::optional<int> repeats;
  std::optional<int> warm_ups;
  std::string json;
  bool smoke = false;
};

/// What is timed of a step. [s]
struct Stage {
  const char* name;
  double (*seconds)(const weft::StepReport&);
};

constexpr Stage stages[] = {
    // The matrix of the first solve, its right-hand side and its preconditioner
    {"assembly", [](const weft::StepReport& r) { return r.stages.assemble; }},
    // Broad phase, proximities, their exchange
    {"contacts", [](const weft::StepReport& r) { return r.stages.contacts; }},
    // Broad phases that had to be repeated after a solve
    {"searches", [](const weft::StepReport& r) { return r.resolve_collisions.searches; }},
    // Continuous detection, in all rounds
    {"detection", [](const weft::StepReport& r) { return r.resolve_collisions.detection; }},
    // The last three: all that looks for collisions
    {"collisions",
     [](const weft::StepReport& r) {
       return r.stages.contacts + r.resolve_collisions.searches + r.resolve_collisions.detection;
     }},
    // Impact zones, and their outcome to all ranks
    {"zones", [](const weft::StepReport& r) { return r.resolve_collisions.zones; }},
    // Linear solves, those that contacts repeat as well
    {"solves",
     [](const weft::StepReport& r) { return r.stages.solve + r.resolve_collisions.solves; }},
    {"step", [](const weft::StepReport& r) { return r.stages.total(); }},
};

/// Where every step starts from.
struct State {
  weft::Sewing sewing;
  std::int64_t step_number = 0;
  double time = 0;  ///< [s]
  std::uint64_t hash = 0;
};

struct Sample {
  weft::StepReport report;
  std::uint64_t hash = 0;  ///< of the state after the step
};

/// All repeats on one set of devices.
struct Series {
  std::string device;
  weft::Backend backend = weft::Backend::host;
  int ranks = 0;
  double setup = 0;  ///< [s] of the set, without the model, which is made once
  std::vector<Sample> samples;
  std::vector<std::size_t> peak_bytes;               ///< [ranks]
  std::vector<std::vector<weft::MemoryUse>> memory;  ///< [ranks]
};

double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

std::string hash_text(std::uint64_t hash) {
  return fmt::format("{:016x}", hash);
}

/// @throws SimulationError if it failed
void expect_good(const weft::StepReport& report, const std::string& device) {
  if (report.failure != weft::Failure::none)
    throw weft::SimulationError(fmt::format("{}: step {}: {}: {}", device, report.number,
                                            describe(report.failure), report.failure_detail));
}

/// @throws SceneError unless every step is one ImplicitStep on the scene's own meshes
void refuse_other_steps(const weft::Scene& scene) {
  if (scene.method != "implicit")
    throw weft::SceneError(scene.file, "method.type", "\"" + scene.method + "\"", "\"implicit\"");
  if (scene.implicit.sleep_distance > 0)
    throw weft::SceneError(scene.file, "method.implicit.sleep_distance",
                           fmt::format("{}", scene.implicit.sleep_distance),
                           "0 where stages are timed: then all cloth takes part");
  if (scene.refinement.when != weft::Refinement::When::never)
    throw weft::SceneError(scene.file, "refine", "a mesh that is refined on the way",
                           "none where stages are timed");
}

/// Simulates the scene to the state, and writes its checkpoint.
void make_state(const weft::Scene& scene, const Options& options, int steps,
                const std::filesystem::path& file) {
  const auto start = Clock::now();
  weft::Simulation simulation(scene, weft::parse_devices(options.state_device));
  const double setup = seconds_since(start);
  for (int k = 0; k < steps; ++k) expect_good(simulation.step(), options.state_device);
  simulation.save(file, false);
  fmt::print("{} steps on {}: {:.1f} s, set-up {:.1f} s\n", steps, options.state_device,
             seconds_since(start) - setup, setup);
  std::fflush(stdout);
}

/// Does the step from `state` again and again.
template <class T>
Series measure(const weft::Scene& scene, const weft::Model& model,
               const weft::StateSnapshot<T>& state, const std::string& device,
               const Options& options) {
  weft::DeviceSet devices = weft::parse_devices(device);
  const auto start = Clock::now();
  weft::Store<T> store(scene, devices, model);
  weft::ImplicitStep<T> step(store);
  step.time_apart(true);
  step.search_every_step(true);
  Series series{device, devices.backend(), devices.size(), seconds_since(start), {}, {}, {}};
  for (int k = 0; k < *options.warm_ups + *options.repeats; ++k) {
    store.restore(state);
    Sample sample;
    sample.report.number = state.step_number + 1;
    step.advance(weft::frame_step_length(scene.time), sample.report);
    expect_good(sample.report, device);
    if (k < *options.warm_ups) continue;
    sample.hash = weft::hash_state(store.model(), store.snapshot());
    series.samples.push_back(std::move(sample));
  }
  for (int r = 0; r < devices.size(); ++r) {
    series.peak_bytes.push_back(devices[r].peak_bytes());
    series.memory.push_back(devices[r].memory_use());
  }
  return series;
}

/// @param file  checkpoint of the state
/// @param state receives what it is
/// @param keep  called after each set with all series so far
template <class T>
std::vector<Series> measure_all(const weft::Scene& scene, const std::filesystem::path& file,
                                const Options& options, State& state,
                                const std::function<void(const std::vector<Series>&)>& keep) {
  const weft::Model model = weft::make_model(scene, state.sewing.welded);
  weft::DeviceSet host = weft::host_devices(1);
  weft::StateSnapshot<T> snapshot = weft::Store<T>(scene, host, model).snapshot();
  weft::read_checkpoint(file, scene, model, snapshot);
  state.step_number = snapshot.step_number;
  state.time = snapshot.time;
  state.hash = weft::hash_state(model, snapshot);
  std::vector<Series> all;
  for (const std::string& device : options.devices) {
    all.push_back(measure<T>(scene, model, snapshot, device, options));
    fmt::print("{}: {} steps, set-up {:.1f} s\n", device, *options.warm_ups + *options.repeats,
               all.back().setup);
    std::fflush(stdout);
    keep(all);
  }
  return all;
}

// ------------------------------------------------------------------------------------ results
Spread times_of(const Series& series, const Stage& stage) {
  std::vector<double> ms;
  for (const Sample& sample : series.samples) ms.push_back(1e3 * stage.seconds(sample.report));
  return spread_of(std::move(ms));
}

/// Median of the first set over that of `series`; none where a stage had nothing to do.
std::optional<double> speed_up(const Series& first, const Series& series, const Stage& stage) {
  const double of_first = times_of(first, stage).median, here = times_of(series, stage).median;
  if (of_first <= 0 || here <= 0) return std::nullopt;
  return of_first / here;
}

/// The first sample on devices of the series' kind.
const Sample& expected_of(const std::vector<Series>& all, const Series& series) {
  for (const Series& other : all)
    if (other.backend == series.backend) return other.samples.front();
  return series.samples.front();
}

/// Whether every step ends in the bits of the first on devices of its kind.
bool hashes_agree(const std::vector<Series>& all) {
  bool agree = true;
  for (const Series& series : all)
    for (const Sample& sample : series.samples)
      agree = agree && sample.hash == expected_of(all, series).hash;
  return agree;
}

Json counts_json(const weft::StepReport& r) {
  return {{"contacts", r.proximities},
          {"face_pairs", r.face_pairs},
          {"edge_pairs", r.edge_pairs},
          {"ccd_tests", r.ccd_tests},
          {"impacts", r.impacts},
          {"zones", r.zones},
          {"zone_largest", r.zone_largest},
          {"zone_rounds", r.zone_rounds},
          {"broad_phases", r.searches},
          {"repeated_searches", r.rebuilds},
          {"solves", r.solves},
          {"iterations", r.iterations},
          {"retries", r.retries}};
}

Json to_json(const Sample& sample) {
  Json ms = Json::object();
  for (const Stage& stage : stages) ms[stage.name] = 1e3 * stage.seconds(sample.report);
  return {
      {"ms", ms}, {"counts", counts_json(sample.report)}, {"state_hash", hash_text(sample.hash)}};
}

/// A rank an object: what its memory is for, and most bytes of each.
Json memory_json(const Series& series) {
  Json ranks = Json::array();
  for (const auto& uses : series.memory) {
    Json rank = Json::object();
    for (const weft::MemoryUse& use : uses) rank[use.name] = use.peak_bytes;
    ranks.push_back(rank);
  }
  return ranks;
}

Json to_json(const Series& series, const Series& first) {
  Json times = Json::object();
  for (const Stage& stage : stages) {
    const std::optional<double> faster = speed_up(first, series, stage);
    times[stage.name] = {{"ms", to_json(times_of(series, stage))},
                         {"speed_up_over_first", faster ? Json(*faster) : Json()}};
  }
  weft::BalanceReport balance;
  Json samples = Json::array();
  for (const Sample& sample : series.samples) {
    balance += sample.report.balance;
    samples.push_back(to_json(sample));
  }
  return {{"device", series.device},
          {"backend", series.backend == weft::Backend::host ? "host" : "cuda"},
          {"ranks", series.ranks},
          {"setup_s", series.setup},
          {"stages", times},
          {"counts", counts_json(series.samples.back().report)},
          {"busiest_over_even",
           {{"rows", balance.rows.imbalance()}, {"queries", balance.queries.imbalance()}}},
          {"peak_device_bytes", series.peak_bytes},
          {"peak_device_bytes_by_use", memory_json(series)},
          {"samples", samples}};
}

Json make_json(const weft::io::SceneFile& file, const Options& options,
               const std::vector<std::string>& command, const State& state,
               const std::vector<Series>& all) {
  std::size_t vertices = 0, triangles = 0;
  for (const weft::Cloth& cloth : file.scene.cloths) {
    vertices += cloth.mesh.positions.size();
    triangles += cloth.mesh.triangles.size();
  }
  Json series = Json::array();
  for (const Series& s : all) series.push_back(to_json(s, all.front()));
  return {{"benchmark", "stages"},
          {"build", weft::bench::build_json()},
          {"command", command},
          {"scene", file.scene.name},
          {"vertex_count", vertices},
          {"triangle_count", triangles},
          {"state",
           {{"step", state.step_number},
            {"time_s", state.time},
            {"made_on", options.resume.empty() ? Json(options.state_device) : Json()},
            {"state_hash", hash_text(state.hash)}}},
          {"repeats", *options.repeats},
          {"warm_ups", *options.warm_ups},
          {"hashes_agree", hashes_agree(all)},
          {"series", series},
          {"resolved_scene", weft::bench::without_folders(file.resolved)}};
}

void print_table(const State& state, const std::vector<Series>& all) {
  fmt::print("\nfrom step {}, {:.4g} s, state {}\n{:<11} {:<16} {:>10} {:>10} {:>10} {:>8}\n",
             state.step_number, state.time, hash_text(state.hash), "stage, ms", "device", "median",
             "min", "max", "speed-up");
  for (const Stage& stage : stages)
    for (const Series& series : all) {
      const Spread ms = times_of(series, stage);
      const std::optional<double> faster = speed_up(all.front(), series, stage);
      fmt::print("{:<11} {:<16} {:>10.3f} {:>10.3f} {:>10.3f} {:>8}\n", stage.name, series.device,
                 ms.median, ms.min, ms.max, faster ? fmt::format("{:.2f}", *faster) : "-");
    }
  for (const Series& series : all) {
    const Sample& last = series.samples.back();
    const weft::StepReport& r = last.report;
    fmt::print(
        "{}: state {}, {} contacts, {} pairs, {} detected, {} impacts in {} rounds of zones; "
        "bytes:",
        series.device, hash_text(last.hash), r.proximities, r.face_pairs + r.edge_pairs,
        r.ccd_tests, r.impacts, r.zone_rounds);
    for (const std::size_t bytes : series.peak_bytes) fmt::print(" {}", bytes);
    fmt::print("\n");
  }
}

// ------------------------------------------------------------------------------------ command line
void add_options(CLI::App& app, Options& options) {
  app.add_option("--scene", options.scene, "Scene file; default: scenes/sphere.json");
  app.add_option("--set", options.overrides, "Override a value of the scene; may be repeated")
      ->type_name("PATH=VALUE")
      ->allow_extra_args(false);
  app.add_option("--device", options.devices,
                 "cpu:N, cuda:0,1, ...; may be repeated; default: cpu:1 and cpu:2")
      ->allow_extra_args(false);
  CLI::Option* steps =
      app.add_option("--steps", options.steps, "Steps to the state that is measured; default: 100")
          ->check(CLI::Range(0, 1000000));
  CLI::Option* made_on =
      app.add_option("--state-device", options.state_device,
                     "Devices that take these steps; default: the first --device");
  CLI::Option* save =
      app.add_option("--save", options.save, "Keep the checkpoint of that state in this file");
  app.add_option("--resume", options.resume, "Take the state from this checkpoint of the scene")
      ->excludes(steps)
      ->excludes(made_on)
      ->excludes(save);
  app.add_option("--repeats", options.repeats, "Steps on each set that count; default: 7")
      ->check(CLI::Range(1, 100000));
  app.add_option("--warm-ups", options.warm_ups,
                 "Steps on each set before these, in which memory is got and ranks share work out; "
                 "default: 3")
      ->check(CLI::Range(0, 100000));
  app.add_option("--json", options.json, "Write all figures to this file");
  app.add_flag("--smoke", options.smoke,
               "1,000 triangles unless --scene is given; cpu:1, cpu:2 and cpu:3, 1 warm-up and 2 "
               "repeats, unless given");
}

/// What is not given.
void fill_in(const CLI::App& app, Options& options) {
  if (options.smoke && app.count("--scene") == 0)
    options.overrides.insert(options.overrides.begin(), "triangles=1000");
  if (options.devices.empty()) options.devices = {"cpu:1", "cpu:2"};
  if (options.smoke && app.count("--device") == 0) options.devices.push_back("cpu:3");
  if (!options.repeats) options.repeats = options.smoke ? 2 : 7;
  if (!options.warm_ups) options.warm_ups = options.smoke ? 1 : 3;
  if (options.state_device.empty()) options.state_device = options.devices.front();
}

int run(const CLI::App& app, Options options, const std::vector<std::string>& command) {
  fill_in(app, options);
  for (const std::string& device : options.devices) weft::parse_devices(device);
  weft::parse_devices(options.state_device);
  weft::io::SceneFile file = weft::bench::read_scene_file(options.scene, options.overrides);
  refuse_other_steps(file.scene);
  Json machine = weft::bench::machine_json();
  machine["devices"] = weft::describe_devices();
  const weft::ScratchFolder scratch;
  std::filesystem::path checkpoint = options.resume;
  if (options.resume.empty()) {
    checkpoint =
        options.save.empty() ? scratch / "checkpoint" : std::filesystem::path(options.save);
    make_state(file.scene, options, options.steps.value_or(100), checkpoint);
  }
  State state;
  const weft::Sewing start = weft::sewing_at_start(file.scene);
  if (file.scene.contact.untangle) weft::untangle_start(file.scene, start.welded);
  state.sewing = weft::read_sewing(checkpoint, start.welded.size(), file.scene.seams.size());
  const auto measure = file.scene.precision == weft::Precision::single_precision
                           ? measure_all<float>
                           : measure_all<double>;
  const std::vector<Series> all =
      measure(file.scene, checkpoint, options, state, [&](const std::vector<Series>& so_far) {
        if (options.json.empty()) return;
        Json json = make_json(file, options, command, state, so_far);
        json["machine"] = machine;
        weft::write_file_atomically(options.json, json.dump(2) + "\n");
      });
  print_table(state, all);
  if (hashes_agree(all)) return weft::bench::done;
  fmt::print(stderr, "weft_bench_stages: the same step has ended in different states\n");
  return weft::bench::wrong_result;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("Stages of the implicit step alone, on several sets of devices",
               "weft_bench_stages");
  Options options;
  add_options(app, options);
  return weft::bench::bench_main(app, argc, argv, [&](const std::vector<std::string>& command) {
    return run(app, options, command);
  });
}
