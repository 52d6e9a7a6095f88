#include "host/app/plan/plan_without.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "host/app/chart/accuracy_target.hpp"
#include "host/app/chart/chart_runs.hpp"
#include "host/app/process/child.hpp"
#include "host/app/run/allow_path.hpp"
#include "weft/error.hpp"

namespace weft::app {
namespace {

constexpr double triangles_max = 1000;  ///< of the finer mesh
constexpr double coarser = 4;
constexpr double seconds_max = 60;  ///< a run

WithoutError unknown(std::string why) {
  return {false, 0, std::move(why)};
}

}  // namespace

WithoutStages::WithoutStages(const Scene& scene, const std::string& file,
                             std::vector<std::string> overrides, std::vector<std::string> allowed,
                             const std::string& chart)
    : file_(file), overrides_(std::move(overrides)), allowed_(std::move(allowed)) {
  for (const Cloth& cloth : scene.cloths)
    triangles_ += static_cast<double>(cloth.mesh.triangles.size());
  if (chart.empty()) return;
  chart_ = load_chart(chart);
  if (chart_->scene != scene.name)
    throw SceneError(chart, "scene", "\"" + chart_->scene + "\"",
                     "\"" + scene.name + "\", as the plan's");
}

std::optional<WithoutError> WithoutStages::from_chart(const std::string& label) const {
  if (!chart_) return std::nullopt;
  const ChartPoint* own = chart_->own_point();
  for (const ChartPoint& p : chart_->points)
    if (p.setting.series == "model" && p.setting.label == label && p.drawn())
      return WithoutError{
          true, p.error,
          fmt::format("its chart has an error of {:.3g} % without it, {}", 100 * p.error,
                      own == nullptr || !own->drawn()
                          ? "and none with it"
                          : fmt::format("{:.3g} % with it", 100 * own->error))};
  return std::nullopt;
}

/// @param triangles 0: the mesh as it is
/// @param off       empty: with all stages
/// @return          its directory; empty if it did not end well
const std::string& WithoutStages::run(double triangles, const std::string& off) {
  const std::string name = fmt::format("{}_{:.0f}", off.empty() ? "all" : off, triangles);
  const auto found = done_.find(name);
  if (found != done_.end()) return found->second;
  const std::string output = (scratch_.path() / name).string();
  std::vector<std::string> words{"run", file_, "--device", "cpu:1", "-o", output, "--no-preview"};
  const std::vector<std::string> allowed = allow_path_words(allowed_);
  words.insert(words.end(), allowed.begin(), allowed.end());
  for (const std::string& text : overrides_) words.insert(words.end(), {"--set", text});
  if (triangles > 0)
    words.insert(words.end(), {"--set", fmt::format("triangles={:.0f}", triangles)});
  if (!off.empty()) words.insert(words.end(), {"--set", off});
  const bool good = run_child(words, output + ".log", seconds_max).exit_code == 0;
  return done_[name] = good ? output : "";
}

/// @param triangles 0: the mesh as it is
/// @return          over the diagonal; nothing if a run did not end well
std::optional<double> WithoutStages::difference(double triangles, const std::string& off) {
  const std::string with = run(triangles, {});
  if (with.empty()) return std::nullopt;
  const std::string without = run(triangles, off);
  if (without.empty()) return std::nullopt;
  try {
    return run_distance(with, without);
  } catch (const SimulationError&) {
    return std::nullopt;
  }
}

WithoutError WithoutStages::error(const std::string& off, const std::string& label) {
  if (const auto found = from_chart(label)) return *found;
  const double fine = std::min(triangles_, triangles_max);
  const bool reducible = takes_triangles(file_, overrides_, allowed_, fine / coarser);
  if (!reducible && triangles_ > triangles_max)
    return unknown("not measured: the mesh has a fixed resolution");
  const auto at_fine = difference(reducible ? fine : 0, off);
  const auto at_coarse =
      reducible && at_fine ? difference(fine / coarser, off) : std::optional<double>(0);
  if (!at_fine || !at_coarse)
    return unknown(
        fmt::format("not measured: a run failed or took longer than {:g} s", seconds_max));
  // The coarser mesh says how much the size changes; without one, twice what was found.
  const double error = *at_fine + std::abs(*at_fine - *at_coarse);
  return {
      true, error,
      fmt::format(
          "frames with and without it differ by {:.3g} % at {:.0f} triangles{}; estimate for "
          "the scene: at most {:.3g} %",
          100 * *at_fine, reducible ? fine : triangles_,
          reducible ? fmt::format(" and {:.3g} % at {:.0f}", 100 * *at_coarse, fine / coarser) : "",
          100 * error)};
}

}  // namespace weft::app
