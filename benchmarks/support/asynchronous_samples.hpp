#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "host/exec/cpu_seconds.hpp"
#include "weft/devices.hpp"
#include "weft/report.hpp"
#include "weft/simulation.hpp"

/// Runs of the asynchronous method, whole or sampled, and what is said of them.
namespace weft::bench::asynchronous {

using Json = nlohmann::ordered_json;
using Clock = std::chrono::steady_clock;

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

inline double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

inline weft::Simulation simulation_of(weft::Scene scene, const Variant& variant, Sample& sample) {
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
inline bool timed_step(weft::Simulation& simulation, Sample& sample) {
  const double cpu_before = weft::cpu_seconds();
  const auto start = Clock::now();
  const weft::StepReport report = simulation.step();
  const double took = seconds_since(start);
  sample.cpu += weft::cpu_seconds() - cpu_before;
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

inline void print(const Sample& s) {
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

inline Json to_json(const Sample& s) {
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

}  // namespace weft::bench::asynchronous
