#include "host/scene/validate.hpp"

#include <cmath>
#include <cstddef>
#include <limits>
#include <string>
#include <vector>

#include "host/scene/camera.hpp"
#include "host/scene/checker.hpp"
#include "host/scene/mesh_check.hpp"
#include "host/scene/method_check.hpp"
#include "host/scene/seam_check.hpp"
#include "weft/error.hpp"

namespace weft {
namespace {

void validate_transform(const Transform& transform, const Checker& check) {
  check.finite("translate", transform.translate);
  check.finite("rotate", transform.rotation_axis);
  check.require(std::abs(length(transform.rotation_axis) - 1) <= 1e-9, "rotate",
                length(transform.rotation_axis), "an axis of length 1");
  check.require(true, "rotate", transform.rotation_angle, "a finite angle");
  check.positive("scale", transform.scale);
}

void validate_rest(const Scene& scene, std::size_t i, const Checker& check) {
  const Cloth& cloth = scene.cloths[i];
  if (cloth.rest_positions.size() != cloth.mesh.positions.size())
    check.refuse("rest", std::to_string(cloth.rest_positions.size()) + " positions",
                 "one for each of the " + std::to_string(cloth.mesh.positions.size()) +
                     " vertices, or none");
  Mesh shape = cloth.mesh;
  shape.positions = cloth.rest_positions;
  check_mesh(shape, {scene.file, numbered("cloths", i) + ".rest", cloth.name}, false);
  // Where two shapes meet in a seam nothing says at what angle.
  for (std::size_t s = 0; s < scene.seams.size(); ++s)
    for (const Index side : scene.seams[s].cloths)
      if (side == static_cast<Index>(i))
        check.refuse("rest", "a shape of a cloth that " + numbered("seams", s) + " sews",
                     "\"flat\" for cloths with seams");
}

void validate_cloth(const Scene& scene, std::size_t i) {
  const Cloth& cloth = scene.cloths[i];
  const Checker check(scene.file, numbered("cloths", i));
  if (cloth.material < 0 || static_cast<std::size_t>(cloth.material) >= scene.materials.size())
    check.refuse("material", std::to_string(cloth.material),
                 "the number of one of the " + std::to_string(scene.materials.size()) +
                     " materials, counted from 0");
  if (!cloth.triangle_material.empty() &&
      cloth.triangle_material.size() != cloth.mesh.triangles.size())
    check.refuse("triangle_material", std::to_string(cloth.triangle_material.size()) + " numbers",
                 "one for each of the " + std::to_string(cloth.mesh.triangles.size()) +
                     " triangles, or none");
  for (std::size_t t = 0; t < cloth.triangle_material.size(); ++t) {
    const Index material = cloth.triangle_material[t];
    if (material < 0 || static_cast<std::size_t>(material) >= scene.materials.size())
      check.refuse(numbered("triangle_material", t), std::to_string(material),
                   "the number of one of the " + std::to_string(scene.materials.size()) +
                       " materials, counted from 0");
  }
  check.require(true, "pressure", cloth.pressure, "a finite number");
  check.finite("velocity", cloth.velocity);
  check.finite("angular_velocity", cloth.angular_velocity);
  check.finite("velocity_origin", cloth.velocity_origin);
  check_mesh(cloth.mesh, {scene.file, numbered("cloths", i) + ".mesh", cloth.name}, true);
  if (!cloth.rest_positions.empty()) validate_rest(scene, i, check);
}

void validate_driven(const Scene& scene, const Obstacle& obstacle, const std::string& field) {
  if (scene.method != "asynchronous")
    throw SceneError(scene.file, field, "given", "method.type \"asynchronous\" with it");
  if (!obstacle.motion.empty() || obstacle.deformation)
    throw SceneError(scene.file, field, "beside a motion of obstacle \"" + obstacle.name + "\"",
                     "a body that is driven, or one whose motion is prescribed");
  const Checker check(scene.file, field);
  const DrivenBody& body = *obstacle.driven;
  check.finite("origin", body.origin);
  const double size = length(body.axis);
  check.require(std::abs(size - 1) < 1e-6, "axis", size, "a unit vector");
  check.positive("inertia", body.inertia);
  check.require(std::isfinite(body.torque), "torque", body.torque, "a finite number");
  check.require(std::isfinite(body.start_time), "start_time", body.start_time, "a finite number");
  if (!(body.end_time >= body.start_time))
    check.refuse("end_time", text_of(body.end_time), "a number >= start_time");
}

void validate_obstacle(const Scene& scene, std::size_t i) {
  const Obstacle& obstacle = scene.obstacles[i];
  const std::string field = numbered("obstacles", i);
  const Checker check(scene.file, field);
  check.not_negative("friction", obstacle.friction);
  validate_transform(obstacle.transform, Checker(scene.file, field + ".transform"));
  validate_motion(obstacle.motion, scene.file, field + ".motion");
  if (obstacle.driven) validate_driven(scene, obstacle, field + ".driven");
  const MeshOrigin origin{scene.file, field + ".mesh", obstacle.name};
  if (!obstacle.deformation) {
    check_mesh(obstacle.mesh, origin, false);
    return;
  }
  Mesh deformed = obstacle.mesh;
  obstacle.deformation->positions(0, deformed.positions);
  check_mesh(deformed, origin, false);
}

void validate_handle(const Scene& scene, std::size_t i) {
  const Handle& handle = scene.handles[i];
  const std::string field = numbered("handles", i);
  const Checker check(scene.file, field);
  if (handle.cloth < 0 || static_cast<std::size_t>(handle.cloth) >= scene.cloths.size())
    check.refuse("cloth", std::to_string(handle.cloth),
                 "the number of one of the " + std::to_string(scene.cloths.size()) +
                     " cloths, counted from 0");
  const Cloth& cloth = scene.cloths[static_cast<std::size_t>(handle.cloth)];
  if (handle.vertices.empty()) check.refuse("vertices", "none", "at least one vertex");
  if (handle.shape == Handle::Shape::glue &&
      (handle.vertices.size() != 2 || handle.vertices[0] == handle.vertices[1]))
    check.refuse("glue", std::to_string(handle.vertices.size()) + " vertices",
                 "two different vertices");
  for (std::size_t k = 0; k < handle.vertices.size(); ++k) {
    const Index v = handle.vertices[k];
    if (v < 0 || static_cast<std::size_t>(v) >= cloth.mesh.positions.size())
      check.refuse(numbered("vertices", k), std::to_string(v),
                   "0 to " + std::to_string(cloth.mesh.positions.size() - 1) +
                       ", the vertices of cloth \"" + cloth.name + "\"");
  }
  validate_motion(handle.motion, scene.file, field + ".motion");
  check.positive("stiffness", handle.stiffness);
  check.not_negative("start_time", handle.start_time);
  if (!(handle.end_time > handle.start_time))
    check.refuse("end_time", text_of(handle.end_time), "a time > start_time, or null for never");
  check.not_negative("fade_time", handle.fade_time);
  if (handle.shape != Handle::Shape::circle) return;
  check.positive("circle.circumference", handle.circumference);
  check.finite("circle.center", handle.center);
  check.finite("circle.axis0", handle.axis0);
  check.finite("circle.axis1", handle.axis1);
  check.require(length(handle.axis0) > 0, "circle.axis0", length(handle.axis0), "a length > 0");
  check.require(length(handle.axis1) > 0, "circle.axis1", length(handle.axis1), "a length > 0");
  check.require(length(handle.direction) > 0, "circle.direction", length(handle.direction),
                "a length > 0");
}

void validate_wind(const Scene& scene) {
  const Checker check(scene.file, "wind");
  check.not_negative("density", scene.wind.density);
  check.finite("velocity", scene.wind.velocity);
  check.not_negative("drag", scene.wind.drag);
}

/// @param owner [cloth][vertex] number of the pin that holds it, -1 where none does
void validate_pin(const Scene& scene, std::size_t i, std::vector<std::vector<Index>>& owner) {
  const Pin& pin = scene.pins[i];
  const std::string field = numbered("pins", i);
  const Checker check(scene.file, field);
  if (pin.cloth < 0 || static_cast<std::size_t>(pin.cloth) >= scene.cloths.size())
    check.refuse("cloth", std::to_string(pin.cloth),
                 "the number of one of the " + std::to_string(scene.cloths.size()) +
                     " cloths, counted from 0");
  const auto c = static_cast<std::size_t>(pin.cloth);
  if (pin.vertices.empty()) check.refuse("vertices", "none", "at least one vertex");
  if (owner[c].empty()) owner[c].assign(scene.cloths[c].mesh.positions.size(), -1);
  for (std::size_t k = 0; k < pin.vertices.size(); ++k) {
    const Index v = pin.vertices[k];
    const std::string entry = numbered("vertices", k);
    if (v < 0 || static_cast<std::size_t>(v) >= owner[c].size())
      check.refuse(entry, std::to_string(v),
                   "0 to " + std::to_string(owner[c].size() - 1) + ", the vertices of cloth \"" +
                       scene.cloths[c].name + "\"");
    Index& holder = owner[c][static_cast<std::size_t>(v)];
    if (holder >= 0)
      check.refuse(entry,
                   std::to_string(v) + ", which " +
                       numbered("pins", static_cast<std::size_t>(holder)) + " already holds,",
                   "each vertex in one pin, once");
    holder = static_cast<Index>(i);
  }
  validate_motion(pin.motion, scene.file, field + ".motion");
  if (pin.obstacle < -1 || pin.obstacle >= static_cast<Index>(scene.obstacles.size()))
    check.refuse("obstacle", std::to_string(pin.obstacle),
                 "the number of one of the " + std::to_string(scene.obstacles.size()) +
                     " obstacles, counted from 0, or -1 for none");
  if (pin.obstacle >= 0 && !pin.motion.empty())
    check.refuse("obstacle", std::to_string(pin.obstacle) + " beside a motion",
                 "an obstacle or a motion, not both");
  if (!(pin.release_time > 0))
    check.refuse("release_time", text_of(pin.release_time), "a time > 0, or never");
}

void validate_time(const Scene& scene) {
  const Checker check(scene.file, "time");
  check.positive("step", scene.time.step);
  check.positive("frame_rate", scene.time.frame_rate);
  check.require(scene.time.frames >= 1, "frames", scene.time.frames, "an integer >= 1");
  check.require(1 / (scene.time.step * scene.time.frame_rate) <= max_steps_per_frame, "step",
                scene.time.step, "at most 1e6 steps a frame");
}

void validate_contact(const Scene& scene) {
  const ContactSettings& contact = scene.contact;
  const Checker check(scene.file, "contact");
  check.positive("thickness", contact.thickness);
  check.not_negative("friction", contact.friction);
  check.positive("stiffness", contact.stiffness);
  check.require(contact.zone_rounds >= 1, "zone_rounds", contact.zone_rounds, "an integer >= 1");
  check.require(contact.halvings >= 0 && contact.halvings <= 20, "halvings", contact.halvings,
                "an integer from 0 to 20");
  if (!(contact.yielding_distance >= 0))
    check.refuse("yielding_distance", text_of(contact.yielding_distance),
                 "a length >= 0, or null for any");
}

void validate_solver(const Scene& scene) {
  const SolverSettings& solver = scene.solver;
  const Checker check(scene.file, "solver");
  check.require(solver.tolerance > 0 && solver.tolerance < 1, "tolerance", solver.tolerance,
                "a number > 0 and < 1");
  check.require(solver.max_iterations >= 1, "max_iterations", solver.max_iterations,
                "an integer >= 1");
  check.require(solver.newton_iterations >= 1, "newton_iterations", solver.newton_iterations,
                "an integer >= 1");
  check.positive("newton_tolerance", solver.newton_tolerance);
  const int rows = solver.partial_rows;
  check.require(rows >= 0 && (rows & (rows - 1)) == 0, "partial_rows", rows,
                "a power of two, or 0 for a choice by the row count");
  if (solver.transport == Transport::pipelined &&
      solver.preconditioner == Preconditioner::multilevel_linear)
    check.refuse("transport", "\"pipelined\"",
                 "auto or peer with the preconditioner multilevel_linear");
}

/// Positive definite: a sheet that stores energy in every stretch.
void validate_orthotropic(const OrthotropicStretch& stretch, const Checker& check) {
  check.positive("orthotropic.stretch_stiffness[0]", stretch.warp);
  check.positive("orthotropic.stretch_stiffness[1]", stretch.weft);
  const double nu = stretch.poisson_ratio;
  check.require(nu * nu * stretch.weft < stretch.warp, "orthotropic.poisson_ratio", nu,
                "a number whose square is below the stretch stiffness of warp over weft");
  check.positive("orthotropic.shear_stiffness", stretch.shear);
}

void validate_measured(const MeasuredStretch& measured, const Checker& check) {
  for (std::size_t i = 0; i < measured.rows.size(); ++i)
    for (std::size_t j = 0; j < 4; ++j) {
      const bool along = i == 0 && (j == 0 || j == 2);
      const std::string field = numbered(numbered("measured.stretching", i).c_str(), j);
      check.require(!along || measured.rows[i][j] > 0, field.c_str(), measured.rows[i][j],
                    along ? "a finite number > 0" : "a finite number");
    }
}

void validate_strain_limits(const StrainLimits& limits, const Checker& check) {
  if (!(limits.min >= 0 && limits.min < 1))
    check.refuse("strain_limits[0]", text_of(limits.min), "a number >= 0 (0: no limit) and < 1");
  if (!(limits.max > 1)) check.refuse("strain_limits[1]", text_of(limits.max), "a number > 1");
}

void validate_orthotropic_bending(const OrthotropicBending& bending, const Checker& check) {
  check.not_negative("orthotropic_bending.stiffness[0]", bending.warp);
  check.not_negative("orthotropic_bending.stiffness[1]", bending.weft);
  check.require(std::abs(bending.coupling) <= std::sqrt(bending.warp * bending.weft),
                "orthotropic_bending.coupling", bending.coupling,
                "a number of at most the root of the product of both stiffnesses");
  check.not_negative("orthotropic_bending.twist", bending.twist);
}

}  // namespace

void validate_total(const Scene& scene) {
  std::size_t vertices = 0;
  std::size_t triangles = 0;
  for (const Cloth& cloth : scene.cloths) {
    vertices += cloth.mesh.positions.size();
    triangles += cloth.mesh.triangles.size();
  }
  for (const Obstacle& obstacle : scene.obstacles) {
    vertices += obstacle.mesh.positions.size();
    triangles += obstacle.mesh.triangles.size();
  }
  // The largest number made of them: four corners times four of a hinge, one and a half hinges a
  // triangle.
  constexpr auto most = static_cast<std::size_t>(std::numeric_limits<Index>::max()) / 25;
  const Checker check(scene.file, "");
  const std::string allowed = "up to " + std::to_string(most) + " in all cloths and obstacles";
  if (vertices > most) check.refuse("cloths", std::to_string(vertices) + " vertices", allowed);
  if (triangles > most) check.refuse("cloths", std::to_string(triangles) + " triangles", allowed);
}

void validate_motion(const Motion& motion, const std::string& file, const std::string& field) {
  if (motion.size() == 1) throw SceneError(file, field, "one key", "no key, or at least two");
  for (std::size_t k = 0; k < motion.size(); ++k) {
    const std::string key = field + "[" + std::to_string(k) + "]";
    const Checker check(file, key);
    check.require(true, "time", motion[k].time, "a finite number");
    if (k > 0 && !(motion[k].time > motion[k - 1].time))
      check.refuse("time", text_of(motion[k].time),
                   "times that increase from key to key, here > " + text_of(motion[k - 1].time));
    validate_transform(motion[k].transform, check);
  }
}

void validate_material(const Material& material, const std::string& file,
                       const std::string& field) {
  const Checker check(file, field);
  check.positive("density", material.density);
  check.positive("stretch_stiffness", material.stretch_stiffness);
  check.require(material.poisson_ratio > -1 && material.poisson_ratio <= 0.5, "poisson_ratio",
                material.poisson_ratio, "a number > -1 and <= 0.5");
  check.not_negative("bending_stiffness", material.bending_stiffness);
  if (material.strain_limits) validate_strain_limits(*material.strain_limits, check);
  if (material.orthotropic) validate_orthotropic(*material.orthotropic, check);
  if (material.measured) validate_measured(*material.measured, check);
  if (material.orthotropic_bending)
    validate_orthotropic_bending(*material.orthotropic_bending, check);
  check.not_negative("damping.mass", material.damping_mass);
  check.not_negative("damping.stiffness", material.damping_stiffness);
}

void validate(const Scene& scene) {
  const Checker check(scene.file, "");
  check.finite("gravity", scene.gravity);
  validate_methods(scene);
  validate_time(scene);
  validate_camera(scene.camera, scene.file);
  validate_view(scene);
  validate_contact(scene);
  validate_solver(scene);
  check.require(scene.output.checkpoint_every >= 0, "output.checkpoint_every",
                scene.output.checkpoint_every, "an integer >= 0");
  for (std::size_t i = 0; i < scene.materials.size(); ++i) {
    const std::string& name = scene.materials[i].name;
    validate_material(scene.materials[i], scene.file,
                      name.empty() ? numbered("materials", i) : "materials." + name);
  }
  if (scene.cloths.empty()) check.refuse("cloths", "none", "at least one cloth");
  validate_total(scene);
  for (std::size_t i = 0; i < scene.cloths.size(); ++i) validate_cloth(scene, i);
  for (std::size_t i = 0; i < scene.obstacles.size(); ++i) validate_obstacle(scene, i);
  std::vector<std::vector<Index>> owner(scene.cloths.size());
  for (std::size_t i = 0; i < scene.pins.size(); ++i) validate_pin(scene, i, owner);
  for (std::size_t i = 0; i < scene.handles.size(); ++i) validate_handle(scene, i);
  validate_seams(scene);
  validate_wind(scene);
}

}  // namespace weft
