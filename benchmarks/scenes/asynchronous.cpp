// The asynchronous method on one scene, with separating slabs and without, on several numbers of
// threads and with several windows: where the time goes, as figure 1 of Ainsley et al. 2012 has it,
// and how fast events are. Times are of the steps alone. With --sample the first run is whole, and
// others are timed on single steps on its way, which end in the same bits. With
// --states these stay, so that other processes sample the same way.
#include <fmt/format.h>
#include <sys/resource.h>
#include <time.h>
#include <unistd.h>
#include <CLI/CLI.hpp>

#include <chrono>
#include <cmath>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <fstream>
#include <limits>
#include <nlohmann/json.hpp>
#include <numeric>
#include <optional>
#include <string>
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

enum ExitCode {
  done = 0,
  wrong_result = 1,
  bad_input = 2,
  device_error = 3,
  simulation_failed = 4
};

struct Options {
  std::string scene = WEFT_SOURCE_DIR "/scenes/two_cloths.json";
  std::optional<int> triangles;
  std::optional<int> frames;
  std::vector<int> threads;
  std::vector<double> windows;
  std::vector<std::string> narrow;
  std::vector<std::string> optimistic;
  std::vector<std::string> overrides;
  int sampled_steps = 0;
  std::string states;
  double limit = std::numeric_limits<double>::infinity();
  std::string json;
  bool smoke = false;
};

/// One run, or what was sampled of one.
struct Sample {
  std::string narrow;
  int threads = 1;
  bool optimistic = false;
  double window = 0;  ///< [s] asked for
  /// [s] of the whole; of a run that was sampled, what its steps took over the share that they are
  double wall = 0;
  double simulated = 0;  ///< [s]
  weft::AsynchronousCounts counts;
  std::string failure = "none";
  std::uint64_t state_hash = 0;
  bool extrapolated = false;
  bool stopped = false;    ///< by --limit, at `simulated`
  std::int64_t steps = 0;  ///< that were timed
  double timed = 0;        ///< [s] what they took
  double timed_sq = 0;     ///< [s^2] sum of the squares
  double cpu = 0;          ///< [s] what they took of processors, which others' work does not change
  std::vector<double> frame_wall;
  std::vector<std::int64_t> frame_rollbacks;

  /// Elements and pairs that were computed, in accepted passes and others.
  double events() const {
    return static_cast<double>(counts.elements + counts.layer_pairs + counts.resimulated);
  }
  /// [s] standard error of `wall`, as times of steps vary
  double wall_error() const {
    if (!extrapolated || steps < 2) return 0;
    const auto n = static_cast<double>(steps);
    const double variance = std::max(timed_sq / n - timed / n * (timed / n), 0.0) * n / (n - 1);
    return wall / timed * std::sqrt(variance * n);
  }
  double wall_per_million_events() const { return events() > 0 ? timed / events() * 1e6 : 0; }
};

/// How a run differs from another one of the same scene.
struct Variant {
  int threads;
  weft::NarrowPhase narrow;
  double window;  ///< [s]
  bool optimistic;
};

/// A state on the way of the first run, and what two steps from there led to.
struct State {
  std::filesystem::path file;
  std::uint64_t hash_after = 0;
};

/// States that the first run has saved, and what it was.
struct Way {
  std::filesystem::path folder;
  std::vector<State> states;
  std::int64_t steps = 0;  ///< of the run
  double simulated = 0;    ///< [s]
  std::uint64_t state_hash = 0;
  bool stopped = false;

  std::filesystem::path list() const { return folder / "states.json"; }
};

/// [s] of processors that this process has used
double cpu_seconds() {
  timespec now{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

weft::Simulation simulation_of(weft::Scene scene, const Variant& variant, Sample& sample) {
  sample.threads = variant.threads;
  sample.window = variant.window;
  sample.optimistic = variant.optimistic;
  sample.narrow = variant.narrow == weft::NarrowPhase::slabs ? "slabs" : "ccd";
  scene.asynchronous.narrow = variant.narrow;
  scene.asynchronous.window = variant.window;
  scene.asynchronous.optimistic = variant.optimistic;
  return {std::move(scene), weft::host_devices(variant.threads)};
}

/// Times one step.
/// @return false if it failed
bool timed_step(weft::Simulation& simulation, Sample& sample) {
  const double cpu_before = cpu_seconds();
  const auto start = Clock::now();
  const weft::StepReport report = simulation.step();
  const double took = seconds_since(start);
  sample.cpu += cpu_seconds() - cpu_before;
  sample.timed += took;
  sample.timed_sq += took * took;
  ++sample.steps;
  sample.counts += report.asynchronous;
  const auto frame = static_cast<std::size_t>((report.number - 1) / simulation.steps_per_frame());
  if (!sample.extrapolated) {
    sample.frame_wall.resize(frame + 1, 0);
    sample.frame_rollbacks.resize(frame + 1, 0);
    sample.frame_wall[frame] += took;
    sample.frame_rollbacks[frame] += report.asynchronous.rollbacks;
  }
  if (report.failure == weft::Failure::none) return true;
  sample.failure = weft::describe(report.failure);
  return false;
}

/// The whole scene, as far as it gets.
/// @param limit [s] of wall time, after which no step is begun
/// @param way   states filled, evenly over the steps, as many as there are steps at most; those
///              beyond the limit are left out
Sample run_whole(const weft::Scene& scene, const Variant& variant, double limit, Way& way) {
  Sample sample;
  weft::Simulation simulation = simulation_of(scene, variant, sample);
  const std::int64_t total =
      static_cast<std::int64_t>(scene.time.frames) * simulation.steps_per_frame();
  const std::int64_t count = std::min(static_cast<std::int64_t>(way.states.size()), total - 1);
  // The step after the one from there is timed: a state that is read has lost its idle layers.
  const auto place = [&](std::int64_t k) { return std::min(total * k / count, total - 2); };
  std::int64_t next = 0, awaited = 0;
  while (simulation.step_number() < total && sample.timed < limit) {
    if (next < count && simulation.step_number() == place(next))
      simulation.save(way.states[static_cast<std::size_t>(next++)].file);
    if (!timed_step(simulation, sample)) break;
    if (awaited < next && simulation.step_number() == place(awaited) + 2)
      way.states[static_cast<std::size_t>(awaited++)].hash_after = simulation.state_hash();
  }
  way.states.resize(static_cast<std::size_t>(awaited));
  sample.wall = sample.timed;
  sample.simulated = simulation.time();
  sample.state_hash = simulation.state_hash();
  sample.stopped = simulation.step_number() < total && sample.failure == "none";
  way.steps = sample.steps;
  way.simulated = sample.simulated;
  way.state_hash = sample.state_hash;
  way.stopped = sample.stopped;
  return sample;
}

/// 0 .. count - 1 in an order whose every beginning is spread out evenly.
std::vector<std::size_t> spread_out(std::size_t count) {
  std::size_t stride = static_cast<std::size_t>(0.618 * static_cast<double>(count)) + 1;
  while (std::gcd(stride, count) > 1) ++stride;
  std::vector<std::size_t> order;
  for (std::size_t k = 0; k < count; ++k) order.push_back(k * stride % count);
  return order;
}

/// The step after the one from each state, by every variant in turn, so that all of them meet the
/// machine as it is at the time.
/// @param limit  [s] of wall time of all together, after which no state is begun
std::vector<Sample> run_sampled(const weft::Scene& scene, const std::vector<Variant>& variants,
                                double limit, const Way& way) {
  std::vector<Sample> samples(variants.size());
  std::vector<weft::Simulation> simulations;
  for (std::size_t v = 0; v < variants.size(); ++v) {
    samples[v].extrapolated = true;
    samples[v].stopped = way.stopped;
    samples[v].state_hash = way.state_hash;
    simulations.push_back(simulation_of(scene, variants[v], samples[v]));
  }
  const auto start = Clock::now();
  bool good = true;
  for (const std::size_t k : spread_out(way.states.size())) {
    if (!good || !(seconds_since(start) < limit)) break;
    const State& state = way.states[k];
    for (std::size_t v = 0; v < variants.size() && good; ++v) {
      simulations[v].resume(state.file);
      const weft::Failure failure = simulations[v].step().failure;
      if (failure != weft::Failure::none) samples[v].failure = weft::describe(failure);
      good = failure == weft::Failure::none && timed_step(simulations[v], samples[v]);
      if (good && simulations[v].state_hash() != state.hash_after) samples[v].state_hash = 0;
    }
  }
  for (Sample& sample : samples) {
    if (sample.steps > 0)
      sample.wall =
          sample.timed * static_cast<double>(way.steps) / static_cast<double>(sample.steps);
    sample.simulated = way.simulated;
  }
  return samples;
}

void print(const Sample& s) {
  const weft::AsynchronousCounts& c = s.counts;
  const double all = c.useful + c.resimulation + c.detection + c.unneeded + c.bookkeeping;
  const auto share = [&](double part) { return all > 0 ? 100 * part / all : 0; };
  fmt::print(
      "{:<6} {:>2} threads{}, R {:.4f} s: {:9.3f} s for {:.3f} s{}, {:8.3f} s a million events; "
      "useful {:4.1f}%, resimulation {:4.1f}%, detection {:4.1f}%, unneeded {:4.1f}%, bookkeeping "
      "{:4.1f}%; {} windows, {} rollbacks, {} layers deep\n",
      s.narrow, s.threads, s.optimistic ? ", optimistic" : "", s.window, s.wall, s.simulated,
      s.extrapolated ? " (extrapolated)" : "", s.wall_per_million_events(), share(c.useful),
      share(c.resimulation), share(c.detection), share(c.unneeded), share(c.bookkeeping), c.windows,
      c.rollbacks, c.layers_max);
  std::fflush(stdout);
}

Json to_json(const Sample& s) {
  const weft::AsynchronousCounts& c = s.counts;
  Json json{{"narrow", s.narrow},
            {"threads", s.threads},
            {"optimistic", s.optimistic},
            {"window_s", s.window},
            {"wall_s", s.wall},
            {"wall_error_s", s.wall_error()},
            {"extrapolated", s.extrapolated},
            {"stopped_by_limit", s.stopped},
            {"simulated_s", s.simulated},
            {"timed_steps", s.steps},
            {"timed_s", s.timed},
            {"timed_cpu_s", s.cpu},
            {"events", s.events()},
            {"wall_s_per_million_events", s.wall_per_million_events()},
            {"useful_s", c.useful},
            {"resimulation_s", c.resimulation},
            {"detection_s", c.detection},
            {"unneeded_s", c.unneeded},
            {"bookkeeping_s", c.bookkeeping},
            {"beside_detection_s", c.beside_detection},
            {"ahead_started", c.ahead_started},
            {"ahead_accepted", c.ahead_accepted},
            {"ahead_cancelled", c.ahead_cancelled},
            {"ahead_held", c.ahead_held},
            {"windows", c.windows},
            {"clean_windows", c.clean_windows},
            {"rollbacks", c.rollbacks},
            {"ticks", c.ticks},
            {"elements", c.elements},
            {"layer_pairs", c.layer_pairs},
            {"acting_pairs", c.acting_pairs},
            {"resimulated", c.resimulated},
            {"candidates", c.candidates},
            {"slabs", c.slabs},
            {"failsafe", c.failsafe},
            {"ccd_tests", c.ccd_tests},
            {"pairs_max", c.pairs_max},
            {"layers_max", c.layers_max},
            {"failure", s.failure},
            {"state_hash", fmt::format("{:016x}", s.state_hash)}};
  if (!s.extrapolated) {
    json["frame_wall_s"] = s.frame_wall;
    json["frame_rollbacks"] = s.frame_rollbacks;
  }
  return json;
}

/// [bytes] of the process, at most so far
std::int64_t peak_bytes() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<std::int64_t>(usage.ru_maxrss) * 1024;
}

Json make_json(const weft::io::SceneFile& file, const std::vector<std::string>& command,
               const Json& machine, const std::vector<Sample>& samples) {
  std::size_t vertices = 0, triangles = 0;
  for (const weft::Cloth& cloth : file.scene.cloths) {
    vertices += cloth.mesh.positions.size();
    triangles += cloth.mesh.triangles.size();
  }
  Json all = Json::array();
  for (const Sample& sample : samples) all.push_back(to_json(sample));
  return {{"benchmark", "asynchronous"},
          {"build", weft::bench::build_json()},
          {"machine", machine},
          {"command", command},
          {"scene", file.scene.name},
          {"vertex_count", vertices},
          {"triangle_count", triangles},
          {"eta_1_m", file.scene.contact.thickness},
          {"r_1_N_per_m", file.scene.asynchronous.stiffness},
          {"peak_bytes", peak_bytes()},
          {"samples", all},
          {"resolved_scene", file.resolved}};
}

void add_options(CLI::App& app, Options& options) {
  app.add_option("--scene", options.scene, "Scene file; default: scenes/two_cloths.json");
  app.add_option("--triangles", options.triangles, "Triangles that the scene's grids aim at")
      ->check(CLI::Range(100, 40000000));
  app.add_option("--frames", options.frames, "Frames to simulate")->check(CLI::Range(1, 1000000));
  app.add_option("--threads", options.threads, "May be repeated; default: 1 and 2")
      ->check(CLI::Range(1, 64))
      ->allow_extra_args(false);
  app.add_option("--window", options.windows, "R in seconds, may be repeated; default: the scene's")
      ->check(CLI::Range(1e-6, 1.0))
      ->allow_extra_args(false);
  app.add_option("--narrow", options.narrow, "May be repeated; default: slabs and ccd")
      ->check(CLI::IsMember({"slabs", "ccd"}))
      ->allow_extra_args(false);
  app.add_option("--optimistic", options.optimistic,
                 "Begin windows while the last one is looked at, may be repeated; default: the "
                 "scene's")
      ->check(CLI::IsMember({"on", "off"}))
      ->allow_extra_args(false);
  app.add_option(
         "--sample", options.sampled_steps,
         "Only the first run is of the whole scene; of the others, time so many steps on its "
         "way, each after one that is not timed, and extrapolate")
      ->check(CLI::Range(1, 100000));
  app.add_option("--states", options.states,
                 "Folder for these states. Where it has some of the same scene already, all runs "
                 "are sampled")
      ->needs("--sample");
  app.add_option("--limit", options.limit,
                 "Seconds of a run, which then stops; of states some are left out")
      ->check(CLI::PositiveNumber);
  app.add_option("--set", options.overrides, "Override a value of the scene; may be repeated")
      ->type_name("PATH=VALUE")
      ->allow_extra_args(false);
  app.add_option("--json", options.json, "Write all figures to this file");
  app.add_flag("--smoke", options.smoke, "400 triangles, 4 frames, unless given");
}

/// Every thread count, narrow phase and window that is asked for.
std::vector<Variant> variants_of(const Options& options, const weft::Scene& scene) {
  const auto or_else = [](const auto& given, auto usual) { return given.empty() ? usual : given; };
  std::vector<Variant> variants;
  for (const double window : or_else(options.windows, std::vector{scene.asynchronous.window}))
    for (const int threads : or_else(options.threads, std::vector{1, 2}))
      for (const std::string& narrow :
           or_else(options.narrow, std::vector<std::string>{"slabs", "ccd"}))
        for (const std::string& optimistic :
             or_else(options.optimistic,
                     std::vector<std::string>{scene.asynchronous.optimistic ? "on" : "off"}))
          variants.push_back({threads,
                              narrow == "slabs" ? weft::NarrowPhase::slabs : weft::NarrowPhase::ccd,
                              window, threads > 1 && optimistic == "on"});
  return variants;
}

/// A folder for states, which goes with the object.
struct Folder {
  std::filesystem::path path =
      std::filesystem::temp_directory_path() / fmt::format("weft_bench_asynchronous_{}", getpid());
  Folder() { std::filesystem::create_directories(path); }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;
  ~Folder() {
    std::error_code ignored;
    std::filesystem::remove_all(path, ignored);
  }
};

/// What has to be the same where states are used again.
Json identity(const weft::io::SceneFile& file) {
  Json scene = file.resolved;
  scene["method"].erase("asynchronous");
  return scene;
}

void write_way(const Way& way, const weft::io::SceneFile& file) {
  Json states = Json::array();
  for (const State& state : way.states)
    states.push_back(
        {{"file", state.file.filename().string()}, {"hash_after_two_steps", state.hash_after}});
  const Json json{{"scene", identity(file)},      {"steps", way.steps},
                  {"simulated_s", way.simulated}, {"state_hash", way.state_hash},
                  {"stopped", way.stopped},       {"states", states}};
  weft::write_file_atomically(way.list(), json.dump(2) + "\n");
}

/// @return false if there is none yet
/// @throws SceneError if it is of another scene
bool read_way(Way& way, const weft::io::SceneFile& file) {
  std::ifstream in(way.list());
  if (!in) return false;
  const Json json = Json::parse(in);
  if (json.at("scene") != identity(file))
    throw weft::SceneError(way.list().string(), "scene", "another one", "that of --scene");
  way.states.clear();
  for (const Json& state : json.at("states"))
    way.states.push_back({way.folder / state.at("file").get<std::string>(),
                          state.at("hash_after_two_steps").get<std::uint64_t>()});
  way.steps = json.at("steps");
  way.simulated = json.at("simulated_s");
  way.state_hash = json.at("state_hash");
  way.stopped = json.at("stopped");
  return true;
}

/// @param written called with all samples after each of them
template <class Written>
std::vector<Sample> run_all(const weft::io::SceneFile& file, const std::vector<Variant>& variants,
                            const Options& options, const Written& written) {
  const Folder temporary;
  Way way;
  way.folder = options.states.empty() ? temporary.path : std::filesystem::path(options.states);
  bool known = options.sampled_steps > 0 && read_way(way, file);
  if (!known) {
    std::filesystem::create_directories(way.folder);
    for (int k = 0; k < options.sampled_steps; ++k)
      way.states.push_back({way.folder / fmt::format("{}.weft", k)});
  }
  std::vector<Sample> samples;
  std::vector<Variant> left = variants;
  while (!left.empty() && !(known && options.sampled_steps > 0)) {
    samples.push_back(run_whole(file.scene, left.front(), options.limit, way));
    left.erase(left.begin());
    if (!options.states.empty() && samples.back().failure == "none") write_way(way, file);
    known = true;
    print(samples.back());
    written(samples);
    if (samples.back().failure != "none") return samples;
  }
  if (left.empty()) return samples;
  for (const Sample& sample : run_sampled(file.scene, left, options.limit, way)) {
    samples.push_back(sample);
    print(sample);
  }
  written(samples);
  return samples;
}

int run(Options options, const std::vector<std::string>& command) {
  const Json machine = weft::bench::machine_json();
  if (!options.triangles && options.smoke) options.triangles = 400;
  if (!options.frames && options.smoke) options.frames = 4;
  std::vector<std::string> overrides = options.overrides;
  if (options.triangles) overrides.push_back(fmt::format("triangles={}", *options.triangles));
  if (options.frames) overrides.push_back(fmt::format("time.frames={}", *options.frames));
  const weft::io::SceneFile file = weft::io::read_scene_file(options.scene, overrides);
  const auto write = [&](const std::vector<Sample>& samples) {
    if (!options.json.empty())
      weft::write_file_atomically(options.json,
                                  make_json(file, command, machine, samples).dump(2) + "\n");
  };
  const std::vector<Sample> samples =
      run_all(file, variants_of(options, file.scene), options, write);
  for (const Sample& sample : samples) {
    if (sample.failure != "none") return simulation_failed;
    const bool same_way = sample.simulated == samples.front().simulated;
    if (!same_way || sample.state_hash == samples.front().state_hash) continue;
    fmt::print(stderr, "weft_bench_asynchronous: runs end in different states\n");
    return wrong_result;
  }
  return done;
}

int fail(const std::exception& error, ExitCode code) {
  std::fflush(stdout);
  fmt::print(stderr, "weft_bench_asynchronous: {}\n", error.what());
  return code;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("The asynchronous method: where its time goes", "weft_bench_asynchronous");
  Options options;
  add_options(app, options);
  try {
    app.parse(argc, argv);
    return run(options, weft::bench::command_words(argc, argv));
  } catch (const CLI::ParseError& error) {
    return error.get_exit_code() == 0 ? app.exit(error) : fail(error, bad_input);
  } catch (const weft::SceneError& error) {
    return fail(error, bad_input);
  } catch (const weft::DeviceError& error) {
    return fail(error, device_error);
  } catch (const std::exception& error) {
    return fail(error, wrong_result);
  }
}
