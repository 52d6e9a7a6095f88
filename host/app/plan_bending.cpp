#include "host/app/plan_bending.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <optional>

#include "host/app/chart_output.hpp"
#include "host/app/chart_runs.hpp"
#include "host/app/child.hpp"
#include "host/app/need.hpp"
#include "host/scene/scratch_folder.hpp"
#include "weft/error.hpp"

namespace weft::app {
namespace {

namespace fs = std::filesystem;

constexpr double triangles_max = 1000;  ///< of the finer mesh
constexpr double coarser = 4;
constexpr double seconds_max = 60;  ///< a run

/// @throws SceneError if it is the chart of another scene
std::optional<BendingError> from_chart(const std::string& file, const std::string& scene) {
  const Chart chart = load_chart(file);
  if (chart.scene != scene)
    throw SceneError(file, "scene", "\"" + chart.scene + "\"", "\"" + scene + "\", as the plan's");
  const ChartPoint* own = chart.own_point();
  for (const ChartPoint& p : chart.points)
    if (p.setting.series == "model" && p.setting.label == "no bending" && p.drawn())
      return BendingError{true, p.error,
                          fmt::format("its chart has {:.3g} % without, {}", 100 * p.error,
                                      own == nullptr || !own->drawn()
                                          ? "nothing with"
                                          : fmt::format("{:.3g} % with", 100 * own->error))};
  return std::nullopt;
}

/// Runs with and without bending at one size of the mesh.
class BendingRuns {
 public:
  BendingRuns(const std::string& scene, const std::vector<std::string>& overrides)
      : scene_(scene), overrides_(overrides) {}

  /// @param triangles 0: the mesh as it is
  /// @return          over the diagonal; nothing if a run did not end well
  std::optional<double> difference(double triangles) const {
    const auto with = run("with", triangles, {});
    const auto without = run("without", triangles, {"--set", "model.bending=false"});
    if (!with || !without) return std::nullopt;
    try {
      return run_distance(*with, *without);
    } catch (const SimulationError&) {
      return std::nullopt;
    }
  }

 private:
  std::optional<fs::path> run(const std::string& name, double triangles,
                              const std::vector<std::string>& more) const {
    const fs::path output = scratch_ / fmt::format("{}_{:.0f}", name, triangles);
    std::vector<std::string> words{"run", scene_,          "--device",    "cpu:1",
                                   "-o",  output.string(), "--no-preview"};
    for (const std::string& text : overrides_) words.insert(words.end(), {"--set", text});
    if (triangles > 0)
      words.insert(words.end(), {"--set", fmt::format("triangles={:.0f}", triangles)});
    words.insert(words.end(), more.begin(), more.end());
    if (run_child(words, output.string() + ".log", seconds_max).exit_code != 0) return std::nullopt;
    return output;
  }

  std::string scene_;
  std::vector<std::string> overrides_;
  ScratchFolder scratch_;
};

BendingError unknown(std::string why) {
  return {false, 0, std::move(why)};
}

}  // namespace

BendingError bending_error(const Scene& scene, const std::string& file,
                           const std::vector<std::string>& overrides, const std::string& chart) {
  if (!chart.empty())
    if (const auto found = from_chart(chart, scene.name)) return *found;
  double triangles = 0;
  for (const Cloth& cloth : scene.cloths)
    triangles += static_cast<double>(cloth.mesh.triangles.size());
  const double fine = std::min(triangles, triangles_max);
  const bool reducible = takes_triangles(file, overrides, fine / coarser);
  if (!reducible && triangles > triangles_max)
    return unknown("not measured: the mesh cannot be had smaller");
  const BendingRuns runs(file, overrides);
  const auto at_fine = runs.difference(reducible ? fine : 0);
  const auto at_coarse = reducible ? runs.difference(fine / coarser) : std::optional<double>(0);
  if (!at_fine || !at_coarse)
    return unknown(
        fmt::format("not measured: a run of it failed or took longer than {:g} s", seconds_max));
  // The coarser mesh says how much the size changes; without one, twice what was found.
  const double error = *at_fine + std::abs(*at_fine - *at_coarse);
  return {
      true, error,
      fmt::format(
          "all frames with and without it differ by {:.3g} % at {:.0f} triangles{}, at "
          "most {:.3g} % is taken for the scene",
          100 * *at_fine, reducible ? fine : triangles,
          reducible ? fmt::format(" and {:.3g} % at {:.0f}", 100 * *at_coarse, fine / coarser) : "",
          100 * error)};
}

}  // namespace weft::app
