#pragma once

#include "host/app/chart/chart_points.hpp"

namespace weft::app {

/// Measures all points of a scene's chart that are not measured yet, and draws it.
/// @throws SceneError, SimulationError as ChartRuns and write_chart()
void sweep_scene(const ChartRequest& request);

}  // namespace weft::app
