#pragma once

#include <optional>
#include <string>

#include "host/app/chart/chart_output.hpp"
#include "host/app/plan/small_runs.hpp"
#include "weft/scene.hpp"

namespace weft::app {

/// How far leaving out a stage would move the cloth.
struct WithoutError {
  bool known = false;
  double error = 0;  ///< over the diagonal, if known
  std::string how;   ///< one line: where the figure comes from, or why there is none
};

/// Measures what leaving out stages of a scene changes.
///
/// By a chart of the scene that has a point without the stage: the whole error of that point. Else
/// by runs of all frames with and without it, at two reduced sizes of the mesh: how far they differ
/// at the finer one, and by as much more as the two sizes differ. Nothing is known where a run
/// fails or takes longer than a minute, or where the mesh cannot be had smaller and is not small.
class WithoutStages {
 public:
  /// @param runs  of the scene
  /// @param chart a chart.json, its directory, or empty
  /// @throws SceneError if the chart cannot be read or is of another scene
  WithoutStages(const Scene& scene, SmallRuns& runs, const std::string& chart);

  /// @param off   what leaves the stage out, for --set
  /// @param label of the chart's point without it, in its series "model"
  WithoutError error(const std::string& off, const std::string& label);

 private:
  std::optional<WithoutError> from_chart(const std::string& label) const;
  std::optional<double> difference(double triangles, const std::string& off);

  SmallRuns& runs_;
  std::optional<Chart> chart_;
};

}  // namespace weft::app
