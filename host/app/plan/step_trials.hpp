#pragma once

#include <optional>
#include <string>
#include <vector>

#include "host/app/plan/small_runs.hpp"
#include "weft/scene.hpp"

namespace weft::app {

/// A run of all frames with a time step.
struct StepTrial {
  double step = 0;             ///< [s]
  std::optional<double> error; /**< distance from the run with the finest step, over the diagonal;
                                    see run_distance() */
  double seconds = 0;          ///< wall time
  double bisected = 0;         ///< share of the steps that were bisected, truncated or the like
  std::string problem;         ///< one line: why the run did not end; empty: it did
};

/// How a scene fares with other time steps.
struct StepTrials {
  double triangles = 0;           ///< of the mesh that was used
  double finest = 0;              ///< [s] step of the run that errors are measured against
  std::vector<StepTrial> trials;  ///< from the longest step on; one has that of the scene
  /// Distance of two runs with the step of the scene whose starts differ by a millionth of the
  /// diagonal: differences below that are chance.
  double chance = 0;
  double allowed = 0;           ///< difference up to which a step is good enough
  std::optional<double> bears;  ///< [s] longest step that is good enough; nothing: none is
  std::string unknown;          ///< one line: why there are no trials; empty: there are
};

/// Tries time steps of four times, twice and half that of the scene, as far as frames allow, beside
/// its own and a quarter of it. Good enough is a step if all frames are within `error_max` of the
/// run with the finest step, or within twice of what chance does, and at most every tenth step was
/// bisected; and if all shorter ones are.
/// @param error_max over the diagonal
StepTrials try_steps(const Scene& scene, SmallRuns& runs, double error_max);

}  // namespace weft::app
