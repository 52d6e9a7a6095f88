#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "benchmarks/support/time_parallel_runs.hpp"
#include "host/scene/frame_steps.hpp"
#include "host/time_parallel/schedule.hpp"
#include "host/time_parallel/slice_boundary.hpp"

/// What weft_bench_time_parallel writes of its runs.
namespace weft::bench {

using Json = nlohmann::ordered_json;

/// What the fine and the coarse run of a scene have cost.
struct Level {
  explicit Level(const TimeParallelScene& s)
      : scene(&s),
        steps_per_coarse(frame_step_length(s.coarse().scene.time) /
                         frame_step_length(s.fine().time)) {}

  const TimeParallelScene* scene;
  const WholeRun* fine = nullptr;
  WholeRun coarse;
  double steps_per_coarse;

  /// Of the coarse run until it is at a step of the fine one.
  double coarse_until(std::int64_t step, const std::vector<double>& sums) const {
    return cost_until(sums, static_cast<double>(step) / steps_per_coarse);
  }
  double ratio(const std::vector<double> StepCosts::*cost) const {
    return (fine->costs.*cost).back() / coarse_until(scene->steps(), coarse.costs.*cost);
  }
};

using Cost = const std::vector<double> StepCosts::*;
inline constexpr Cost by_wall = &StepCosts::wall;
inline constexpr Cost by_work = &StepCosts::work;

/// Where the cost of steps goes: by the clock, and in what counted_work() has. Null where no step
/// was looked at.
inline Json profile_json(const StepProfile& p) {
  if (p.steps == 0) return nullptr;
  const auto a_step = [&](auto sum) {
    return static_cast<double>(sum) / static_cast<double>(p.steps);
  };
  return {{"steps", p.steps},
          {"stages_ms_a_step",
           {{"contacts", 1e3 * a_step(p.stages.contacts)},
            {"assemble", 1e3 * a_step(p.stages.assemble)},
            {"solve", 1e3 * a_step(p.stages.solve)},
            {"certify", 1e3 * a_step(p.stages.resolve_collisions)},
            {"other", 1e3 * a_step(p.stages.other)}}},
          {"solves_a_step", a_step(p.solves)},
          {"iterations_a_step", a_step(p.iterations)},
          {"proximities_a_step", a_step(p.proximities)},
          {"zone_visits_a_step", a_step(p.zone_visits)},
          {"searches_a_step", a_step(p.searches)},
          {"rebuilds_a_step", a_step(p.rebuilds)},
          {"steps_halved", p.halved},
          {"steps_with_rigid_zones", p.rigid}};
}

/// Eq. (11) and (16).
/// @param slices   of which there are no more than steps
/// @param recovery steps that each slice begins with
inline Json bounds_json(double ratio, int slices, std::int64_t steps, double recovery) {
  if (!(ratio > 1)) return nullptr;
  const int p = static_cast<int>(std::min<std::int64_t>(slices, steps));
  const double balanced = balanced_speedup(ratio, p);
  return {{"least", least_speedup(ratio, p)},
          {"uniform", uniform_speedup(ratio, p)},
          {"balanced", balanced},
          {"with_recovery", speedup_with_recovery(steps, recovery, balanced)}};
}

/// When the last slice ends if each has a core of its own.
inline double path_length(const Level& level, const SlicesOutcome& outcome, bool by_clock) {
  double end = 0;
  for (std::size_t j = 0; j < outcome.starts.size(); ++j) {
    const SliceOutcome& s = outcome.slices[j];
    const double begin = level.coarse_until(
        outcome.starts[j], by_clock ? level.coarse.costs.wall : level.coarse.costs.work);
    end = std::max(end, begin + (by_clock ? s.start_wall + s.wall : s.work));
  }
  return end;
}

/// What the start of a slice has cost on average.
inline double mean_start_cost(Cost cost, const SlicesOutcome& outcome) {
  double sum = 0;
  for (const SliceOutcome& s : outcome.slices) sum += cost == by_wall ? s.start_wall : s.start.work;
  return sum / std::max(1.0, static_cast<double>(outcome.slices.size()) - 1);
}
inline double mean_start_cost(Cost cost, const WholeRun& sampled) {
  const std::vector<double>& sums = sampled.starts.*cost;
  return sums.back() / std::max(1.0, static_cast<double>(sums.size()) - 1);
}

/// Speed-up over the serial run against what eq. (16) has for the measured K and recovery.
inline Json speedup_json(const Level& level, const SlicesOutcome& outcome, Cost cost) {
  const bool by_clock = cost == by_wall;
  const std::vector<double>& fine = level.fine->costs.*cost;
  const double length = path_length(level, outcome, by_clock);
  const double a_step = fine.back() / static_cast<double>(outcome.steps);
  const double recovery_steps = mean_start_cost(cost, outcome) / a_step;
  const Json bounds = bounds_json(level.ratio(cost), static_cast<int>(outcome.slices.size()),
                                  outcome.steps, recovery_steps);
  const double speedup = fine.back() / length;
  Json json{{"ratio", level.ratio(cost)},
            {"recovery_steps", recovery_steps},
            {"speedup_with_a_core_each", speedup},
            {"bounds", bounds}};
  if (!bounds.is_null()) json["efficiency"] = speedup / bounds.at("with_recovery").get<double>();
  return json;
}

inline Json seams_json(const Level& level, const SlicedRun& run) {
  const SlicesOutcome& outcome = run.outcome;
  double position = 0, rms = 0, velocity = 0, curvature = 0;
  for (const BoundaryJump& seam : outcome.seams) {
    position = std::max(position, seam.position);
    rms = std::max(rms, seam.position_rms);
    velocity = std::max(velocity, seam.velocity);
    curvature = std::max(curvature, seam.curvature);
  }
  Json json{{"position_max_m", position},
            {"position_rms_max_m", rms},
            {"velocity_max_m_per_s", velocity},
            {"curvature_max", curvature},
            {"dihedral_max", run.dihedral_max}};
  if (level.fine->largest_change > 0)
    json["position_over_largest_frame_change"] = position / level.fine->largest_change;
  return json;
}

/// Algorithm 1 and the formulas on the measured cost of every step, for any number of workers, each
/// with a core of its own: what these steps would come to in other slices.
/// @param recovery what the start of each slice costs
inline Json schedules_json(const Level& level, Cost cost, double recovery) {
  ScheduleCosts costs;
  costs.fine = level.fine->costs.*cost;
  costs.recovery = recovery;
  const auto steps = static_cast<std::int64_t>(costs.fine.size()) - 1;
  for (std::int64_t n = 0; n <= steps; ++n)
    costs.coarse.push_back(level.coarse_until(n, level.coarse.costs.*cost));
  const double ratio = level.ratio(cost);
  const double recovery_steps = recovery / (costs.fine.back() / static_cast<double>(steps));
  Json all = Json::array();
  for (const int workers : {1, 2, 4, 8, 16, 32, 64, 128, 256, 512}) {
    if (workers > steps || !(ratio > 1)) break;
    const auto speedup = [&](const std::vector<std::int64_t>& starts) {
      return costs.fine.back() / schedule_length(costs, starts);
    };
    const Json bounds = bounds_json(ratio, workers, steps, workers > 1 ? recovery_steps : 0);
    const double adaptive = speedup(adaptive_starts(costs, workers));
    all.push_back({{"workers", workers},
                   {"uniform", speedup(uniform_starts(steps, workers))},
                   {"balanced", speedup(balanced_starts(steps, workers, ratio))},
                   {"adaptive", adaptive},
                   {"bounds", bounds},
                   {"efficiency", adaptive / bounds.at("with_recovery").get<double>()}});
  }
  return all;
}

inline Json run_json(const Level& level, const std::string& schedule, const SlicedRun& run) {
  const SlicesOutcome& outcome = run.outcome;
  Json iterations = Json::array();
  int most = 0;
  Json slice_wall = Json::array(), start_wall = Json::array(), notes = Json::array(),
       spin_up = Json::array();
  for (std::size_t j = 0; j < outcome.slices.size(); ++j) {
    const SliceOutcome& slice = outcome.slices[j];
    slice_wall.push_back(slice.wall);
    if (j == 0) continue;
    start_wall.push_back(slice.start_wall);
    iterations.push_back(slice.start.iterations);
    spin_up.push_back(slice.start.spin_up);
    most = slice.start.iterations_max;
    if (!slice.start.note.empty()) notes.push_back(slice.start.note);
  }
  const double wall = outcome.wall;
  return {{"partition", schedule},
          {"slices", outcome.slices.size()},
          {"workers_at_once", run.workers},
          {"wall_s", wall},
          {"coarse_s", outcome.coarse.wall},
          {"coarse_eased_at_steps", outcome.coarse.relaxed},
          {"seams_s", outcome.boundaries_wall},
          {"slices_s", slice_wall},
          {"starts_s", start_wall},
          {"speedup_measured", level.fine->costs.wall.back() / wall},
          {"by_clock", speedup_json(level, outcome, by_wall)},
          {"by_counted_work", speedup_json(level, outcome, by_work)},
          {"recovery_iterations", iterations},
          {"recovery_iterations_by_formula", most},
          {"recoveries_ended_by", notes},
          {"run_in_steps", spin_up},
          {"seams", seams_json(level, run)},
          {"tangled_seam_states", run.intersecting_boundaries},
          {"starts", outcome.starts},
          {"state_hash", fmt::format("{:016x}", run.state_hash)}};
}

/// What more workers, and longer runs of the same cost a step, would come to by eq. (16), and
/// before recovery by eq. (11). [Table 7]
inline Json prediction_json(const Level& level, Cost cost, double recovery_steps) {
  Json all = Json::array();
  const double ratio = level.ratio(cost);
  const double step = frame_step_length(level.scene->fine().time);
  for (const double seconds : {static_cast<double>(level.scene->steps()) * step, 20.0, 40.0, 80.0})
    for (const int workers : {8, 16, 32, 64, 128, 512, 100000}) {
      const std::int64_t steps = std::llround(seconds / step);
      const Json bounds = bounds_json(ratio, workers, steps, recovery_steps);
      all.push_back({{"workers", workers},
                     {"simulated_s", seconds},
                     {"steps", steps},
                     {"extrapolated", true},
                     {"slices", std::min<std::int64_t>(workers, steps)},
                     {"bounds", bounds}});
    }
  return all;
}

/// How a state compares with that of the serial run at the same time.
inline Json difference_json(const Scene& scene, const Frame& wanted, const Frame& frame) {
  const BoundaryJump jump = boundary_jump(scene, wanted, frame);
  return {{"curvature", jump.curvature},
          {"dihedral", dihedral_error(scene, wanted, frame)},
          {"angles_over_serial", angle_sum(scene, frame) / angle_sum(scene, wanted)},
          {"position_rms_m", jump.position_rms},
          {"position_max_m", jump.position},
          {"velocity_max_m_per_s", jump.velocity}};
}

}  // namespace weft::bench
