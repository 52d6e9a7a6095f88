#pragma once

#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "host/app/run/json_archive.hpp"
#include "host/app/run/scene_request.hpp"
#include "weft/scene.hpp"

namespace weft::app {

/// What `weft chart` was asked for.
struct ChartRequest : SceneRequest {
  std::vector<std::string> scenes;
  std::string output;              ///< default: out/chart
  std::string device = "cpu:1";    ///< of all points but those of the device count
  std::vector<std::string> knobs;  ///< "path=value,value,..." each: more series
  std::string frames;
  std::string peers;         ///< CSV of others' points
  int runs = 5;              ///< timed ones a point
  int starts = 1;            ///< whose means are compared after chaos sets in
  double limit = 0;          ///< [s] a run; 0: none
  int jobs = 1;              ///< runs at once, each on cores of its own
  int reference_steps = 16;  ///< of the reference, for one of the scene
  bool fresh = false;        ///< forget what an earlier sweep has done
  bool quick = false;        ///< fewer points
  bool draw = false;         ///< `scenes` are folders of charts, which are drawn again
  bool check = false;        ///< also asked whether defaults and plans are among the best
};

/// A place on the chart before it is run: the scene with something changed.
struct ChartSetting {
  std::string series;  ///< which knob, such as "time step"
  std::string label;   ///< its value
  std::string method;
  std::string device;
  std::vector<std::string> overrides;  ///< beside those for every run
};

/// A place on the chart. What is not known is NaN.
struct ChartPoint {
  static constexpr double unknown = std::numeric_limits<double>::quiet_NaN();
  ChartSetting setting;
  std::string command;  ///< that repeats it
  std::string commit;
  std::string state_hash;
  int starts = 1;               ///< that statistics are means over
  std::string failure;          ///< why there is no point; empty if there is one
  std::vector<double> seconds;  ///< wall time a simulated second, in increasing order
  double error = unknown;       ///< mean distance over the diagonal, over the frames before chaos
  double statistics = unknown;  ///< of frames after that, means over starts, over the diagonal
  double statistics_error = unknown;  ///< standard error of that; unknown with a single start
  double hausdorff = unknown;         ///< over the diagonal, at the last frame before chaos
  double curvature = unknown;         ///< there too
  double stretch = unknown;           ///< largest principal stretch less one, at the last frame
  double drift = unknown;             ///< of the energy, as the run's report has it
  double intersections = unknown;     ///< in all frames, by the independent validator

  double median() const { return seconds.empty() ? unknown : seconds[seconds.size() / 2]; }
  bool drawn() const { return failure.empty() && std::isfinite(error) && !seconds.empty(); }
};

void fields(JsonArchive& io, ChartPoint& point);
/// @throws Json::exception if it is no point
ChartPoint point_from_json(const Json& json);

/// Of all cloths.
std::size_t triangle_count(const Scene& scene);

/// [m] of the box around all cloths at the start
double diagonal_of(const Scene& scene);

/// The scene itself.
/// @param command that tries other time steps, for the message
/// @throws SceneError if steps are of automatic length
Scene with_fixed_steps(Scene scene, const std::string& command);

/// The points of a sweep.
/// @param scene as it is without any knob turned
/// @throws SceneError for a malformed --knob
std::vector<ChartSetting> chart_settings(const Scene& scene, const ChartRequest& request);

/// Settings of the run that a reference is made of.
/// @param steps      for one of the scene
/// @param integrator "bdf2" or "implicit_euler"
std::vector<std::string> reference_overrides(const Scene& scene, int steps,
                                             const std::string& integrator);

/// Peers' points: a CSV file with the columns name, error, seconds, and others that do not matter.
/// @throws SceneError with file and line
std::vector<ChartPoint> read_peers(const std::string& file);

}  // namespace weft::app
