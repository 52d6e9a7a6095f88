#pragma once

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "host/scene/frame_steps.hpp"
#include "host/time_parallel/boundary_states.hpp"
#include "host/time_parallel/coarse_run.hpp"
#include "host/time_parallel/coarse_states.hpp"
#include "host/time_parallel/material_frame.hpp"
#include "host/time_parallel/schedule.hpp"
#include "host/time_parallel/slice_boundary.hpp"
#include "host/time_parallel/slice_run.hpp"
#include "host/time_parallel/slice_start.hpp"
#include "host/time_parallel/slices.hpp"
#include "weft/devices.hpp"
#include "weft/error.hpp"
#include "weft/simulation.hpp"

/// Runs that weft_bench_time_parallel compares: the serial one, the coarse one, and one in slices.
namespace weft::bench {

/// What a run has cost until the end of each step, by the clock and by what was counted.
struct StepCosts {
  std::vector<double> wall{0};  ///< [steps + 1] [s]
  std::vector<double> work{0};  ///< [steps + 1] see counted_work()

  void add(double step_wall, double step_work) {
    wall.push_back(wall.back() + step_wall);
    work.push_back(work.back() + step_work);
  }
};

/// What steps were taken for, those that failed or were repeated too.
struct StepProfile {
  StageTimes stages;  ///< [s]
  std::int64_t steps = 0;
  std::int64_t solves = 0;
  std::int64_t iterations = 0;
  std::int64_t proximities = 0;
  std::int64_t zone_visits = 0;
  std::int64_t searches = 0, rebuilds = 0;
  std::int64_t halved = 0, rigid = 0;  ///< steps on these fallback levels
  std::int64_t remeshes = 0;
  std::int64_t remeshed = 0;  ///< triangles after each remesh, in sum

  void add(const StepReport& r) {
    stages += r.stages;
    ++steps;
    solves += r.solves;
    iterations += r.iterations;
    proximities += r.proximities;
    zone_visits += r.zone_visits;
    searches += r.searches;
    rebuilds += r.rebuilds;
    halved += r.fallback_level == FallbackLevel::halved ? 1 : 0;
    rigid += r.fallback_level == FallbackLevel::rigid ? 1 : 0;
    remeshes += r.remesh.triangles > 0 ? 1 : 0;
    remeshed += r.remesh.triangles;
  }
};

/// Cost of all steps before a place between two of them.
inline double cost_until(const std::vector<double>& sums, double place) {
  const auto last = static_cast<double>(sums.size() - 1);
  const double inside = std::clamp(place, 0.0, last);
  const auto i = static_cast<std::size_t>(std::min(inside, last - 1));
  return sums[i] + (inside - static_cast<double>(i)) * (sums[i + 1] - sums[i]);
}

inline std::size_t triangle_count(const Scene& scene) {
  std::size_t count = 0;
  for (const Cloth& cloth : scene.cloths) count += cloth.mesh.triangles.size();
  return count;
}

inline std::size_t obstacle_triangle_count(const Scene& scene) {
  std::size_t count = 0;
  for (const Obstacle& obstacle : scene.obstacles) count += obstacle.mesh.triangles.size();
  return count;
}

inline std::size_t bytes_of(const Simulation& simulation) {
  std::size_t sum = 0;
  for (const std::size_t bytes : simulation.peak_device_bytes()) sum += bytes;
  return sum;
}

/// A state of a run and the meshes that it is on.
struct KeptState {
  Frame frame;
  std::vector<Mesh> meshes;  ///< [cloths]

  /// On the meshes that a scene has now.
  Frame on(const Scene& scene) const {
    return frame_on(frame, cloth_meshes(meshes), cloth_meshes(scene));
  }
};

/// One run from its first to its last step, on one thread.
struct WholeRun {
  StepCosts costs;
  StepProfile profile;
  std::size_t bytes = 0;
  double largest_change = 0;               ///< [m] of a vertex between two frames
  std::map<std::int64_t, KeptState> kept;  ///< by step
  std::uint64_t state_hash = 0;
  std::int64_t steps_timed = 0;
  bool extrapolated = false;  ///< costs are those of some of the steps, spread over all
  /// What making starts from the coarse run's states has cost, where steps were sampled.
  StepCosts starts;
  std::vector<SliceStart> sampled_starts;
  bool from_slices = false;  ///< costs are those of the steps of slices, put together

  /// Of the cloths, on average where meshes change.
  /// @param scene as the run begins
  std::int64_t triangles(const Scene& scene) const {
    return profile.remeshes > 0 ? (profile.remeshed + profile.remeshes / 2) / profile.remeshes
                                : static_cast<std::int64_t>(triangle_count(scene));
  }
};

/// Takes a step, and counts it.
/// @throws SimulationError if it fails
inline StepReport counted_step(Simulation& simulation, StepCosts& costs) {
  const std::int64_t rows = cloth_rows(simulation.scene());
  const auto start = std::chrono::steady_clock::now();
  const StepReport report = simulation.step();
  const std::chrono::duration<double> took = std::chrono::steady_clock::now() - start;
  if (report.failure != Failure::none)
    throw SimulationError("step " + std::to_string(report.number) + " of " +
                          simulation.scene().name + ": " + describe(report.failure));
  costs.add(took.count(), counted_work(report, rows));
  return report;
}

/// The whole of a coarse run.
/// @param states directory for all states, see CoarseStates
/// @throws SimulationError if a step fails
inline WholeRun run_coarse(const CoarseScene& level, const std::filesystem::path& states) {
  WholeRun run;
  std::filesystem::create_directories(states);
  CoarseRun coarse(level, states);
  const std::int64_t steps = std::int64_t{frame_steps(level.scene.time)} * level.scene.time.frames;
  while (run.steps_timed < steps) {
    const auto start = std::chrono::steady_clock::now();
    const CoarseRun::Step step = coarse.step([] { return false; }, [](double) {});
    const std::chrono::duration<double> took = std::chrono::steady_clock::now() - start;
    if (step.done) run.costs.add(took.count(), step.work);
    ++run.steps_timed;
    for (const StepReport& report : step.taken) run.profile.add(report);
    if (step.failure != Failure::none)
      throw SimulationError("step " + std::to_string(run.steps_timed) + " of " + level.scene.name +
                            ": " + describe(step.failure) + ": " + step.failure_detail);
  }
  run.bytes = bytes_of(coarse.simulation());
  run.state_hash = coarse.simulation().state_hash();
  return run;
}

/// The farthest that a vertex moves from frame to frame, on the meshes of the later one.
class LargestMove {
 public:
  LargestMove() = default;
  explicit LargestMove(const Simulation& begin) { go_on(begin.scene(), begin.frame()); }
  void go_on(const Scene& scene, const Frame& frame) {
    if (last_)
      most_ = std::max(
          most_, largest_move(frame_on(*last_, cloth_meshes(meshes_), cloth_meshes(scene)), frame));
    last_ = frame;
    meshes_ = copied_meshes(scene);
  }
  double most() const { return most_; }  ///< [m]

 private:
  std::optional<Frame> last_;
  std::vector<Mesh> meshes_;  ///< of that
  double most_ = 0;
};

/// @param keep steps after which the state is kept
inline WholeRun run_whole(const Scene& scene, const std::set<std::int64_t>& keep) {
  WholeRun run;
  Simulation simulation(scene, host_devices(1));
  LargestMove largest(simulation);
  const auto keep_state = [&](std::int64_t step) {
    if (keep.count(step) > 0)
      run.kept[step] = {simulation.frame(), copied_meshes(simulation.scene())};
  };
  keep_state(0);
  while (simulation.frame_number() < scene.time.frames) {
    run.profile.add(counted_step(simulation, run.costs));
    const std::int64_t step = simulation.step_number();
    keep_state(step);
    if (step % simulation.steps_per_frame() != 0) continue;
    largest.go_on(simulation.scene(), simulation.frame());
  }
  run.largest_change = largest.most();
  run.bytes = bytes_of(simulation);
  run.state_hash = simulation.state_hash();
  run.steps_timed = simulation.step_number();
  return run;
}

/// The serial run from some of its steps: a few from each of `places` states, spread over the run,
/// that are those in which slices would start.
/// @param states of the coarse run
/// @param count  steps to time in all, at least
inline WholeRun run_sampled(const TimeParallelScene& scene, const std::filesystem::path& states,
                            std::int64_t count, int places) {
  WholeRun run;
  run.extrapolated = true;
  const auto starts = uniform_starts(scene.steps(), places);
  const std::int64_t each = (count + places - 1) / places;
  const auto file = states.parent_path() / "sample.weft";
  Simulation simulation(scene.fine(), host_devices(1));
  for (std::size_t j = 0; j < starts.size(); ++j) {
    if (j > 0) {
      const auto begin = std::chrono::steady_clock::now();
      run.sampled_starts.push_back(write_slice_start(scene.fine(), scene.coarse(), starts[j],
                                                     states, file, [](double) { return true; }));
      const std::chrono::duration<double> took = std::chrono::steady_clock::now() - begin;
      run.starts.add(took.count(), run.sampled_starts.back().work);
      simulation.resume(file, weft::SceneChanges::allow);
    }
    const std::int64_t next = j + 1 < starts.size() ? starts[j + 1] : scene.steps();
    StepCosts sample;
    for (std::int64_t k = 0; k < std::min(each, next - starts[j]); ++k) {
      run.profile.add(counted_step(simulation, sample));
      ++run.steps_timed;
    }
    const auto steps = static_cast<double>(sample.wall.size() - 1);
    for (std::int64_t k = starts[j]; k < next; ++k)
      run.costs.add(sample.wall.back() / steps, sample.work.back() / steps);
  }
  run.bytes = bytes_of(simulation);
  return run;
}

/// Notes what the steps of slices took, and how far vertices move from frame to frame.
class StepRecorder : public SliceSink {
 public:
  explicit StepRecorder(const TimeParallelScene& scene)
      : slices_(static_cast<std::size_t>(scene.slices())) {}

  void begin(int, std::int64_t, const Energy&) override {}
  void step(int slice, const StepReport& report, const std::optional<Energy>&,
            double wall) override {
    of(slice).wall.push_back(wall);
    of(slice).reports.push_back(report);
  }
  void frame(int slice, const Scene& scene, const Frame& frame) override {
    of(slice).change.go_on(scene, frame);
  }
  void sync(int) override {}

  /// The run as if it were one: each step costs what it has cost in its slice.
  /// @param run directory of the run, which is done
  WholeRun whole(const std::filesystem::path& run) const {
    WholeRun all;
    for (std::size_t j = 0; j < slices_.size(); ++j) {
      const Slice& slice = slices_[j];
      const std::vector<double> work = read_work(SliceFiles(run, static_cast<int>(j)).work());
      for (std::size_t k = 0; k < slice.wall.size(); ++k)
        all.costs.add(slice.wall[k], work.at(k + 1) - work[k]);
      for (const StepReport& report : slice.reports) all.profile.add(report);
      all.largest_change = std::max(all.largest_change, slice.change.most());
    }
    all.steps_timed = static_cast<std::int64_t>(all.costs.wall.size()) - 1;
    all.from_slices = true;
    return all;
  }

 private:
  struct Slice {
    std::vector<double> wall;  ///< [steps] [s]
    std::vector<StepReport> reports;
    LargestMove change;
  };
  Slice& of(int slice) { return slices_[static_cast<std::size_t>(slice)]; }

  std::vector<Slice> slices_;  ///< each is for the thread that works it off
};

/// A run in slices, each by a worker of its own as far as there are threads.
struct SlicedRun {
  SlicesOutcome outcome;
  WholeRun steps;                   ///< what its own steps have cost
  int workers = 1;                  ///< at once
  std::uint64_t state_hash = 0;     ///< at the end
  int intersecting_boundaries = 0;  ///< states at seams that intersect
  double dihedral_max = 0;          ///< largest dihedral_error() across a seam
};

/// @throws SimulationError if it does not come to its end
inline SlicedRun run_sliced(const TimeParallelScene& scene, int workers,
                            const std::filesystem::path& directory) {
  SliceOptions options;
  options.workers = workers;
  options.run = directory;
  options.devices = [](int) { return host_devices(1); };
  StepRecorder recorder(scene);
  SlicedRun run;
  run.workers = workers;
  run.outcome = run_slices(scene, options, recorder);
  const auto refuse = [](const std::string& who, Failure failure, const std::string& detail) {
    if (failure != Failure::none)
      throw SimulationError(who + ": " + describe(failure) + (detail.empty() ? "" : ": " + detail));
  };
  const CoarseOutcome& coarse = run.outcome.coarse;
  refuse("coarse step " + std::to_string(coarse.steps + 1), coarse.failure, coarse.failure_detail);
  for (const SliceOutcome& slice : run.outcome.slices)
    refuse("step " + std::to_string(slice.end + 1), slice.failure, slice.failure_detail);
  if (!run.outcome.done) throw SimulationError("slices did not come to their end");
  run.steps = recorder.whole(directory);
  std::atomic<int> tangled{0};
  std::vector<double> dihedral(static_cast<std::size_t>(scene.slices()));
  for_each_seam(scene.fine(), directory, scene.slices(), workers,
                [&](int slice, BoundaryStates& states) {
                  tangled += states.free_before(slice) ? 0 : 1;
                  const BoundarySides sides = states.at(slice);
                  tangled += free_of_intersections(sides.scene, sides.after) ? 0 : 1;
                  dihedral[static_cast<std::size_t>(slice)] =
                      dihedral_error(sides.scene, sides.before, sides.after);
                });
  run.intersecting_boundaries = tangled;
  run.dihedral_max = *std::max_element(dihedral.begin(), dihedral.end());
  Simulation end(scene.fine(), host_devices(1));
  end.resume(SliceFiles(directory, scene.slices() - 1).end(), SceneChanges::allow);
  run.state_hash = end.state_hash();
  return run;
}

/// Some steps again of a slice that is done, with nothing of this process beside them.
struct StepsAlone {
  std::int64_t steps = 0;
  double wall = 0;         ///< [s]
  double wall_in_run = 0;  ///< [s] what the same steps took beside the other slices
  std::size_t fine_bytes = 0, coarse_bytes = 0;  ///< of a simulation of each level
  std::int64_t coarse_triangles = 0;             ///< half-way through the coarse run
};

/// @param most steps
inline StepsAlone steps_alone(const TimeParallelScene& scene, const SlicedRun& run,
                              const std::filesystem::path& directory, std::int64_t most) {
  const int slice = scene.slices() / 2;
  const auto first = static_cast<std::size_t>(run.outcome.starts[static_cast<std::size_t>(slice)]);
  const auto last = slice + 1 < scene.slices()
                        ? run.outcome.starts[static_cast<std::size_t>(slice) + 1]
                        : scene.steps();
  StepsAlone alone;
  alone.steps = std::min<std::int64_t>(most, last - static_cast<std::int64_t>(first));
  Simulation fine(scene.fine(), host_devices(1));
  if (slice > 0) fine.resume(SliceFiles(directory, slice).start(), SceneChanges::allow);
  StepCosts costs;
  for (std::int64_t k = 0; k < alone.steps; ++k) counted_step(fine, costs);
  alone.wall = costs.wall.back();
  alone.wall_in_run = run.steps.costs.wall[first + static_cast<std::size_t>(alone.steps)] -
                      run.steps.costs.wall[first];
  alone.fine_bytes = bytes_of(fine);
  Simulation coarse(scene.coarse().scene, host_devices(1));
  coarse.resume(CoarseStates::file(SliceFiles::coarse(directory), run.outcome.coarse.steps / 2),
                SceneChanges::allow);
  alone.coarse_triangles = static_cast<std::int64_t>(triangle_count(coarse.scene()));
  counted_step(coarse, costs);
  alone.coarse_bytes = bytes_of(coarse);
  return alone;
}

/// Costs of the coarse run beneath slices; of the steps that it was not needed for, the mean.
/// @param steps of the coarse run, were it to come to the end
inline StepCosts coarse_costs(const CoarseOutcome& outcome, std::int64_t steps) {
  StepCosts costs;
  costs.wall = outcome.wall_until;
  costs.work = outcome.work_until;
  const auto done = static_cast<double>(costs.wall.size() - 1);
  const double wall = done > 0 ? costs.wall.back() / done : 0;
  const double work = done > 0 ? costs.work.back() / done : 0;
  while (static_cast<std::int64_t>(costs.wall.size()) < steps + 1) costs.add(wall, work);
  return costs;
}

}  // namespace weft::bench
