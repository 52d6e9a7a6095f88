#include "host/app/plan/plan_without.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "host/app/chart/chart_runs.hpp"
#include "weft/error.hpp"

namespace weft::app {
namespace {

constexpr double coarser = 4;

WithoutError unknown(std::string why) {
  return {false, 0, std::move(why)};
}

}  // namespace

WithoutStages::WithoutStages(const Scene& scene, SmallRuns& runs, const std::string& chart)
    : runs_(runs) {
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
/// @return          over the diagonal; nothing if a run did not end well
std::optional<double> WithoutStages::difference(double triangles, const std::string& off) {
  const std::string with = runs_.run(triangles, {}).folder;
  if (with.empty()) return std::nullopt;
  const std::string without = runs_.run(triangles, {off}).folder;
  if (without.empty()) return std::nullopt;
  try {
    return run_distance(with, without);
  } catch (const SimulationError&) {
    return std::nullopt;
  }
}

WithoutError WithoutStages::error(const std::string& off, const std::string& label) {
  if (const auto found = from_chart(label)) return *found;
  const double fine = std::min(runs_.triangles(), SmallRuns::triangles_max);
  const bool reducible = runs_.reducible(fine / coarser);
  if (!reducible && runs_.triangles() > SmallRuns::triangles_max)
    return unknown("not measured: the mesh has a fixed resolution");
  const auto at_fine = difference(reducible ? fine : 0, off);
  const auto at_coarse =
      reducible && at_fine ? difference(fine / coarser, off) : std::optional<double>(0);
  if (!at_fine || !at_coarse)
    return unknown(fmt::format("not measured: a run failed or took longer than {:g} s",
                               SmallRuns::seconds_max));
  // The coarser mesh says how much the size changes; without one, twice what was found.
  const double error = *at_fine + std::abs(*at_fine - *at_coarse);
  return {
      true, error,
      fmt::format(
          "frames with and without it differ by {:.3g} % at {:.0f} triangles{}; estimate for "
          "the scene: at most {:.3g} %",
          100 * *at_fine, reducible ? fine : runs_.triangles(),
          reducible ? fmt::format(" and {:.3g} % at {:.0f}", 100 * *at_coarse, fine / coarser) : "",
          100 * error)};
}

}  // namespace weft::app
