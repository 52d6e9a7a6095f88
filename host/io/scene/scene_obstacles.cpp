#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <numbers>
#include <set>

#include "host/geometry/mesh_check.hpp"
#include "host/geometry/mesh_repair.hpp"
#include "host/geometry/outline.hpp"
#include "host/input/counted.hpp"
#include "host/io/scene/file_axes.hpp"
#include "host/io/scene/scene_parts.hpp"
#include "host/io/usd/surface_file.hpp"
#include "weft/error.hpp"
#include "weft/shapes.hpp"

namespace weft::io {
namespace {

/// [m] Least edge that primitives are asked for. Those that become too many triangles are made with
/// a longer one, found by stretching, which nothing can do to 0.
constexpr double min_edge = 1e-100;

/// Most triangles of a primitive that gives no resolution of its own.
constexpr double max_default_triangles = 40000;

/// Most times that the triangles of a sphere or capsule may be split in four.
constexpr int max_subdivisions = 8;

/// Splits of a capsule's caps whose edges are nearest to `edge`, by ratio.
int default_capsule_subdivisions(double radius, double length, double edge) {
  int best = 0;
  for (int s = 0; capsule_triangles(radius, length, 1 << s) <= max_default_triangles; ++s) {
    best = s;
    // A split halves edges of a quarter of the circumference over the number of rings.
    if (std::numbers::pi / 2 * radius / (1 << s) <= edge * std::numbers::sqrt2) break;
  }
  return best;
}

Mesh read_capsule(Fields& fields, double edge) {
  Fields capsule = fields.object("capsule", {"radius", "length", "subdivisions"});
  const double radius = capsule.number("radius", quantity::length);
  const double length = capsule.number("length", quantity::length);
  const int fallback = default_capsule_subdivisions(radius, length, edge);
  const auto rings =
      static_cast<Index>(1 << capsule.integer("subdivisions", fallback, 0, max_subdivisions));
  if (!(capsule_triangles(radius, length, rings) <= max_made_triangles))
    capsule.refuse("length", "up to " + std::to_string(static_cast<long long>(max_made_triangles)) +
                                 " triangles as long as wide");
  return make_capsule(radius, length, rings);
}

/// Of a surface of revolution: so many that the coarsest mesh stays below max_default_triangles.
constexpr std::size_t max_profile_points = 6000;

Mesh read_revolution(Fields& fields, double edge) {
  Fields revolution = fields.object("revolution", {"profile", "closed", "edge"});
  Revolution shape;
  double widest = 0;
  for (const std::vector<double>& point : revolution.number_lists("profile", 2, 2)) {
    const std::string entry = "profile[" + std::to_string(shape.profile.size()) + "]";
    if (!quantity::length_or_zero.holds(point[0]))
      revolution.refuse(entry, short_text(point[0]), quantity::length_or_zero.allowed());
    if (!quantity::coordinate.holds(point[1]))
      revolution.refuse(entry, short_text(point[1]), quantity::coordinate.allowed());
    shape.profile.push_back({point[0], point[1]});
    widest = std::max(widest, point[0]);
  }
  if (shape.profile.size() > max_profile_points)
    revolution.refuse("profile", counted(shape.profile.size(), "point"),
                      "up to " + std::to_string(max_profile_points) + " points");
  shape.closed = revolution.boolean("closed", false);
  if (!can_revolve(shape))
    revolution.refuse("profile",
                      "at least two points (three if closed), none like the next, with radius 0 "
                      "only at the ends of a profile that is not closed");
  const bool given = revolution.has("edge");
  if (given) edge = revolution.number("edge", quantity::length);
  const double most = given ? max_made_triangles : max_default_triangles;
  const auto around = [&] {
    return std::max(3.0, std::round(2 * std::numbers::pi * widest / edge));
  };
  const auto too_many = [&] {
    return !(around() <= most) ||
           revolution_triangles(shape, static_cast<Index>(around()), edge) > most;
  };
  if (given && too_many())
    revolution.refuse("edge", "a length that makes up to " +
                                  std::to_string(static_cast<long long>(most)) + " triangles");
  while (too_many()) edge *= 1.02;
  revolution.record("edge", edge);
  return make_revolution(shape, static_cast<Index>(around()), edge);
}

/// Subdivisions whose edges are nearest to `edge`, by ratio.
int default_subdivisions(double radius, double edge) {
  int best = 0;
  double best_ratio = std::numeric_limits<double>::infinity();
  for (int s = 0; 20 * std::pow(4.0, s) <= max_default_triangles; ++s) {
    const double ratio = std::abs(std::log(icosphere_edge(s) * radius / edge));
    if (ratio < best_ratio) {
      best = s;
      best_ratio = ratio;
    }
  }
  return best;
}

/// Triangles on the surface of a box, or on both sides of a rectangle.
template <int N>
double surface_triangles(const std::array<Index, N>& cells) {
  const double a = cells[0];
  const double b = cells[1];
  if constexpr (N == 2)
    return 2 * a * b;
  else
    return 4 * (a * b + b * cells[2] + cells[2] * a);
}

/// Cells of a box or plane: as given, or else nearly square with sides near `edge`.
/// @param size [m] along each axis, in the world
template <int N>
std::array<Index, N> read_cells(Fields& fields, const Vec<double, N>& size, double edge) {
  std::array<Index, N> cells{};
  if (fields.has("cells")) {
    const auto given = fields.integers("cells", 1, 10000, N);
    for (std::size_t k = 0; k < N; ++k) cells[k] = static_cast<Index>(given[k]);
    if (surface_triangles<N>(cells) > max_made_triangles)
      fields.refuse("cells", "up to " + std::to_string(static_cast<long long>(max_made_triangles)) +
                                 " triangles");
    return cells;
  }
  do {
    for (std::size_t k = 0; k < N; ++k)
      cells[k] = static_cast<Index>(
          std::clamp(std::round(size[static_cast<int>(k)] / edge), 1.0, max_default_triangles));
    edge *= 1.02;
  } while (surface_triangles<N>(cells) > max_default_triangles);
  fields.record("cells", cells);
  return cells;
}

template <int N>
Vec<double, N> read_size(Fields& fields) {
  return fields.vector<N>("size", quantity::length);
}

std::vector<std::string> shape_keys() {
  return {"sphere", "box",      "plane",   "capsule", "revolution",
          "mesh",   "sequence", "skinned", "capture"};
}

/// @param edge [m] wanted, before the obstacle's own scale
void read_shape(Fields& fields, const ReadableFolders& folders, const FileAxes& usual, double edge,
                Scene& scene, Obstacle& obstacle) {
  const std::string shape = fields.one_of(shape_keys());
  const bool of_file = shape == "mesh" || shape == "skinned" || shape == "capture";
  if (fields.has("units") && !of_file) fields.refuse("units", "nothing beside " + shape);
  if (fields.has("up") && !of_file && shape != "sequence")
    fields.refuse("up", "nothing beside " + shape);
  if (shape == "sphere") {
    Fields sphere = fields.object("sphere", {"radius", "subdivisions"});
    const double radius = sphere.number("radius", quantity::length);
    const int fallback = default_subdivisions(radius, edge);
    obstacle.mesh = make_icosphere(
        radius, static_cast<int>(sphere.integer("subdivisions", fallback, 0, max_subdivisions)));
  } else if (shape == "box") {
    Fields box = fields.object("box", {"size", "cells"});
    const Vec3<double> size = read_size<3>(box);
    obstacle.mesh = make_box(size, read_cells<3>(box, size, edge));
  } else if (shape == "plane") {
    Fields plane = fields.object("plane", {"size", "cells"});
    const Vec2<double> size = read_size<2>(plane);
    obstacle.mesh = make_grid(size, read_cells<2>(plane, size, edge), Diagonals::alternating);
    obstacle.mesh.material.clear();
  } else if (shape == "capsule") {
    obstacle.mesh = read_capsule(fields, edge);
  } else if (shape == "revolution") {
    obstacle.mesh = read_revolution(fields, edge);
  } else if (shape == "mesh") {
    const std::filesystem::path path = read_path(fields, "mesh", folders);
    const FileAxes axes = read_axes_of(path, fields, usual);
    obstacle.mesh = read_surface(path, Uv::ignore, folders, &scene.warnings);
    to_scene_axes(axes, obstacle.mesh);
    if (fields.boolean("repair", false)) repair_from_file(obstacle.mesh, path, 0, scene);
    check_mesh(obstacle.mesh, {path.string(), "mesh", ""}, false);
    warn_of_axes(obstacle.mesh, obstacle.transform, fields.path_of("mesh"), scene);
  } else {
    read_body(fields, shape, folders, edge, scene, obstacle);
  }
}

void read_driven(Fields& fields, Obstacle& obstacle) {
  if (!fields.has("driven")) return;
  Fields driven = fields.object("driven", {"axis", "inertia", "torque", "start_time", "end_time"});
  DrivenBody body;
  body.origin = obstacle.transform.translate;
  body.axis = driven.direction("axis", body.axis);
  body.inertia = driven.number("inertia", quantity::inertia);
  body.torque = driven.number("torque", body.torque);
  body.start_time = driven.number("start_time", body.start_time);
  if (driven.has("end_time")) body.end_time = driven.number("end_time", body.end_time);
  obstacle.driven = body;
}

}  // namespace

void read_obstacles(Fields& root, const ReadableFolders& folders, double edge, Scene& scene) {
  std::set<std::string> names;
  double made = 0;  // triangles so far
  const FileAxes usual = read_file_axes(root, {});
  std::vector<std::string> keys = shape_keys();
  keys.insert(keys.end(),
              {"name", "repair", "units", "up", "transform", "motion", "driven", "friction"});
  for (Fields& fields : root.objects("obstacles", keys)) {
    Obstacle obstacle;
    obstacle.name = fields.name("name", "obstacle_" + std::to_string(scene.obstacles.size()));
    if (!names.insert(obstacle.name).second)
      fields.refuse("name", "a name of its own for each obstacle");
    Fields transform = fields.object("transform", transform_keys());
    obstacle.transform = read_transform(transform);
    obstacle.motion = read_motion(fields, "motion");
    read_driven(fields, obstacle);
    const Transform& start =
        obstacle.motion.empty() ? obstacle.transform : obstacle.motion.front().transform;
    read_shape(fields, folders, usual, std::max(edge / start.scale, min_edge), scene, obstacle);
    obstacle.friction = fields.number("friction", obstacle.friction);
    made += static_cast<double>(obstacle.mesh.triangles.size());
    if (made > max_made_triangles)
      root.refuse("obstacles", short_text(made) + " triangles",
                  "up to " + std::to_string(static_cast<long long>(max_made_triangles)));
    scene.obstacles.push_back(std::move(obstacle));
  }
}

}  // namespace weft::io
