#include "host/app/time_parallel/time_report.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "host/scene/frame_steps.hpp"
#include "host/time_parallel/coarse_run.hpp"
#include "host/time_parallel/schedule.hpp"

namespace weft::app {
namespace {

using Json = nlohmann::ordered_json;

constexpr const char* schedule_names[] = {"uniform", "balanced", "adaptive"};

Json number(double value) {
  return std::isfinite(value) ? Json(value) : Json(nullptr);
}

Json slices_json(const SlicesOutcome& outcome) {
  Json list = Json::array();
  for (std::size_t j = 0; j < outcome.slices.size(); ++j) {
    const SliceOutcome& s = outcome.slices[j];
    Json slice{{"start", outcome.starts[j]},
               {"steps", s.end - outcome.starts[j]},
               {"done", s.done},
               {"work", s.work},
               {"steps_s", s.wall},
               {"start_s", s.start_wall}};
    if (j > 0) {
      slice["recovery"] = {{"iterations", s.start.iterations},
                           {"iterations_max", s.start.iterations_max},
                           {"change", s.start.change},
                           {"work", s.start.work},
                           {"tracking_error", s.start.tracking_error},
                           {"untangled", s.start.untangled}};
      if (!s.start.note.empty()) slice["recovery"]["ended_by"] = s.start.note;
      if (s.start.spin_up > 0)
        slice["spin_up"] = {{"steps", s.start.spin_up}, {"because", s.start.refused}};
    }
    list.push_back(std::move(slice));
  }
  return list;
}

/// Where the coarse run jammed at first, and what contact it went on with.
Json eased_json(const TimeParallelScene& scene, const CoarseOutcome& coarse) {
  Json list = Json::array();
  const std::vector<CoarseRelaxation> eases = coarse_relaxations(scene.coarse().scene);
  for (std::size_t k = 0; k < std::min(coarse.relaxed.size(), eases.size()); ++k)
    list.push_back({{"step", coarse.relaxed[k]},
                    {"thickness", eases[k].thickness},
                    {"substep_bisections", eases[k].substep_bisections}});
  return list;
}

Json seams_json(const TimeParallelScene& scene, const SlicesOutcome& outcome,
                const TimeFacts& facts) {
  Json list = Json::array();
  for (std::size_t j = 0; j < outcome.seams.size(); ++j) {
    const BoundaryJump& s = outcome.seams[j];
    const double share = facts.largest_move > 0 ? s.position / facts.largest_move : 0;
    list.push_back({{"step", outcome.starts[j + 1]},
                    {"position", s.position},
                    {"position_rms", s.position_rms},
                    {"velocity", s.velocity},
                    {"curvature_error", number(s.curvature)},
                    {"jump_over_frame_change", share},
                    {"within_tolerance", share <= scene.fine().time_parallel.boundary_tolerance}});
    if (!facts.blended.empty()) list.back()["blended_frames"] = facts.blended[j];
  }
  return list;
}

/// Speed-ups by one measure of cost.
struct Costs {
  double coarse = 0;    ///< of the coarse run, for each step of the fine one that it reached
  double fine = 0;      ///< a step
  double recovery = 0;  ///< of a slice, in steps
};

Json prediction_json(const Costs& costs, std::int64_t steps, int slices) {
  if (!(costs.coarse > 0) || !(costs.fine > costs.coarse)) return nullptr;
  const double ratio = costs.fine / costs.coarse;
  const double balanced = balanced_speedup(ratio, slices);
  return {{"ratio", ratio},
          {"least", least_speedup(ratio, slices)},
          {"uniform", uniform_speedup(ratio, slices)},
          {"balanced", balanced},
          {"with_recovery", speedup_with_recovery(steps, costs.recovery, balanced)},
          {"recovery_steps", costs.recovery},
          {"with_512_slices",
           speedup_with_recovery(steps, costs.recovery, balanced_speedup(ratio, 512))},
          {"with_100000_slices",
           speedup_with_recovery(steps, costs.recovery, balanced_speedup(ratio, 100000))}};
}

/// Of the cloths; null where meshes change.
Json triangles_json(const Scene& scene) {
  if (remeshes(scene)) return nullptr;
  std::size_t count = 0;
  for (const Cloth& cloth : scene.cloths) count += cloth.mesh.triangles.size();
  return count;
}

}  // namespace

Json time_report(const TimeParallelScene& scene, const SlicesOutcome& outcome,
                 const TimeFacts& facts) {
  const TimeParallelSettings& settings = scene.fine().time_parallel;
  Costs counted, clocked;
  double fine_steps = 0, fine_work = 0, fine_wall = 0, recovery_work = 0, recovery_wall = 0;
  for (std::size_t j = 0; j < outcome.slices.size(); ++j) {
    const SliceOutcome& s = outcome.slices[j];
    fine_steps += static_cast<double>(s.end - outcome.starts[j]);
    fine_work += s.work - s.start.work;
    fine_wall += s.wall;
    recovery_work += s.start.work;
    recovery_wall += s.start_wall;
  }
  const double reached = std::max(1.0, static_cast<double>(outcome.coarse.reached));
  const double recoveries = std::max(1.0, static_cast<double>(outcome.slices.size()) - 1);
  fine_steps = std::max(fine_steps, 1.0);
  counted = {outcome.coarse.work / reached, fine_work / fine_steps, 0};
  clocked = {outcome.coarse.wall / reached, fine_wall / fine_steps, 0};
  if (counted.fine > 0) counted.recovery = recovery_work / recoveries / counted.fine;
  if (clocked.fine > 0) clocked.recovery = recovery_wall / recoveries / clocked.fine;
  const Json seams = seams_json(scene, outcome, facts);
  const auto beyond = std::count_if(seams.begin(), seams.end(), [](const Json& seam) {
    return !seam.at("within_tolerance").get<bool>();
  });
  return {{"method", settings.method},
          {"partition", schedule_names[static_cast<int>(settings.schedule)]},
          {"workers", facts.workers},
          {"worker_kind", facts.worker_kind},
          {"steps", outcome.steps},
          {"coarse",
           {{"mesh", settings.coarse_adaptive ? "adaptive" : "uniform"},
            {"triangles", triangles_json(scene.coarse().scene)},
            {"fine_triangles", triangles_json(scene.fine())},
            {"step", frame_step_length(scene.coarse().scene.time)},
            {"fine_step", frame_step_length(scene.fine().time)},
            {"steps", outcome.coarse.steps},
            {"work", outcome.coarse.work},
            {"steps_s", outcome.coarse.wall},
            {"relaxed", eased_json(scene, outcome.coarse)}}},
          {"largest_frame_change", facts.largest_move},
          {"boundaries_beyond_tolerance", beyond},
          {"speedup",
           {{"by_counted_work", prediction_json(counted, outcome.steps, scene.slices())},
            {"by_clock", prediction_json(clocked, outcome.steps, scene.slices())},
            {"fine_steps_s_over_wall_s", outcome.wall > 0 ? fine_wall / outcome.wall : 0.0}}},
          {"slices", slices_json(outcome)},
          {"slice_boundaries", seams}};
}

}  // namespace weft::app
