#include "host/app/chart.hpp"

#include <fmt/format.h>
#include <unistd.h>
#include <CLI/CLI.hpp>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <memory>
#include <string>
#include <thread>

#include "host/app/chart_output.hpp"
#include "host/app/chart_points.hpp"
#include "host/app/chart_runs.hpp"
#include "host/io/scene_file.hpp"
#include "weft/devices.hpp"
#include "weft/error.hpp"
#include "weft/version.hpp"

namespace weft::app {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;
using Json = nlohmann::ordered_json;

std::string now_text() {
  const std::time_t now = std::time(nullptr);
  std::tm utc{};
  char text[32] = "";
  if (::gmtime_r(&now, &utc) != nullptr)
    std::strftime(text, sizeof text, "%Y-%m-%d %H:%M UTC", &utc);
  return text;
}

/// Points that an earlier sweep has measured, a line each.
class PointBook {
 public:
  PointBook(fs::path file, bool fresh) : file_(std::move(file)) {
    if (fresh) fs::remove(file_);
    std::ifstream in(file_);
    for (std::string line; std::getline(in, line);) {
      try {
        points_.push_back(point_from_json(Json::parse(line)));
      } catch (const Json::exception&) {
        continue;  // cut off in the middle
      }
    }
  }

  /// @return null if the point is not there, or was measured by another build or less often
  const ChartPoint* find(const ChartPoint& wanted, int runs) const {
    for (const ChartPoint& p : points_)
      if (p.command == wanted.command && p.commit == wanted.commit &&
          p.setting.series == wanted.setting.series &&
          (!p.failure.empty() || static_cast<int>(p.seconds.size()) >= runs))
        return &p;
    return nullptr;
  }

  void add(const ChartPoint& point) {
    std::ofstream(file_, std::ios::app)
        << to_json(point).dump(-1, ' ', false, Json::error_handler_t::replace) << "\n";
  }

 private:
  fs::path file_;
  std::vector<ChartPoint> points_;
};

/// Shows a line a point, and how long the rest will take.
class SweepProgress {
 public:
  SweepProgress(std::string scene, std::size_t count)
      : scene_(std::move(scene)), count_(count), terminal_(::isatty(1) != 0) {}
  void begin(std::size_t k, const ChartSetting& s) const {
    if (!terminal_) return;
    const std::size_t filled = 24 * k / std::max<std::size_t>(1, count_);
    fmt::print("\r\x1b[K[{:<24}] {}/{}  {}{}: {}", std::string(filled, '#'), k, count_, left(k),
               s.series, s.label);
    std::fflush(stdout);
  }
  void done(std::size_t k, const ChartPoint& p) {
    const std::string what =
        p.failure.empty() ? fmt::format("error {:.3g}, {:.3g} s a simulated s", p.error, p.median())
                          : "failed: " + p.failure;
    fmt::print("{}{} {}/{}  {}: {} ({}): {}\n", terminal_ ? "\r\x1b[K" : "", scene_, k + 1, count_,
               p.setting.series, p.setting.label, p.setting.method, what);
    std::fflush(stdout);
  }

 private:
  std::string left(std::size_t k) const {
    if (k == 0) return "";
    const double spent = std::chrono::duration<double>(Clock::now() - start_).count();
    return fmt::format("{:.0f} s left  ",
                       spent / static_cast<double>(k) * static_cast<double>(count_ - k));
  }

  std::string scene_;
  std::size_t count_;
  bool terminal_;
  Clock::time_point start_ = Clock::now();
};

/// Another number of ranks must not move a result.
void require_same_bits(std::vector<ChartPoint>& points, const std::string& base_hash) {
  for (ChartPoint& p : points)
    if (p.setting.series == "devices" && p.failure.empty() && !base_hash.empty() &&
        p.state_hash != base_hash)
      p.failure = "another number of devices ended in another state";
}

void chart_scene(const std::string& file, const ChartRequest& request) {
  std::vector<std::string> overrides = request.overrides;
  if (!request.frames.empty()) overrides.push_back("time.frames=" + request.frames);
  const Scene scene = io::read_scene(file, overrides);
  const fs::path folder =
      fs::path(request.output.empty() ? "out/chart" : request.output) / scene.name;
  const ChartRuns runs(file, folder / "runs", request);
  std::vector<ChartSetting> settings = chart_settings(scene, request);
  settings.insert(settings.begin(), {"scene", "as it is", scene.method, request.device, {}});
  const std::vector<ChartPoint> peers =
      request.peers.empty() ? std::vector<ChartPoint>() : read_peers(request.peers);
  fmt::print("{}: {} points; first the reference\n", scene.name, settings.size());
  std::fflush(stdout);
  const ChartReference reference = runs.make_reference(scene);

  Chart chart;
  chart.scene = scene.name;
  chart.about = fmt::format("Reference: {}. Chaos: {}.", reference.source, reference.chaos);
  chart.floor = reference.floor;
  chart.machine = describe_devices().front();
  PointBook book(folder / "points.jsonl", request.fresh);
  SweepProgress progress(scene.name, settings.size());
  for (std::size_t k = 0; k < settings.size(); ++k) {
    ChartPoint wanted = runs.unmeasured(settings[k]);
    if (const ChartPoint* kept = book.find(wanted, request.runs)) {
      chart.points.push_back(*kept);
      continue;
    }
    progress.begin(k, settings[k]);
    chart.points.push_back(runs.measure(settings[k], reference));
    book.add(chart.points.back());
    progress.done(k, chart.points.back());
  }
  require_same_bits(chart.points, chart.points.front().state_hash);
  chart.points.insert(chart.points.end(), peers.begin(), peers.end());
  chart.finished = now_text();
  write_chart(chart, folder);
  fmt::print("{}{}\n", (folder / "chart.html").string(),
             chart.reference_limited() ? ": reference-limited; raise --reference-steps" : "");
}

}  // namespace

void add_chart_verb(CLI::App& app, int& exit_code) {
  auto* verb = app.add_subcommand("chart", "Speed against accuracy of scenes: CSV, SVG, PNG, HTML");
  const auto request = std::make_shared<ChartRequest>();
  verb->add_option("scenes", request->scenes, "Scene files")->required()->type_name("SCENE");
  verb->add_option("-o,--output", request->output, "Directory; default: out/chart")
      ->type_name("DIR");
  verb->add_option("--device", request->device, "Of all points but those of the device count")
      ->type_name("D");
  verb->add_option("--frames", request->frames, "How many frames, instead of the scene's")
      ->type_name("N");
  verb->add_option("--set", request->overrides, "Override a value in every run; may be repeated")
      ->type_name("PATH=VALUE")
      ->allow_extra_args(false);
  verb->add_option("--knob", request->knobs, "One more series; may be repeated")
      ->type_name("PATH=V,V,...")
      ->allow_extra_args(false);
  verb->add_option("--runs", request->runs, "Timed runs a point")->check(CLI::Range(1, 1000));
  verb->add_option("--limit", request->limit, "Seconds a run may take; 0: any")
      ->check(CLI::NonNegativeNumber);
  verb->add_option("--reference-steps", request->reference_steps,
                   "Steps of the reference for one of the scene, a power of two")
      ->check(CLI::IsMember({2, 4, 8, 16, 32, 64, 128}));
  verb->add_option("--peers", request->peers, "CSV of others' points: name,error,seconds")
      ->type_name("FILE");
  verb->add_flag("--quick", request->quick, "Fewer points");
  verb->add_flag("--fresh", request->fresh, "Measure again what an earlier sweep has measured");
  verb->callback([request, &exit_code] {
    for (const std::string& scene : request->scenes) chart_scene(scene, *request);
    exit_code = 0;
  });
}

}  // namespace weft::app
