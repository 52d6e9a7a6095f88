#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "benchmarks/support/time_parallel_runs.hpp"
#include "host/time_parallel/partition.hpp"
#include "host/time_parallel/seam.hpp"

/// What weft_bench_time_parallel writes of its runs.
namespace weft::bench {

using Json = nlohmann::ordered_json;

inline std::size_t triangle_count(const Scene& scene) {
  std::size_t count = 0;
  for (const Cloth& cloth : scene.cloths) count += cloth.mesh.triangles.size();
  return count;
}

/// What the fine and the coarse run of a scene have cost.
struct Level {
  const TimeParallelScene* scene = nullptr;
  const WholeRun* fine = nullptr;
  WholeRun coarse;
  double steps_per_coarse = 1;

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

/// Speed-up over the serial run against what eq. (16) has for the measured K and recovery.
inline Json speedup_json(const Level& level, const SlicesOutcome& outcome, Cost cost) {
  const bool by_clock = cost == by_wall;
  const std::vector<double>& fine = level.fine->costs.*cost;
  const double length = path_length(level, outcome, by_clock);
  double recovery = 0;
  for (const SliceOutcome& s : outcome.slices) recovery += by_clock ? s.start_wall : s.start.work;
  const double a_step = fine.back() / static_cast<double>(outcome.steps);
  const double recoveries = std::max(1.0, static_cast<double>(outcome.slices.size()) - 1);
  const double recovery_steps = recovery / recoveries / a_step;
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

inline Json seams_json(const Level& level, const SlicesOutcome& outcome) {
  double position = 0, rms = 0, velocity = 0, curvature = 0;
  for (const SeamJump& seam : outcome.seams) {
    position = std::max(position, seam.position);
    rms = std::max(rms, seam.position_rms);
    velocity = std::max(velocity, seam.velocity);
    curvature = std::max(curvature, seam.curvature);
  }
  Json json{{"position_max_m", position},
            {"position_rms_max_m", rms},
            {"velocity_max_m_per_s", velocity},
            {"curvature_max", curvature}};
  if (level.fine->largest_change > 0)
    json["position_over_largest_frame_change"] = position / level.fine->largest_change;
  return json;
}

inline Json run_json(const Level& level, const std::string& partition, const SlicedRun& run) {
  const SlicesOutcome& outcome = run.outcome;
  Json iterations = Json::array();
  int most = 0;
  for (std::size_t j = 1; j < outcome.slices.size(); ++j) {
    iterations.push_back(outcome.slices[j].start.iterations);
    most = outcome.slices[j].start.iterations_max;
  }
  const double wall = outcome.wall;
  return {{"partition", partition},
          {"slices", outcome.slices.size()},
          {"workers_at_once", run.workers},
          {"wall_s", wall},
          {"speedup_measured", level.fine->costs.wall.back() / wall},
          {"by_clock", speedup_json(level, outcome, by_wall)},
          {"by_counted_work", speedup_json(level, outcome, by_work)},
          {"recovery_iterations", iterations},
          {"recovery_iterations_by_formula", most},
          {"seams", seams_json(level, outcome)},
          {"tangled_seam_states", run.tangled_seams},
          {"starts", outcome.starts},
          {"state_hash", fmt::format("{:016x}", run.state_hash)}};
}

/// What more workers, and longer runs of the same cost a step, would come to by eq. (16). [Table 7]
inline Json prediction_json(const Level& level, Cost cost, double recovery_steps) {
  Json all = Json::array();
  const double ratio = level.ratio(cost);
  for (const int length : {1, 2, 4})
    for (const int workers : {64, 128, 512, 100000}) {
      const std::int64_t steps = length * level.scene->steps();
      const Json bounds = bounds_json(ratio, workers, steps, recovery_steps);
      all.push_back({{"workers", workers},
                     {"steps", steps},
                     {"extrapolated", true},
                     {"slices", std::min<std::int64_t>(workers, steps)},
                     {"bounds", bounds}});
    }
  return all;
}

/// How a state compares with that of the serial run at the same time.
inline Json difference_json(const Scene& scene, const Frame& wanted, const Frame& frame) {
  const SeamJump jump = seam_jump(scene, wanted, frame);
  return {{"curvature", jump.curvature},
          {"dihedral", dihedral_error(scene, wanted, frame)},
          {"angles_over_serial", angle_sum(scene, frame) / angle_sum(scene, wanted)},
          {"position_rms_m", jump.position_rms},
          {"position_max_m", jump.position},
          {"velocity_max_m_per_s", jump.velocity}};
}

}  // namespace weft::bench
