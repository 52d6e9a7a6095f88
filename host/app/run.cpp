#include "host/app/run.hpp"

#include <CLI/CLI.hpp>

#include <cstdio>
#include <exception>
#include <filesystem>
#include <memory>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "host/app/chart/accuracy_target.hpp"
#include "host/app/process/show.hpp"
#include "host/app/process/stop_signal.hpp"
#include "host/app/run/number_range.hpp"
#include "host/app/run/run_directory.hpp"
#include "host/app/run/run_end.hpp"
#include "host/app/run/run_lock.hpp"
#include "host/app/run/run_output.hpp"
#include "host/app/run/scene_name.hpp"
#include "host/app/scene_run.hpp"
#include "host/app/time_parallel/slice_ranks.hpp"
#include "host/app/time_parallel/time_run.hpp"
#include "host/base/file_operations.hpp"
#include "host/input/safe_text.hpp"
#include "host/io/scene/scene_file.hpp"
#include "host/scene/tangled_start.hpp"
#include "weft/error.hpp"

namespace weft::app {
namespace {

/// Draws what untangling left, unless the directory holds a run that may not be replaced.
/// @return whether it could be
bool draw_tangled(const TangledStart& tangled, const RunDirectory& directory,
                  const RunRequest& request) {
  if (directory.holds_run() && !request.overwrite) return false;
  try {
    const std::unique_ptr<RunLock> lock = lock_existing(directory, request);
    directory.create();
    return write_failure_picture(directory, frame_meshes(tangled.scene(), tangled.left()),
                                 tangled.place());
  } catch (const std::exception& error) {
    show(stderr, "weft: warning: no picture of the failure: {}\n", error.what());
    return false;
  }
}

/// A run writes its own scene.json: refuses that in place of one that no run has written.
void refuse_replacing_scene(const std::string& output, const std::string& scene) {
  const RunDirectory directory(output);
  std::error_code error;
  if (std::filesystem::equivalent(directory.scene(), scene, error) && !is_there(directory.steps()))
    throw SceneError(output, "-o", "the folder of the scene, which is called scene.json",
                     "another directory: a run writes a scene.json of its own");
}

}  // namespace

int run_scene(const RunRequest& request) {
  listen_for_signals();
  const TimeLimit limit(request.time_limit);
  refuse_unwritable(request.report, "--report", request.scene);
  if (request.resume_changed && request.resume.empty())
    throw SceneError("", "--resume-changed", "without --resume", "--resume with it");
  io::SceneFile file = io::read_scene_file(request.scene, all_overrides(request), request.allowed,
                                           request.experimental);
  for (const std::string& warning : file.scene.warnings)
    show(stderr, "weft: warning: {}\n", one_line(warning));
  refuse_replacing_scene(output_of(request, file.scene), request.scene);
  if (request.live_port >= 0 && file.scene.method == "time_parallel")
    throw SceneError("", "--live", "the method \"time_parallel\"", "the other methods");
  if (file.scene.method == "time_parallel") return run_slices_of(request, std::move(file));
  if (const int ranks = mpi_rank_count(); ranks > 1)
    throw SceneError(
        "", "mpirun",
        std::to_string(ranks) + " processes with the method \"" + file.scene.method + "\"",
        "the method \"time_parallel\", whose slices of time they share out, or one");
  const char* beyond = request.workers > 0         ? "--workers"
                       : !request.schedule.empty() ? "--partition"
                       : request.processes         ? "--processes"
                                                   : nullptr;
  if (beyond != nullptr)
    throw SceneError("", beyond, "the method \"" + file.scene.method + "\"",
                     "the method \"time_parallel\", whose slices of time it is for");
  const RunDirectory directory(output_of(request, file.scene));
  try {
    return SceneRun(request, std::move(file)).execute();
  } catch (const TangledStart& tangled) {
    const bool drawn = draw_tangled(tangled, directory, request);
    throw SceneError(tangled.what() +
                     (drawn ? "; picture " + directory.failure().string() : std::string()));
  }
}

void add_run_subcommand(CLI::App& app, int& exit_code) {
  auto* subcommand = app.add_subcommand("run", "Simulate a scene and write its frames and report");
  auto request = std::make_shared<RunRequest>();
  subcommand->add_option("scene", request->scene, "Scene file, or the name of a shipped scene")
      ->required()
      ->type_name("SCENE");
  subcommand
      ->add_option("-o,--output", request->output,
                   "Directory of the run; default: out/<scene name>")
      ->type_name("DIR");
  subcommand->add_option("--method", request->method, "Method, instead of the scene's")
      ->type_name("M");
  subcommand
      ->add_option("--device", request->device,
                   "auto, cpu, cpu:N, cuda or cuda:0,1; default: where the run took place that is "
                   "resumed, else as the scene says, else auto: as many GPUs as pay")
      ->type_name("D");
  subcommand
      ->add_option("--precision", request->precision, "float or double, instead of the scene's")
      ->type_name("P");
  subcommand->add_option("--frames", request->frames, "How many frames, instead of the scene's")
      ->type_name("N");
  request->add_options(*subcommand);
  subcommand
      ->add_option("--resume", request->resume,
                   "Go on from a checkpoint, or from the latest whole one of the directory")
      ->type_name("FILE|latest");
  subcommand->add_flag(
      "--resume-changed", request->resume_changed,
      "Resume although the scene has changed since the checkpoint; says what changed");
  subcommand->add_flag("--overwrite", request->overwrite,
                       "Replace the run that the directory holds");
  subcommand
      ->add_option("--time-limit", request->time_limit,
                   "Stop after so many seconds of wall time, as a signal would, with a checkpoint")
      ->type_name("SECONDS")
      ->check(number_range(1e-3, 1e9));
  auto* live =
      subcommand
          ->add_option("--live", request->live_port,
                       "Let a browser of this machine watch, pause and stop the run; PORT of "
                       "127.0.0.1, any free one without it")
          ->type_name("[PORT]")
          ->expected(0, 1)
          ->default_str("0")
          ->check(whole_number_range(0, 65535));
  subcommand->add_option("--report", request->report, "Write the report to this file too")
      ->type_name("FILE");
  subcommand
      ->add_option("--workers", request->workers,
                   "time_parallel: slices of time that are simulated at once")
      ->type_name("N")
      ->check(whole_number_range(1, 1000000));
  subcommand
      ->add_option("--partition", request->schedule,
                   "time_parallel: where slices begin, as an earlier run wrote it")
      ->type_name("FILE");
  subcommand->add_flag(
      "--processes", request->processes,
      "time_parallel: a process for each slice, which is replaced if it is killed");
  auto* with = subcommand->add_flag_callback(
      "--preview", [request] { request->preview = true; },
      "Draw preview.png; without this, only if the program runs in a terminal");
  auto* without = subcommand->add_flag_callback(
      "--no-preview", [request] { request->preview = false; }, "Leave preview.png out");
  with->excludes(without);
  const auto target = std::make_shared<std::string>(), chart = std::make_shared<std::string>();
  auto* wanted =
      subcommand->add_option("--need", *target,
                             "Choose settings, estimate the error, refine until it is met: "
                             "\"error<1%,intersections=0\"");
  wanted->type_name("TEXT")->excludes("--resume")->excludes(live);
  subcommand->add_option("--chart", *chart, "What weft chart has written: where --need starts")
      ->type_name("DIR")
      ->needs(wanted);
  subcommand->callback([request, target, chart, &exit_code] {
    request->scene = find_scene(request->scene);
    exit_code =
        target->empty() ? run_scene(*request) : run_to_accuracy_target(*request, *target, *chart);
  });
}

}  // namespace weft::app
