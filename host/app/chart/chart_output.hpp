#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "host/app/chart/chart_points.hpp"

namespace weft::app {

/// Name of the series of points that `weft plan` chose from the others.
inline constexpr const char* planned_series = "planned";

/// Name of the series of the one point with the scene's own settings.
inline constexpr const char* own_series = "scene";

/// All that a chart shows.
struct Chart {
  std::string scene;
  std::string about;       ///< reference and chaos, a line each
  double floor = 0;        ///< how far two independent references differ, over the diagonal
  double after_chaos = 0;  ///< share of the frames that are compared by statistics
  std::vector<ChartPoint> points;
  std::string machine;   ///< one line
  std::string finished;  ///< date

  /// Whether the references' difference is more than a fifth of the smallest error drawn.
  bool reference_limited() const;
  /// Numbers of the points that no other beats in both error and time, by increasing time.
  std::vector<std::size_t> front() const;
  /// The point of the scene's own settings, failed or not; null: there is none.
  const ChartPoint* own_point() const;
  /// Error of a point over all frames: root mean square of distances before chaos and, with several
  /// starts, of differences of statistics after it.
  double whole_error(const ChartPoint& point) const;
  /// Numbers of the points that beat the scene's own settings in both error and time, by more than
  /// runs, starts and references differ: the slowest of their runs is faster than fastest_like(),
  /// and the whole error smaller by a hundredth and by the references' difference plus two standard
  /// errors.
  std::vector<std::size_t> better_than_default() const;
  /// Numbers of the planned points that failed, or are above the front of all others: one of them
  /// has no larger error, and its slowest run is faster than fastest_like() of the planned point.
  std::vector<std::size_t> planned_above_front() const;
  /// The fastest run of a point, and of all others that ended in the same state by the same method
  /// and device: what differs there is noise. [s] a simulated second
  /// @pre point.drawn()
  double fastest_like(const ChartPoint& point) const;
};

/// Everything, for programs: chart.json. `weft run --need` reads it.
std::string chart_json(const Chart& chart);

/// @param path a chart.json, or its directory
/// @throws SceneError if it cannot be read
Chart load_chart(const std::string& path);

/// A line a point; failures too.
std::string chart_csv(const Chart& chart);

/// A script that draws chart.svg and chart.png where it is run.
std::string chart_gnuplot(const Chart& chart);

/// One page that needs nothing else: the chart with a note at each point, and tables.
std::string chart_page(const Chart& chart);

/// Writes chart.json, chart.csv, chart.gp and chart.html.
/// @throws SceneError if one cannot be written
void write_chart_files(const Chart& chart, const std::filesystem::path& folder);

/// Writes these, and has gnuplot draw chart.svg and chart.png.
/// @throws SceneError if a file cannot be written, or gnuplot is missing or fails: all else has
/// been
///         written then
void write_chart(const Chart& chart, const std::filesystem::path& folder);

}  // namespace weft::app
