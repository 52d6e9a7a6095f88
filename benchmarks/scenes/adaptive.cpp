// Adaptive meshes, with and without a camera, against those that a scene was given: faces,
// vertices, seconds a frame, and what of them is remeshing. Also takes scenes of ARCSim; --arcsim
// runs three of those that come with it and says how long ARCSim 0.2.1 took.
#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "benchmarks/support/provenance.hpp"
#include "benchmarks/support/scene_settings.hpp"
#include "host/adaptive/remesh_scene.hpp"
#include "host/base/atomic_file.hpp"
#include "host/exec/cpu_seconds.hpp"
#include "host/io/scene/scene_file.hpp"
#include "weft/devices.hpp"
#include "weft/error.hpp"
#include "weft/simulation.hpp"

namespace {

using Json = nlohmann::ordered_json;
using Clock = std::chrono::steady_clock;

enum ExitCode { done = 0, bad_input = 2, simulation_failed = 4 };

struct Options {
  std::string scene = WEFT_SOURCE_DIR "/scenes/drape.json";
  std::optional<int> frames;
  std::vector<std::string> methods{"implicit", "adaptive", "view"};
  std::string arcsim;  ///< folder of ARCSim's scene files; empty: none
  std::string only;    ///< of these, with its frames, as in sphere/20; empty: all
  double coarser = 1;  ///< what adaptive meshes are refined for is so many times as large
  double seconds = 0;  ///< wall time after which a run begins no frame; 0: any
  std::string device = "cpu:1";
  std::vector<std::string> overrides;
  std::string json;
  bool smoke = false;
};

/// Least, greatest and mean over the frames.
struct Range {
  double min = 0, max = 0, mean = 0;
};

Range range_of(const std::vector<double>& values) {
  Range r;
  if (values.empty()) return r;
  const auto [low, high] = std::minmax_element(values.begin(), values.end());
  r.min = *low;
  r.max = *high;
  for (const double value : values) r.mean += value / static_cast<double>(values.size());
  return r;
}

Json to_json(const Range& r) {
  return {{"min", r.min}, {"max", r.max}, {"mean", r.mean}};
}

/// One run of the scene by one method.
struct Result {
  std::string method;
  std::string failure;  ///< empty: none
  int frames_asked = 0;
  std::vector<double> faces;  ///< [frames]
  std::vector<double> vertices;
  std::vector<double> wall;         ///< [s]
  std::vector<double> cpu;          ///< [s] of all threads
  double remeshing = 0;             ///< [s] wall, in all
  double rebuilding = 0;            ///< [s] of these: rebuilding the model
  double remeshing_cpu = 0;         ///< [s] of all threads
  std::vector<double> view_factor;  ///< [frames] mean; empty: no camera
  double energy_jump = 0;           ///< [J] the largest
  double peak_kinetic = 0;          ///< [J] at frames
  std::uint64_t state_hash = 0;
};

/// The file of results, which is up to date after every frame.
class Book {
 public:
  Book(std::string path, Json head) : path_(std::move(path)), head_(std::move(head)) {}

  /// @param row of the run that is not done yet; null: none
  void write(const Json& row = nullptr) const {
    if (path_.empty()) return;
    Json report = head_;
    report["runs"] = rows;
    if (!row.is_null()) report["runs"].push_back(row);
    weft::write_file_atomically(path_, report.dump(2) + "\n");
  }

  Json rows = Json::array();

 private:
  std::string path_;
  Json head_;
};

/// A scene whose meshes were made so many times coarser asks for the same shapes: what an edge may
/// turn, shrink and shear by grows with its length. Without this an adaptive mesh is at its least
/// size everywhere, as fine as the fixed one that it is compared with. Sizes follow the given mesh.
void coarsen(weft::Scene& scene, double coarser) {
  for (weft::Cloth& cloth : scene.cloths) {
    weft::Remeshing r = weft::remeshing_of(scene, cloth);
    for (double* value : {&r.refine_angle, &r.refine_compression, &r.refine_velocity})
      *value *= coarser;
    cloth.remeshing = r;
  }
}

double sum(const std::vector<double>& values) {
  double total = 0;
  for (const double value : values) total += value;
  return total;
}

Json to_json(const Result& r) {
  const double wall = sum(r.wall);
  return {{"method", r.method},
          {"failure", r.failure.empty() ? Json(nullptr) : Json(r.failure)},
          {"frames", r.wall.size()},
          {"frames_asked", r.frames_asked},
          {"faces", to_json(range_of(r.faces))},
          {"vertices", to_json(range_of(r.vertices))},
          {"wall_s_a_frame", to_json(range_of(r.wall))},
          {"cpu_s_a_frame", to_json(range_of(r.cpu))},
          {"wall_s", wall},
          {"cpu_s", sum(r.cpu)},
          {"remeshing_share", wall > 0 ? r.remeshing / wall : 0.0},
          {"remeshing_cpu_share", sum(r.cpu) > 0 ? r.remeshing_cpu / sum(r.cpu) : 0.0},
          {"rebuilding_share", wall > 0 ? r.rebuilding / wall : 0.0},
          {"view_factor_by_frame", r.view_factor},
          {"energy_jump_share", r.peak_kinetic > 0 ? r.energy_jump / r.peak_kinetic : 0.0},
          {"faces_by_frame", r.faces},
          {"wall_s_by_frame", r.wall},
          {"cpu_s_by_frame", r.cpu},
          {"state_hash", fmt::format("{:016x}", r.state_hash)}};
}

Result run(const Options& options, const Book& book, const std::string& file,
           std::optional<int> frame_count, const std::string& method) {
  std::vector<std::string> overrides = options.overrides;
  overrides.push_back("method.type=" + method);
  if (frame_count) overrides.push_back(fmt::format("time.frames={}", *frame_count));
  weft::Scene scene = weft::bench::read_scene_file(file, overrides).scene;
  const int frames = scene.time.frames;
  if (options.coarser != 1) coarsen(scene, options.coarser);
  const auto begin = Clock::now();
  weft::Simulation simulation(std::move(scene), weft::parse_devices(options.device));
  Result result;
  result.method = method;
  result.frames_asked = frames;
  while (simulation.frame_number() < frames) {
    if (options.seconds > 0 &&
        std::chrono::duration<double>(Clock::now() - begin).count() > options.seconds)
      break;
    const auto start = Clock::now();
    const double cpu = weft::cpu_seconds();
    do {
      const weft::StepReport report = simulation.step();
      if (report.failure != weft::Failure::none) {
        result.failure = fmt::format("step {}: {}: {}", report.number, describe(report.failure),
                                     report.failure_detail);
        return result;
      }
      result.remeshing += report.remesh.seconds;
      result.remeshing_cpu += report.remesh.cpu_seconds;
      result.rebuilding += report.remesh.rebuild_seconds;
      if (report.remesh.factor_mean > 0) result.view_factor.push_back(report.remesh.factor_mean);
      result.energy_jump = std::max(result.energy_jump, std::abs(report.remesh.energy_jump));
    } while (!simulation.at_frame_end());
    result.cpu.push_back(weft::cpu_seconds() - cpu);
    result.wall.push_back(std::chrono::duration<double>(Clock::now() - start).count());
    result.peak_kinetic = std::max(result.peak_kinetic, simulation.energy().kinetic);
    double faces = 0, vertices = 0;
    for (const weft::Cloth& cloth : simulation.scene().cloths) {
      faces += static_cast<double>(cloth.mesh.triangles.size());
      vertices += static_cast<double>(cloth.mesh.positions.size());
    }
    result.faces.push_back(faces);
    result.vertices.push_back(vertices);
    book.write(to_json(result));
  }
  result.state_hash = simulation.state_hash();
  return result;
}

/// A scene of ARCSim's, as far as it was timed: CPU seconds of ARCSim 0.2.1 on one thread.
struct Rival {
  const char* scene;
  int frames;
  double cpu;
};
constexpr Rival rivals[] = {
    {"sphere", 60, 89.3}, {"sphere", 20, 8.1}, {"flag", 13, 80.1}, {"dress-blue", 12, 74.0}};

/// Faces that ARCSim 0.2.1 had, by frame, as far as they are known.
std::map<std::string, int> faces_of_arcsim(const std::string& scene) {
  if (scene == "sphere")
    return {{"0", 128}, {"10", 1011}, {"20", 1774}, {"40", 2977}, {"60", 6540}};
  if (scene == "flag") return {{"0", 118}, {"10", 5177}, {"12", 7695}};
  return {{"0", 3197}, {"12", 6698}};
}

void print_row(const Result& r, const Json& row) {
  const Range faces = range_of(r.faces), wall = range_of(r.wall);
  fmt::print(
      "{:<10} {:>9.0f} {:>9.0f} {:>9.0f} {:>10.4f} {:>10.4f} {:>10.3f} {:>8.1f}% {:>7.2f}%\n",
      r.method, faces.mean, faces.max, range_of(r.vertices).mean, wall.mean, wall.max, sum(r.cpu),
      100 * row["remeshing_share"].get<double>(), 100 * row["energy_jump_share"].get<double>());
  if (!r.failure.empty()) fmt::print(stderr, "weft_bench_adaptive: {}: {}\n", r.method, r.failure);
  std::fflush(stdout);
}

void print_head() {
  fmt::print("{:<10} {:>9} {:>9} {:>9} {:>10} {:>10} {:>10} {:>9} {:>8}\n", "method", "faces",
             "max", "vertices", "s/frame", "max", "cpu s", "remesh", "jump");
}

/// Rows of one scene, method by method.
void compare(const Options& options, Book& book) {
  for (const std::string& method : options.methods) {
    const Result r = run(options, book, options.scene, options.frames, method);
    book.rows.push_back(to_json(r));
    print_row(r, book.rows.back());
  }
}

/// Rows of ARCSim's scenes, by the method adaptive.
void compare_with_arcsim(const Options& options, Book& book) {
  for (const Rival& rival : rivals) {
    if (!options.only.empty() && options.only != fmt::format("{}/{}", rival.scene, rival.frames))
      continue;
    const std::string file = options.arcsim + "/" + rival.scene + ".json";
    const Result r = run(options, book, file, rival.frames, "adaptive");
    Json row = to_json(r);
    print_row(r, row);
    row["scene"] = rival.scene;
    // Only of whole runs: frames do not cost the same.
    const bool whole = r.failure.empty() && static_cast<int>(r.wall.size()) == rival.frames;
    row["arcsim_cpu_s"] = rival.cpu;
    row["arcsim_over_weft"] = whole ? Json(rival.cpu / sum(r.cpu)) : Json(nullptr);
    row["arcsim_faces_by_frame"] = Json(faces_of_arcsim(rival.scene));
    book.rows.push_back(std::move(row));
  }
}

int execute(const Options& options, Json machine, const std::vector<std::string>& command) {
  Book book(options.json,
            {{"benchmark", "adaptive"},
             {"build", weft::bench::build_json()},
             {"machine", std::move(machine)},
             {"command", command},
             {"scene", options.arcsim.empty()
                           ? Json(std::filesystem::path(options.scene).filename().string())
                           : Json("ARCSim's")},
             {"overrides", options.overrides},
             {"coarser", options.coarser},
             {"device", options.device},
             {"seconds_limit", options.seconds > 0 ? Json(options.seconds) : Json(nullptr)}});
  print_head();
  if (options.arcsim.empty())
    compare(options, book);
  else
    compare_with_arcsim(options, book);
  book.write();
  for (const Json& row : book.rows)
    if (!row["failure"].is_null()) return simulation_failed;
  return done;
}

}  // namespace

int main(int argc, char** argv) {
  Options options;
  CLI::App app("Adaptive meshes against fixed ones");
  app.add_option("--scene", options.scene, "Scene file, of weft or of ARCSim");
  app.add_option("--frames", options.frames, "Instead of the scene's");
  app.add_option("--methods", options.methods, "implicit, adaptive, view")->delimiter(',');
  app.add_option("--arcsim", options.arcsim,
                 "Folder of ARCSim's conf files: run sphere, flag and dress-blue instead");
  app.add_option("--only", options.only, "One of these, with its frames: sphere/20");
  app.add_option(
         "--coarser", options.coarser,
         "Refine for angles, compressions and velocities so many times as large: of a scene "
         "whose triangles are n times fewer, the root of n")
      ->check(CLI::Range(0.1, 100.0));
  app.add_option("--seconds", options.seconds, "Wall time after which a run begins no frame");
  app.add_option("--device", options.device, "As of weft run");
  app.add_option("--set", options.overrides, "Override a value of the scene")
      ->allow_extra_args(false);
  app.add_option("--json", options.json, "Write results to this file");
  app.add_flag("--smoke", options.smoke, "A small scene, a few frames");
  CLI11_PARSE(app, argc, argv);
  Json machine = weft::bench::machine_json();
  if (options.smoke) {
    options.overrides.emplace_back("triangles=800");
    if (!options.frames) options.frames = 6;
  }
  try {
    return execute(options, std::move(machine), weft::bench::command_words(argc, argv));
  } catch (const std::exception& error) {
    fmt::print(stderr, "weft_bench_adaptive: {}\n", error.what());
    return bad_input;
  }
}
