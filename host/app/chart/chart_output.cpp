#include "host/app/chart/chart_output.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "host/app/process/child.hpp"
#include "host/base/atomic_file.hpp"
#include "host/base/file_bytes.hpp"
#include "host/base/scratch_folder.hpp"
#include "host/input/safe_text.hpp"
#include "weft/error.hpp"

namespace weft::app {
namespace {

namespace fs = std::filesystem;

constexpr std::array colours{"#1b6ca8", "#c8553d", "#3a7d44", "#8e5aa8", "#b8860b", "#555555"};

struct Range {
  double low = std::numeric_limits<double>::infinity();
  double high = 0;
  void add(double value) {
    if (!(value > 0) || !std::isfinite(value)) return;
    low = std::min(low, value);
    high = std::max(high, value);
  }
  /// With room around it; something where there is nothing.
  Range wide() const {
    if (!(high > 0)) return {1e-3, 1};
    return {low / 2, high * 2};
  }
};

/// Points without any difference from the reference cannot stand on a logarithmic axis.
double shown(double error) {
  return std::max(error, 1e-16);
}

std::string cell(double value) {
  return std::isfinite(value) ? fmt::format("{:.6g}", value) : "";
}

std::vector<std::string> methods_of(const Chart& chart) {
  std::vector<std::string> methods;
  for (const ChartPoint& p : chart.points)
    if (std::find(methods.begin(), methods.end(), p.setting.method) == methods.end())
      methods.push_back(p.setting.method);
  return methods;
}

std::string staircase(const Chart& chart) {
  std::string lines;
  double last = 0;
  for (const std::size_t k : chart.front()) {
    const ChartPoint& p = chart.points[k];
    if (last > 0) lines += fmt::format("{:.9g} {:.9g}\n", last, p.median());
    lines += fmt::format("{:.9g} {:.9g}\n", shown(p.error), p.median());
    last = shown(p.error);
  }
  return lines;
}

/// Has gnuplot draw chart.svg and chart.png, in a folder of its own: nothing that stands in
/// `folder` decides where it writes.
void draw(const std::string& script, const fs::path& folder) {
  const ScratchFolder scratch;
  write_file_atomically(scratch / "chart.gp", script, Durability::none);
  const std::optional<ChildEnd> end =
      run_program({"gnuplot", "chart.gp"}, scratch.path(), scratch / "gnuplot.log");
  if (!end)
    throw SceneError(
        folder.string(), "chart.svg and chart.png", "gnuplot is not installed",
        "the package gnuplot-nox of Debian and Ubuntu; chart.html and chart.csv need it "
        "not");
  if (end->exit_code != 0)
    throw SceneError((folder / "chart.gp").string() + ": gnuplot failed: " + end->message);
  for (const char* name : {"chart.svg", "chart.png"})
    write_file_atomically(folder / name, read_file_bytes(scratch / name));
}

}  // namespace

bool Chart::reference_limited() const {
  double smallest = std::numeric_limits<double>::infinity();
  for (const ChartPoint& p : points)
    if (p.drawn()) smallest = std::min(smallest, p.error);
  return floor > smallest / 5;
}

std::vector<std::size_t> Chart::front() const {
  std::vector<std::size_t> order;
  for (std::size_t k = 0; k < points.size(); ++k)
    if (points[k].drawn() && points[k].setting.series != "peer") order.push_back(k);
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    const ChartPoint &p = points[a], &q = points[b];
    return p.median() != q.median() ? p.median() < q.median() : p.error < q.error;
  });
  std::vector<std::size_t> best;
  for (const std::size_t k : order)
    if (best.empty() || points[k].error < points[best.back()].error) best.push_back(k);
  return best;
}

double Chart::fastest_like(const ChartPoint& point) const {
  double fastest = point.seconds.front();
  for (const ChartPoint& p : points)
    if (p.drawn() && p.state_hash == point.state_hash && p.setting.device == point.setting.device &&
        p.setting.method == point.setting.method)
      fastest = std::min(fastest, p.seconds.front());
  return fastest;
}

const ChartPoint* Chart::own_point() const {
  const auto own = std::find_if(points.begin(), points.end(),
                                [](const ChartPoint& p) { return p.setting.series == own_series; });
  return own == points.end() ? nullptr : &*own;
}

double Chart::whole_error(const ChartPoint& point) const {
  if (!std::isfinite(point.statistics_error)) return point.error;
  return std::sqrt((1 - after_chaos) * point.error * point.error +
                   after_chaos * point.statistics * point.statistics);
}

std::vector<std::size_t> Chart::better_than_default() const {
  constexpr double noticed = 0.99;
  std::vector<std::size_t> better;
  const ChartPoint* own = own_point();
  if (own == nullptr || !own->drawn()) return better;
  const double time = fastest_like(*own);
  const auto chance = [this](const ChartPoint& p) {
    return std::isfinite(p.statistics_error) ? std::sqrt(after_chaos) * p.statistics_error : 0;
  };
  for (std::size_t k = 0; k < points.size(); ++k) {
    const ChartPoint& p = points[k];
    if (!p.drawn() || p.setting.series == "peer" || !(p.seconds.back() < time)) continue;
    const double error = whole_error(p), own_error = whole_error(*own);
    const double noise = floor + 2 * std::hypot(chance(p), chance(*own));
    if (error + noise < own_error && error < noticed * own_error) better.push_back(k);
  }
  return better;
}

std::vector<std::size_t> Chart::planned_above_front() const {
  std::vector<std::size_t> above;
  for (std::size_t k = 0; k < points.size(); ++k) {
    const ChartPoint& plan = points[k];
    if (plan.setting.series != planned_series) continue;
    if (!plan.drawn()) {
      above.push_back(k);
      continue;
    }
    const double time = fastest_like(plan);
    if (std::any_of(points.begin(), points.end(), [&](const ChartPoint& p) {
          return p.drawn() && p.setting.series != "peer" && p.setting.series != planned_series &&
                 p.setting.series != "devices" && p.error <= plan.error && p.seconds.back() < time;
        }))
      above.push_back(k);
  }
  return above;
}

Chart load_chart(const std::string& path) {
  const fs::path file = fs::is_directory(path) ? fs::path(path) / "chart.json" : fs::path(path);
  const Json json = Json::parse(read_file_bytes(file), nullptr, false);
  if (!json.is_object() || !json.contains("points"))
    throw SceneError(file.string(), "chart", "no chart", "what weft chart has written");
  Chart chart;
  try {
    for (const Json& point : json["points"]) chart.points.push_back(point_from_json(point));
    chart.scene = json.at("scene");
    chart.about = json.at("about");
    chart.floor = json.at("reference_floor");
    chart.after_chaos = json.value("after_chaos", 0.0);
    chart.machine = json.at("machine");
    chart.finished = json.at("finished");
  } catch (const Json::exception& error) {
    throw SceneError(file.string() + ": " + error.what());
  }
  return chart;
}

std::string chart_json(const Chart& chart) {
  Json points = Json::array();
  for (const ChartPoint& p : chart.points) points.push_back(json_of(p));
  const Json json{{"scene", chart.scene},
                  {"about", chart.about},
                  {"reference_floor", chart.floor},
                  {"reference_limited", chart.reference_limited()},
                  {"after_chaos", chart.after_chaos},
                  {"machine", chart.machine},
                  {"finished", chart.finished},
                  {"front", chart.front()},
                  {"points", points}};
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

std::string chart_csv(const Chart& chart) {
  std::string text =
      "series,label,method,device,error,seconds,seconds_min,seconds_max,statistics,statistics_"
      "error,"
      "hausdorff,curvature,stretch,energy_drift,intersections,state_hash,commit,failure,command\n";
  for (const ChartPoint& p : chart.points) {
    const double low = p.seconds.empty() ? ChartPoint::unknown : p.seconds.front();
    const double high = p.seconds.empty() ? ChartPoint::unknown : p.seconds.back();
    text += fmt::format(
        "{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{}\n", csv_text(p.setting.series),
        csv_text(p.setting.label), csv_text(p.setting.method), csv_text(p.setting.device),
        cell(p.error), cell(p.median()), cell(low), cell(high), cell(p.statistics),
        cell(p.statistics_error), cell(p.hausdorff), cell(p.curvature), cell(p.stretch),
        cell(p.drift), cell(p.intersections), csv_text(p.state_hash), csv_text(p.commit),
        csv_text(p.failure), csv_text(p.command));
  }
  return text;
}

std::string chart_gnuplot(const Chart& chart) {
  Range x, y;
  for (const ChartPoint& p : chart.points) {
    if (p.drawn()) x.add(shown(p.error));
    if (!p.seconds.empty()) y.add(p.median());
  }
  x = x.wide();
  y = y.wide();
  std::string text = fmt::format(
      "# speed against accuracy\nset logscale xy\nset xlabel 'error over the diagonal'\n"
      "set ylabel 'wall s per simulated s'\nset title {} noenhanced\nset grid\n"
      "set key outside right noenhanced\n"
      "set xrange [{:.6g}:{:.6g}]\nset yrange [{:.6g}:{:.6g}]\nset format xy '10^{{%T}}'\n",
      gnuplot_text(chart.scene + (chart.reference_limited() ? ", reference-limited" : "")), x.low,
      x.high, y.low, y.high);
  if (chart.reference_limited())
    text += fmt::format(
        "set object 1 rect from {:.6g},{:.6g} to {:.6g},{:.6g} fc rgb '#dddddd' "
        "fs solid 0.6 noborder behind\n",
        x.low, y.low, std::clamp(chart.floor, x.low, x.high), y.high);
  const auto methods = methods_of(chart);
  std::vector<std::string> plots;
  for (std::size_t m = 0; m < methods.size(); ++m) {
    std::string points, crosses;
    for (const ChartPoint& p : chart.points) {
      if (p.setting.method != methods[m]) continue;
      if (p.drawn())
        points += fmt::format("{:.9g} {:.9g} {:.9g} {:.9g}\n", shown(p.error), p.median(),
                              p.seconds.front(), p.seconds.back());
      else
        crosses += fmt::format("{:.9g} {:.9g}\n", x.high / 1.1,
                               p.seconds.empty() ? y.high / 1.1 : p.median());
    }
    const char* colour = colours[m % colours.size()];
    if (!points.empty()) {
      text += fmt::format("$points{} << EOD\n{}EOD\n", m, points);
      plots.push_back(fmt::format("$points{} with yerrorbars pt 7 lc rgb '{}' title {}", m, colour,
                                  gnuplot_text(methods[m])));
    }
    if (!crosses.empty()) {
      text += fmt::format("$failed{} << EOD\n{}EOD\n", m, crosses);
      plots.push_back(fmt::format("$failed{} with points pt 2 lc rgb '{}' title {}", m, colour,
                                  gnuplot_text(methods[m] + ", failed")));
    }
  }
  if (const std::string steps = staircase(chart); !steps.empty()) {
    text += fmt::format("$front << EOD\n{}EOD\n", steps);
    plots.push_back("$front with lines lc rgb '#000000' title 'front'");
  }
  // An error that falls with the first or second power of the step, which costs its inverse.
  const double x0 = std::sqrt(x.low * x.high), y0 = std::sqrt(y.low * y.high);
  plots.push_back(
      fmt::format("{0:.6g}*({1:.6g}/x) with lines dt 2 lc rgb '#999999' title 'order 1'", y0, x0));
  plots.push_back(fmt::format(
      "{0:.6g}*sqrt({1:.6g}/x) with lines dt 3 lc rgb '#999999' title 'order 2'", y0, x0));
  const std::string plot = fmt::format("plot {}\n", fmt::join(plots, ", \\\n  "));
  text += "set terminal svg size 960,640 dynamic\nset output 'chart.svg'\n" + plot;
  text += "set terminal pngcairo size 1440,960 fontscale 1.4\nset output 'chart.png'\nreplot\n";
  return text;
}

void write_chart_files(const Chart& chart, const fs::path& folder) {
  write_file_atomically(folder / "chart.json", chart_json(chart));
  write_file_atomically(folder / "chart.csv", chart_csv(chart));
  write_file_atomically(folder / "chart.gp", chart_gnuplot(chart));
  write_file_atomically(folder / "chart.html", chart_page(chart));
}

void write_chart(const Chart& chart, const fs::path& folder) {
  write_chart_files(chart, folder);
  draw(chart_gnuplot(chart), folder);
}

}  // namespace weft::app
