#include "host/scene/validate.hpp"
#include "host/input/counted.hpp"
#include "host/scene/live_shape.hpp"
#include "host/scene/part_check.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "host/geometry/mesh_check.hpp"
#include "host/input/checker.hpp"
#include "host/input/quantity.hpp"
#include "host/scene/camera.hpp"
#include "host/scene/defaults.hpp"
#include "host/scene/method_check.hpp"
#include "host/scene/product_check.hpp"
#include "host/scene/seam_check.hpp"
#include "weft/core/at.hpp"
#include "weft/error.hpp"

namespace weft {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

/// Pairs of primitives within the contact thickness of each other that one cloth at rest may have:
/// lists of them take some 6 GB.
constexpr double most_neighbour_pairs = 5e8;

void validate_transform(const Transform& transform, const Checker& check) {
  check.within("translate", transform.translate, quantity::coordinate);
  check.require(std::abs(length(transform.rotation_axis) - 1) <= 1e-9, "rotate",
                length(transform.rotation_axis), "an axis of length 1");
  check.within("rotate", transform.rotation_angle, quantity::radians);
  check.within("scale", transform.scale, quantity::scale);
}

/// Checks where a motion takes what starts at `points`.
void validate_reach(const std::vector<Vec3<double>>& points, const Motion& motion,
                    const std::string& file, const std::string& field) {
  double size = 0;
  for (const Vec3<double>& x : points) size = std::max(size, length(x));
  for (std::size_t k = 0; k < motion.size(); ++k) {
    const Transform& key = motion[k].transform;
    const double reach = size * key.scale + length(key.translate);
    if (!(reach <= 2 * quantity::most_length))
      Checker(file, field + "[" + std::to_string(k) + "]")
          .refuse("scale", text_of(key.scale) + " (as far as " + text_of(reach) + " m)",
                  "a place within " + short_number(2 * quantity::most_length) + " m");
  }
}

std::vector<Vec3<double>> positions_of(const Mesh& mesh, const std::vector<Index>& vertices) {
  std::vector<Vec3<double>> positions;
  positions.reserve(vertices.size());
  for (const Index v : vertices) positions.push_back(mesh.positions[static_cast<std::size_t>(v)]);
  return positions;
}

void validate_rest(const Scene& scene, std::size_t i, const Checker& check) {
  const Cloth& cloth = scene.cloths[i];
  if (cloth.rest_positions.size() != cloth.mesh.positions.size())
    check.refuse(
        "rest", std::to_string(cloth.rest_positions.size()) + " positions",
        "one for each of the " + counted(cloth.mesh.positions.size(), "vertex") + ", or none");
  Mesh shape = cloth.mesh;
  shape.positions = cloth.rest_positions;
  const MeshOrigin origin{scene.file, numbered("cloths", i) + ".rest", cloth.name};
  check_mesh(shape, origin, false);
  check_size(shape, origin);
}

/// Refuses a thickness within which cloth has so many neighbours on itself that their pairs do not
/// fit into memory. In a flat sheet of F triangles, 1.5 F edges and F / 2 vertices, the share of
/// the area that lies within the thickness holds F^2 / 2 pairs of vertices and faces and 9 F^2 / 8
/// pairs of edges.
void validate_thickness(const Scene& scene, std::size_t i) {
  if (!scene.contact.self) return;
  const Cloth& cloth = scene.cloths[i];
  const Mesh& mesh = cloth.mesh;
  double area = 0;
  for (const Tri& t : mesh.material_triangles.empty() ? mesh.triangles : mesh.material_triangles) {
    const auto at = [&](int j) { return mesh.material[static_cast<std::size_t>(t.v[j])]; };
    const Vec2<double> a = at(1) - at(0), b = at(2) - at(0);
    area += (a[0] * b[1] - a[1] * b[0]) / 2;
  }
  const auto faces = static_cast<double>(mesh.triangles.size());
  const double pairs = 13.0 / 8 * faces * faces;
  if (pairs <= most_neighbour_pairs) return;
  const double most = std::sqrt(most_neighbour_pairs / pairs * area / std::numbers::pi);
  const double thickness = thickness_of(scene);
  if (thickness > most)
    throw SceneError(scene.file, "contact.thickness", text_of(thickness),
                     "at most " + short_number(most) + " m with the mesh of " +
                         numbered("cloths", i) + " (" + cloth.name +
                         "), of which some 500 million pairs of primitives would be neighbours");
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
    check.refuse(
        "triangle_material", counted(cloth.triangle_material.size(), "number"),
        "one for each of the " + counted(cloth.mesh.triangles.size(), "triangle") + ", or none");
  for (std::size_t t = 0; t < cloth.triangle_material.size(); ++t) {
    const Index material = cloth.triangle_material[t];
    if (material < 0 || static_cast<std::size_t>(material) >= scene.materials.size())
      check.refuse(numbered("triangle_material", t), std::to_string(material),
                   "the number of one of the " + std::to_string(scene.materials.size()) +
                       " materials, counted from 0");
  }
  check.within("pressure", cloth.pressure, quantity::pressure);
  check.within("velocity", cloth.velocity, quantity::velocity);
  check.within("angular_velocity", cloth.angular_velocity, quantity::angular_velocity);
  check.within("velocity_origin", cloth.velocity_origin, quantity::coordinate);
  const MeshOrigin origin{scene.file, numbered("cloths", i) + ".mesh", cloth.name};
  check_mesh(cloth.mesh, origin, true);
  check_size(cloth.mesh, origin);
  check_slivers(cloth.mesh, origin, least_height(scene.precision));
  validate_thickness(scene, i);
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
  check.within("origin", body.origin, quantity::coordinate);
  const double size = length(body.axis);
  check.require(std::abs(size - 1) < 1e-6, "axis", size, "a unit vector");
  check.within("inertia", body.inertia, quantity::inertia);
  check.within("torque", body.torque, quantity::torque);
  check.within("start_time", body.start_time, quantity::instant);
  if (!(body.end_time >= body.start_time))
    check.refuse("end_time", text_of(body.end_time), "a number >= start_time");
  if (body.end_time < infinity) check.within("end_time", body.end_time, quantity::instant);
}

void validate_obstacle(const Scene& scene, std::size_t i) {
  const Obstacle& obstacle = scene.obstacles[i];
  const std::string field = numbered("obstacles", i);
  const Checker check(scene.file, field);
  check.within("friction", obstacle.friction, quantity::friction);
  validate_transform(obstacle.transform, Checker(scene.file, field + ".transform"));
  validate_motion(obstacle.motion, scene.file, field + ".motion");
  if (obstacle.driven) validate_driven(scene, obstacle, field + ".driven");
  const bool own_motion = !obstacle.motion.empty() || obstacle.driven ||
                          (obstacle.deformation && std::dynamic_pointer_cast<const LiveShape>(
                                                       obstacle.deformation) == nullptr);
  if (obstacle.live && own_motion)
    throw SceneError(scene.file, field + " (" + obstacle.name + ")",
                     "live beside a motion of its own", "one of the two");
  const MeshOrigin origin{scene.file, field + ".mesh", obstacle.name};
  Mesh placed = obstacle.mesh;
  if (obstacle.deformation) obstacle.deformation->positions(0, placed.positions);
  check_mesh(placed, origin, false);
  validate_reach(placed.positions, obstacle.motion, scene.file, field + ".motion");
  const Transform& transform =
      obstacle.motion.empty() ? obstacle.transform : obstacle.motion.front().transform;
  for (Vec3<double>& x : placed.positions) x = apply(transform, x);
  check_size(placed, origin);
}

void validate_carrier(const Scene& scene, const Handle& handle, const Checker& check) {
  const Handle::Carrier& carrier = handle.carrier;
  if (carrier.obstacle == -1) return;
  const std::size_t obstacles = scene.obstacles.size();
  if (carrier.obstacle < 0 || static_cast<std::size_t>(carrier.obstacle) >= obstacles)
    check.refuse("carrier.obstacle", std::to_string(carrier.obstacle),
                 "the number of one of the " + std::to_string(obstacles) +
                     " obstacles, counted from 0, or -1 for none");
  if (handle.shape == Handle::Shape::glue)
    check.refuse("carrier", "beside glue", "an obstacle only for springs to places");
  const std::size_t count =
      scene.obstacles[static_cast<std::size_t>(carrier.obstacle)].mesh.positions.size();
  for (const Index v : carrier.vertices)
    if (v < 0 || static_cast<std::size_t>(v) >= count)
      check.refuse("carrier.vertices", std::to_string(v),
                   "0 to " + std::to_string(count - 1) + ", the vertices of the obstacle");
  if (carrier.vertices.size() < 3 || carrier.start.size() != carrier.vertices.size())
    check.refuse("carrier",
                 counted(carrier.vertices.size(), "vertex") + " and " +
                     counted(carrier.start.size(), "place"),
                 "three vertices or more, with a place each");
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
    check.refuse("glue", counted(handle.vertices.size(), "vertex"), "two different vertices");
  for (std::size_t k = 0; k < handle.vertices.size(); ++k) {
    const Index v = handle.vertices[k];
    if (v < 0 || static_cast<std::size_t>(v) >= cloth.mesh.positions.size())
      check.refuse(numbered("vertices", k), std::to_string(v),
                   "0 to " + std::to_string(cloth.mesh.positions.size() - 1) +
                       ", the vertices of cloth \"" + cloth.name + "\"");
  }
  validate_motion(handle.motion, scene.file, field + ".motion");
  validate_reach(positions_of(cloth.mesh, handle.vertices), handle.motion, scene.file,
                 field + ".motion");
  check.within("stiffness", handle.stiffness, quantity::spring);
  check.within("start_time", handle.start_time, quantity::instant_from_zero);
  if (!(handle.end_time > handle.start_time))
    check.refuse("end_time", text_of(handle.end_time), "a time > start_time, or null for never");
  if (handle.end_time < infinity)
    check.within("end_time", handle.end_time, quantity::instant_from_zero);
  check.within("fade_time", handle.fade_time, quantity::duration_or_zero);
  if (!(handle.along == Vec3<double>{0, 0, 0})) {
    if (!quantity::scale.holds(length(handle.along)))
      check.refuse("along", text_of(length(handle.along)) + " long", quantity::scale.allowed());
    if (handle.shape == Handle::Shape::glue)
      check.refuse("along", "beside glue", "a direction only for springs to places");
  }
  validate_carrier(scene, handle, check);
  if (handle.shape != Handle::Shape::circle) return;
  check.within("circle.circumference", handle.circumference, quantity::length);
  check.within("circle.center", handle.center, quantity::coordinate);
  const std::pair<const char*, double> lengths[] = {{"circle.axis0", length(handle.axis0)},
                                                    {"circle.axis1", length(handle.axis1)},
                                                    {"circle.direction", length(handle.direction)}};
  for (const auto& [name, size] : lengths)
    if (!quantity::scale.holds(size))
      check.refuse(name, text_of(size) + " long", quantity::scale.allowed());
}

void validate_garment_start(const Scene& scene, std::size_t i) {
  const GarmentStart& start = scene.garment_starts[i];
  const Checker check(scene.file, numbered("garment_starts", i));
  if (start.cloth < 0 || at(start.cloth) >= scene.cloths.size())
    check.refuse("cloth", std::to_string(start.cloth),
                 "the number of one of the " + std::to_string(scene.cloths.size()) +
                     " cloths, counted from 0");
  const std::size_t count = scene.cloths[at(start.cloth)].mesh.positions.size();
  if (start.apart.empty() && start.start != SewnStart::automatic) return;
  if (start.apart.size() != count)
    check.refuse("apart", std::to_string(start.apart.size()) + " places",
                 std::to_string(count) + ", one for each vertex of cloth \"" +
                     scene.cloths[at(start.cloth)].name + "\"");
  for (const Vec3<double>& x : start.apart) check.within("apart", x, quantity::coordinate);
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
                       numbered("pins", static_cast<std::size_t>(holder)) + " already holds",
                   "each vertex in one pin, once");
    holder = static_cast<Index>(i);
  }
  validate_motion(pin.motion, scene.file, field + ".motion");
  validate_reach(positions_of(scene.cloths[c].mesh, pin.vertices), pin.motion, scene.file,
                 field + ".motion");
  if (pin.obstacle < -1 || pin.obstacle >= static_cast<Index>(scene.obstacles.size()))
    check.refuse("obstacle", std::to_string(pin.obstacle),
                 "the number of one of the " + std::to_string(scene.obstacles.size()) +
                     " obstacles, counted from 0, or -1 for none");
  if (pin.obstacle >= 0 && !pin.motion.empty())
    check.refuse("obstacle", std::to_string(pin.obstacle) + " beside a motion",
                 "an obstacle or a motion, not both");
  if (!(pin.release_time > 0))
    check.refuse("release_time", text_of(pin.release_time), "a time > 0, or never");
  if (pin.release_time < infinity)
    check.within("release_time", pin.release_time, quantity::duration);
}

void validate_time(const Scene& scene) {
  const Checker check(scene.file, "time");
  check.within("step", scene.time.step, quantity::step);
  check.within("frame_rate", scene.time.frame_rate, quantity::rate);
  check.integer("frames", scene.time.frames, 1, count::frames);
  check.within("tolerance", scene.time.tolerance, quantity::loose_tolerance);
  if (!scene.time.automatic)
    check.require(1 / (scene.time.step * scene.time.frame_rate) <= max_steps_per_frame, "step",
                  scene.time.step, "at most 1e6 steps a frame");
  else if (!quantity::step.holds(1 / scene.time.frame_rate))
    check.refuse("frame_rate", text_of(scene.time.frame_rate) + " with the step \"auto\"",
                 "a frame that lasts " + quantity::step.allowed());
  const double end = scene.time.frames / scene.time.frame_rate;
  if (end > quantity::most_time)
    check.refuse("frames", std::to_string(scene.time.frames) + " (" + text_of(end) + " s)",
                 "a run of up to " + short_number(quantity::most_time) + " s");
}

void validate_contact(const Scene& scene) {
  const ContactSettings& contact = scene.contact;
  const Checker check(scene.file, "contact");
  check.within("thickness", contact_thickness(contact), quantity::length);
  check.within("friction", contact.friction, quantity::friction);
  check.within("stiffness", contact.stiffness, quantity::repulsion);
  check.integer("zone_rounds", contact.zone_rounds, 1, count::iterations);
  check.integer("substep_bisections", contact.substep_bisections, 0, 20);
  if (!contact.compliance_distance) return;
  const double distance = *contact.compliance_distance;
  if (!(distance >= 0))
    check.refuse("compliance_distance", text_of(distance), "a length >= 0, or null for any");
  if (distance < infinity) check.within("compliance_distance", distance, quantity::length_or_zero);
}

void validate_solver(const Scene& scene) {
  const SolverSettings& solver = scene.solver;
  const Checker check(scene.file, "solver");
  check.within("tolerance", solver.tolerance, quantity::tolerance);
  check.integer("max_iterations", solver.max_iterations, 1, count::iterations);
  check.integer("newton_iterations", solver.newton_iterations, 0, count::iterations);
  check.within("newton_tolerance", solver.newton_tolerance, quantity::loose_tolerance);
  const int rows = solver.partial_rows;
  check.require(rows >= 0 && rows <= count::partial_rows && (rows & (rows - 1)) == 0,
                "partial_rows", rows,
                "a power of two up to 1048576, or 0 for a choice by the row count");
}

/// Positive definite: a sheet that stores energy in every stretch.
void validate_orthotropic(const OrthotropicStretch& stretch, const Checker& check) {
  check.within("orthotropic.stretch_stiffness[0]", stretch.warp, quantity::stiffness);
  check.within("orthotropic.stretch_stiffness[1]", stretch.weft, quantity::stiffness);
  const double nu = stretch.poisson_ratio;
  check.require(nu * nu * stretch.weft < stretch.warp * (1 - 1e-5), "orthotropic.poisson_ratio", nu,
                "a number whose square is below the stretch stiffness of warp over weft");
  check.within("orthotropic.shear_stiffness", stretch.shear, quantity::stiffness);
}

void validate_measured(const MeasuredStretch& measured, const Checker& check) {
  for (std::size_t i = 0; i < measured.rows.size(); ++i)
    for (std::size_t j = 0; j < 4; ++j) {
      const bool along = i == 0 && (j == 0 || j == 2);
      const std::string field = numbered(numbered("measured.stretching", i).c_str(), j);
      check.within(field, measured.rows[i][j], along ? quantity::stiffness : quantity::coefficient);
    }
}

void validate_strain_limits(const StrainLimits& limits, const Checker& check) {
  check.within("strain_limits[0]", limits.min, quantity::least_stretch);
  if (!(limits.max == infinity))
    check.within("strain_limits[1]", limits.max, quantity::most_stretch);
}

void validate_orthotropic_bending(const OrthotropicBending& bending, const Checker& check) {
  check.within("orthotropic_bending.stiffness[0]", bending.warp, quantity::bending);
  check.within("orthotropic_bending.stiffness[1]", bending.weft, quantity::bending);
  check.within("orthotropic_bending.coupling", bending.coupling, quantity::bending_coupling);
  check.require(std::abs(bending.coupling) <= std::sqrt(bending.warp * bending.weft),
                "orthotropic_bending.coupling", bending.coupling,
                "a number of at most the root of the product of both stiffnesses");
  check.within("orthotropic_bending.twist", bending.twist, quantity::bending);
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
  const Checker check(scene.file, "");
  const std::string allowed =
      "up to " + std::to_string(most_elements) + " in all cloths and obstacles";
  if (vertices > most_elements) check.refuse("cloths", counted(vertices, "vertex"), allowed);
  if (triangles > most_elements) check.refuse("cloths", counted(triangles, "triangle"), allowed);
}

void validate_motion(const Motion& motion, const std::string& file, const std::string& field) {
  if (motion.size() == 1) throw SceneError(file, field, "one key", "no key, or at least two");
  for (std::size_t k = 0; k < motion.size(); ++k) {
    const std::string key = field + "[" + std::to_string(k) + "]";
    const Checker check(file, key);
    check.within("time", motion[k].time, quantity::instant);
    if (k > 0 && !(motion[k].time - motion[k - 1].time >= quantity::least_time))
      check.refuse("time", text_of(motion[k].time),
                   "times that increase from key to key, here > " + text_of(motion[k - 1].time));
    validate_transform(motion[k].transform, check);
  }
}

void validate_material(const Material& material, const std::string& file,
                       const std::string& field) {
  const Checker check(file, field);
  check.within("density", material.density, quantity::area_density);
  check.within("stretch_stiffness", material.stretch_stiffness, quantity::stiffness);
  check.within("poisson_ratio", material.poisson_ratio, quantity::poisson_ratio);
  check.within("bending_stiffness", material.bending_stiffness, quantity::bending);
  if (material.strain_limits) validate_strain_limits(*material.strain_limits, check);
  if (material.orthotropic) validate_orthotropic(*material.orthotropic, check);
  if (material.measured) validate_measured(*material.measured, check);
  if (material.orthotropic_bending)
    validate_orthotropic_bending(*material.orthotropic_bending, check);
  check.within("damping.mass", material.damping_mass, quantity::damping_rate);
  check.within("damping.stiffness", material.damping_stiffness, quantity::damping_time);
}

void validate_wind(const Scene& scene) {
  const Checker check(scene.file, "wind");
  check.within("density", scene.wind.density, quantity::air_density);
  check.within("velocity", scene.wind.velocity, quantity::velocity);
  check.within("drag", scene.wind.drag, quantity::drag);
}

void validate(const Scene& scene) {
  if (takes_default_fabric(scene)) {
    Scene whole = scene;
    fill_in_defaults(whole);
    return validate(whole);
  }
  const Checker check(scene.file, "");
  if (scene.origin) check.within("origin", *scene.origin, quantity::origin);
  check.within("gravity", scene.gravity, quantity::acceleration);
  validate_methods(scene);
  validate_time(scene);
  validate_camera(scene.camera, scene.file);
  validate_view(scene);
  validate_contact(scene);
  validate_solver(scene);
  check.integer("output.checkpoint_every", scene.output.checkpoint_every, 0, count::frames);
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
  for (std::size_t i = 0; i < scene.garment_starts.size(); ++i) validate_garment_start(scene, i);
  validate_seams(scene);
  validate_wind(scene);
  check_products(scene);
}

}  // namespace weft
