#include "host/app/plan/step_trials.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "host/app/chart/chart_runs.hpp"
#include "host/base/file_bytes.hpp"
#include "host/scene/frame_steps.hpp"

namespace weft::app {
namespace {

constexpr double bisected_max = 0.1;
constexpr double jitter = 1e-6;  ///< over the diagonal

std::string step_setting(const Scene& scene, int per_frame) {
  return fmt::format("time.step={:.17g}", 1 / (scene.time.frame_rate * per_frame));
}

void read_report(const std::string& folder, StepTrial& trial) {
  const auto report = nlohmann::json::parse(read_file_bytes(folder + "/report.json"));
  trial.seconds = report.at("wall_s").get<double>();
  const auto steps = report.at("steps").get<double>();
  const auto whole = report.at("contacts").at("steps_at_fallback_level").at("whole").get<double>();
  trial.bisected = steps > 0 ? 1 - whole / steps : 0;
}

bool good_enough(const StepTrial& trial, double error_max) {
  return trial.error && *trial.error <= error_max && trial.bisected <= bisected_max;
}

}  // namespace

StepTrials try_steps(const Scene& scene, SmallRuns& runs, double error_max) {
  StepTrials all;
  const bool reducible = runs.reducible(SmallRuns::triangles_max);
  all.triangles =
      reducible ? std::min(runs.triangles(), SmallRuns::triangles_max) : runs.triangles();
  if (scene.method == "asynchronous" || scene.method == "time_parallel") {
    all.unknown = "the method " + scene.method + " has other steps";
    return all;
  }
  if (scene.time.automatic) {
    all.unknown = "time.step is auto";
    return all;
  }
  if (!reducible && runs.triangles() > SmallRuns::triangles_max) {
    all.unknown = "the mesh has a fixed resolution";
    return all;
  }
  const double triangles = reducible ? all.triangles : 0;
  const int own = frame_steps(scene.time);
  const auto step = [&](int per_frame) { return 1 / (scene.time.frame_rate * per_frame); };
  all.finest = step(4 * own);
  const SmallRuns::Run finest = runs.run(triangles, {step_setting(scene, 4 * own)});
  if (finest.folder.empty()) {
    all.unknown = fmt::format("the run with a step of {:.3g} s: {}", all.finest, finest.problem);
    return all;
  }
  const std::string own_setting = step_setting(scene, own);
  const SmallRuns::Run as_is = runs.run(triangles, {own_setting});
  const SmallRuns::Run beside =
      runs.run(triangles,
               {own_setting, fmt::format("jitter.amplitude={:.17g}", jitter * diagonal_of(scene))});
  if (!as_is.folder.empty() && !beside.folder.empty())
    all.chance = run_distance(as_is.folder, beside.folder);
  std::vector<int> counts{std::max(1, own / 4), std::max(1, own / 2), own, 2 * own};
  counts.erase(std::unique(counts.begin(), counts.end()), counts.end());
  for (const int per_frame : counts) {
    const SmallRuns::Run run = runs.run(triangles, {step_setting(scene, per_frame)});
    StepTrial trial;
    trial.step = step(per_frame);
    trial.problem = run.problem;
    if (!run.folder.empty()) {
      read_report(run.folder, trial);
      trial.error = run_distance(finest.folder, run.folder);
    }
    all.trials.push_back(trial);
  }
  all.allowed = std::max(error_max, 2 * all.chance);
  for (auto trial = all.trials.rbegin(); trial != all.trials.rend(); ++trial) {
    if (!good_enough(*trial, all.allowed)) break;
    all.bears = trial->step;
  }
  return all;
}

}  // namespace weft::app
