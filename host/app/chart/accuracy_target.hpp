#pragma once

#include <optional>
#include <string>
#include <vector>

#include "host/app/chart/chart_points.hpp"
#include "host/app/run/run_request.hpp"

namespace weft::app {

/// What a run has to keep: of `--need "error<1%,intersections=0"`.
struct AccuracyTarget {
  std::optional<double> error;         ///< mean distance from the truth over the diagonal
  std::optional<int> intersections{};  ///< in all frames
};

/// @throws SceneError for anything but error<NUMBER% up to 100 %, error<NUMBER below 1 and
///         intersections=0
AccuracyTarget parse_accuracy_target(const std::string& text);

/// Whether a scene with meshes of its own making can be had with so many triangles.
bool takes_triangles(SceneRequest request, double count);

/// Points of a chart.
/// @param path a chart.json, or its directory
/// @throws SceneError if it cannot be read
std::vector<ChartPoint> read_chart(const std::string& path);

/// The point that meets the need in the least time; null: none.
const ChartPoint* cheapest(const std::vector<ChartPoint>& points, const AccuracyTarget& target);

/// Runs a scene with the cheapest settings of its chart, estimates the error by half the step and
/// by a mesh of a quarter of the triangles, refines until that meets the need, and leaves the run
/// in its directory. The need is met only if every part of the error, and every frame's
/// intersections, are known; need.json lists those that are not.
/// @param chart   a chart.json, its directory, or empty: the scene's own settings
/// @return 0 met; 4 not met, with the estimate on standard error
/// @throws SceneError for bad input, SimulationError if a run fails
int run_to_accuracy_target(const RunRequest& request, const std::string& target,
                           const std::string& chart);

}  // namespace weft::app
