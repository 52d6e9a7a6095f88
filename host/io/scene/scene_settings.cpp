#include <algorithm>
#include <limits>

#include "host/io/scene/scene_parts.hpp"
#include "host/scene/defaults.hpp"
#include "host/scene/suitable_precision.hpp"
#include "host/scene/validate.hpp"
#include "weft/error.hpp"

namespace weft::io {
namespace {

int read_int(Fields& fields, const char* key, int fallback, std::int64_t low, std::int64_t high) {
  return static_cast<int>(fields.integer(key, fallback, low, high));
}

void read_time(Fields& root, TimeSettings& time) {
  Fields fields = root.object("time", {"step", "tolerance", "frame_rate", "frames", "until"});
  time.automatic = fields.is_text("step");
  if (!time.automatic)
    time.step = fields.number("step", quantity::step, time.step);
  else if (fields.text("step", "auto") != "auto")
    fields.refuse("step", "\"auto\", or " + quantity::step.allowed());
  time.tolerance = fields.number("tolerance", time.tolerance);
  time.frame_rate = fields.number("frame_rate", quantity::rate, time.frame_rate);
  time.frames = read_int(fields, "frames", time.frames, 1, count::frames);
  time.until =
      fields.choice("until", {"frames", "rest"}, 0) == 0 ? RunUntil::frames : RunUntil::rest;
}

void read_solver(Fields& root, SolverSettings& solver) {
  Fields fields = root.object(
      "solver", {"tolerance", "max_iterations", "preconditioner", "newton_iterations",
                 "newton_tolerance", "line_search", "partial_rows", "transport", "rebalance"});
  solver.tolerance = fields.number("tolerance", solver.tolerance);
  solver.max_iterations =
      read_int(fields, "max_iterations", solver.max_iterations, 1, count::iterations);
  constexpr Preconditioner preconditioners[] = {Preconditioner::block_jacobi,
                                                Preconditioner::multilevel};
  solver.preconditioner =
      preconditioners[fields.choice("preconditioner", {"block_jacobi", "multilevel"}, 1)];
  if (!fields.has("newton_iterations") || fields.is_text("newton_iterations")) {
    if (fields.text("newton_iterations", "auto") != "auto")
      fields.refuse("newton_iterations", "\"auto\", or a whole number from 1");
    solver.newton_iterations = 0;
  } else {
    solver.newton_iterations = read_int(fields, "newton_iterations", 1, 1, count::iterations);
  }
  solver.newton_tolerance = fields.number("newton_tolerance", solver.newton_tolerance);
  solver.line_search = fields.boolean("line_search", solver.line_search);
  solver.partial_rows =
      read_int(fields, "partial_rows", solver.partial_rows, 0, count::partial_rows);
  constexpr Transport transports[] = {Transport::automatic, Transport::peer, Transport::pipelined};
  solver.transport = transports[fields.choice("transport", {"auto", "peer", "pipelined"}, 0)];
  constexpr Rebalance rebalances[] = {Rebalance::when_it_pays, Rebalance::never,
                                      Rebalance::every_step};
  solver.rebalance = rebalances[fields.choice("rebalance", {"auto", "never", "every_step"}, 0)];
}

void read_implicit(Fields& method, ImplicitSettings& settings) {
  Fields fields = method.object("implicit", {"sleep_distance", "sleep_window"});
  settings.sleep_distance = fields.number("sleep_distance", settings.sleep_distance);
  settings.sleep_window = fields.number("sleep_window", settings.sleep_window);
}

void read_asynchronous(Fields& method, AsynchronousSettings& settings) {
  Fields fields =
      method.object("asynchronous", {"window", "narrow", "optimistic", "stiffness", "restitution",
                                     "layers", "rollbacks", "smallest_step"});
  settings.window = fields.number("window", settings.window);
  settings.narrow =
      fields.choice("narrow", {"slabs", "ccd"}, 0) == 0 ? NarrowPhase::slabs : NarrowPhase::ccd;
  settings.optimistic = fields.boolean("optimistic", settings.optimistic);
  settings.stiffness = fields.number("stiffness", settings.stiffness);
  settings.restitution = fields.number("restitution", settings.restitution);
  settings.layers = read_int(fields, "layers", settings.layers, 1, 10000);
  settings.rollbacks = read_int(fields, "rollbacks", settings.rollbacks, 0, count::iterations);
  settings.smallest_step = fields.number("smallest_step", settings.smallest_step);
}

void read_recovery(Fields& time_parallel, TimeParallelSettings& settings) {
  Fields fields = time_parallel.object("recovery", {"factor", "iterations", "tolerance"});
  settings.recovery_factor = fields.number("factor", settings.recovery_factor);
  settings.recovery_iterations =
      read_int(fields, "iterations", settings.recovery_iterations, -1, count::iterations);
  settings.recovery_tolerance = fields.number("tolerance", settings.recovery_tolerance);
}

/// @param step [s] of the fine run
void read_time_parallel(Fields& method, double step, TimeParallelSettings& settings) {
  Fields fields = method.object(
      "time_parallel", {"method", "partition", "slices", "ratio", "coarsening", "coarse_mesh",
                        "coarse_step", "coarse_thickness", "coarse_integrator",
                        "coarse_newton_iterations", "coarse_newton_tolerance", "coarse_tolerance",
                        "recovery", "boundary_tolerance", "blend_frames"});
  settings.method = fields.text("method", settings.method);
  constexpr TimeSchedule partitions[] = {TimeSchedule::uniform, TimeSchedule::balanced,
                                         TimeSchedule::adaptive};
  settings.schedule =
      partitions[fields.choice("partition", {"uniform", "balanced", "adaptive"}, 2)];
  settings.slices = read_int(fields, "slices", settings.slices, 0, count::slices);
  settings.ratio = fields.number("ratio", settings.ratio);
  settings.coarsening = fields.number("coarsening", settings.coarsening);
  settings.coarse_adaptive = fields.choice("coarse_mesh", {"uniform", "adaptive"}, 0) == 1;
  settings.coarse_step = fields.number("coarse_step", std::max(settings.coarse_step, step));
  settings.coarse_thickness = fields.number("coarse_thickness", settings.coarse_thickness);
  settings.coarse_integrator =
      fields.choice("coarse_integrator", {"implicit_euler", "bdf2"}, 0) == 0
          ? Integrator::implicit_euler
          : Integrator::bdf2;
  settings.coarse_newton_iterations =
      read_int(fields, "coarse_newton_iterations", settings.coarse_newton_iterations, 1, 1000);
  settings.coarse_newton_tolerance =
      fields.number("coarse_newton_tolerance", settings.coarse_newton_tolerance);
  settings.coarse_tolerance = fields.number("coarse_tolerance", settings.coarse_tolerance);
  read_recovery(fields, settings);
  settings.boundary_tolerance = fields.number("boundary_tolerance", settings.boundary_tolerance);
  settings.blend_frames = read_int(fields, "blend_frames", settings.blend_frames, 0, 1000);
}

}  // namespace

Motion read_motion(Fields& fields, const std::string& key) {
  Motion motion;
  std::vector<std::string> keys = transform_keys();
  keys.insert(keys.end(), {"time", "interpolation"});
  for (Fields& entry : fields.objects(key, keys)) {
    Keyframe frame;
    frame.time = entry.number("time", quantity::instant);
    frame.transform = read_transform(entry);
    frame.interpolation = entry.choice("interpolation", {"cubic", "linear"}, 0) == 0
                              ? Interpolation::cubic
                              : Interpolation::linear;
    motion.push_back(frame);
  }
  validate_motion(motion, fields.file(), fields.path_of(key));
  return motion;
}

void read_precision(Fields& root, Scene& scene) {
  const std::size_t usual = suitable_precision(scene) == Precision::double_precision ? 1 : 0;
  scene.precision = root.choice("precision", {"float", "double"}, usual) == 0
                        ? Precision::single_precision
                        : Precision::double_precision;
}

void read_settings(Fields& root, Scene& scene) {
  scene.gravity = root.vector<3>("gravity", quantity::acceleration, scene.gravity);
  read_time(root, scene.time);
  read_solver(root, scene.solver);
  scene.bending =
      root.choice("bending", {"hinge", "plate"}, 1) == 0 ? Bending::hinge : Bending::plate;
  Fields method = root.object(
      "method", {"type", "integrator", "implicit", "asynchronous", "time_parallel", "view"});
  const std::vector<std::string> methods{"implicit", "adaptive", "view", "asynchronous",
                                         "time_parallel"};
  scene.method = methods[method.choice("type", methods, 0)];
  read_implicit(method, scene.implicit);
  read_asynchronous(method, scene.asynchronous);
  read_time_parallel(method, scene.time.step, scene.time_parallel);
  read_view(method, scene.view);
  scene.integrator = method.choice("integrator", {"implicit_euler", "bdf2"}, 0) == 0
                         ? Integrator::implicit_euler
                         : Integrator::bdf2;
  Fields output = root.object("output", {"format", "frames", "checkpoint_every"});
  constexpr FrameFormat formats[] = {FrameFormat::obj, FrameFormat::ply, FrameFormat::pc2,
                                     FrameFormat::usda, FrameFormat::glb};
  scene.output.format = formats[output.choice("format", {"obj", "ply", "pc2", "usda", "glb"}, 0)];
  scene.output.frames =
      output.choice("frames", {"all", "last"}, 0) == 0 ? FramesWritten::all : FramesWritten::last;
  scene.output.checkpoint_every =
      read_int(output, "checkpoint_every", scene.output.checkpoint_every, 0, count::frames);
}

void read_contact(Fields& root, Scene& scene) {
  ContactSettings& contact = scene.contact;
  Fields fields =
      root.object("contact", {"self", "self_certificate", "untangle", "thickness", "friction",
                              "zone_rounds", "substep_bisections", "compliance_distance"});
  contact.self = fields.boolean("self", contact.self);
  contact.self_certificate = fields.boolean("self_certificate", contact.self_certificate);
  contact.untangle = fields.boolean("untangle", contact.untangle);
  contact.thickness = fields.number("thickness", thickness_of(scene));
  contact.friction = fields.number("friction", contact.friction);
  contact.zone_rounds = read_int(fields, "zone_rounds", contact.zone_rounds, 1, count::iterations);
  contact.substep_bisections =
      read_int(fields, "substep_bisections", contact.substep_bisections, 0, 20);
  if (fields.has("compliance_distance"))
    contact.compliance_distance = fields.number_or_null("compliance_distance")
                                      .value_or(std::numeric_limits<double>::infinity());
}

}  // namespace weft::io
