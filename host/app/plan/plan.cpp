#include "host/app/plan/plan.hpp"

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "host/app/chart/accuracy_target.hpp"
#include "host/app/chart/chart_points.hpp"
#include "host/app/plan/plan_without.hpp"
#include "host/app/plan/step_trials.hpp"
#include "host/app/process/child.hpp"
#include "host/app/run/number_range.hpp"
#include "host/app/run/run_device.hpp"
#include "host/app/run/run_output.hpp"
#include "host/app/run/scene_name.hpp"
#include "host/app/run/scene_request.hpp"
#include "host/base/atomic_file.hpp"
#include "host/input/counted.hpp"
#include "host/input/safe_text.hpp"
#include "host/lab/plan/plan.hpp"
#include "host/scene/frame_steps.hpp"
#include "weft/devices.hpp"
#include "weft/error.hpp"
#include "weft/simulation.hpp"

namespace weft::app {
namespace {

using Clock = std::chrono::steady_clock;

struct PlanRequest : SceneRequest {
  std::string chart;  ///< a chart.json, or its directory
  std::string json;
  std::string target;  ///< as of `weft run --need`; empty: none
  double probe = 5;    ///< [s] per device
  bool steps = false;  ///< whether other time steps are tried
};

/// The first steps of a run on one device.
struct Probe {
  std::string device;
  int steps = 0;
  double step_s = 0;  ///< wall time per step
  double simulated_s = 0;
  double shortest = 0, longest = 0;  ///< [s] time steps
  StageTimes stages;
  std::string failure;
};

/// Simulates the first steps, for about `limit` seconds, at least one.
Probe probe(const Scene& scene, const std::string& device, double limit) {
  Probe p;
  p.device = device;
  Simulation simulation(scene, parse_devices(device));
  const auto start = Clock::now();
  double spent = 0;
  while (p.failure.empty() && simulation.frame_number() < scene.time.frames &&
         (p.steps == 0 || spent < limit)) {
    const StepReport report = simulation.step();
    ++p.steps;
    p.stages += report.stages;
    p.shortest = p.steps > 1 ? std::min(p.shortest, report.step) : report.step;
    p.longest = std::max(p.longest, report.step);
    if (report.failure != Failure::none) p.failure = describe(report.failure);
    spent = std::chrono::duration<double>(Clock::now() - start).count();
  }
  p.step_s = spent / p.steps;
  p.simulated_s = simulation.time();
  return p;
}

/// One rank, and as many as there are cores; the GPUs that auto takes, if any.
std::vector<std::string> devices_to_try(const DeviceChoice& choice) {
  std::vector<std::string> devices{"cpu:1"};
  const unsigned cores = std::min(64u, std::thread::hardware_concurrency());
  if (cores > 1) devices.push_back(fmt::format("cpu:{}", cores));
  if (choice.device.starts_with("cuda")) devices.push_back(choice.device);
  return devices;
}

std::vector<Probe> probe_all(const Scene& scene, const DeviceChoice& choice, double limit) {
  std::vector<Probe> probes;
  if (!(limit > 0)) return probes;
  for (const std::string& device : devices_to_try(choice)) {
    try {
      probes.push_back(probe(scene, device, limit));
    } catch (const DeviceError& error) {
      fmt::print("{}: {}\n", device, error.what());
    }
  }
  std::stable_sort(probes.begin(), probes.end(),
                   [](const Probe& a, const Probe& b) { return a.step_s < b.step_s; });
  return probes;
}

void print_stages(const std::vector<lab::StagePlan>& stages) {
  for (const lab::StagePlan& s : stages)
    fmt::print(
        "{:<29} {:<13} {}{}\n", s.stage, describe(s.verdict), s.why,
        s.setting.empty() ? "" : fmt::format("; {}", fmt::join(setting_words({s.setting}), " ")));
}

void print_probes(const Scene& scene, const std::vector<Probe>& probes) {
  const double length = scene.time.frames / scene.time.frame_rate;
  for (const Probe& p : probes) {
    const double mean_step =
        scene.time.automatic && p.simulated_s > 0 ? p.simulated_s / p.steps : scene.time.step;
    const double all = std::max(1e-12, p.stages.total());
    fmt::print(
        "{:<8} {:.3g} ms per step in the first {}: contacts {:.0f} %, assembly {:.0f} %, "
        "solve {:.0f} %, collisions {:.0f} %; {}about {:.3g} s for the run at this rate{}\n",
        p.device, 1e3 * p.step_s, counted(p.steps, "step"), 100 * p.stages.contacts / all,
        100 * p.stages.assemble / all, 100 * p.stages.solve / all,
        100 * p.stages.resolve_collisions / all,
        scene.time.automatic
            ? fmt::format("time steps of {:.3g} to {:.3g} s; ", p.shortest, p.longest)
            : "",
        length / mean_step * p.step_s, p.failure.empty() ? "" : "; failed: " + p.failure);
  }
}

/// Cheapest settings of a chart for some errors.
void print_chart(const std::string& file) {
  const std::vector<ChartPoint> points = read_chart(file);
  for (const double limit : {0.1, 0.01, 0.001}) {
    const ChartPoint* best = cheapest(points, {limit, {}});
    fmt::print("to {:g} %: {}\n", 100 * limit,
               best == nullptr ? "no point of the chart"
                               : one_line(fmt::format("{}: {}, {:.3g} s per simulated s; {}",
                                                      best->setting.series, best->setting.label,
                                                      best->median(), best->command)));
  }
}

/// A stage that may be left out within an accuracy target, and the setting that leaves it out.
struct Spare {
  const char* stage;
  const char* off;
  const char* label;  ///< of the point without it, in a chart
};
constexpr std::array spares{Spare{"bending", "model.bending=false", "no bending"},
                            Spare{"friction", "model.friction=false", "no friction"},
                            Spare{"wind", "wind.density=0", "no wind"}};

/// Leaves out stages that change little enough by measurement: all of them together use at most
/// half of the target, so that the other half is left for the step and the mesh. Stages that change
/// least go first.
void decide_spares(const Scene& scene, const PlanRequest& request, SmallRuns& small,
                   std::vector<lab::StagePlan>& stages) {
  if (request.target.empty()) return;
  const AccuracyTarget target = parse_accuracy_target(request.target);
  if (!target.error) return;
  struct Found {
    lab::StagePlan* stage;
    const char* off;
    WithoutError without;
  };
  std::vector<Found> all;
  WithoutStages runs(scene, small, request.chart);
  for (const Spare& spare : spares) {
    const auto stage = std::find_if(stages.begin(), stages.end(), [&](const lab::StagePlan& s) {
      return s.stage == spare.stage;
    });
    if (stage->verdict == lab::Verdict::left_out) continue;
    all.push_back({&*stage, spare.off, runs.error(spare.off, spare.label)});
  }
  std::stable_sort(all.begin(), all.end(), [](const Found& a, const Found& b) {
    return a.without.error < b.without.error;
  });
  const double allowed = *target.error / 2;
  double spent = 0;
  for (const Found& f : all) {
    const bool spare = f.without.known && spent + f.without.error <= allowed;
    f.stage->verdict = spare ? lab::Verdict::in_need : lab::Verdict::needed;
    f.stage->setting = spare ? f.off : "";
    f.stage->why =
        fmt::format("{}; the target allows {:.3g} %{}", f.without.how, 100 * allowed,
                    spent > 0 ? fmt::format(", of which {:.3g} % is used", 100 * spent) : "");
    if (spare) spent += f.without.error;
  }
}

/// Which time steps the scene bears, and what they cost.
void print_steps(const Scene& scene, const StepTrials& all) {
  if (!all.unknown.empty()) return fmt::print("\ntime steps: not tried: {}\n", all.unknown);
  const double own = frame_step_length(scene.time);
  const auto is_own = [&](const StepTrial& t) { return std::abs(t.step / own - 1) < 1e-6; };
  const auto as_is = std::find_if(all.trials.begin(), all.trials.end(), is_own);
  fmt::print("\ntime steps, all frames at {:.0f} triangles, against a step of {:.3g} s:\n",
             all.triangles, all.finest);
  for (const StepTrial& t : all.trials) {
    fmt::print("{:>9.3g} s{}  ", t.step, is_own(t) ? " *" : "  ");
    if (!t.problem.empty()) {
      fmt::print("fails: {}\n", one_line(t.problem));
      continue;
    }
    fmt::print("differs by {:.3g} %", 100 * *t.error);
    if (t.bisected > 0) fmt::print(", {:.0f} % of its steps are bisected", 100 * t.bisected);
    if (as_is->seconds > 0) fmt::print(", {:.2g} times the time", t.seconds / as_is->seconds);
    fmt::print("\n");
  }
  fmt::print("starts that differ by 1e-6 of the size end {:.3g} % apart\n", 100 * all.chance);
  const double allowed = 100 * all.allowed;
  if (all.bears)
    fmt::print("to {:.3g} % the scene bears steps of {:.3g} s\n", allowed, *all.bears);
  else
    fmt::print("to {:.3g} % the scene bears none of these steps\n", allowed);
}

Json steps_json(const StepTrials& all) {
  Json list = Json::array();
  for (const StepTrial& t : all.trials)
    list.push_back({{"step", t.step},
                    {"error", t.error ? Json(*t.error) : Json(nullptr)},
                    {"seconds", t.seconds},
                    {"bisected", t.bisected},
                    {"problem", t.problem}});
  return {{"triangles", all.triangles}, {"finest", all.finest},
          {"chance", all.chance},       {"bears", all.bears ? Json(*all.bears) : Json(nullptr)},
          {"unknown", all.unknown},     {"trials", list}};
}

Json plan_json(const std::string& scene, const std::vector<lab::StagePlan>& stages,
               const DeviceChoice& choice, const std::vector<Probe>& probes) {
  Json list = Json::array(), measured = Json::array();
  for (const lab::StagePlan& s : stages)
    list.push_back({{"stage", s.stage},
                    {"verdict", describe(s.verdict)},
                    {"why", s.why},
                    {"setting", s.setting},
                    {"off", s.off}});
  for (const Probe& p : probes)
    measured.push_back({{"device", p.device},
                        {"steps", p.steps},
                        {"ms_a_step", 1e3 * p.step_s},
                        {"failure", p.failure}});
  return {{"scene", scene}, {"stages", list}, {"auto", choice_json(choice)}, {"devices", measured}};
}

/// Over the diagonal: of the target, or else 1 %.
double step_error_max(const PlanRequest& request) {
  if (request.target.empty()) return 0.01;
  return parse_accuracy_target(request.target).error.value_or(0.01);
}

void make_plan(const PlanRequest& request) {
  if (!request.target.empty())
    parse_accuracy_target(request.target);  // refused before anything runs
  refuse_unwritable(request.json, "--json", request.scene);
  const Scene scene = request.read();
  for (const std::string& warning : scene.warnings)
    fmt::print(stderr, "weft: warning: {}\n", one_line(warning));
  fmt::print("{}: {}, method {}, {}\n\n", one_line(scene.name),
             counted(triangle_count(scene), "triangle"), scene.method,
             counted(scene.time.frames, "frame"));
  auto stages = lab::plan_stages(scene);
  SmallRuns small(scene, request);
  decide_spares(scene, request, small, stages);
  print_stages(stages);
  fmt::print("\n");
  const DeviceChoice choice = look_for_devices(scene);
  print_choice(choice, true);
  const std::vector<Probe> probes = probe_all(scene, choice, request.probe);
  if (!probes.empty()) fmt::print("\n");
  print_probes(scene, probes);
  std::optional<StepTrials> steps;
  if (request.steps) {
    steps = try_steps(scene, small, step_error_max(request));
    print_steps(scene, *steps);
  }
  if (!request.chart.empty()) print_chart(request.chart);
  std::vector<std::string> words{"weft", "run", request.scene};
  if (!probes.empty()) words.insert(words.end(), {"--device", probes.front().device});
  std::vector<std::string> settings;
  for (const lab::StagePlan& s : stages)
    if ((s.verdict == lab::Verdict::left_out || s.verdict == lab::Verdict::in_need) &&
        !s.setting.empty())
      settings.push_back(s.setting);
  const bool same = std::none_of(stages.begin(), stages.end(), [](const lab::StagePlan& s) {
    return s.verdict == lab::Verdict::in_need;
  });
  fmt::print("\n{} for the least time: {}\n",
             same ? "the same result" : "a result within the target",
             shell_text(request.command(std::move(words), settings)));
  if (request.json.empty()) return;
  Json json = plan_json(scene.name, stages, choice, probes);
  if (steps) json["time_steps"] = steps_json(*steps);
  write_file_atomically(request.json, json.dump(2) + "\n");
}

}  // namespace

void add_plan_subcommand(CLI::App& app, int& exit_code) {
  auto* subcommand =
      app.add_subcommand("plan", "What a scene needs, what it can leave out, and the cost");
  const auto request = std::make_shared<PlanRequest>();
  subcommand->add_option("scene", request->scene, "Scene file, or the name of a shipped scene")
      ->required()
      ->type_name("SCENE");
  request->add_options(*subcommand);
  subcommand
      ->add_option("--probe", request->probe,
                   "Seconds of simulation per device, to measure the cost; 0: none")
      ->type_name("SECONDS")
      ->check(number_range(0, 1e9));
  subcommand->add_flag("--steps", request->steps,
                       "Try time steps of four times, twice and half that of the scene, on a "
                       "smaller mesh: which ones it bears and what they cost");
  subcommand->add_option("--chart", request->chart, "Chart of the scene: its directory")
      ->type_name("DIR");
  subcommand
      ->add_option(
          "--need", request->target,
          "Accuracy target, as of run: bending, friction and wind are left out if runs of a "
          "smaller mesh, or the chart, show that this changes less")
      ->type_name("NEED");
  subcommand->add_option("--json", request->json, "Write the plan to this file")->type_name("FILE");
  subcommand->callback([request, &exit_code] {
    request->scene = find_scene(request->scene);
    make_plan(*request);
    exit_code = 0;
  });
}

}  // namespace weft::app
