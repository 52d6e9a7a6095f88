#include "host/app/chart/chart_sweep.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <cstdio>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <future>
#include <mutex>
#include <sstream>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "host/app/chart/accuracy_target.hpp"
#include "host/app/chart/chart_output.hpp"
#include "host/app/chart/chart_progress.hpp"
#include "host/app/chart/chart_runs.hpp"
#include "host/app/process/child.hpp"
#include "host/app/run/run_lock.hpp"
#include "host/base/file_bytes.hpp"
#include "host/base/file_operations.hpp"
#include "host/input/counted.hpp"
#include "host/input/safe_text.hpp"
#include "host/io/scene/scene_file.hpp"
#include "host/lab/plan/plan.hpp"
#include "weft/devices.hpp"

namespace weft::app {
namespace {

namespace fs = std::filesystem;

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
    if (!is_file(file_)) return;
    std::istringstream in(read_file_bytes(file_));
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
          p.setting.series == wanted.setting.series && p.setting.label == wanted.setting.label &&
          p.starts == wanted.starts &&
          (!p.failure.empty() || static_cast<int>(p.seconds.size()) >= runs))
        return &p;
    return nullptr;
  }

  void add(const ChartPoint& point) const {
    std::ofstream(file_, std::ios::app)
        << json_of(point).dump(-1, ' ', false, Json::error_handler_t::replace) << "\n";
  }

 private:
  fs::path file_;
  std::vector<ChartPoint> points_;
};

std::string name_of(const ChartSetting& s) {
  return fmt::format("{}: {} ({})", s.series, s.label, s.method);
}

std::string outcome_of(const ChartPoint& p) {
  return p.failure.empty()
             ? fmt::format("error {:.3g}, {:.3g} s per simulated s", p.error, p.median())
             : "failed: " + p.failure;
}

/// Another number of ranks must not move a result.
void require_same_bits(std::vector<ChartPoint>& points) {
  const auto own = std::find_if(points.begin(), points.end(), [](const ChartPoint& p) {
    return p.setting.series == own_series && p.failure.empty();
  });
  if (own == points.end()) return;
  const std::string hash = own->state_hash;
  for (ChartPoint& p : points)
    if (p.setting.series == "devices" && p.failure.empty() && p.state_hash != hash)
      p.failure = "another number of devices ended in another state";
}

/// For each of some needs the settings that `weft run --need` would begin with, less what the plan
/// leaves out.
std::vector<ChartSetting> planned_settings(const Scene& scene,
                                           const std::vector<ChartPoint>& points) {
  std::vector<std::string> unneeded;
  for (const lab::StagePlan& stage : lab::plan_stages(scene))
    if (stage.verdict == lab::Verdict::left_out && !stage.off.empty())
      unneeded.push_back(stage.off);
  std::vector<ChartSetting> settings;
  for (const double error : {0.1, 0.01, 0.001}) {
    const ChartPoint* best = cheapest(points, {error, {}});
    if (best == nullptr) continue;
    ChartSetting setting = best->setting;
    setting.series = planned_series;
    setting.label = fmt::format("error < {:g} %: {}, {}", 100 * error, best->setting.series,
                                best->setting.label);
    setting.overrides.insert(setting.overrides.end(), unneeded.begin(), unneeded.end());
    settings.push_back(std::move(setting));
  }
  return settings;
}

/// The sweep of one scene.
class Sweep {
 public:
  explicit Sweep(const ChartRequest& request);
  void execute();

 private:
  void measure_all(std::vector<ChartSetting> settings);
  std::string measure(const ChartSetting& setting, std::size_t place, int slot,
                      const std::vector<int>& cores);
  Chart chart() const;

  const ChartRequest& request_;
  Scene scene_;
  fs::path folder_;
  ChartRuns runs_;
  RunLock lock_;  ///< of the folder, which runs_ makes
  PointBook book_;
  ChartReference reference_;
  std::vector<std::vector<int>> cores_;
  std::vector<ChartPoint> points_, peers_;
  std::mutex mutex_;
};

Scene scene_of(const ChartRequest& request) {
  SceneRequest with_frames = request;
  if (!request.frames.empty()) with_frames.overrides.push_back("time.frames=" + request.frames);
  return with_fixed_steps(with_frames.read(), "weft chart");
}

Sweep::Sweep(const ChartRequest& request)
    : request_(request),
      scene_(scene_of(request)),
      folder_(fs::path(request.output.empty() ? "out/chart" : request.output) /
              safe_file_name(scene_.name)),
      runs_(folder_ / "runs", request),
      lock_(folder_),
      book_(folder_ / "points.jsonl", request.fresh),
      cores_(request.jobs > 1 ? core_groups(request.jobs) : std::vector<std::vector<int>>(1)) {
  if (!request.peers.empty()) peers_ = read_peers(request.peers);
}

Chart Sweep::chart() const {
  Chart chart;
  chart.scene = scene_.name;
  chart.about = fmt::format("Reference: {}. Chaos: {}.", reference_.source, reference_.chaos);
  if (cores_.size() > 1)
    chart.about += fmt::format(" {} runs at once, each on {} of its own.", cores_.size(),
                               counted(cores_.front().size(), "core"));
  if (request_.starts > 1)
    chart.about += fmt::format(" After it, means over {} starts are compared.", request_.starts);
  chart.floor = reference_.floor;
  chart.after_chaos = reference_.after_chaos();
  for (const std::string& line : describe_devices())
    if (line.starts_with("cpu") || request_.device.starts_with("cuda"))
      chart.machine += (chart.machine.empty() ? "" : "; ") + line;
  for (const ChartPoint& p : points_)
    if (!p.command.empty()) chart.points.push_back(p);
  require_same_bits(chart.points);
  chart.points.insert(chart.points.end(), peers_.begin(), peers_.end());
  chart.finished = now_text();
  return chart;
}

/// @param place in points_
/// @return one line that says how it went
std::string Sweep::measure(const ChartSetting& setting, std::size_t place, int slot,
                           const std::vector<int>& cores) {
  const ChartPoint point = runs_.measure(setting, reference_, slot, cores);
  const std::lock_guard<std::mutex> lock(mutex_);
  points_[place] = point;
  book_.add(point);
  // What is cut off has all that was measured.
  write_chart_files(chart(), folder_);
  return outcome_of(point);
}

/// Adds points, by as many threads as there are groups of cores; those of other devices alone.
void Sweep::measure_all(std::vector<ChartSetting> settings) {
  const std::size_t first = points_.size();
  points_.resize(first + settings.size());
  ChartProgress progress(stdout, scene_.name, settings.size());
  std::vector<std::size_t> side_by_side, alone;
  for (std::size_t k = 0; k < settings.size(); ++k) {
    if (const ChartPoint* kept = book_.find(runs_.unmeasured(settings[k]), request_.runs)) {
      points_[first + k] = *kept;
      progress.skip();
      continue;
    }
    const bool other = cores_.size() > 1 && settings[k].device != request_.device;
    (other ? alone : side_by_side).push_back(k);
  }
  const auto work = [&](std::size_t k, int slot, const std::vector<int>& cores) {
    progress.begin(name_of(settings[k]));
    progress.end(name_of(settings[k]), measure(settings[k], first + k, slot, cores));
  };
  std::atomic<std::size_t> next{0};
  std::vector<std::future<void>> workers;
  for (std::size_t g = 0; g < cores_.size(); ++g)
    workers.push_back(std::async(std::launch::async, [&, g] {
      for (std::size_t i = next++; i < side_by_side.size(); i = next++)
        work(side_by_side[i], static_cast<int>(g), cores_[g]);
    }));
  for (auto& worker : workers) worker.wait();
  for (auto& worker : workers) worker.get();
  for (const std::size_t k : alone) work(k, 0, {});
}

void Sweep::execute() {
  std::vector<ChartSetting> settings = chart_settings(scene_, request_);
  settings.insert(settings.begin(), {own_series, "as it is", scene_.method, request_.device, {}});
  fmt::print("{}: {}; first the reference\n", one_line(scene_.name),
             counted(settings.size(), "point"));
  std::fflush(stdout);
  reference_ = runs_.make_reference(scene_);
  measure_all(std::move(settings));
  measure_all(planned_settings(scene_, points_));
  const Chart done = chart();
  write_chart(done, folder_);
  fmt::print("{}{}\n", (folder_ / "chart.html").string(),
             done.reference_limited() ? ": reference-limited; raise --reference-steps" : "");
}

}  // namespace

void sweep_scene(const ChartRequest& request) {
  Sweep(request).execute();
}

}  // namespace weft::app
