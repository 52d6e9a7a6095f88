#include "host/app/chart/chart.hpp"

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include <filesystem>
#include <memory>
#include <string>

#include "host/app/chart/chart_output.hpp"
#include "host/app/chart/chart_points.hpp"
#include "host/app/chart/chart_sweep.hpp"
#include "host/app/run/number_range.hpp"
#include "host/app/run/scene_name.hpp"
#include "host/input/safe_text.hpp"
#include "weft/error.hpp"

namespace weft::app {
namespace {

namespace fs = std::filesystem;

/// Draws again what is there.
void draw_again(const fs::path& folder) {
  write_chart(load_chart(folder.string()), folder);
  fmt::print("{}\n", (folder / "chart.html").string());
}

std::string place_of(const ChartPoint& p) {
  return one_line(fmt::format("{}: {} (error {:.3g}, {:.3g} s per simulated s)", p.setting.series,
                              p.setting.label, p.error, p.median()));
}

/// @return whether the scene's own settings and all planned ones are among the best
/// @throws SceneError where the scene's own settings have not been measured: then nothing can be
///         said of them
bool check_chart(const fs::path& folder) {
  const Chart chart = load_chart(folder.string());
  const ChartPoint* own = chart.own_point();
  if (own == nullptr)
    throw SceneError(folder.string(), "points", "none of the scene's own settings",
                     "a chart that has them, under \"scene\": weft chart measures them first");
  if (!own->drawn()) {
    fmt::print("{}: the scene's own settings have no error and time{}{}\n", folder.string(),
               own->failure.empty() ? "" : ": ", one_line(own->failure));
    return false;
  }
  const auto better = chart.better_than_default();
  for (const std::size_t k : better)
    fmt::print("{}: better than the scene's own settings in both error and time: {}\n",
               folder.string(), place_of(chart.points[k]));
  const auto above = chart.planned_above_front();
  for (const std::size_t k : above)
    fmt::print("{}: above the front: {}\n", folder.string(), place_of(chart.points[k]));
  return better.empty() && above.empty();
}

}  // namespace

void add_chart_subcommand(CLI::App& app, int& exit_code) {
  auto* subcommand =
      app.add_subcommand("chart", "Speed against accuracy of scenes: CSV, SVG, PNG, HTML");
  const auto request = std::make_shared<ChartRequest>();
  subcommand->add_option("scenes", request->scenes, "Scene files; with --draw or --check: folders")
      ->required()
      ->type_name("SCENE");
  subcommand->add_option("-o,--output", request->output, "Directory; default: out/chart")
      ->type_name("DIR");
  subcommand->add_option("--device", request->device, "Of all points but those of the device count")
      ->type_name("D");
  subcommand->add_option("--frames", request->frames, "How many frames, instead of the scene's")
      ->type_name("N");
  request->add_options(*subcommand);
  subcommand->add_option("--knob", request->knobs, "One more series; may be repeated")
      ->type_name("PATH=V,V,...")
      ->allow_extra_args(false);
  subcommand->add_option("--runs", request->runs, "Timed runs a point")
      ->type_name("N")
      ->check(whole_number_range(1, 1000));
  subcommand
      ->add_option("--starts", request->starts,
                   "Starts of each point, moved by a millionth of the diagonal, whose means are "
                   "compared after chaos sets in")
      ->type_name("N")
      ->check(whole_number_range(1, 1000));
  subcommand
      ->add_option("--jobs", request->jobs,
                   "Points at once, each on cores of its own; those of more devices come alone")
      ->type_name("N")
      ->check(whole_number_range(1, 1024));
  subcommand->add_option("--limit", request->limit, "Seconds a run may take; 0: any")
      ->type_name("SECONDS")
      ->check(number_range(0, 1e9));
  subcommand
      ->add_option("--reference-steps", request->reference_steps,
                   "Steps of the reference for one of the scene, a power of two")
      ->type_name("N")
      ->check(CLI::IsMember({2, 4, 8, 16, 32, 64, 128}));
  subcommand->add_option("--peers", request->peers, "CSV of others' points: name,error,seconds")
      ->type_name("FILE");
  subcommand->add_flag("--quick", request->quick, "Fewer points");
  subcommand->add_flag("--fresh", request->fresh,
                       "Measure again what an earlier sweep has measured");
  subcommand->add_flag("--draw", request->draw,
                       "Draw charts that are there already, and run nothing");
  subcommand->add_flag(
      "--check", request->check,
      "Ask charts that are there whether anything beats the scene's own settings in both "
      "error and time, or a plan: exit code 4");
  subcommand->callback([request, &exit_code] {
    bool good = true;
    for (const std::string& scene : request->scenes) {
      if (request->draw) draw_again(scene);
      if (request->check) good = check_chart(scene) && good;
      if (request->draw || request->check) continue;
      request->scene = find_scene(scene);
      sweep_scene(*request);
    }
    exit_code = good ? 0 : 4;
  });
}

}  // namespace weft::app
