// The asynchronous method on one scene, with separating slabs and without, on several numbers of
// threads and with several windows: where the time goes, as figure 1 of Ainsley et al. 2012 has it,
// and how fast events are. Times are of the steps alone. With --sample the first run is whole, and
// others are timed on single steps on its way, which end in the same bits. With
// --states these stay, so that other processes sample the same way.
#include <fmt/format.h>
#include <sys/resource.h>
#include <CLI/CLI.hpp>

#include <cstdio>
#include <exception>
#include <filesystem>
#include <limits>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "benchmarks/support/asynchronous_samples.hpp"
#include "benchmarks/support/asynchronous_trajectories.hpp"
#include "benchmarks/support/provenance.hpp"
#include "benchmarks/support/scene_settings.hpp"
#include "host/base/atomic_file.hpp"
#include "host/io/scene/scene_file.hpp"
#include "weft/error.hpp"

namespace {

using namespace weft::bench::asynchronous;

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
  std::vector<std::size_t> part{0, 1};
  double limit = std::numeric_limits<double>::infinity();
  std::string json;
  bool smoke = false;
};

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
          {"eta_1_m", contact_thickness(file.scene.contact)},
          {"r_1_N_per_m", file.scene.asynchronous.stiffness},
          {"peak_bytes", peak_bytes()},
          {"samples", all},
          {"resolved_scene", weft::bench::without_folders(file.resolved)}};
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
  app.add_option("--part", options.part,
                 "K N: of these states only every N-th from number K on, for N processes side by "
                 "side")
      ->needs("--states")
      ->expected(2);
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
  way.take_part(options.part[0], options.part[1]);
  const auto with = [&](const std::vector<Sample>& sampled) {
    std::vector<Sample> all = samples;
    all.insert(all.end(), sampled.begin(), sampled.end());
    return all;
  };
  const std::vector<Sample> sampled =
      run_sampled(file.scene, left, options.limit, way,
                  [&](const std::vector<Sample>& so_far) { written(with(so_far)); });
  for (const Sample& sample : sampled) print(sample);
  return with(sampled);
}

int run(Options options, const std::vector<std::string>& command) {
  const Json machine = weft::bench::machine_json();
  if (!options.triangles && options.smoke) options.triangles = 400;
  if (!options.frames && options.smoke) options.frames = 4;
  std::vector<std::string> overrides = options.overrides;
  if (options.triangles) overrides.push_back(fmt::format("triangles={}", *options.triangles));
  if (options.frames) overrides.push_back(fmt::format("time.frames={}", *options.frames));
  const weft::io::SceneFile file = weft::bench::read_scene_file(options.scene, overrides);
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
    if (options.part[0] >= options.part[1])
      throw CLI::ValidationError("--part", "K has to be below N");
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
