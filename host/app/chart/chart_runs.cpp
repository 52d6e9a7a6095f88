#include "host/app/chart/chart_runs.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <future>
#include <optional>
#include <system_error>
#include <thread>
#include <utility>

#include "host/app/process/child.hpp"
#include "host/app/run/run_directory.hpp"
#include "host/app/run/sewn_scene.hpp"
#include "host/base/atomic_file.hpp"
#include "host/base/file_bytes.hpp"
#include "host/base/file_operations.hpp"
#include "host/io/animation/mesh_sequence.hpp"
#include "host/io/scene/scene_file.hpp"
#include "host/lab/check/displaced_verdict.hpp"
#include "weft/error.hpp"
#include "weft/version.hpp"

namespace weft::app {
namespace {

namespace fs = std::filesystem;
using Positions = std::vector<Vec3<double>>;

constexpr double perturbation = 1e-12;  ///< over the diagonal: what chaos is looked for with
/// Frames are compared point by point until the perturbation has grown so many times: a step that
/// is off by a thousandth of the cloth is then off by all of it, and no smaller step makes it
/// better.
constexpr double growth_max = 1e3;
constexpr double chaotic = growth_max * perturbation;  ///< over the diagonal
constexpr double start_distance = 1e-6;  ///< over the diagonal: by which starts differ

Json json_of(const fs::path& file) {
  if (!is_file(file)) return {};
  Json json = Json::parse(read_file_bytes(file), nullptr, false);
  return json.is_discarded() ? Json() : json;
}

/// Cloth of all frames of a run, at positions of the first mesh if that never changes.
std::vector<Mesh> cloth_frames(const fs::path& run) {
  const auto sequence = io::open_sequence(run);
  std::vector<Mesh> frames;
  for (std::size_t k = 0; k < sequence->frames().size(); ++k)
    frames.push_back(io::joined(io::in_world(sequence->read(k)).cloths));
  return frames;
}

std::vector<Positions> positions_of(std::vector<Mesh> frames) {
  std::vector<Positions> positions;
  for (Mesh& mesh : frames) positions.push_back(std::move(mesh.positions));
  return positions;
}

/// Mean over the frames up to `last` of the mean distance, over `size`.
double mean_error(const Mesh& mesh, const std::vector<Positions>& a,
                  const std::vector<Positions>& b, int last, double size) {
  double sum = 0;
  for (int k = 1; k <= last; ++k) {
    const auto i = static_cast<std::size_t>(k);
    const double e = lab::mean_distance(mesh.triangles, a[i], b[i]) / size;
    sum += e * e;
  }
  return std::sqrt(sum / std::max(1, last));
}

double largest_strain(const Scene& scene) {
  return lab::validate(scene.cloths[0].mesh, nullptr).strain.largest.max;
}

/// Of the frames after `horizon`.
std::vector<lab::Statistics> statistics_after(int horizon, const std::vector<Mesh>& frames) {
  std::vector<lab::Statistics> all;
  for (std::size_t k = static_cast<std::size_t>(horizon) + 1; k < frames.size(); ++k)
    all.push_back(lab::statistics(frames[k]));
  return all;
}

/// @param of_starts [start][frame]
std::vector<lab::MeanStatistics> means_over_starts(
    const std::vector<std::vector<lab::Statistics>>& of_starts) {
  std::vector<lab::MeanStatistics> means;
  for (std::size_t k = 0; k < of_starts.front().size(); ++k) {
    std::vector<lab::Statistics> of_frame;
    for (const auto& start : of_starts) of_frame.push_back(start.at(k));
    means.push_back(lab::mean_statistics(of_frame));
  }
  return means;
}

/// Errors of the frames before chaos.
void compare(const std::vector<Mesh>& frames, const ChartReference& reference, ChartPoint& point) {
  double sum = 0;
  const auto horizon = static_cast<std::size_t>(reference.horizon);
  for (std::size_t k = 1; k <= horizon; ++k) {
    const Mesh& mesh = frames[k];
    const lab::Resampling map(reference.mesh, mesh);  // adaptive meshes change
    if (!map.known()) throw SimulationError("its mesh has nothing in common with the reference");
    const Positions there = map.positions(reference.frames[k]);
    const double e = lab::mean_distance(mesh.triangles, there, mesh.positions) / reference.size;
    sum += e * e;
    if (k < horizon) continue;
    Mesh surface = reference.mesh;
    surface.positions = reference.frames[k];
    point.hausdorff = lab::hausdorff_distance(surface, mesh) / reference.size;
    point.curvature = lab::curvature_error(mesh.triangles, there, mesh.positions);
  }
  point.error = std::sqrt(sum / static_cast<double>(std::max<std::size_t>(1, horizon)));
}

int all_cores() {
  return static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
}

/// What the independent validator says of all frames.
void validate_all(const fs::path& run, int threads, ChartPoint& point) {
  const auto sequence = io::open_sequence(run);
  const Json resolved = json_of(run / "scene.json");
  lab::ValidatorOptions options;
  options.sewn = sews(resolved);
  options.list_limit = 0;
  options.threads = threads;
  point.intersections = 0;
  for (std::size_t k = 0; k < sequence->frames().size(); ++k) {
    const io::FrameMeshes meshes = sequence->read(k);
    const Mesh obstacle = io::joined(meshes.obstacles);
    std::optional<Mesh> displaced = RunDirectory(run).read_displaced(sequence->frames()[k]);
    if (displaced) io::move_origin(*displaced, {0, 0, 0}, meshes.origin);
    const auto verdict =
        lab::validate(io::joined(meshes.cloths), meshes.obstacles.empty() ? nullptr : &obstacle,
                      displaced ? &*displaced : nullptr, options);
    point.intersections += static_cast<double>(verdict.intersections());
    point.stretch = verdict.prescribed.strain.largest.max;
  }
}

std::vector<std::string> overrides_of(const ChartSetting& setting) {
  std::vector<std::string> overrides = setting.overrides;
  overrides.insert(overrides.begin(), "method.type=" + setting.method);
  return overrides;
}

std::string reference_name(const std::string& integrator, int steps) {
  return fmt::format("reference_{}_{}", integrator, steps);
}

std::string start_name(int start) {
  return fmt::format("reference_start_{}", start);
}

const char* chaos_name(bool shaken) {
  return shaken ? "chaos_shaken" : "chaos_plain";
}

std::vector<std::string> chaos_overrides(const Scene& scene, bool shaken) {
  std::vector<std::string> overrides{"precision=double"};
  if (shaken)
    overrides.push_back(fmt::format("jitter.amplitude={:.3g}", perturbation * diagonal_of(scene)));
  return overrides;
}

}  // namespace

ChartRuns::ChartRuns(fs::path folder, const ChartRequest& request)
    : folder_(std::move(folder)), request_(request) {
  fs::create_directories(folder_);
}

std::vector<std::string> ChartRuns::arguments(const std::string& device,
                                              const std::vector<std::string>& overrides) const {
  std::vector<std::string> words{"run", request_.scene, "--device", device, "--no-preview"};
  if (!request_.frames.empty()) words.insert(words.end(), {"--frames", request_.frames});
  return request_.command(std::move(words), overrides);
}

/// @return why it failed, or nothing
std::string ChartRuns::run(const fs::path& output, const std::string& device,
                           const std::vector<std::string>& overrides,
                           const std::vector<int>& cores) const {
  fs::remove_all(output);
  std::vector<std::string> words = arguments(device, overrides);
  words.insert(words.end(), {"-o", output.string()});
  const fs::path log = output.string() + ".log";
  const ChildEnd end = run_child(words, log, request_.limit, cores);
  fs::remove(log);
  if (end.timed_out) return fmt::format("not done after {:g} s", request_.limit);
  if (end.exit_code == 0) return {};
  if (end.exit_code == 130) throw SimulationError("stopped by a signal");
  return end.message.empty() ? fmt::format("ended with {}", end.exit_code) : end.message;
}

/// Dearest first.
std::vector<ChartRuns::ReferenceRun> ChartRuns::reference_runs(const Scene& scene) const {
  std::vector<const char*> integrators{"bdf2", "implicit_euler"};
  // A truth that is known needs no limit of BDF2.
  if (free_fall(scene, 0)) integrators = {"implicit_euler"};
  std::vector<ReferenceRun> all;
  for (const int steps : {request_.reference_steps, request_.reference_steps / 2})
    for (const char* integrator : integrators)
      all.push_back(
          {reference_name(integrator, steps), reference_overrides(scene, steps, integrator)});
  for (const bool shaken : {false, true})
    all.push_back({chaos_name(shaken), chaos_overrides(scene, shaken)});
  for (int start = 1; start < request_.starts; ++start) {
    all.push_back({start_name(start),
                   reference_overrides(scene, request_.reference_steps / 2, integrators.front())});
    for (const std::string& text : start_overrides(diagonal_of(scene), start))
      all.back().overrides.push_back(text);
  }
  return all;
}

/// Of a start that differs from the scene's.
/// @param size [m]
std::vector<std::string> ChartRuns::start_overrides(double size, int start) const {
  return {fmt::format("jitter.amplitude={:.3g}", start_distance * size),
          fmt::format("jitter.seed={}", start)};
}

/// One that is there, made by the same command and commit, is kept.
void ChartRuns::run_reference(const ReferenceRun& reference, ChartProgress& progress) const {
  const fs::path output = folder_ / reference.name;
  const Json wanted{{"command", shell_text(arguments(request_.device, reference.overrides))},
                    {"commit", build_info().commit}};
  if (!request_.fresh && json_of(output / "reference.json") == wanted) {
    progress.skip();
    return;
  }
  progress.begin(reference.name);
  const auto start = std::chrono::steady_clock::now();
  const std::string failure = run(output, request_.device, reference.overrides);
  if (!failure.empty())
    throw SimulationError(fmt::format("the reference {} failed: {}", reference.name, failure));
  write_file_atomically(output / "reference.json", wanted.dump(2) + "\n");
  const std::chrono::duration<double> spent = std::chrono::steady_clock::now() - start;
  progress.end(reference.name, fmt::format("{:.3g} s", spent.count()));
}

void ChartRuns::run_references(const Scene& scene) const {
  const std::vector<ReferenceRun> all = reference_runs(scene);
  ChartProgress progress(stdout, scene.name + ": reference", all.size());
  std::atomic<std::size_t> next{0};
  std::vector<std::future<void>> workers;
  for (int k = 0; k < request_.jobs; ++k)
    workers.push_back(std::async(std::launch::async, [&] {
      for (std::size_t i = next++; i < all.size(); i = next++) run_reference(all[i], progress);
    }));
  for (auto& worker : workers) worker.wait();
  for (auto& worker : workers) worker.get();
}

ChartReference ChartRuns::make_reference(const Scene& scene) const {
  ChartReference reference;
  run_references(scene);
  const int n = request_.reference_steps;
  const auto frames_of = [&](int steps, const std::string& integrator) {
    return cloth_frames(folder_ / reference_name(integrator, steps));
  };
  const auto limit = [&](const std::string& integrator, int order) {
    std::vector<Mesh> fine = frames_of(n, integrator);
    const auto coarse = positions_of(frames_of(n / 2, integrator));
    if (reference.frames.empty()) reference.mesh = fine[0];
    std::vector<Positions> frames = positions_of(std::move(fine));
    for (std::size_t k = 0; k < frames.size(); ++k)
      frames[k] = lab::extrapolated(coarse.at(k), frames[k], order);
    return frames;
  };
  const std::vector<Positions> second = limit("implicit_euler", 1);
  const bool exact = free_fall(scene, 0).has_value();
  if (exact) {
    reference.source = "the parabola of free fall";
    for (std::size_t k = 0; k < second.size(); ++k)
      reference.frames.push_back(*free_fall(scene, static_cast<double>(k) / scene.time.frame_rate));
  } else {
    reference.frames = second;
    reference.frames = limit("bdf2", 2);
    reference.source = fmt::format(
        "Richardson's extrapolation in double: BDF2 with Newton's method at {} and {} steps for "
        "one "
        "of the scene; checked against implicit Euler's",
        n / 2, n);
  }
  reference.size = lab::diagonal(reference.mesh.positions);
  reference.horizon = static_cast<int>(reference.frames.size()) - 1;
  find_horizon(scene, reference);
  std::vector<Mesh> first(reference.frames.size(), reference.mesh);
  for (std::size_t k = 0; k < first.size(); ++k) first[k].positions = reference.frames[k];
  std::vector<std::vector<lab::Statistics>> of_starts{statistics_after(reference.horizon, first)};
  for (int start = 1; start < request_.starts; ++start)
    of_starts.push_back(
        statistics_after(reference.horizon, cloth_frames(folder_ / start_name(start))));
  reference.after = means_over_starts(of_starts);
  if (!exact)
    reference.floor =
        mean_error(reference.mesh, reference.frames, second, reference.horizon, reference.size);
  return reference;
}

/// A tiny change of the start tells how long frames can be compared point by point.
void ChartRuns::find_horizon(const Scene& scene, ChartReference& reference) const {
  std::vector<Mesh> before = cloth_frames(folder_ / chaos_name(false));
  std::vector<Mesh> after = cloth_frames(folder_ / chaos_name(true));
  double grown = 0;
  for (std::size_t k = 1; k < std::min(before.size(), after.size()); ++k) {
    const lab::Resampling map(after[k], before[k]);
    if (map.known())
      grown = lab::mean_distance(before[k].triangles, before[k].positions,
                                 map.positions(after[k].positions)) /
              reference.size;
    if (map.known() && grown <= chaotic) continue;
    reference.horizon = std::max(1, static_cast<int>(k) - 1);
    break;
  }
  reference.chaos = fmt::format(
      "a start changed by {:g} of the diagonal ends {:.2g} of it away at frame {} of {}; points "
      "are "
      "compared up to frame {}, {:.4g} s",
      perturbation, grown,
      std::min<std::size_t>(before.size() - 1, static_cast<std::size_t>(reference.horizon) + 1),
      before.size() - 1, reference.horizon, reference.horizon / scene.time.frame_rate);
}

ChartPoint ChartRuns::unmeasured(const ChartSetting& setting) const {
  ChartPoint point;
  point.setting = setting;
  std::vector<std::string> words = arguments(setting.device, overrides_of(setting));
  words.insert(words.begin(), "weft");
  point.command = shell_text(words);
  point.commit = std::string(build_info().commit) + (build_info().dirty ? " with changes" : "");
  point.starts = request_.starts;
  return point;
}

/// Runs the other starts of a point, and compares means of the frames after chaos.
/// @param of_starts [start][frame] of the first one
void ChartRuns::measure_starts(const ChartReference& reference, const fs::path& output,
                               const std::vector<int>& cores,
                               std::vector<std::vector<lab::Statistics>> of_starts,
                               ChartPoint& point) const {
  for (int start = 1; start < request_.starts; ++start) {
    std::vector<std::string> overrides = overrides_of(point.setting);
    for (const std::string& text : start_overrides(reference.size, start))
      overrides.push_back(text);
    point.failure = run(output, point.setting.device, overrides, cores);
    if (!point.failure.empty()) return;
    of_starts.push_back(statistics_after(reference.horizon, cloth_frames(output)));
  }
  const std::vector<lab::MeanStatistics> means = means_over_starts(of_starts);
  double difference = 0, error = 0;
  for (std::size_t k = 0; k < means.size(); ++k) {
    difference += lab::difference(reference.after[k].mean, means[k].mean);
    error += lab::difference_error(reference.after[k], means[k]);
  }
  const double scale = 1 / (static_cast<double>(means.size()) * reference.size);
  point.statistics = scale * difference;
  if (request_.starts > 1) point.statistics_error = scale * error;
}

ChartPoint ChartRuns::measure(const ChartSetting& setting, const ChartReference& reference,
                              int slot, const std::vector<int>& cores) const {
  ChartPoint point = unmeasured(setting);
  const std::vector<std::string> overrides = overrides_of(setting);
  const fs::path output = folder_ / fmt::format("point_{}", slot);
  try {
    for (int n = 0; n < request_.runs; ++n) {
      point.failure = run(output, setting.device, overrides, cores);
      if (!point.failure.empty()) return point;
      const Json report = json_of(output / "report.json");
      point.seconds.push_back(report.at("wall_s").get<double>() /
                              report.at("simulated_s").get<double>());
      const std::string hash = report.at("state_hash");
      if (n > 0 && hash != point.state_hash)
        throw SimulationError("two runs of the same command ended in different states");
      point.state_hash = hash;
      if (report.at("energy").at("drift").is_number()) point.drift = report["energy"]["drift"];
    }
    std::sort(point.seconds.begin(), point.seconds.end());
    const std::vector<Mesh> frames = cloth_frames(output);
    if (frames.size() != reference.frames.size())
      throw SimulationError("it has another number of frames than the reference");
    compare(frames, reference, point);
    validate_all(output, cores.empty() ? all_cores() : static_cast<int>(cores.size()), point);
    if (!reference.after.empty())
      measure_starts(reference, output, cores, {statistics_after(reference.horizon, frames)},
                     point);
  } catch (const SceneError& error) {
    point.failure = error.what();
  } catch (const Json::exception& error) {
    point.failure = std::string("its report lacks something: ") + error.what();
  } catch (const SimulationError& error) {
    if (std::string(error.what()) == "stopped by a signal") throw;
    point.failure = error.what();
  }
  fs::remove_all(output);
  return point;
}

double run_distance(const fs::path& reference, const fs::path& run) {
  const std::vector<Mesh> there = cloth_frames(reference), here = cloth_frames(run);
  if (there.size() != here.size() || there.empty())
    throw SimulationError("two runs of a scene differ in their number of frames");
  double sum = 0;
  for (std::size_t k = 1; k < here.size(); ++k) {
    const lab::Resampling map(there[k], here[k]);  // adaptive meshes change
    if (!map.known()) throw SimulationError("two runs of a scene have no mesh in common");
    const double e =
        lab::mean_distance(here[k].triangles, map.positions(there[k].positions), here[k].positions);
    sum += e * e;
  }
  return std::sqrt(sum / static_cast<double>(std::max<std::size_t>(1, here.size() - 1))) /
         lab::diagonal(there[0].positions);
}

double run_intersections(const fs::path& run) {
  ChartPoint point;
  validate_all(run, all_cores(), point);
  return point.intersections;
}

std::optional<Positions> free_fall(const Scene& scene, double time) {
  const bool alone = scene.cloths.size() == 1 && scene.obstacles.empty() && scene.pins.empty() &&
                     scene.handles.empty() && scene.seams.empty() && scene.wind.density == 0;
  if (!alone) return {};
  const Cloth& cloth = scene.cloths[0];
  const auto still = [](const Vec3<double>& v) { return length(v) == 0; };
  const bool damped = std::any_of(scene.materials.begin(), scene.materials.end(),
                                  [](const Material& m) { return m.damping_mass > 0; });
  if (damped || cloth.pressure != 0 || !still(cloth.angular_velocity) ||
      !cloth.rest_positions.empty())
    return {};
  // Flat and unstretched: then nothing acts but gravity.
  const auto& x = cloth.mesh.positions;
  const bool flat = std::all_of(x.begin(), x.end(), [&](const auto& p) { return p[2] == x[0][2]; });
  if (!flat || std::abs(largest_strain(scene)) > 1e-12) return {};
  const Vec3<double> moved = time * cloth.velocity + (0.5 * time * time) * scene.gravity;
  Positions positions = x;
  for (auto& p : positions) p += moved;
  return positions;
}

}  // namespace weft::app
