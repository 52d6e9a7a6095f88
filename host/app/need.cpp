#include "host/app/need.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <sstream>
#include <utility>

#include "host/app/allow_path.hpp"
#include "host/app/chart_output.hpp"
#include "host/app/chart_runs.hpp"
#include "host/app/child.hpp"
#include "host/app/output_folder.hpp"
#include "host/app/run_directory.hpp"
#include "host/io/safe_text.hpp"
#include "host/io/scene_file.hpp"
#include "host/scene/atomic_file.hpp"
#include "weft/error.hpp"

namespace weft::app {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr int refinements_max = 3;
constexpr const char* half_step = "half_step";

/// How far a run may be from the truth, over the diagonal, by its cause.
struct Estimate {
  double step = 0;
  double mesh = 0;
  double model = 0;  ///< what the settings leave out of the scene
  double total() const { return step + mesh + model; }
};

/// Settings that are tried.
struct Trial {
  std::vector<std::string> overrides;  ///< of the chart's point
  double step;                         ///< [s]
  double triangles;
};

class NeedRun {
 public:
  NeedRun(const RunRequest& request, Need need, std::vector<std::string> overrides);
  int execute();

 private:
  fs::path run(const std::string& name, const Trial& trial);
  Estimate estimate(const fs::path& found, const Trial& trial);
  std::string explain(const Estimate& e, double intersections) const;
  int finish(const fs::path& found, const Estimate& e, double intersections, bool met);
  int order() const { return bdf2_ ? 2 : 1; }

  const RunRequest& request_;
  Need need_;
  Trial first_;
  std::vector<std::string> model_;  ///< overrides that leave something out
  fs::path output_, folder_;
  bool bdf2_ = false;
  bool other_meshes_ = true;  ///< the scene can be had with another number of triangles
  int frames_ = 1;
};

bool is_model_switch(const std::string& text) {
  return text.starts_with("model.") || text == "contact.self=false" || text == "wind.density=0";
}

std::vector<std::string> base_overrides(const RunRequest& request) {
  std::vector<std::string> overrides = request.overrides;
  if (!request.method.empty()) overrides.push_back("method.type=" + request.method);
  if (!request.precision.empty()) overrides.push_back("precision=" + request.precision);
  if (!request.frames.empty()) overrides.push_back("time.frames=" + request.frames);
  return overrides;
}

NeedRun::NeedRun(const RunRequest& request, Need need, std::vector<std::string> overrides)
    : request_(request), need_(need) {
  std::vector<std::string> all = base_overrides(request);
  all.insert(all.end(), overrides.begin(), overrides.end());
  const Scene scene = io::read_scene(request.scene, all, request.allowed);
  for (const std::string& text : overrides)
    if (is_model_switch(text)) model_.push_back(text);
  std::size_t triangles = 0;
  for (const Cloth& cloth : scene.cloths) triangles += cloth.mesh.triangles.size();
  first_ = {std::move(all), scene.time.step, static_cast<double>(triangles)};
  other_meshes_ = takes_triangles(request.scene, first_.overrides, request.allowed,
                                  std::max(100.0, first_.triangles));
  bdf2_ = scene.integrator == Integrator::bdf2;
  frames_ = scene.time.frames;
  output_ = output_folder(request.output, scene.name);
  folder_ = output_ / "need";
  fs::create_directories(folder_);
}

/// @return the directory of the run
/// @throws SimulationError if it fails
fs::path NeedRun::run(const std::string& name, const Trial& trial) {
  const fs::path output = folder_ / name;
  fs::remove_all(output);
  std::vector<std::string> words{"run", request_.scene, "-o", output.string()};
  const std::vector<std::string> allowed = allow_path_words(request_.allowed);
  words.insert(words.end(), allowed.begin(), allowed.end());
  if (!request_.device.empty()) words.insert(words.end(), {"--device", request_.device});
  if (!request_.preview) words.push_back("--no-preview");
  for (const std::string& text : trial.overrides) words.insert(words.end(), {"--set", text});
  words.insert(words.end(), {"--set", fmt::format("time.step={:.17g}", trial.step)});
  if (trial.triangles != first_.triangles)
    words.insert(words.end(), {"--set", fmt::format("triangles={:.0f}", trial.triangles)});
  fmt::print("{}: step {:.4g} s, {:.0f} triangles\n", name, trial.step, trial.triangles);
  std::fflush(stdout);
  const ChildEnd end = run_child(words, output.string() + ".log", 0);
  if (end.exit_code == 130) throw SimulationError("stopped by a signal");
  if (end.exit_code != 0) throw SimulationError(fmt::format("{}: {}", name, end.message));
  return output;
}

/// By runs that differ in one thing each: the step, the mesh, what is left out.
Estimate NeedRun::estimate(const fs::path& found, const Trial& trial) {
  Estimate e;
  Trial other = trial;
  other.step /= 2;
  const double power = std::pow(2.0, order());
  e.step = run_distance(run(half_step, other), found) * power / (power - 1);
  other = trial;
  other.triangles = std::max(100.0, std::round(trial.triangles / 4));
  if (other_meshes_ && other.triangles < trial.triangles)
    e.mesh = run_distance(found, run("coarse_mesh", other)) / 3;
  if (model_.empty()) return e;
  other = trial;
  std::erase_if(other.overrides, [&](const std::string& text) {
    return std::find(model_.begin(), model_.end(), text) != model_.end();
  });
  e.model = run_distance(run("whole_model", other), found);
  return e;
}

std::string NeedRun::explain(const Estimate& e, double intersections) const {
  const std::string mesh = other_meshes_ ? fmt::format("{:.3g} % by the mesh", 100 * e.mesh)
                                         : "that of its mesh is not known";
  return fmt::format(
      "error about {:.3g} % ({:.3g} % by the step, {}, {:.3g} % by what is left out), {:g} "
      "intersections in {} frames",
      100 * e.total(), 100 * e.step, mesh, 100 * e.model, intersections, frames_);
}

/// Puts a run where the user wants it.
int NeedRun::finish(const fs::path& found, const Estimate& e, double intersections, bool met) {
  RunDirectory(output_).create();
  RunDirectory(output_).clear();
  for (const auto& entry : fs::directory_iterator(found)) {
    const fs::path target = output_ / entry.path().filename();
    fs::remove_all(target);
    fs::rename(entry.path(), target);
  }
  fs::remove_all(folder_);
  const Json json{{"wanted_error", need_.error ? Json(*need_.error) : Json(nullptr)},
                  {"met", met},
                  {"error", e.total()},
                  {"error_by_step", e.step},
                  {"error_by_mesh", other_meshes_ ? Json(e.mesh) : Json(nullptr)},
                  {"error_by_model", e.model},
                  {"intersections", intersections}};
  write_file_atomically(output_ / "need.json", json.dump(2) + "\n");
  if (met)
    fmt::print("{}: need met: {}\n", output_.string(), explain(e, intersections));
  else
    fmt::print(stderr, "weft: need not met: {}\n", explain(e, intersections));
  return met ? 0 : 4;
}

int NeedRun::execute() {
  Trial trial = first_;
  fs::path found = run("trial_0", trial);
  for (int k = 0;; ++k) {
    const double intersections = run_intersections(found);
    const bool clean = !need_.intersections || intersections <= *need_.intersections;
    const Estimate e = need_.error ? estimate(found, trial) : Estimate{};
    const bool met = clean && (!need_.error || e.total() <= *need_.error);
    // Nothing that could be refined helps against the model or against an intersection.
    const bool hopeless = !clean || (need_.error && e.model > *need_.error);
    if (met || hopeless || k == refinements_max) return finish(found, e, intersections, met);
    fmt::print("{}\n", explain(e, intersections));
    const std::string next = fmt::format("trial_{}", k + 1);
    if (e.mesh > e.step) {
      trial.triangles *= 4;
      found = run(next, trial);
    } else {
      trial.step /= 2;
      found = folder_ / next;  // what has judged this trial is the next one
      fs::rename(folder_ / half_step, found);
    }
  }
}

}  // namespace

Need parse_need(const std::string& text) {
  const std::string allowed =
      "error<NUMBER, error<NUMBER% and intersections=0, with commas between";
  Need need;
  std::istringstream parts(text);
  for (std::string part; std::getline(parts, part, ',');) {
    std::erase(part, ' ');
    if (part == "intersections=0") {
      need.intersections = 0;
      continue;
    }
    if (!part.starts_with("error<")) throw SceneError("", "--need", text, allowed);
    std::string number = part.substr(6);
    const bool percent = number.ends_with('%');
    if (percent) number.pop_back();
    double value = 0;
    const auto [end, error] = std::from_chars(number.data(), number.data() + number.size(), value);
    if (error != std::errc() || end != number.data() + number.size() || !(value > 0) ||
        !std::isfinite(value))
      throw SceneError("", "--need", text, allowed);
    need.error = percent ? value / 100 : value;
  }
  if (!need.error && !need.intersections) throw SceneError("", "--need", text, allowed);
  return need;
}

bool takes_triangles(const std::string& scene, std::vector<std::string> overrides,
                     const std::vector<std::string>& allowed, double count) {
  overrides.push_back(fmt::format("triangles={:.0f}", count));
  try {
    io::read_scene(scene, overrides, allowed);
  } catch (const SceneError&) {
    return false;
  }
  return true;
}

std::vector<ChartPoint> read_chart(const std::string& path) {
  return load_chart(path).points;
}

const ChartPoint* cheapest(const std::vector<ChartPoint>& points, const Need& need) {
  const ChartPoint* best = nullptr;
  for (const ChartPoint& p : points) {
    if (!p.drawn() || p.setting.series == "peer" || p.setting.series == "devices" ||
        p.setting.series == planned_series)
      continue;
    if (need.error && p.error > *need.error) continue;
    if (need.intersections && !(p.intersections <= *need.intersections)) continue;
    if (best == nullptr || p.median() < best->median()) best = &p;
  }
  return best;
}

int run_to_need(const RunRequest& request, const std::string& text, const std::string& chart) {
  const Need need = parse_need(text);
  std::vector<std::string> overrides;
  if (!chart.empty()) {
    const std::vector<ChartPoint> points = read_chart(chart);
    const ChartPoint* best = cheapest(points, need);
    if (best != nullptr) {
      overrides = best->setting.overrides;
      overrides.push_back("method.type=" + best->setting.method);
      fmt::print("from the chart: {}: {}\n", io::one_line(best->setting.series),
                 io::one_line(best->setting.label));
    } else {
      fmt::print("nothing on the chart meets the need; starting from the scene's settings\n");
    }
  }
  return NeedRun(request, need, std::move(overrides)).execute();
}

}  // namespace weft::app
