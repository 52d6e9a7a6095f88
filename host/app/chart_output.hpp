#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "host/app/chart_points.hpp"

namespace weft::app {

/// All that a chart shows.
struct Chart {
  std::string scene;
  std::string about;  ///< reference and chaos, a line each
  double floor = 0;   ///< how far two independent references differ, over the diagonal
  std::vector<ChartPoint> points;
  std::string machine;   ///< one line
  std::string finished;  ///< date

  /// Whether the references' difference is more than a fifth of the smallest error drawn.
  bool reference_limited() const;
  /// Numbers of the points that no other beats in both error and time, by increasing time.
  std::vector<std::size_t> front() const;
};

/// Everything, for programs: chart.json. `weft run --need` reads it.
std::string chart_json(const Chart& chart);

/// A line a point; failures too.
std::string chart_csv(const Chart& chart);

/// A script that draws chart.svg and chart.png where it is run.
std::string chart_gnuplot(const Chart& chart);

/// One page that needs nothing else: the chart with a note at each point, and tables.
std::string chart_page(const Chart& chart);

/// Writes chart.json, chart.csv, chart.gp and chart.html, and has gnuplot draw chart.svg and
/// chart.png.
/// @throws SceneError if a file cannot be written, or gnuplot is missing or fails: all else has
/// been
///         written then
void write_chart(const Chart& chart, const std::filesystem::path& folder);

}  // namespace weft::app
