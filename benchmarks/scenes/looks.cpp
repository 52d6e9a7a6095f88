// How adaptive meshes look from the camera of a scene, against the meshes that it was given
// (`reference`, the method implicit). --measure picks what is looked at:
//   pixels   silhouettes and shading, in pictures of the scene's camera
//   edges    the shortest edges in these pictures, cloth by cloth (Koh et al. 2015, Fig. 4)
//   popping  how much farther visible points move from one frame to the next than the reference's,
//            with and without anticipation (Fig. 3)
//   shape    cloth out of the picture, by how it yields to compression (Fig. 6 and 7)
#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "benchmarks/support/bench_main.hpp"
#include "benchmarks/support/joined_cloths.hpp"
#include "benchmarks/support/raster.hpp"
#include "benchmarks/support/scene_settings.hpp"
#include "host/base/atomic_file.hpp"
#include "host/io/scene/scene_file.hpp"
#include "host/lab/chart/compare.hpp"
#include "host/scene/camera.hpp"
#include "weft/devices.hpp"
#include "weft/simulation.hpp"

namespace {

using namespace weft;
using namespace weft::bench;
using Json = nlohmann::ordered_json;
using Clock = std::chrono::steady_clock;

struct Options {
  std::string scene = WEFT_SOURCE_DIR "/scenes/row.json";
  std::string measure = "pixels";
  std::optional<int> frames;
  double seconds = 0;  ///< wall time after which no frame is begun; 0: any
  std::string device = "cpu:1";
  std::vector<std::string> overrides;
  std::string json;
  bool smoke = false;
};

/// One of the runs that are looked at side by side.
struct Variant {
  std::string name;
  std::vector<std::string> overrides;
};

std::vector<Variant> variants_of(const std::string& measure) {
  const Variant fixed{"reference", {"method.type=implicit"}};
  const Variant adaptive{"adaptive", {"method.type=adaptive"}};
  const auto view = [](const char* name, std::vector<std::string> more) {
    more.emplace_back("method.type=view");
    return Variant{name, std::move(more)};
  };
  if (measure == "edges") return {adaptive, view("view", {})};
  if (measure == "popping")
    return {fixed, adaptive, view("anticipation_5", {"method.view.anticipation=5"}),
            view("anticipation_0", {"method.view.anticipation=0"})};
  if (measure == "shape")
    return {fixed, adaptive, view("none", {"method.view.compensation=none"}),
            view("beta_0", {"method.view.compensation=full"}),
            view("k_10", {"method.view.compensation=area"})};
  // How far apart two runs of the reference are that differ by next to nothing.
  return {fixed,
          {"jittered", {"method.type=implicit", "jitter.amplitude=1e-5"}},
          adaptive,
          view("view", {})};
}

/// A running variant, where it was a frame ago, and what has been measured of it.
struct Runner {
  std::string name;
  std::unique_ptr<Simulation> simulation;
  Mesh cloths;
  std::vector<std::size_t> first;             ///< [cloths + 1] triangles
  std::vector<Vec3<double>> carried, before;  ///< [m] at the reference's vertices, now and then
  double wall = 0;                            ///< [s]
  double face_frames = 0;
  std::string failure;
  Json frames = Json::array();

  bool advance() {
    const auto start = Clock::now();
    do {
      const StepReport report = simulation->step();
      if (report.failure == Failure::none) continue;
      failure = fmt::format("step {}: {}", report.number, describe(report.failure));
      return false;
    } while (!simulation->at_frame_end());
    wall += std::chrono::duration<double>(Clock::now() - start).count();
    first.clear();
    cloths = joined_cloths(*simulation, &first);
    face_frames += static_cast<double>(cloths.triangles.size());
    return true;
  }
};

Mesh obstacles_of(const Simulation& simulation) {
  Mesh all;
  const Frame frame = simulation.frame();
  for (std::size_t i = 0; i < frame.obstacle_positions.size(); ++i) {
    const auto vertex = static_cast<Index>(all.positions.size());
    for (Tri t : simulation.scene().obstacles[i].mesh.triangles) {
      for (Index& v : t.v) v += vertex;
      all.triangles.push_back(t);
    }
    const auto& x = frame.obstacle_positions[i];
    all.positions.insert(all.positions.end(), x.begin(), x.end());
  }
  return all;
}

/// The value below which a share of the values are; of sorted ones.
double quantile(const std::vector<double>& sorted, double share) {
  if (sorted.empty()) return 0;
  return sorted[std::min(sorted.size() - 1,
                         static_cast<std::size_t>(share * static_cast<double>(sorted.size())))];
}

bool in_picture(const ViewCamera& camera, const Vec3<double>& x, Vec2<double>& pixel) {
  const Vec3<double> seen = camera.seen(x);
  if (!(seen[2] > camera.near())) return false;
  pixel = camera.pixel(seen);
  return pixel[0] >= 0 && pixel[1] >= 0 && pixel[0] < camera.width() && pixel[1] < camera.height();
}

/// Edges of triangles that turn their front to the camera and are whole in the picture.
Json edges_of(const Runner& run, const ViewCamera& camera) {
  Json rows = Json::array();
  for (std::size_t c = 0; c + 1 < run.first.size(); ++c) {
    std::vector<double> lengths;
    Vec3<double> mean{0, 0, 0};
    for (std::size_t t = run.first[c]; t < run.first[c + 1]; ++t) {
      Vec3<double> x[3];
      Vec2<double> p[3];
      bool in = true;
      for (int j = 0; j < 3; ++j) {
        x[j] = run.cloths.positions[static_cast<std::size_t>(run.cloths.triangles[t].v[j])];
        in = in_picture(camera, x[j], p[j]) && in;
        mean += x[j];
      }
      if (!in || dot(cross(x[1] - x[0], x[2] - x[0]), x[0] - camera.eye()) >= 0) continue;
      for (int j = 0; j < 3; ++j) lengths.push_back(length(p[(j + 1) % 3] - p[j]));
    }
    std::sort(lengths.begin(), lengths.end());
    const auto count = static_cast<double>(run.first[c + 1] - run.first[c]);
    rows.push_back({{"distance_m", length((1 / (3 * count)) * mean - camera.eye())},
                    {"faces", run.first[c + 1] - run.first[c]},
                    {"edges_seen", lengths.size()},
                    {"shortest_px", quantile(lengths, 0)},
                    {"p5_px", quantile(lengths, 0.05)},
                    {"median_px", quantile(lengths, 0.5)}});
  }
  return rows;
}

/// What visible vertices of the reference have moved farther in a variant since the last frame.
Json popping_of(const Runner& reference, const Runner& run, const ViewCamera& camera,
                const Raster& picture) {
  std::vector<double> beyond;
  double squares = 0;
  for (std::size_t v = 0; v < run.carried.size(); ++v) {
    Vec2<double> now, then, own_now, own_then;
    if (!in_picture(camera, reference.cloths.positions[v], own_now) ||
        !in_picture(camera, reference.before[v], own_then) ||
        !in_picture(camera, run.carried[v], now) || !in_picture(camera, run.before[v], then))
      continue;
    const double depth = camera.seen(run.carried[v])[2];
    const float front =
        picture.depth[picture.at(static_cast<int>(now[0]), static_cast<int>(now[1]))];
    if (depth > 1.01 * front) continue;  // hidden
    beyond.push_back(std::max(0.0, length(now - then) - length(own_now - own_then)));
    squares += beyond.back() * beyond.back();
  }
  std::sort(beyond.begin(), beyond.end());
  const auto count = static_cast<double>(beyond.size());
  return {{"visible", beyond.size()},
          {"largest_px", quantile(beyond, 1)},
          {"p99_px", quantile(beyond, 0.99)},
          {"rms_px", count > 0 ? std::sqrt(squares / count) : 0.0}};
}

/// Size of the cloths as a whole.
Json shape_of(const Runner& reference, const Runner& run) {
  const lab::Statistics own = lab::statistics(run.cloths);
  double area = 0, rest = 0;
  for (std::size_t t = 0; t < run.cloths.triangles.size(); ++t) {
    const auto x = [&](int j) {
      return run.cloths.positions[static_cast<std::size_t>(run.cloths.triangles[t].v[j])];
    };
    const auto u = [&](int j) {
      return run.cloths.material[static_cast<std::size_t>(run.cloths.material_triangles[t].v[j])];
    };
    area += length(cross(x(1) - x(0), x(2) - x(0))) / 2;
    const Vec2<double> a = u(1) - u(0), b = u(2) - u(0);
    rest += (a[0] * b[1] - a[1] * b[0]) / 2;
  }
  return {{"distance_m",
           lab::mean_distance(reference.cloths.triangles, reference.cloths.positions, run.carried)},
          {"mean_height_m", own.mean[2]},
          {"spread_m", {own.spread[0], own.spread[1], own.spread[2]}},
          {"width_m", std::hypot(own.spread[0], own.spread[1])},
          {"area_over_rest", area / rest}};
}

/// What one frame shows of every run; the reference, where there is one, is the first.
void measure(const Options& options, std::vector<Runner>& runs, const Camera& track) {
  const double time = runs[0].simulation->time();
  const CameraKey key = track.keys.empty() ? CameraKey{} : camera_at(track, time);
  const ViewCamera camera(key, track.width, track.height);
  const Mesh obstacles = obstacles_of(*runs[0].simulation);
  Raster reference;
  for (Runner& run : runs) {
    Json row{{"time", time}, {"faces", run.cloths.triangles.size()}};
    if (options.measure == "edges") {
      row["cloths"] = edges_of(run, camera);
    } else {
      const lab::Resampling at_reference(run.cloths, runs[0].cloths);
      run.before.swap(run.carried);
      if (at_reference.known()) run.carried = at_reference.positions(run.cloths.positions);
      if (options.measure == "shape") row.update(shape_of(runs[0], run));
    }
    if (options.measure == "pixels" || options.measure == "popping") {
      const Raster picture = picture_of(camera, run.cloths, obstacles);
      if (&run == &runs[0]) reference = picture;
      const PictureError error = picture_error(reference, picture);
      if (options.measure == "pixels" && error.any)
        row.update(Json{{"silhouette_mean_px", error.silhouette_mean},
                        {"silhouette_p95_px", error.silhouette_p95},
                        {"shade_rms", error.shade_rms},
                        {"shade_share_off_by_a_tenth", error.shade_share}});
      if (options.measure == "popping" && run.before.size() == run.carried.size())
        row.update(popping_of(runs[0], run, camera, picture));
    }
    run.frames.push_back(std::move(row));
  }
}

/// Mean and largest of a number over the frames that have it.
void summarise(const Json& frames, const char* name, Json& into) {
  double sum = 0, most = 0;
  int count = 0;
  for (const Json& frame : frames)
    if (frame.contains(name)) {
      sum += frame[name].get<double>();
      most = std::max(most, frame[name].get<double>());
      ++count;
    }
  if (count > 0) into[name] = {{"mean", sum / count}, {"max", most}, {"frames", count}};
}

Json to_json(const Runner& run) {
  Json summary = Json::object();
  for (const char* name : {"silhouette_mean_px", "silhouette_p95_px", "shade_rms",
                           "shade_share_off_by_a_tenth", "largest_px", "p99_px", "rms_px",
                           "distance_m", "mean_height_m", "width_m", "area_over_rest"})
    summarise(run.frames, name, summary);
  const auto frames = static_cast<double>(run.frames.size());
  return {
      {"name", run.name},   {"failure", run.failure.empty() ? Json(nullptr) : Json(run.failure)},
      {"wall_s", run.wall}, {"faces_mean", frames > 0 ? run.face_frames / frames : 0.0},
      {"summary", summary}, {"by_frame", run.frames}};
}

int execute(const Options& options, const std::vector<std::string>& command) {
  Json machine = machine_json();
  std::vector<Runner> runs;
  Camera track;
  int frames = 0;
  for (const Variant& variant : variants_of(options.measure)) {
    std::vector<std::string> overrides = options.overrides;
    overrides.insert(overrides.end(), variant.overrides.begin(), variant.overrides.end());
    if (options.frames) overrides.push_back(fmt::format("time.frames={}", *options.frames));
    Scene scene = bench::read_scene_file(options.scene, overrides).scene;
    track = scene.camera;
    frames = scene.time.frames;
    runs.emplace_back();
    runs.back().name = variant.name;
    runs.back().simulation =
        std::make_unique<Simulation>(std::move(scene), parse_devices(options.device));
  }
  Json report{{"benchmark", "looks"},
              {"measure", options.measure},
              {"build", build_json()},
              {"machine", std::move(machine)},
              {"command", command},
              {"scene", std::filesystem::path(options.scene).filename().string()},
              {"overrides", options.overrides},
              {"device", options.device},
              {"resolution", {track.width, track.height}},
              {"frames_asked", frames}};
  const auto start = Clock::now();
  bool failed = false;
  for (int frame = 0; frame < frames && !failed; ++frame) {
    if (options.seconds > 0 &&
        std::chrono::duration<double>(Clock::now() - start).count() > options.seconds)
      break;
    for (Runner& run : runs) failed = !run.advance() || failed;
    if (!failed) measure(options, runs, track);
    report["frames"] = runs[0].frames.size();
    report["runs"] = Json::array();
    for (const Runner& run : runs) report["runs"].push_back(to_json(run));
    // Every time, so that a run that is cut off still counts.
    if (!options.json.empty()) write_file_atomically(options.json, report.dump(1) + "\n");
  }
  for (const Runner& run : runs) {
    const Json row = to_json(run);
    fmt::print("{:<16} {:>9.0f} faces {:>9.2f} s  {}\n", run.name, row["faces_mean"].get<double>(),
               run.wall, row["summary"].dump());
    if (!run.failure.empty()) fmt::print(stderr, "weft_bench_looks: {}\n", run.failure);
  }
  return failed ? simulation_failed : done;
}

}  // namespace

int main(int argc, char** argv) {
  Options options;
  CLI::App app("How adaptive meshes look from the camera", "weft_bench_looks");
  app.add_option("--scene", options.scene, "Scene file with a camera");
  app.add_option("--measure", options.measure, "pixels, edges, popping, shape")
      ->check(CLI::IsMember({"pixels", "edges", "popping", "shape"}));
  app.add_option("--frames", options.frames, "Instead of the scene's");
  app.add_option("--seconds", options.seconds, "Wall time after which no frame is begun");
  app.add_option("--device", options.device, "As of weft run");
  app.add_option("--set", options.overrides, "Override a value of the scene")
      ->allow_extra_args(false);
  app.add_option("--json", options.json, "Write results to this file");
  app.add_flag("--smoke", options.smoke, "A small scene, a few frames");
  return bench_main(app, argc, argv, [&](const std::vector<std::string>& command) -> int {
    if (!options.smoke) return execute(options, command);
    options.overrides.insert(options.overrides.begin(),
                             {"triangles=800", "camera.resolution=[320,180]"});
    options.frames = 4;
    int worst = done;
    for (const char* name : {"pixels", "edges", "popping", "shape"}) {
      options.measure = name;
      worst = std::max(worst, execute(options, command));
    }
    return worst;
  });
}
