#include "host/scene/method_check.hpp"

#include <algorithm>
#include <cstddef>
#include <limits>
#include <string>
#include <tuple>

#include "host/input/checker.hpp"
#include "host/scene/frame_limits.hpp"

namespace weft {
namespace {

/// Each takes a snapshot of all vertices.
constexpr double max_windows_per_step = 1e5;

void validate_implicit_settings(const Scene& scene) {
  const Checker check(scene.file, "method.implicit");
  const ImplicitSettings& settings = scene.implicit;
  check.within("sleep_distance", settings.sleep_distance, quantity::length_or_zero);
  check.within("sleep_window", settings.sleep_window, quantity::duration);
  if (settings.sleep_distance > 0 && scene.method != "implicit")
    check.refuse("sleep_distance",
                 text_of(settings.sleep_distance) + " with the method \"" + scene.method + "\"",
                 "0: nothing sleeps there");
}

void validate_asynchronous_settings(const Scene& scene) {
  const AsynchronousSettings& settings = scene.asynchronous;
  const Checker check(scene.file, "method.asynchronous");
  check.within("window", settings.window, quantity::duration);
  if (scene.method == "asynchronous" && !scene.time.automatic &&
      scene.time.step / settings.window > max_windows_per_step)
    check.refuse("window", text_of(settings.window), "at most 100,000 windows per time.step");
  check.within("stiffness", settings.stiffness, quantity::stiffness);
  check.within("restitution", settings.restitution, quantity::share);
  check.integer("layers", settings.layers, 1, 10000);
  check.integer("rollbacks", settings.rollbacks, 0, count::iterations);
  check.within("smallest_step", settings.smallest_step, quantity::shortest_step);
}

/// What the asynchronous method cannot simulate.
void refuse_beyond_asynchronous(const Scene& scene) {
  const Checker check(scene.file, "");
  const std::string without = " with method.type \"asynchronous\"";
  if (scene.precision != Precision::double_precision)
    check.refuse("precision", "\"float\"", "\"double\"" + without);
  if (scene.integrator != Integrator::implicit_euler)
    check.refuse("method.integrator", "\"bdf2\"", "nothing" + without);
  for (const Material& m : scene.materials) {
    const std::string field = "materials." + m.name;
    if (m.measured) check.refuse(field + ".measured", "given", "no measured tables" + without);
    if (m.strain_limits) check.refuse(field + ".strain_limits", "given", "no limits" + without);
  }
  for (std::size_t i = 0; i < scene.cloths.size(); ++i) {
    const Cloth& cloth = scene.cloths[i];
    if (cloth.pressure != 0)
      check.refuse(numbered("cloths", i) + ".pressure", text_of(cloth.pressure), "0" + without);
    if (!cloth.rest_positions.empty() && scene.bending == Bending::plate)
      check.refuse(numbered("cloths", i) + ".rest", "a curved shape",
                   "a flat rest shape, or bending: hinge," + without);
  }
  if (!scene.handles.empty()) check.refuse("handles", "given", "no handles" + without);
  if (!scene.seams.empty()) check.refuse("seams", "given", "no seams" + without);
  if (scene.wind.density > 0)
    check.refuse("wind.density", text_of(scene.wind.density), "0" + without);
}

void validate_remeshing(const Remeshing& r, const Checker& check) {
  check.within("size[0]", r.size_min, quantity::length_or_zero);
  check.within("size[1]", r.size_max, quantity::length_or_zero);
  check.require(r.size_max >= r.size_min && (r.size_min > 0) == (r.size_max > 0), "size[1]",
                r.size_max, "a number >= size[0]");
  const std::tuple<const char*, double, const Quantity&> limits[] = {
      {"refine_angle", r.refine_angle, quantity::bend},
      {"refine_compression", r.refine_compression, quantity::length},
      {"refine_velocity", r.refine_velocity, quantity::speed}};
  for (const auto& [name, value, kind] : limits)
    if (!(value == std::numeric_limits<double>::infinity())) check.within(name, value, kind);
  check.within("aspect_min", r.aspect_min, quantity::share_below_one);
}

bool is_remeshing(const std::string& method) {
  return method == "adaptive" || method == "view";
}

/// @param with says which meshes change
void refuse_curved_rest(const Scene& scene, const std::string& with) {
  for (std::size_t c = 0; c < scene.cloths.size(); ++c)
    if (!scene.cloths[c].rest_positions.empty())
      Checker(scene.file, "")
          .refuse(numbered("cloths", c) + ".rest", "a curved shape" + with,
                  "flat rest shapes only");
}

void validate_time_parallel_settings(const Scene& scene) {
  const TimeParallelSettings& t = scene.time_parallel;
  const Checker check(scene.file, "method.time_parallel");
  if (t.method != "implicit" && !is_remeshing(t.method))
    check.refuse(
        "method", "\"" + t.method + "\"",
        "\"implicit\", \"adaptive\", \"view\": what recovers detail, and hands states over, is "
        "there for those methods alone");
  check.integer("slices", t.slices, 0, count::slices);
  check.within("ratio", t.ratio, quantity::factor_above_one);
  check.within("coarsening", t.coarsening, quantity::factor_above_one);
  check.within("coarse_step", t.coarse_step, quantity::step);
  check.require(t.coarse_step >= scene.time.step || scene.method != "time_parallel", "coarse_step",
                t.coarse_step, "a finite time of at least time.step");
  check.within("coarse_thickness", t.coarse_thickness, quantity::factor_from_one);
  check.integer("coarse_newton_iterations", t.coarse_newton_iterations, 1, 1000);
  check.within("coarse_newton_tolerance", t.coarse_newton_tolerance, quantity::tolerance);
  check.within("coarse_tolerance", t.coarse_tolerance, quantity::tolerance);
  check.within("recovery.factor", t.recovery_factor, quantity::weight);
  check.integer("recovery.iterations", t.recovery_iterations, -1, count::iterations);
  check.within("recovery.tolerance", t.recovery_tolerance, quantity::tolerance_or_zero);
  check.within("boundary_tolerance", t.boundary_tolerance, quantity::loose_tolerance);
  check.integer("blend_frames", t.blend_frames, 0, 1000);
}

/// What needs meshes that stay as they are, of slices and of the coarse run.
void refuse_tied_meshes(const Scene& scene) {
  const TimeParallelSettings& t = scene.time_parallel;
  const Checker check(scene.file, "method.time_parallel");
  const std::string with = slices_remesh(scene) ? " with slices of the method \"" + t.method + "\""
                                                : " with the coarse_mesh \"adaptive\"";
  if (t.blend_frames > 0 && slices_remesh(scene))
    check.refuse("blend_frames", std::to_string(t.blend_frames) + with,
                 "0: frames on both sides of a seam have to be of one mesh");
  // Of slices that remesh they are refused anyway, see validate_adaptive().
  if (!slices_remesh(scene)) refuse_curved_rest(scene, with);
}

/// What slices of time cannot begin in the midst of.
void refuse_beyond_time_parallel(const Scene& scene) {
  if (slices_remesh(scene) || scene.time_parallel.coarse_adaptive) refuse_tied_meshes(scene);
  const Checker check(scene.file, "");
  if (!scene.seams.empty())
    check.refuse("seams", "seams with the method \"time_parallel\"",
                 "cloths that are sewn already, or another method");
  if (scene.refinement.when != Refinement::When::never)
    check.refuse("refine", "\"sewn\" with the method \"time_parallel\"", "\"never\"");
  if (scene.time.until == RunUntil::rest)
    check.refuse("time.until", "\"rest\" with the method \"time_parallel\"",
                 "\"frames\": slices of time need an end that is known before");
  if (scene.output.frames == FramesWritten::last)
    check.refuse("output.frames", "\"last\" with the method \"time_parallel\"",
                 "\"all\", or another method");
}

void validate_adaptive(const Scene& scene) {
  const AdaptiveSettings& adaptive = scene.adaptive;
  const Checker check(scene.file, "remeshing");
  validate_remeshing(adaptive.remeshing, check);
  check.within("flip_threshold", adaptive.flip_threshold, quantity::weight);
  if (!(adaptive.energy_share == std::numeric_limits<double>::infinity()))
    check.within("energy_share", adaptive.energy_share, quantity::weight);
  for (std::size_t c = 0; c < scene.cloths.size(); ++c)
    if (scene.cloths[c].remeshing)
      validate_remeshing(*scene.cloths[c].remeshing,
                         Checker(scene.file, numbered("cloths", c) + ".remeshing"));
  if (!remeshes(scene) && !slices_remesh(scene)) return;
  const Checker all(scene.file, "");
  const std::string with =
      remeshes(scene) ? " with the method \"" + scene.method + "\""
                      : " with slices of the method \"" + scene.time_parallel.method + "\"";
  if (scene.refinement.when != Refinement::When::never)
    all.refuse("refine", "\"sewn\"" + with, "\"never\": the method refines by itself");
  if (scene.output.format == FrameFormat::pc2 || scene.output.format == FrameFormat::glb)
    all.refuse("output.format",
               (scene.output.format == FrameFormat::pc2 ? "\"pc2\"" : "\"glb\"") + with,
               "a format whose frames may differ in their meshes: obj, ply or usda");
  refuse_curved_rest(scene, with);
}

/// A .glb is limited in frames and bytes: refused before the run rather than at its end.
void refuse_beyond_glb(const Scene& scene) {
  if (scene.output.format != FrameFormat::glb) return;
  const Checker check(scene.file, "output");
  const double frames = scene.time.frames + 1;
  if (frames > max_glb_frames)
    check.refuse("format", "\"glb\" for " + std::to_string(scene.time.frames + 1) + " frames",
                 "up to " + std::to_string(max_glb_frames) + " frames, or the format usda");
  double vertices = 0;
  for (const Cloth& cloth : scene.cloths)
    vertices +=
        static_cast<double>(std::max(cloth.mesh.positions.size(), cloth.mesh.material.size()));
  for (const Obstacle& obstacle : scene.obstacles)
    if (obstacle.deformation || obstacle.live)
      vertices += static_cast<double>(obstacle.mesh.positions.size());
  if (vertices * frames * glb_bytes_per_vertex > 0.95 * max_glb_bytes)
    check.refuse("format", "\"glb\" for more than 4 GiB of frames",
                 "fewer vertices or frames, or the format usda");
}

/// What has a schedule of steps of its own.
void refuse_automatic_steps(const Scene& scene) {
  if (!scene.time.automatic) return;
  const Checker check(scene.file, "time");
  if (scene.method == "asynchronous" || scene.method == "time_parallel")
    check.refuse("step", "\"auto\" with the method \"" + scene.method + "\"",
                 "a time: only implicit steps have an error estimate");
  if (scene.implicit.sleep_distance > 0)
    check.refuse("step", "\"auto\" with method.implicit.sleep_distance",
                 "a time, or a sleep_distance of 0: sleep counts steps");
}

}  // namespace

bool remeshes(const Scene& scene) {
  return is_remeshing(scene.method);
}

bool slices_remesh(const Scene& scene) {
  return scene.method == "time_parallel" && is_remeshing(scene.time_parallel.method);
}

void validate_methods(const Scene& scene) {
  const Checker check(scene.file, "");
  if (scene.method != "implicit" && scene.method != "asynchronous" &&
      scene.method != "time_parallel" && !remeshes(scene))
    check.refuse("method.type", "\"" + scene.method + "\"",
                 "\"implicit\", \"adaptive\", \"view\", \"asynchronous\", \"time_parallel\"");
  validate_time_parallel_settings(scene);
  if (scene.method == "time_parallel") refuse_beyond_time_parallel(scene);
  refuse_beyond_glb(scene);
  validate_adaptive(scene);
  validate_implicit_settings(scene);
  validate_asynchronous_settings(scene);
  if (scene.method == "asynchronous") refuse_beyond_asynchronous(scene);
  refuse_automatic_steps(scene);
}

}  // namespace weft
