#include "host/io/scene/cloth_file.hpp"
#include "host/geometry/aabb.hpp"
#include "weft/core/at.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdio>
#include <string>
#include <vector>

#include "host/geometry/mesh_check.hpp"
#include "host/geometry/mesh_repair.hpp"
#include "host/geometry/unfold.hpp"
#include "host/io/scene/scene_parts.hpp"
#include "host/io/usd/surface_file.hpp"
#include "weft/error.hpp"

namespace weft::io {
namespace {

/// Median stretches between these are as garments start that are put on a body.
constexpr double least_plain_stretch = 0.8;
constexpr double most_plain_stretch = 1.25;

/// Material coordinates of a flat mesh are coordinates in its own plane, those of a curved one in
/// the plane that it unfolds into.
/// @throws SceneError if it is curved and may not be
void add_material(Mesh& mesh, const std::string& file, bool may_be_curved) {
  const Aabb box = aabb_of(mesh.positions);
  const Vec3<double> centre = box.center();
  Vec3<double> normal{};
  for (const Tri& tri : mesh.triangles) {
    const auto& a = mesh.positions[static_cast<std::size_t>(tri.v[0])];
    const auto& b = mesh.positions[static_cast<std::size_t>(tri.v[1])];
    const auto& c = mesh.positions[static_cast<std::size_t>(tri.v[2])];
    normal += cross(b - a, c - a);
  }
  const double size = box.diagonal();
  const std::string allowed =
      "texture coordinates (vt, or s and t), a mesh that is flat, or \"rest\": \"initial\"";
  if (!(length(normal) > 0)) {
    if (may_be_curved) return unfold(mesh);
    throw SceneError(file, "vt", "missing on a closed mesh", allowed);
  }
  normal *= 1.0 / length(normal);
  for (std::size_t v = 0; v < mesh.positions.size(); ++v)
    if (!(std::abs(dot(mesh.positions[v] - mesh.positions.front(), normal)) <= 1e-6 * size)) {
      if (may_be_curved) return unfold(mesh);
      throw SceneError(file, "vt",
                       "missing on a mesh that is not flat (vertex " + std::to_string(v) + ")",
                       allowed);
    }
  // u is x projected into the plane, unless the plane faces along x.
  const Vec3<double> along =
      std::abs(normal[0]) < 0.9 ? Vec3<double>{1, 0, 0} : Vec3<double>{0, 1, 0};
  Vec3<double> u = along - normal * dot(along, normal);
  u *= 1.0 / length(u);
  const Vec3<double> v = cross(normal, u);
  for (const Vec3<double>& x : mesh.positions)
    mesh.material.push_back({dot(x - centre, u), dot(x - centre, v)});
}

/// Lengths of edges over those of their material coordinates, the middle one.
double median_stretch(const Mesh& mesh) {
  std::vector<double> stretch;
  const std::vector<Tri>& corners =
      mesh.material_triangles.empty() ? mesh.triangles : mesh.material_triangles;
  for (std::size_t t = 0; t < corners.size(); ++t)
    for (int k = 0; k < 3; ++k) {
      const auto x = [&](int j) {
        return mesh.positions[static_cast<std::size_t>(mesh.triangles[t].v[j % 3])];
      };
      const auto u = [&](int j) {
        return mesh.material[static_cast<std::size_t>(corners[t].v[j % 3])];
      };
      stretch.push_back(length(x(k + 1) - x(k)) / length(u(k + 1) - u(k)));
    }
  const auto middle = stretch.begin() + static_cast<std::ptrdiff_t>(stretch.size() / 2);
  std::nth_element(stretch.begin(), middle, stretch.end());
  return *middle;
}

/// "metres": texture coordinates are lengths; "fit": they are scaled until the median is 1.
void read_uv(Fields& fields, Mesh& mesh, Scene& scene) {
  const bool fit = fields.choice("uv", {"metres", "fit"}, 0) == 1;
  const double stretch = median_stretch(mesh);
  if (fit) {
    if (!std::isfinite(stretch) || !(stretch > 0))
      fields.refuse("uv", "\"metres\" for a mesh without a finite stretch");
    for (Vec2<double>& u : mesh.material) u *= stretch;
    return;
  }
  if (stretch >= least_plain_stretch && stretch <= most_plain_stretch) return;
  scene.warnings.push_back(fields.path_of("mesh") +
                           ": half of its edges start stretched by a factor of " +
                           rounded_text(stretch) + (stretch > 1 ? " or more" : " or less") +
                           ", as its texture coordinates are taken for metres; \"uv\": \"fit\" "
                           "scales these to the mesh");
}

}  // namespace

std::string rounded_text(double value) {
  char buffer[32];
  std::snprintf(buffer, sizeof buffer, "%.3g", value);
  return buffer;
}

bool may_be_in_other_units(double size) {
  return size >= 30 && size <= 3000;
}

Mesh read_cloth_file(Fields& fields, const std::filesystem::path& path,
                     const ReadableFolders& folders, const FileAxes& axes, Scene& scene) {
  Mesh mesh = read_surface(path, Uv::material, folders, &scene.warnings);
  to_scene_axes(axes, mesh);
  if (fields.boolean("repair", false)) repair_from_file(mesh, path, repaired_height, scene);
  if (mesh.material.empty()) {
    check_mesh(mesh, {path.string(), "mesh", ""}, false);
    add_material(mesh, path.string(), fields.text("rest", "flat") == "initial");
  }
  // Here, where the message can name the mesh file rather than the scene.
  check_mesh(mesh, {path.string(), "mesh", ""}, true);
  read_uv(fields, mesh, scene);
  return mesh;
}

void repair_from_file(Mesh& mesh, const std::filesystem::path& path, double least_height,
                      Scene& scene) {
  const std::string done = repair_mesh(mesh, least_height);
  if (mesh.triangles.empty())
    throw SceneError(path.string(), "repair", "nothing is left (" + done + ")",
                     "a mesh with triangles that a cloth can have");
  if (!done.empty()) scene.warnings.push_back(path.string() + ": repaired: " + done);
}

void warn_of_axes(const Mesh& mesh, const Transform& transform, const std::string& field,
                  Scene& scene) {
  const Vec3<double>& g = scene.gravity;
  const Vec3<double> size = aabb_of(mesh.positions).size();
  const auto lies = [&](int longest, int fall) {
    const double other = size[3 - longest - fall];
    return std::abs(g[fall]) > std::max(std::abs(g[longest]), std::abs(g[3 - longest - fall])) &&
           size[longest] >= 1.5 * other && size[longest] >= 2.5 * size[fall] &&
           std::min(other, size[fall]) >= 0.08 * size[longest];
  };
  constexpr int y = 1, z = 2;
  if ((!lies(y, z) && !lies(z, y)) || transform.rotation_angle != 0) return;
  const auto text = [&](int longest, int fall) {
    const std::string names = "xyz";
    return field + ": it is " + rounded_text(size[longest]) + " m long along " +
           names[at(longest)] + " and " + rounded_text(size[fall]) + " m along " + names[at(fall)] +
           ", while gravity acts along " + names[at(fall)];
  };
  scene.warnings.push_back(
      lies(y, z) ? text(y, z) + "; if y is up in its file, \"up\": \"y\" puts it upright"
                 : text(z, y) + "; if z is up, leave gravity out");
}

void warn_of_units(const Mesh& mesh, const Transform& transform, const std::string& field,
                   Scene& scene) {
  const Vec3<double> extents = aabb_of(mesh.positions).size();
  const double size = std::max({extents[0], extents[1], extents[2]});
  if (transform.scale != 1 || !may_be_in_other_units(size)) return;
  const bool centimetres = size < 300;
  scene.warnings.push_back(field + ": it is " + rounded_text(size) +
                           " m large; if its file is in " +
                           (centimetres ? "centimetres" : "millimetres") + ", \"units\": \"" +
                           (centimetres ? "cm" : "mm") + "\" makes metres of them");
}

}  // namespace weft::io
