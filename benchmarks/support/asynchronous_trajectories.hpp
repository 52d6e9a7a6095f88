#pragma once

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <numeric>
#include <string>
#include <vector>

#include "benchmarks/support/asynchronous_samples.hpp"
#include "host/base/atomic_file.hpp"
#include "host/io/scene/scene_file.hpp"
#include "weft/error.hpp"

/// States on the way of a run of the asynchronous method, from where others are sampled.
namespace weft::bench::asynchronous {

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
  /// Leaves every parts-th state from number `part` on.
  void take_part(std::size_t part, std::size_t parts) {
    std::vector<State> taken;
    for (std::size_t k = part; k < states.size(); k += parts) taken.push_back(states[k]);
    states = taken;
  }
};

/// The whole scene, as far as it gets.
/// @param limit [s] of wall time, after which no step is begun
/// @param way   states filled, evenly over the steps, as many as there are steps at most; those
///              beyond the limit are left out
inline Sample run_whole(const weft::Scene& scene, const Variant& variant, double limit, Way& way) {
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
inline std::vector<std::size_t> spread_out(std::size_t count) {
  if (count == 0) return {};
  std::size_t stride = static_cast<std::size_t>(0.618 * static_cast<double>(count)) + 1;
  while (std::gcd(stride, count) > 1) ++stride;
  std::vector<std::size_t> order;
  for (std::size_t k = 0; k < count; ++k) order.push_back(k * stride % count);
  return order;
}

/// The step after the one from each state, by every variant in turn, so that all of them meet the
/// machine as it is at the time.
/// @param limit   [s] of wall time of all together, after which no state is begun
/// @param written called with all samples after each state
template <class Written>
std::vector<Sample> run_sampled(const weft::Scene& scene, const std::vector<Variant>& variants,
                                double limit, const Way& way, const Written& written) {
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
    for (Sample& sample : samples) {
      if (sample.steps > 0)
        sample.wall =
            sample.timed * static_cast<double>(way.steps) / static_cast<double>(sample.steps);
      sample.simulated = way.simulated;
    }
    written(samples);
  }
  return samples;
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
inline Json identity(const weft::io::SceneFile& file) {
  Json scene = file.resolved;
  scene["method"].erase("asynchronous");
  return scene;
}

inline void write_way(const Way& way, const weft::io::SceneFile& file) {
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
inline bool read_way(Way& way, const weft::io::SceneFile& file) {
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

}  // namespace weft::bench::asynchronous
