// The asynchronous method on one scene, with separating slabs and without, and on several numbers
// of threads: where the time goes, as figure 1 of Ainsley et al. 2012 has it, and how fast events
// are. Times are of the steps alone.
#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include <chrono>
#include <cstdio>
#include <exception>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "host/io/scene_file.hpp"
#include "host/scene/atomic_file.hpp"
#include "weft/devices.hpp"
#include "weft/error.hpp"
#include "weft/simulation.hpp"
#include "weft/version.hpp"

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
  std::vector<std::string> overrides;
  std::string json;
  bool smoke = false;
};

/// One run.
struct Sample {
  std::string narrow;
  int threads = 1;
  double window = 0;     ///< [s] asked for
  double wall = 0;       ///< [s]
  double simulated = 0;  ///< [s]
  weft::AsynchronousCounts counts;
  std::string failure = "none";
  std::uint64_t state_hash = 0;

  /// Elements and pairs that were computed, in accepted passes and others.
  double events() const {
    return static_cast<double>(counts.elements + counts.layer_pairs + counts.resimulated);
  }
};

Sample run_once(weft::Scene scene, int threads, weft::NarrowPhase narrow, double window) {
  Sample sample;
  sample.threads = threads;
  sample.window = window;
  sample.narrow = narrow == weft::NarrowPhase::slabs ? "slabs" : "ccd";
  scene.asynchronous.narrow = narrow;
  scene.asynchronous.window = window;
  const int frames = scene.time.frames;
  weft::Simulation simulation(std::move(scene), weft::host_devices(threads));
  const auto start = Clock::now();
  while (simulation.frame_number() < frames) {
    const weft::StepReport report = simulation.step();
    sample.counts += report.asynchronous;
    if (report.failure == weft::Failure::none) continue;
    sample.failure = weft::describe(report.failure);
    break;
  }
  sample.wall = std::chrono::duration<double>(Clock::now() - start).count();
  sample.simulated = simulation.time();
  sample.state_hash = simulation.state_hash();
  return sample;
}

void print(const Sample& s) {
  const weft::AsynchronousCounts& c = s.counts;
  const double all = c.useful + c.resimulation + c.detection + c.unneeded + c.bookkeeping;
  const auto share = [&](double part) { return all > 0 ? 100 * part / all : 0; };
  fmt::print(
      "{:<6} {:>2} threads, R {:.4f} s: {:9.3f} s for {:.3f} s, {:8.3f} s a million events; useful "
      "{:4.1f}%, resimulation {:4.1f}%, detection {:4.1f}%, unneeded {:4.1f}%, bookkeeping "
      "{:4.1f}%; {} windows, {} rollbacks, {} layers deep\n",
      s.narrow, s.threads, s.window, s.wall, s.simulated,
      s.events() > 0 ? s.wall / s.events() * 1e6 : 0, share(c.useful), share(c.resimulation),
      share(c.detection), share(c.unneeded), share(c.bookkeeping), c.windows, c.rollbacks,
      c.layers_max);
  std::fflush(stdout);
}

Json to_json(const Sample& s) {
  const weft::AsynchronousCounts& c = s.counts;
  return {{"narrow", s.narrow},
          {"threads", s.threads},
          {"window_s", s.window},
          {"wall_s", s.wall},
          {"simulated_s", s.simulated},
          {"events", s.events()},
          {"wall_s_per_million_events", s.events() > 0 ? s.wall / s.events() * 1e6 : 0},
          {"useful_s", c.useful},
          {"resimulation_s", c.resimulation},
          {"detection_s", c.detection},
          {"unneeded_s", c.unneeded},
          {"bookkeeping_s", c.bookkeeping},
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
}

Json make_json(const weft::io::SceneFile& file, const std::vector<std::string>& command,
               const std::vector<Sample>& samples) {
  const weft::BuildInfo& build = weft::build_info();
  std::size_t vertices = 0;
  for (const weft::Cloth& cloth : file.scene.cloths) vertices += cloth.mesh.positions.size();
  Json all = Json::array();
  for (const Sample& sample : samples) all.push_back(to_json(sample));
  return {{"benchmark", "asynchronous"},
          {"build",
           {{"version", build.version},
            {"commit", build.commit},
            {"dirty", build.dirty},
            {"compiler", build.compiler},
            {"build_type", build.build_type}}},
          {"cores", std::thread::hardware_concurrency()},
          {"command", command},
          {"scene", file.scene.name},
          {"vertex_count", vertices},
          {"samples", all},
          {"resolved_scene", file.resolved}};
}

void add_options(CLI::App& app, Options& options) {
  app.add_option("--scene", options.scene, "Scene file; default: scenes/two_cloths.json");
  app.add_option("--triangles", options.triangles, "Triangles that the scene's grids aim at")
      ->check(CLI::Range(100, 4000000));
  app.add_option("--frames", options.frames, "Frames to simulate")->check(CLI::Range(1, 1000000));
  app.add_option("--threads", options.threads, "May be repeated; default: 1 and 2")
      ->check(CLI::Range(1, 64))
      ->allow_extra_args(false);
  app.add_option("--window", options.windows, "R in seconds, may be repeated; default: the scene's")
      ->check(CLI::Range(1e-6, 1.0))
      ->allow_extra_args(false);
  app.add_option("--set", options.overrides, "Override a value of the scene; may be repeated")
      ->type_name("PATH=VALUE")
      ->allow_extra_args(false);
  app.add_option("--json", options.json, "Write all figures to this file");
  app.add_flag("--smoke", options.smoke, "400 triangles, 4 frames, unless given");
}

int run(Options options, const std::vector<std::string>& command) {
  if (options.threads.empty()) options.threads = {1, 2};
  if (!options.triangles && options.smoke) options.triangles = 400;
  if (!options.frames && options.smoke) options.frames = 4;
  std::vector<std::string> overrides = options.overrides;
  if (options.triangles) overrides.push_back(fmt::format("triangles={}", *options.triangles));
  if (options.frames) overrides.push_back(fmt::format("time.frames={}", *options.frames));
  const weft::io::SceneFile file = weft::io::read_scene_file(options.scene, overrides);
  if (options.windows.empty()) options.windows = {file.scene.asynchronous.window};
  std::vector<Sample> samples;
  for (const double window : options.windows)
    for (const int threads : options.threads)
      for (const auto narrow : {weft::NarrowPhase::slabs, weft::NarrowPhase::ccd}) {
        samples.push_back(run_once(file.scene, threads, narrow, window));
        print(samples.back());
      }
  if (!options.json.empty())
    weft::write_file_atomically(options.json, make_json(file, command, samples).dump(2) + "\n");
  for (const Sample& sample : samples) {
    if (sample.failure != "none") return simulation_failed;
    if (sample.state_hash == samples.front().state_hash) continue;
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
    return run(options, std::vector<std::string>(argv, argv + argc));
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
