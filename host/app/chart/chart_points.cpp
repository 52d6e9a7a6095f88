#include "host/app/chart/chart_points.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <sstream>
#include <thread>

#include "host/base/file_bytes.hpp"
#include "host/geometry/aabb.hpp"
#include "host/input/counted.hpp"
#include "weft/error.hpp"

namespace weft::app {
namespace {

/// The list that is being made, with what its points have in common.
class SweepSettings {
 public:
  SweepSettings(const Scene& scene, const ChartRequest& request)
      : method_(scene.method), device_(request.device) {}

  void add(const std::string& series, const std::string& label,
           std::vector<std::string> overrides) {
    add_with(series, label, method_, device_, std::move(overrides));
  }
  void add_with(const std::string& series, const std::string& label, const std::string& method,
                const std::string& device, std::vector<std::string> overrides) {
    points_.push_back({series, label, method, device, std::move(overrides)});
  }
  std::vector<ChartSetting> take() { return std::move(points_); }

 private:
  std::string method_, device_;
  std::vector<ChartSetting> points_;
};

std::string set(const char* path, double value) {
  return fmt::format("{}={:.17g}", path, value);
}

/// Integrators with one linear solve a step and with Newton's method. A single solve leaves an
/// error of the first order in stiff cloth that turns: only with Newton's method are integrators of
/// the order that they are named for.
struct StepKind {
  const char* series;
  const char* integrator;
  int newton_iterations;
};
constexpr std::array step_kinds{
    StepKind{"implicit Euler", "implicit_euler", 1}, StepKind{"BDF2", "bdf2", 1},
    StepKind{"Newton", "implicit_euler", 3}, StepKind{"BDF2, Newton", "bdf2", 3}};

bool is_own(const StepKind& kind, const Scene& scene) {
  return (scene.integrator == Integrator::bdf2) == (kind.integrator == std::string("bdf2")) &&
         scene.solver.newton_iterations == kind.newton_iterations;
}

void add_steps(const Scene& scene, bool quick, SweepSettings& sweep) {
  const double h = scene.time.step;
  const std::vector<double> shares =
      quick ? std::vector<double>{2, 1, 0.5} : std::vector<double>{4, 2, 1, 0.5, 0.25};
  for (const double share : shares)
    sweep.add("time step", fmt::format("{:.4g} s", h * share), {set("time.step", h * share)});
  if (scene.method == "asynchronous") return;
  for (const StepKind& kind : step_kinds) {
    if (is_own(kind, scene)) continue;
    const bool dear = kind.newton_iterations > 1;
    for (const double share : shares) {
      if (dear && (share == 4 || (quick && share != 1))) continue;
      const std::string step = fmt::format("{:.4g} s", h * share);
      sweep.add(kind.series,
                dear ? counted(kind.newton_iterations, "iteration") + ", " + step : step,
                {set("time.step", h * share), std::string("method.integrator=") + kind.integrator,
                 fmt::format("solver.newton_iterations={}", kind.newton_iterations)});
    }
  }
}

void add_numerics(const Scene& scene, bool quick, SweepSettings& sweep) {
  const bool asynchronous = scene.method == "asynchronous";
  if (!asynchronous) {
    for (const double tolerance :
         quick ? std::vector<double>{1e-1, 1e-4} : std::vector<double>{3e-1, 1e-1, 1e-3, 1e-5})
      sweep.add("solver tolerance", fmt::format("{:g}", tolerance),
                {set("solver.tolerance", tolerance)});
    const bool single = scene.precision == Precision::single_precision;
    sweep.add("precision", single ? "double" : "float",
              {single ? "precision=double" : "precision=float"});
  }
  for (const double share : quick ? std::vector<double>{2} : std::vector<double>{0.5, 2})
    sweep.add("thickness", fmt::format("{:.4g} m", contact_thickness(scene.contact) * share),
              {set("contact.thickness", contact_thickness(scene.contact) * share)});
}

/// Scenes whose meshes are files do not change; their points lie on each other.
void add_meshes(const Scene& scene, bool quick, SweepSettings& sweep) {
  const auto triangles = static_cast<double>(triangle_count(scene));
  for (const double share :
       quick ? std::vector<double>{0.25} : std::vector<double>{1.0 / 16, 0.25, 0.5})
    if (triangles * share >= 100)
      sweep.add("mesh", fmt::format("{:.0f} triangles", triangles * share),
                {fmt::format("triangles={:.0f}", triangles * share)});
}

void add_devices(const Scene& scene, const std::string& device, SweepSettings& sweep) {
  if (!device.starts_with("cpu")) return;
  for (const int n : {1, 2, 4, 8})
    if (const std::string name = fmt::format("cpu:{}", n);
        name != device && n <= static_cast<int>(std::thread::hardware_concurrency()))
      sweep.add_with("devices", name, scene.method, name, {});
}

void add_methods(const Scene& scene, bool quick, SweepSettings& sweep, const std::string& device) {
  for (const char* method : {"implicit", "adaptive"})
    if (scene.method != method) sweep.add_with("method", method, method, device, {});
  if (scene.method != "asynchronous" && !quick)
    sweep.add_with(
        "method", "asynchronous", "asynchronous", device,
        {"precision=double", "method.integrator=implicit_euler", "solver.newton_iterations=1"});
  if (!quick)
    for (const double angle : {0.15, 0.6})
      sweep.add_with("remeshing", fmt::format("refine_angle {:g}", angle), "adaptive", device,
                     {set("remeshing.refine_angle", angle)});
}

void add_model(const Scene& scene, SweepSettings& sweep) {
  const bool bends = std::any_of(scene.materials.begin(), scene.materials.end(),
                                 [](const Material& m) { return m.bending_stiffness > 0; });
  const bool moves = std::any_of(
      scene.obstacles.begin(), scene.obstacles.end(),
      [](const Obstacle& o) { return !o.motion.empty() || o.deformation != nullptr || o.driven; });
  if (bends) sweep.add("model", "no bending", {"model.bending=false"});
  if (scene.contact.self) sweep.add("model", "no self-contact", {"contact.self=false"});
  sweep.add("model", "no friction", {"model.friction=false"});
  if (moves) sweep.add("model", "frozen obstacles", {"model.obstacle_motion=false"});
  if (scene.wind.density > 0) sweep.add("model", "no wind", {"wind.density=0"});
}

void add_knob(const std::string& text, SweepSettings& sweep) {
  const auto equals = text.find('=');
  if (equals == std::string::npos || equals == 0)
    throw SceneError("", "--knob", text, "path=value,value,...");
  const std::string path = text.substr(0, equals);
  std::istringstream values(text.substr(equals + 1));
  for (std::string value; std::getline(values, value, ',');)
    sweep.add(path, value, {path + "=" + value});
}

double number_of(const std::string& text, const std::string& place) {
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size() || !(value > 0))
    throw SceneError(place, "value", text, "a number > 0");
  return value;
}

std::vector<std::string> cells_of(const std::string& line) {
  std::vector<std::string> cells;
  std::istringstream text(line);
  for (std::string cell; std::getline(text, cell, ',');) {
    while (!cell.empty() && (cell.back() == '\r' || cell.back() == ' ')) cell.pop_back();
    cells.push_back(cell.substr(std::min(cell.size(), cell.find_first_not_of(' '))));
  }
  return cells;
}

}  // namespace

void fields(JsonArchive& io, ChartPoint& p) {
  io("series", p.setting.series);
  io("label", p.setting.label);
  io("method", p.setting.method);
  io("device", p.setting.device);
  io("overrides", p.setting.overrides);
  io("command", p.command);
  io("commit", p.commit);
  io("state_hash", p.state_hash);
  io("starts", p.starts);
  io("failure", p.failure);
  io("seconds", p.seconds);
  io("error", p.error);
  io("statistics", p.statistics);
  io("statistics_error", p.statistics_error);
  io("hausdorff", p.hausdorff);
  io("curvature", p.curvature);
  io("stretch", p.stretch);
  io("drift", p.drift);
  io("intersections", p.intersections);
}

ChartPoint point_from_json(const Json& json) {
  return read_fields<ChartPoint>(json, {"series", "method", "seconds", "error"});
}

std::size_t triangle_count(const Scene& scene) {
  std::size_t triangles = 0;
  for (const Cloth& cloth : scene.cloths) triangles += cloth.mesh.triangles.size();
  return triangles;
}

double diagonal_of(const Scene& scene) {
  Aabb box;
  for (const Cloth& cloth : scene.cloths) box.include(aabb_of(cloth.mesh.positions));
  return box.diagonal();
}

Scene with_fixed_steps(Scene scene, const std::string& command) {
  if (scene.time.automatic)
    throw SceneError(scene.file, "time.step", "\"auto\" with " + command,
                     "a time: other steps are tried around it");
  if (scene.time.until == RunUntil::rest)
    throw SceneError(scene.file, "time.until", "\"rest\" with " + command,
                     "\"frames\": runs are compared frame by frame");
  if (scene.output.frames == FramesWritten::last)
    throw SceneError(scene.file, "output.frames", "\"last\" with " + command,
                     "\"all\": runs are compared frame by frame");
  return scene;
}

std::vector<ChartSetting> chart_settings(const Scene& scene, const ChartRequest& request) {
  SweepSettings sweep(scene, request);
  add_steps(scene, request.quick, sweep);
  add_numerics(scene, request.quick, sweep);
  add_meshes(scene, request.quick, sweep);
  add_devices(scene, request.device, sweep);
  add_methods(scene, request.quick, sweep, request.device);
  add_model(scene, sweep);
  for (const std::string& knob : request.knobs) add_knob(knob, sweep);
  return sweep.take();
}

std::vector<std::string> reference_overrides(const Scene& scene, int steps,
                                             const std::string& integrator) {
  return {"method.type=implicit",
          "method.integrator=" + integrator,
          "precision=double",
          set("time.step", scene.time.step / steps),
          "solver.tolerance=1e-6",
          "solver.newton_iterations=20",
          "solver.newton_tolerance=1e-8"};
}

std::vector<ChartPoint> read_peers(const std::string& file) {
  std::istringstream lines(read_file_bytes(file));
  std::string line;
  std::getline(lines, line);
  const std::vector<std::string> heads = cells_of(line);
  std::array<std::size_t, 3> column{};
  for (std::size_t k = 0; k < 3; ++k) {
    const char* const name = std::array{"name", "error", "seconds"}[k];
    column[k] =
        static_cast<std::size_t>(std::find(heads.begin(), heads.end(), name) - heads.begin());
    if (column[k] == heads.size())
      throw SceneError(file, "line 1", line, "a line with the columns name, error, seconds");
  }
  std::vector<ChartPoint> points;
  for (int number = 2; std::getline(lines, line); ++number) {
    if (line.empty() || line[0] == '#') continue;
    const std::string place = fmt::format("{}:{}", file, number);
    const std::vector<std::string> cells = cells_of(line);
    if (cells.size() <= std::max({column[0], column[1], column[2]}))
      throw SceneError(place, "line", line, "as many values as there are columns");
    ChartPoint p;
    p.setting = {"peer", cells[column[0]], "peer: " + cells[column[0]], "", {}};
    p.error = number_of(cells[column[1]], place);
    p.seconds = {number_of(cells[column[2]], place)};
    p.command = place;
    points.push_back(std::move(p));
  }
  return points;
}

}  // namespace weft::app
