// Steps, and what is asked after them.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <mutex>
#include <optional>
#include <stdexcept>
#include <utility>

#include "benchmarks/stability/isolate.hpp"
#include "benchmarks/stability/run.hpp"
#include "host/io/mesh/mesh_file.hpp"
#include "host/lab/check/displaced_verdict.hpp"
#include "host/time_parallel/slices.hpp"
#include "weft/error.hpp"

namespace weft::stability {
namespace {

namespace fs = std::filesystem;

constexpr int slices_wanted = 3;

bool finite(const Vec3<double>& x) {
  return std::isfinite(x[0]) && std::isfinite(x[1]) && std::isfinite(x[2]);
}

void require_finite(const Frame& frame, std::int64_t step) {
  for (std::size_t c = 0; c < frame.cloth_positions.size(); ++c)
    for (std::size_t v = 0; v < frame.cloth_positions[c].size(); ++v)
      if (!finite(frame.cloth_positions[c][v]) || !finite(frame.cloth_velocities[c][v]))
        throw Wrong(fmt::format("vertex {} of cloth {} is not finite after step {}", v, c, step));
}

/// All meshes as one.
/// @param positions of mesh k: positions(k)
template <class Parts, class Positions>
Mesh joined(const Parts& parts, const Positions& positions) {
  std::vector<io::NamedMesh> meshes;
  for (std::size_t k = 0; k < parts.size(); ++k) {
    Mesh mesh;
    mesh.positions = positions(k);
    mesh.triangles = parts[k].mesh.triangles;
    meshes.push_back({parts[k].name, std::move(mesh)});
  }
  return io::joined(meshes);
}

void require_no_intersection(const Scene& scene, const Frame& frame, std::int64_t step) {
  lab::ValidatorOptions options;
  options.sewn = !scene.seams.empty();
  const Mesh cloth = joined(scene.cloths, [&](std::size_t k) { return frame.cloth_positions[k]; });
  const Mesh obstacle =
      joined(scene.obstacles, [&](std::size_t k) { return frame.obstacle_positions[k]; });
  const Mesh displaced =
      joined(scene.obstacles, [&](std::size_t k) { return frame.simulated_obstacle(k); });
  const lab::DisplacedVerdict verdict =
      lab::validate(cloth, scene.obstacles.empty() ? nullptr : &obstacle,
                    frame.any_displaced() ? &displaced : nullptr, options);
  const auto pairs = verdict.intersections();
  if (pairs > 0)
    throw Wrong(fmt::format("{} pairs of triangles intersect after step {}, which was accepted",
                            pairs, step));
}

void validate_state(const Scene& scene, const Frame& frame, std::int64_t step) {
  require_finite(frame, step);
  if (scene.contact.self) require_no_intersection(scene, frame, step);
}

/// Checks what slices give.
class JudgingSink final : public SliceSink {
 public:
  JudgingSink(int steps, int steps_per_frame, int every, const Observer& observer)
      : steps_(steps), steps_per_frame_(steps_per_frame), every_(every), observer_(observer) {}
  void begin(int slice, std::int64_t, const Energy& energy) override {
    const std::lock_guard<std::mutex> lock(mutex_);
    energies_[slice] = energy;
  }
  void step(int slice, const StepReport&, const std::optional<Energy>& energy, double) override {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (energy) energies_[slice] = *energy;
  }
  void frame(int slice, const Scene& scene, const Frame& frame) override {
    const std::lock_guard<std::mutex> lock(mutex_);
    const int step = frame.number * steps_per_frame_;
    if (step % every_ != 0 && step != steps_) return;
    validate_state(scene, frame, step);
    if (observer_ && frame.number > 0) observer_(scene, frame, energies_[slice]);
  }
  void sync(int) override {}

 private:
  int steps_, steps_per_frame_, every_;
  const Observer& observer_;
  std::mutex mutex_;
  std::map<int, Energy> energies_;
};

[[noreturn]] void refuse(const std::string& who, Failure failure, const std::string& detail) {
  throw SimulationError(fmt::format("{}: {}: {}", who, describe(failure), detail));
}

void require_done(const SlicesOutcome& outcome) {
  if (outcome.coarse.failure != Failure::none)
    refuse(fmt::format("coarse step {}", outcome.coarse.steps + 1), outcome.coarse.failure,
           outcome.coarse.failure_detail);
  for (const SliceOutcome& slice : outcome.slices)
    if (slice.failure != Failure::none)
      refuse(fmt::format("step {}", slice.end + 1), slice.failure, slice.failure_detail);
  if (!outcome.done) throw Wrong("slices are left, and none has failed");
}

/// What a simulation of single steps can begin with.
Scene first_scene(Scene scene) {
  if (scene.method == "time_parallel") scene.method = scene.time_parallel.method;
  return scene;
}

}  // namespace

Run::Run(Scene scene, std::function<DeviceSet()> devices)
    : scene_(scene.method == "time_parallel" ? scene : Scene{}),
      devices_(std::move(devices)),
      simulation_(first_scene(std::move(scene)), devices_()) {}

void Run::watch(int steps, int judged, const Observer& observer, const fs::path& folder) {
  const int every = std::max(1, steps / judged);
  if (scene_.method == "time_parallel") {
    const fs::path place = folder.empty() ? scratch_folder() / "slices" : folder;
    if (folder.empty()) fs::remove_all(place);  // of a run that failed
    watch_slices(steps, every, observer, place);
    if (folder.empty()) fs::remove_all(place);
    return;
  }
  for (int n = 1; n <= steps; ++n) {
    const StepReport report = simulation_.step();
    const bool refused = report.failure != Failure::none;
    if (refused || n % every == 0 || n == steps) {
      const Frame frame = simulation_.frame();
      validate_state(simulation_.scene(), frame, report.number);
      if (observer) observer(simulation_.scene(), frame, simulation_.energy());
    }
    if (refused)
      refuse(fmt::format("step {}", report.number), report.failure, report.failure_detail);
  }
}

void Run::watch_slices(int steps, int every, const Observer& observer, const fs::path& folder) {
  if (simulation_.step_number() > 0) throw std::logic_error("slices begin at the start");
  const int per_frame = simulation_.steps_per_frame();
  if (steps % per_frame != 0) throw std::logic_error("slices end with a frame");
  scene_.time.frames = steps / per_frame;
  scene_.output.checkpoint_every = 0;
  const TimeParallelScene scene(scene_, std::min(slices_wanted, steps));
  JudgingSink sink(steps, per_frame, std::max(every, per_frame), observer);
  SliceOptions options;
  options.workers = 2;
  options.run = folder;
  options.devices = [this](int) { return devices_(); };
  require_done(run_slices(scene, options, sink));
  simulation_ = Simulation(scene.fine(), devices_());
  simulation_.resume(SliceFiles(folder, scene.slices() - 1).end(), SceneChanges::allow);
}

void Run::resume(const fs::path& file, SceneChanges changes) {
  if (scene_.method == "time_parallel")
    throw SceneError("", "resume", "a checkpoint of one state",
                     "the folder of a run that was cut off, with the method \"time_parallel\"");
  simulation_.resume(file, changes);
}

}  // namespace weft::stability
