// Parallel in time, as Liang & Lin 2018 measure it: speed-up over the serial fine run against the
// bounds of eq. (11) and (16), partitions (Table 3), coarse steps (Table 8), curvature before and
// after recovery of detail (Table 4), jumps at seams, memory, and what 512 and 100,000 workers
// would do. The presets of its scenes have the triangles and steps of its Table 6.
//
// Where the curvature is compared, two more are measured: recovery from averages of the serial run
// in place of the coarse one, which is recovery by itself; and the serial run again from a start
// that is a micrometre off, nearer to which than that no other run can be expected to come.
#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "benchmarks/support/bench_main.hpp"
#include "benchmarks/support/time_parallel_accuracy.hpp"
#include "benchmarks/support/time_parallel_json.hpp"
#include "benchmarks/support/time_parallel_presets.hpp"
#include "benchmarks/support/time_parallel_runs.hpp"
#include "benchmarks/support/time_parallel_text.hpp"
#include "benchmarks/support/scene_settings.hpp"
#include "host/base/atomic_file.hpp"
#include "host/io/scene/scene_file.hpp"
#include "host/scene/frame_steps.hpp"

namespace {

namespace fs = std::filesystem;
using weft::bench::Accuracy;
using weft::bench::Folder;
using weft::bench::Json;
using weft::bench::Level;
using weft::bench::Preset;
using weft::bench::presets;
using weft::bench::print_accuracy;
using weft::bench::print_run;
using weft::bench::SlicedRun;
using weft::bench::WholeRun;

/// Steps of the serial run that are timed where it is sampled, and from how many states.
constexpr int sample_min = 200;
constexpr int sample_places = 10;
constexpr double twin_offset = 1e-6;  ///< [m]
/// Steps that are done again without other slices beside them.
constexpr int steps_alone_max = 10;

struct Options {
  std::string preset = "swing";
  std::string scene;
  std::string arcsim;
  std::vector<std::string> overrides;
  std::optional<int> frames;
  std::vector<int> workers;
  std::vector<std::string> schedules;
  std::vector<double> coarse_steps;
  int threads = 0;
  int sample = 0;
  bool from_slices = false;
  int states = 4;
  bool no_twin = false;
  bool no_runs = false;
  std::string json;
  bool smoke = false;
};

weft::Scene with_time_parallel(weft::Scene scene, double coarse_step, const std::string& schedule,
                               double ratio) {
  weft::TimeParallelSettings& settings = scene.time_parallel;
  settings.coarse_step = coarse_step;
  settings.ratio = std::max(ratio, 1.01);
  settings.slices = 0;
  settings.schedule = schedule == "uniform"    ? weft::TimeSchedule::uniform
                      : schedule == "balanced" ? weft::TimeSchedule::balanced
                                               : weft::TimeSchedule::adaptive;
  return scene;
}

/// All that is measured of one scene. The result is rewritten after each part.
class Benchmark {
 public:
  Benchmark(const Options& options, weft::io::SceneFile file, Json head)
      : options_(options), scene_(std::move(file.scene)), json_(std::move(head)) {
    json_["coarse_levels"] = Json::array();
    json_["failures"] = Json::array();
    json_["resolved_scene"] = weft::bench::without_folders(file.resolved);
  }
  int execute();

 private:
  void measure_level(double coarse_step);
  void measure_slices(double coarse_step);
  void measure_serial(const weft::TimeParallelScene& scene);
  void note_serial(const weft::TimeParallelScene& scene, const WholeRun& serial);
  Json& note_level(const Level& level, std::int64_t coarse_triangles);
  template <class Starts>
  void note_schedules(const Level& level, const Starts& starts, Json& json);
  void note_run(const Level& level, const std::string& schedule, const SlicedRun& run, Json& json);
  void note_prediction(const Level& level, Json& json);
  weft::TimeParallelScene sliced_scene(double coarse_step, const std::string& schedule,
                                       double ratio, int workers) const {
    return {with_time_parallel(scene_, coarse_step, schedule, ratio), workers};
  }
  SlicedRun run_sliced(const weft::TimeParallelScene& scene) const;
  void measure_runs(const Level& level, Json& json, bool but_first);
  void measure_accuracy(const Level& level, Json& json);
  std::set<std::int64_t> kept_steps() const;
  void write() const {
    if (!options_.json.empty()) weft::write_file_atomically(options_.json, json_.dump(2) + "\n");
  }

  const Options& options_;
  weft::Scene scene_;
  Json json_;
  Folder folder_;
  std::optional<WholeRun> serial_, twin_;
};

/// Steps of the serial run that coarse steps end at, and those one coarse step before.
std::set<std::int64_t> Benchmark::kept_steps() const {
  std::set<std::int64_t> steps;
  const std::int64_t total = std::int64_t{weft::frame_steps(scene_.time)} * scene_.time.frames;
  for (const double coarse : options_.coarse_steps) {
    weft::TimeSettings time = scene_.time;
    time.step = coarse;
    const double each = weft::frame_step_length(time) / weft::frame_step_length(scene_.time);
    if (std::abs(each - std::round(each)) > 1e-6) continue;
    const auto coarse_total = static_cast<std::int64_t>(static_cast<double>(total) / each);
    for (int k = 1; k <= options_.states; ++k) {
      const std::int64_t n = coarse_total * k / (options_.states + 1);
      if (n < 1) continue;
      steps.insert(std::llround(static_cast<double>(n) * each));
      steps.insert(std::llround(static_cast<double>(n - 1) * each));
    }
  }
  return steps;
}

void Benchmark::measure_serial(const weft::TimeParallelScene& scene) {
  if (options_.sample > 0) {
    serial_ = weft::bench::run_sampled(scene, folder_.path / "coarse", options_.sample,
                                       std::min<int>(sample_places, scene.slices()));
  } else {
    serial_ = weft::bench::run_whole(scene.fine(), kept_steps());
    if (!options_.no_twin) {
      weft::Scene other = scene.fine();
      std::size_t v = 0;
      for (weft::Cloth& cloth : other.cloths)
        for (auto& x : cloth.mesh.positions)
          x[2] += twin_offset * std::sin(12.9898 * static_cast<double>(++v));
      twin_ = weft::bench::run_whole(other, kept_steps());
    }
  }
  note_serial(scene, *serial_);
}

void Benchmark::note_serial(const weft::TimeParallelScene& scene, const WholeRun& serial) {
  const std::int64_t triangles = serial.triangles(scene.fine());
  json_["triangle_count"] = triangles;
  json_["serial"] = {{"wall_s", serial.costs.wall.back()},
                     {"work", serial.costs.work.back()},
                     {"extrapolated", serial.extrapolated},
                     {"from_slices", serial.from_slices},
                     {"steps_timed", serial.steps_timed},
                     {"steps", scene.steps()},
                     {"simulated_s", static_cast<double>(scene.steps()) *
                                         weft::frame_step_length(scene.fine().time)},
                     {"largest_frame_change_m", serial.largest_change},
                     {"device_bytes", serial.bytes},
                     {"profile", weft::bench::profile_json(serial.profile)},
                     {"state_hash", fmt::format("{:016x}", serial.state_hash)}};
  fmt::print("serial: {} triangles, {} steps, {:.2f} s{}\n", triangles, scene.steps(),
             serial.costs.wall.back(),
             serial.extrapolated  ? " (extrapolated)"
             : serial.from_slices ? " (of the steps of slices)"
                                  : "");
  write();
}

/// A level of the result, without its runs.
Json& Benchmark::note_level(const Level& level, std::int64_t coarse_triangles) {
  const weft::Scene& coarse = level.scene->coarse().scene;
  json_["coarse_levels"].push_back(
      {{"coarse_step_s", weft::frame_step_length(coarse.time)},
       {"triangles", coarse_triangles},
       {"wall_s", level.coarse.costs.wall.back()},
       {"work", level.coarse.costs.work.back()},
       {"device_bytes_over_fine",
        static_cast<double>(level.coarse.bytes) / static_cast<double>(level.fine->bytes)},
       {"profile", weft::bench::profile_json(level.coarse.profile)},
       {"ratio_by_clock", level.ratio(weft::bench::by_wall)},
       {"ratio_by_counted_work", level.ratio(weft::bench::by_work)},
       {"runs", Json::array()},
       {"accuracy", Json::array()}});
  Json& json = json_["coarse_levels"].back();
  fmt::print(
      "coarse: {} triangles, steps of {:.4f} s, {:.2f} s; K = {:.1f} by clock, {:.1f} by "
      "counted work\n",
      coarse_triangles, json["coarse_step_s"].get<double>(), level.coarse.costs.wall.back(),
      level.ratio(weft::bench::by_wall), level.ratio(weft::bench::by_work));
  write();
  return json;
}

void Benchmark::note_run(const Level& level, const std::string& schedule, const SlicedRun& run,
                         Json& json) {
  json["runs"].push_back(weft::bench::run_json(level, schedule, run));
  print_run(json["runs"].back());
  write();
}

/// What the steps that were measured come to in slices that begin as those of `starts` have.
template <class Starts>
void Benchmark::note_schedules(const Level& level, const Starts& starts, Json& json) {
  using namespace weft::bench;
  json["schedules_by_clock"] = schedules_json(level, by_wall, mean_start_cost(by_wall, starts));
  json["schedules_by_counted_work"] =
      schedules_json(level, by_work, mean_start_cost(by_work, starts));
  write();
}

/// By what recovery has cost on average.
void Benchmark::note_prediction(const Level& level, Json& json) {
  const auto mean = [&](const char* cost) {
    double sum = 0;
    int count = 0;
    for (const Json& run : json["runs"]) {
      if (run.at("slices").get<int>() < 2) continue;
      sum += run.at(cost).at("recovery_steps").get<double>();
      ++count;
    }
    return count > 0 ? sum / count : 0;
  };
  json["prediction_by_counted_work"] =
      weft::bench::prediction_json(level, weft::bench::by_work, mean("by_counted_work"));
  json["prediction_by_clock"] =
      weft::bench::prediction_json(level, weft::bench::by_wall, mean("by_clock"));
  write();
}

SlicedRun Benchmark::run_sliced(const weft::TimeParallelScene& scene) const {
  const int threads = options_.threads > 0
                          ? options_.threads
                          : static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
  return weft::bench::run_sliced(scene, std::min(scene.slices(), threads), folder_.fresh("run"));
}

/// @param but_first the first of them has been measured
void Benchmark::measure_runs(const Level& level, Json& json, bool but_first) {
  const double ratio = level.ratio(weft::bench::by_work);
  for (const std::string& schedule : options_.schedules)
    for (const int workers : options_.workers) {
      if (std::exchange(but_first, false)) continue;
      const auto scene =
          sliced_scene(level.scene->coarse().scene.time.step, schedule, ratio, workers);
      note_run(level, schedule, run_sliced(scene), json);
    }
  note_prediction(level, json);
}

void Benchmark::measure_accuracy(const Level& level, Json& json) {
  if (level.fine->extrapolated) return;
  Accuracy accuracy(level, folder_);
  const auto total =
      static_cast<std::int64_t>(static_cast<double>(level.scene->steps()) / level.steps_per_coarse);
  for (int k = 1; k <= options_.states; ++k) {
    const std::int64_t n = total * k / (options_.states + 1);
    if (n < 1) continue;
    const weft::bench::KeptState* twin = nullptr;
    if (twin_)
      if (const auto found = twin_->kept.find(accuracy.fine_step(n)); found != twin_->kept.end())
        twin = &found->second;
    const Json row = accuracy.at(n, twin);
    if (row.is_null()) continue;
    print_accuracy(row);
    json["accuracy"].push_back(row);
    write();
  }
}

void Benchmark::measure_level(double coarse_step) {
  const auto total = std::int64_t{weft::frame_steps(scene_.time)} * scene_.time.frames;
  const auto scene = sliced_scene(coarse_step, "adaptive", 100,
                                  static_cast<int>(std::min<std::int64_t>(sample_places, total)));
  Level level(scene);
  level.coarse = weft::bench::run_coarse(scene.coarse(), folder_.fresh("coarse"));
  const bool samples_here = !serial_ && options_.sample > 0;
  if (!serial_) measure_serial(scene);
  level.fine = &*serial_;
  Json& json = note_level(level, level.coarse.triangles(scene.coarse().scene));
  if (samples_here) {  // starts of other coarse levels would cost something else
    for (const weft::SliceStart& start : serial_->sampled_starts)
      json["sampled_recovery_iterations"].push_back(start.iterations);
    note_schedules(level, *serial_, json);
  }
  measure_accuracy(level, json);
  if (!options_.no_runs) measure_runs(level, json, false);
}

/// With the first run's own steps for the serial run, and what other numbers of workers would make
/// of them.
void Benchmark::measure_slices(double coarse_step) {
  const auto scene =
      sliced_scene(coarse_step, options_.schedules.front(), 100, options_.workers.front());
  Level level(scene);
  SlicedRun run = run_sliced(scene);
  level.coarse.costs = weft::bench::coarse_costs(
      run.outcome.coarse, static_cast<std::int64_t>(std::ceil(static_cast<double>(scene.steps()) /
                                                              level.steps_per_coarse)));
  const auto alone = weft::bench::steps_alone(scene, run, folder_.path / "run", steps_alone_max);
  level.coarse.bytes = alone.coarse_bytes;
  run.steps.bytes = alone.fine_bytes;
  run.steps.state_hash = run.state_hash;
  level.fine = &run.steps;
  if (json_["coarse_levels"].empty()) note_serial(scene, run.steps);
  Json& json = note_level(level, alone.coarse_triangles);
  json["serial_wall_s"] = run.steps.costs.wall.back();
  json["steps_alone"] = {
      {"steps", alone.steps}, {"wall_s", alone.wall}, {"wall_in_run_s", alone.wall_in_run}};
  note_run(level, options_.schedules.front(), run, json);
  note_schedules(level, run.outcome, json);
  measure_runs(level, json, true);
}

int Benchmark::execute() {
  int code = weft::bench::done;
  for (const double coarse_step : options_.coarse_steps) try {
      if (options_.from_slices)
        measure_slices(coarse_step);
      else
        measure_level(coarse_step);
    } catch (const weft::SimulationError& error) {
      json_["failures"].push_back({{"coarse_step_s", coarse_step}, {"failure", error.what()}});
      fmt::print(stderr, "weft_bench_time_parallel: coarse steps of {} s: {}\n", coarse_step,
                 error.what());
      code = weft::bench::simulation_failed;
    }
  write();
  return code;
}

void add_options(CLI::App& app, Options& options) {
  std::set<std::string> names;
  for (const auto& [name, preset] : presets) names.insert(name);
  app.add_option("--preset", options.preset, "Scene and sizes; default: swing")
      ->check(CLI::IsMember(names));
  app.add_option("--scene", options.scene, "Scene file instead of a preset's");
  app.add_option("--arcsim", options.arcsim,
                 "Folder of ARCSim, with conf and meshes; default: arcsim in WEFT_TEST_DATA");
  app.add_option("--frames", options.frames, "Frames to simulate")->check(CLI::Range(1, 1000000));
  app.add_option("--workers", options.workers, "Slices; may be repeated; default: 1, 2, 4, 8")
      ->check(CLI::Range(1, 100000))
      ->allow_extra_args(false);
  app.add_option("--threads", options.threads,
                 "Slices that are worked off at once, at most; default: one a core")
      ->check(CLI::Range(1, 1024));
  app.add_option("--partition", options.schedules, "May be repeated; default: all three")
      ->check(CLI::IsMember({"uniform", "balanced", "adaptive"}))
      ->allow_extra_args(false);
  app.add_option("--coarse-step", options.coarse_steps,
                 "Of the coarse run, in seconds; may be repeated; default: the scene's, and twice "
                 "the fine step")
      ->check(CLI::PositiveNumber)
      ->allow_extra_args(false);
  CLI::Option* sample =
      app.add_option("--sample", options.sample,
                     "Do not run the scene serially, but time so many steps of it, and "
                     "extrapolate; nothing is compared with the serial run")
          ->check(CLI::Range(sample_min, 1000000));
  app.add_flag("--from-slices", options.from_slices,
               "Do not run the scene serially: each of its steps costs what it takes in its slice "
               "of the first run, by the first --workers and --partition")
      ->excludes(sample);
  app.add_option("--states", options.states, "Times at which starts are compared; default: 4")
      ->check(CLI::Range(0, 1000));
  app.add_flag("--no-runs", options.no_runs, "No runs in slices");
  app.add_flag("--no-twin", options.no_twin, "No second serial run from a start next to it");
  app.add_option("--set", options.overrides, "Override a value of the scene; may be repeated")
      ->type_name("PATH=VALUE")
      ->allow_extra_args(false);
  app.add_option("--json", options.json, "Write all figures to this file");
  app.add_flag("--smoke", options.smoke, "Few frames");
}

/// @throws SceneError if there is no folder of ARCSim
fs::path arcsim_scene(const Options& options, const std::string& name) {
  const char* data = std::getenv("WEFT_TEST_DATA");
  const fs::path folder = !options.arcsim.empty() ? fs::path(options.arcsim)
                          : data != nullptr       ? fs::path(data) / "arcsim"
                                                  : fs::path();
  if (folder.empty())
    throw weft::SceneError("", "--arcsim", "missing",
                           "the folder of ARCSim, for the preset \"" + options.preset +
                               "\"; or WEFT_TEST_DATA, which holds it");
  return folder / "conf" / (name + ".json");
}

weft::io::SceneFile scene_of(const Options& options) {
  std::vector<std::string> overrides;
  fs::path path = options.scene;
  bool arcsim = false;
  if (options.scene.empty()) {
    const Preset& preset = presets.at(options.preset);
    arcsim = preset.arcsim;
    path = preset.arcsim ? arcsim_scene(options, preset.scene)
                         : fs::path(WEFT_SOURCE_DIR) / "scenes" / (preset.scene + ".json");
    overrides = preset.overrides;
  }
  if (options.smoke) overrides.push_back("time.frames=4");
  if (options.frames) overrides.push_back(fmt::format("time.frames={}", *options.frames));
  overrides.insert(overrides.end(), options.overrides.begin(), options.overrides.end());
  overrides.push_back("method.type=time_parallel");
  weft::io::SceneFile file = weft::bench::read_scene_file(path, overrides);
  if (arcsim) {
    // Results hold what is set here, not ARCSim's meshes and the thousands of keys that move them.
    weft::bench::without_folders(file.resolved).erase("obstacles");
    for (auto& cloth : weft::bench::without_folders(file.resolved).at("cloths"))
      cloth.erase("mesh");
  }
  return file;
}

int run(Options options, const std::vector<std::string>& command) {
  const Json machine = weft::bench::machine_json();
  weft::io::SceneFile file = scene_of(options);
  if (options.workers.empty())
    options.workers = options.smoke ? std::vector{2} : std::vector{1, 2, 4, 8};
  if (options.schedules.empty()) {
    if (options.from_slices)
      options.schedules = {"adaptive"};
    else
      options.schedules = {"uniform", "balanced", "adaptive"};
  }
  if (options.smoke) options.states = std::min(options.states, 1);
  if (options.coarse_steps.empty()) {
    options.coarse_steps = {file.scene.time_parallel.coarse_step};
    const double small = 2 * weft::frame_step_length(file.scene.time);
    if (!options.smoke && small < options.coarse_steps.front())
      options.coarse_steps.push_back(small);
  }
  Json head{{"benchmark", "time_parallel"},
            {"build", weft::bench::build_json()},
            {"machine", machine},
            {"command", command},
            {"scene", file.scene.name},
            {"preset", options.scene.empty() ? Json(options.preset) : Json(nullptr)},
            {"triangle_count", weft::bench::triangle_count(file.scene)},
            {"obstacle_triangle_count", weft::bench::obstacle_triangle_count(file.scene)}};
  return Benchmark(options, std::move(file), std::move(head)).execute();
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("Slices of time: speed-up, bounds, accuracy", "weft_bench_time_parallel");
  Options options;
  add_options(app, options);
  return weft::bench::bench_main(app, argc, argv, [&](const std::vector<std::string>& command) {
    return run(options, command);
  });
}
