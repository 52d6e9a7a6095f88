#include "host/scene/method_check.hpp"

#include <cmath>
#include <cstddef>
#include <string>
#include <utility>

#include "host/scene/checker.hpp"

namespace weft {
namespace {

void validate_implicit_settings(const Scene& scene) {
  const Checker check(scene.file, "method.implicit");
  const ImplicitSettings& settings = scene.implicit;
  check.not_negative("sleep_distance", settings.sleep_distance);
  check.positive("sleep_window", settings.sleep_window);
  if (settings.sleep_distance > 0 && scene.method != "implicit")
    check.refuse("sleep_distance",
                 text_of(settings.sleep_distance) + " with the method \"" + scene.method + "\"",
                 "0: nothing sleeps there");
}

void validate_asynchronous_settings(const Scene& scene) {
  const AsynchronousSettings& settings = scene.asynchronous;
  const Checker check(scene.file, "method.asynchronous");
  check.positive("window", settings.window);
  check.positive("stiffness", settings.stiffness);
  check.require(settings.restitution >= 0 && settings.restitution <= 1, "restitution",
                settings.restitution, "a number from 0 to 1");
  check.require(settings.layers >= 1 && settings.layers <= 10000, "layers", settings.layers,
                "an integer from 1 to 10000");
  check.require(settings.rollbacks >= 0, "rollbacks", settings.rollbacks, "an integer >= 0");
  check.positive("smallest_step", settings.smallest_step);
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
  check.require(r.size_min >= 0 && std::isfinite(r.size_min), "size[0]", r.size_min,
                "a number > 0, or 0 for the size of the mesh");
  check.require(
      r.size_max >= r.size_min && (r.size_min > 0) == (r.size_max > 0) && std::isfinite(r.size_max),
      "size[1]", r.size_max, "a number >= size[0]");
  const std::pair<const char*, double> limits[] = {{"refine_angle", r.refine_angle},
                                                   {"refine_compression", r.refine_compression},
                                                   {"refine_velocity", r.refine_velocity}};
  for (const auto& [name, value] : limits)
    if (!(value > 0)) check.refuse(name, text_of(value), "a number > 0");
  check.require(r.aspect_min >= 0 && r.aspect_min < 1, "aspect_min", r.aspect_min,
                "a number >= 0 and < 1");
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
  check.require(t.slices >= 0, "slices", t.slices, "an integer >= 0");
  check.require(t.ratio > 1, "ratio", t.ratio, "a number > 1");
  check.require(t.coarsening > 1, "coarsening", t.coarsening,
                "a number > 1: the coarse mesh has the longer edges");
  check.require(t.coarse_step >= scene.time.step || scene.method != "time_parallel", "coarse_step",
                t.coarse_step, "a finite time of at least time.step");
  check.require(t.coarse_thickness >= 1, "coarse_thickness", t.coarse_thickness, "a number >= 1");
  check.require(t.coarse_newton_iterations >= 1, "coarse_newton_iterations",
                t.coarse_newton_iterations, "an integer >= 1");
  check.require(t.coarse_newton_tolerance > 0 && t.coarse_newton_tolerance < 1,
                "coarse_newton_tolerance", t.coarse_newton_tolerance, "a number > 0 and < 1");
  check.require(t.coarse_tolerance > 0 && t.coarse_tolerance < 1, "coarse_tolerance",
                t.coarse_tolerance, "a number > 0 and < 1");
  check.not_negative("recovery.factor", t.recovery_factor);
  check.require(t.recovery_iterations >= -1, "recovery.iterations", t.recovery_iterations,
                "an integer >= 0, or -1 for the formula");
  check.not_negative("recovery.tolerance", t.recovery_tolerance);
  check.positive("seam_tolerance", t.seam_tolerance);
  check.require(t.blend_frames >= 0, "blend_frames", t.blend_frames, "an integer >= 0");
}

/// What needs meshes that stay as they are, of slices and of the coarse run.
void refuse_tied_meshes(const Scene& scene) {
  const TimeParallelSettings& t = scene.time_parallel;
  const Checker check(scene.file, "method.time_parallel");
  const std::string with = slices_remesh(scene) ? " with slices of the method \"" + t.method + "\""
                                                : " with the coarse_mesh \"adaptive\"";
  if (t.track_always)
    check.refuse("track", "\"always\"" + with, "\"recovery\": averages are tied mesh to mesh");
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
}

void validate_adaptive(const Scene& scene) {
  const AdaptiveSettings& adaptive = scene.adaptive;
  const Checker check(scene.file, "remeshing");
  validate_remeshing(adaptive.remeshing, check);
  check.not_negative("flip_threshold", adaptive.flip_threshold);
  if (!(adaptive.energy_share >= 0))
    check.refuse("energy_share", text_of(adaptive.energy_share), "a number >= 0");
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
  if (scene.output.format == FrameFormat::pc2)
    all.refuse("output.format", "\"pc2\"" + with,
               "a format whose frames may differ in their meshes: obj, ply or usda");
  refuse_curved_rest(scene, with);
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
  validate_adaptive(scene);
  validate_implicit_settings(scene);
  validate_asynchronous_settings(scene);
  if (scene.method == "asynchronous") refuse_beyond_asynchronous(scene);
}

}  // namespace weft
