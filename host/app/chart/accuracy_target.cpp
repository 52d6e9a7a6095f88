#include "host/app/chart/accuracy_target.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <memory>
#include <optional>
#include <sstream>
#include <utility>

#include "host/app/chart/chart_output.hpp"
#include "host/app/chart/chart_points.hpp"
#include "host/app/chart/chart_runs.hpp"
#include "host/app/process/child.hpp"
#include "host/app/run/output_folder.hpp"
#include "host/app/run/run_directory.hpp"
#include "host/app/run/run_end.hpp"
#include "host/app/run/run_output.hpp"
#include "host/base/atomic_file.hpp"
#include "host/base/file_bytes.hpp"
#include "host/input/counted.hpp"
#include "host/input/safe_text.hpp"
#include "host/io/scene/scene_file.hpp"
#include "weft/error.hpp"

namespace weft::app {
namespace {

namespace fs = std::filesystem;

constexpr int refinements_max = 3;
constexpr const char* half_step = "half_step";
constexpr const char* stopped_by_signal = "stopped by a signal";

/// Estimated errors of a run; empty: unknown.
struct Estimate {
  // distances from the truth over the diagonal, by their cause
  std::optional<double> step;
  std::optional<double> mesh;
  std::optional<double> model;          ///< stages that the settings leave out of the scene
  std::optional<double> intersections;  ///< in all frames

  /// Of the parts that are known.
  double total() const { return step.value_or(0) + mesh.value_or(0) + model.value_or(0); }
};

/// Settings that are tried.
struct Trial {
  std::vector<std::string> overrides;  ///< of the chart's point
  double step;                         ///< [s]
  double triangles;
};

class AccuracyTargetRun {
 public:
  AccuracyTargetRun(const RunRequest& request, AccuracyTarget target,
                    std::vector<std::string> overrides);
  int execute();

 private:
  fs::path run(const std::string& name, const Trial& trial);
  std::optional<double> distance(const std::string& name, const Trial& trial,
                                 const fs::path& found);
  Estimate estimate(const fs::path& found, const Trial& trial);
  std::vector<std::string> unknown(const Estimate& e) const;
  std::string explain(const Estimate& e) const;
  int finish(const fs::path& found, const Estimate& e, bool met);
  int order() const { return bdf2_ ? 2 : 1; }

  const RunRequest& request_;
  AccuracyTarget target_;
  Trial first_;
  std::vector<std::string> model_;  ///< overrides that leave something out
  fs::path output_, folder_;
  std::unique_ptr<RunLock> lock_;
  bool bdf2_ = false;
  bool other_meshes_ = true;  ///< the scene can have another number of triangles
  int frames_ = 1;
};

/// Intersections in all frames of a run; nothing if its report or a frame does not tell.
std::optional<double> known_intersections(const fs::path& run) {
  try {
    const Json report = Json::parse(read_file_bytes(run / "report.json"));
    if (report.contains("failure") || !report.at("intersections").is_number()) return {};
    return run_intersections(run);
  } catch (const Json::exception&) {
    return {};
  } catch (const SceneError&) {
    return {};
  } catch (const SimulationError&) {
    return {};
  }
}

bool is_model_switch(const std::string& text) {
  return text.starts_with("model.") || text == "contact.self=false" || text == "wind.density=0";
}

AccuracyTargetRun::AccuracyTargetRun(const RunRequest& request, AccuracyTarget target,
                                     std::vector<std::string> overrides)
    : request_(request), target_(target) {
  const io::Settings of_point = io::split_settings(overrides);
  SceneRequest first = request;
  first.overrides = all_overrides(request);
  std::vector<std::string> all = first.overrides;
  all.insert(all.end(), overrides.begin(), overrides.end());
  first.overrides.insert(first.overrides.end(), of_point.keys.begin(), of_point.keys.end());
  first.experimental.insert(first.experimental.end(), of_point.experimental.begin(),
                            of_point.experimental.end());
  const Scene scene = with_fixed_steps(first.read(), "--need");
  for (const std::string& text : overrides)
    if (is_model_switch(text)) model_.push_back(text);
  first_ = {std::move(all), scene.time.step, static_cast<double>(triangle_count(scene))};
  other_meshes_ = takes_triangles(std::move(first), std::max(100.0, first_.triangles));
  bdf2_ = scene.integrator == Integrator::bdf2;
  frames_ = scene.time.frames;
  output_ = output_folder(request.output, scene.name);
  folder_ = output_ / "need";
  lock_ = lock_existing(RunDirectory(output_), request);
  fs::create_directories(folder_);
  if (!lock_) lock_ = std::make_unique<RunLock>(output_);
  fs::remove(output_ / "need.json");  // of an earlier run; none stands if this one fails
}

/// @return the directory of the run
/// @throws SimulationError if it fails
fs::path AccuracyTargetRun::run(const std::string& name, const Trial& trial) {
  const fs::path output = folder_ / name;
  fs::remove_all(output);
  // The child writes into a log, where it cannot see a terminal.
  std::vector<std::string> words{"run", request_.scene, "-o", output.string(),
                                 draws_preview(request_) ? "--preview" : "--no-preview"};
  if (!request_.device.empty()) words.insert(words.end(), {"--device", request_.device});
  SceneRequest of_trial = request_;
  of_trial.overrides = trial.overrides;
  std::vector<std::string> sizes{fmt::format("time.step={:.17g}", trial.step)};
  if (trial.triangles != first_.triangles)
    sizes.push_back(fmt::format("triangles={:.0f}", trial.triangles));
  fmt::print("{}: step {:.4g} s, {:.0f} triangles\n", name, trial.step, trial.triangles);
  std::fflush(stdout);
  const ChildEnd end =
      run_child(of_trial.command(std::move(words), sizes), output.string() + ".log", 0);
  if (end.exit_code == 130) throw SimulationError(stopped_by_signal);
  if (end.exit_code != 0) throw SimulationError(fmt::format("{}: {}", name, end.message));
  return output;
}

/// Distance between a run and one that differs in one setting; nothing if that one fails.
std::optional<double> AccuracyTargetRun::distance(const std::string& name, const Trial& trial,
                                                  const fs::path& found) {
  try {
    return run_distance(run(name, trial), found);
  } catch (const SimulationError& error) {
    if (std::string(error.what()) == stopped_by_signal) throw;
    fmt::print(stderr, "weft: {}\n", error.what());
    return {};
  }
}

/// By runs that differ in one setting each: the step, the mesh, what is left out.
Estimate AccuracyTargetRun::estimate(const fs::path& found, const Trial& trial) {
  Estimate e;
  e.intersections = known_intersections(found);
  if (!target_.error) return e;
  Trial other = trial;
  other.step /= 2;
  const double power = std::pow(2.0, order());
  if (const auto d = distance(half_step, other, found)) e.step = *d * power / (power - 1);
  other = trial;
  other.triangles = std::max(100.0, std::round(trial.triangles / 4));
  if (other_meshes_ && other.triangles < trial.triangles)
    if (const auto d = distance("coarse_mesh", other, found)) e.mesh = *d / 3;
  if (model_.empty()) {
    e.model = 0;
    return e;
  }
  other = trial;
  std::erase_if(other.overrides, [&](const std::string& text) {
    return std::find(model_.begin(), model_.end(), text) != model_.end();
  });
  e.model = distance("whole_model", other, found);
  return e;
}

/// Parts of the target that are not known.
std::vector<std::string> AccuracyTargetRun::unknown(const Estimate& e) const {
  std::vector<std::string> names;
  if (target_.error && !e.step) names.emplace_back("step");
  if (target_.error && !e.mesh) names.emplace_back("mesh");
  if (target_.error && !e.model) names.emplace_back("model");
  if (!e.intersections) names.emplace_back("intersections");
  return names;
}

std::string AccuracyTargetRun::explain(const Estimate& e) const {
  std::string text;
  if (target_.error) {
    const auto part = [](const std::optional<double>& value) {
      return value ? fmt::format("{:.3g} %", 100 * *value) : std::string("unknown");
    };
    text = fmt::format("error {} {:.3g} % (time step: {}, mesh: {}, parts left out: {}), ",
                       unknown(e).empty() ? "about" : "at least about", 100 * e.total(),
                       part(e.step), part(e.mesh), part(e.model));
  }
  text += e.intersections ? fmt::format("{:g} {} in {}", *e.intersections,
                                        noun_for(std::llround(*e.intersections), "intersection"),
                                        counted(frames_, "frame"))
                          : "intersections unknown";
  if (const auto names = unknown(e); !names.empty())
    text += fmt::format("; unknown: {}", fmt::join(names, ", "));
  if (target_.error && !e.mesh && !other_meshes_)
    text += " (no cloth has a mesh whose resolution can be changed)";
  return text;
}

/// Moves a run to the user's folder.
int AccuracyTargetRun::finish(const fs::path& found, const Estimate& e, bool met) {
  RunDirectory(output_).create();
  RunDirectory(output_).clear();
  for (const auto& entry : fs::directory_iterator(found)) {
    if (entry.path().filename() == RunLock::file_name) continue;  // that of the trial
    const fs::path target = output_ / entry.path().filename();
    fs::remove_all(target);
    fs::rename(entry.path(), target);
  }
  fs::remove_all(folder_);
  const auto json_of = [](const std::optional<double>& value) {
    return value ? Json(*value) : Json(nullptr);
  };
  const std::vector<std::string> names = unknown(e);
  const bool error_known = e.step && e.mesh && e.model;
  const Json json{{"wanted_error", json_of(target_.error)},
                  {"met", met},
                  {"unknown", names},
                  {"error", error_known ? Json(e.total()) : Json(nullptr)},
                  {"error_by_step", json_of(e.step)},
                  {"error_by_mesh", json_of(e.mesh)},
                  {"error_by_model", json_of(e.model)},
                  {"intersections", json_of(e.intersections)}};
  write_file_atomically(output_ / "need.json", json.dump(2) + "\n");
  if (met)
    fmt::print("{}: accuracy target met: {}\n", output_.string(), explain(e));
  else
    fmt::print(stderr, "weft: accuracy target not met: {}\n", explain(e));
  return met ? 0 : 4;
}

int AccuracyTargetRun::execute() {
  Trial trial = first_;
  fs::path found = run("trial_0", trial);
  for (int k = 0;; ++k) {
    const Estimate e = estimate(found, trial);
    const bool clean =
        !target_.intersections || e.intersections.value_or(1) <= *target_.intersections;
    const bool known = unknown(e).empty();
    const bool met = clean && known && (!target_.error || e.total() <= *target_.error);
    // Refining helps neither against stages left out, nor intersections, nor unknown errors.
    const bool hopeless = !clean || !known || (target_.error && *e.model > *target_.error);
    if (met || hopeless || k == refinements_max) return finish(found, e, met);
    fmt::print("{}\n", explain(e));
    const std::string next = fmt::format("trial_{}", k + 1);
    if (*e.mesh > *e.step) {
      trial.triangles *= 4;
      found = run(next, trial);
    } else {
      trial.step /= 2;
      found = folder_ / next;  // the run that tested this trial is the next one
      fs::rename(folder_ / half_step, found);
    }
  }
}

}  // namespace

AccuracyTarget parse_accuracy_target(const std::string& text) {
  const std::string allowed =
      "error<NUMBER% with a number up to 100, error<NUMBER with a number below 1, and "
      "intersections=0, with commas between";
  AccuracyTarget target;
  std::istringstream parts(text);
  for (std::string part; std::getline(parts, part, ',');) {
    std::erase(part, ' ');
    if (part == "intersections=0") {
      target.intersections = 0;
      continue;
    }
    if (!part.starts_with("error<")) throw SceneError("", "--need", text, allowed);
    std::string number = part.substr(6);
    const bool percent = number.ends_with('%');
    if (percent) number.pop_back();
    double value = 0;
    const auto [end, error] = std::from_chars(number.data(), number.data() + number.size(), value);
    if (error != std::errc() || end != number.data() + number.size() || !(value > 0) ||
        !(percent ? value <= 100 : value < 1))
      throw SceneError("", "--need", text, allowed);
    target.error = percent ? value / 100 : value;
  }
  if (!target.error && !target.intersections) throw SceneError("", "--need", text, allowed);
  return target;
}

bool takes_triangles(SceneRequest request, double count) {
  request.overrides.push_back(fmt::format("triangles={:.0f}", count));
  try {
    request.read();
  } catch (const SceneError&) {
    return false;
  }
  return true;
}

std::vector<ChartPoint> read_chart(const std::string& path) {
  return load_chart(path).points;
}

const ChartPoint* cheapest(const std::vector<ChartPoint>& points, const AccuracyTarget& target) {
  const ChartPoint* best = nullptr;
  for (const ChartPoint& p : points) {
    if (!p.drawn() || p.setting.series == "peer" || p.setting.series == "devices" ||
        p.setting.series == planned_series)
      continue;
    if (target.error && p.error > *target.error) continue;
    if (target.intersections && !(p.intersections <= *target.intersections)) continue;
    if (best == nullptr || p.median() < best->median()) best = &p;
  }
  return best;
}

int run_to_accuracy_target(const RunRequest& request, const std::string& text,
                           const std::string& chart) {
  const AccuracyTarget target = parse_accuracy_target(text);
  std::vector<std::string> overrides;
  if (!chart.empty()) {
    const std::vector<ChartPoint> points = read_chart(chart);
    const ChartPoint* best = cheapest(points, target);
    if (best != nullptr) {
      overrides = best->setting.overrides;
      overrides.push_back("method.type=" + best->setting.method);
      fmt::print("from the chart: {}: {}\n", one_line(best->setting.series),
                 one_line(best->setting.label));
    } else {
      fmt::print("no point of the chart meets the target; starting from the scene's settings\n");
    }
  }
  return AccuracyTargetRun(request, target, std::move(overrides)).execute();
}

}  // namespace weft::app
