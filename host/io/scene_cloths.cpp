#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <set>

#include "host/io/mesh_file.hpp"
#include "host/io/scene_parts.hpp"
#include "host/scene/mesh_check.hpp"
#include "host/scene/procedural.hpp"
#include "weft/error.hpp"

namespace weft::io {
namespace {

struct Grid {
  Vec2<double> size{};
  std::optional<std::array<Index, 2>> cells;
  Diagonals diagonals = Diagonals::alternating;
};

struct Copies {
  Index count = 1;
  Transform step;  ///< translation and rotation of each copy against the one before
};

/// One entry of "cloths" before its mesh is made, since grids share the triangle budget.
struct ClothEntry {
  std::string name;
  std::string field;
  std::optional<Grid> grid;
  Fields grid_fields;  ///< of the entry itself for a mesh file
  Mesh mesh;           ///< from a file
  Transform transform;
  Index material = 0;
  Vec3<double> velocity{};
  Copies copies;
};

Grid read_grid(Fields& fields) {
  Grid grid;
  grid.size = fields.vector<2>("size");
  for (int k = 0; k < 2; ++k)
    if (!(grid.size[k] > 0)) fields.refuse("size", "two numbers > 0");
  if (fields.has("cells")) {
    const auto cells = fields.integers("cells", 1, std::numeric_limits<Index>::max(), 2);
    grid.cells = {static_cast<Index>(cells[0]), static_cast<Index>(cells[1])};
  }
  grid.diagonals = fields.choice("diagonals", {"alternating", "same"}, 0) == 0
                       ? Diagonals::alternating
                       : Diagonals::same;
  return grid;
}

/// Material coordinates of a flat mesh are coordinates in its own plane.
/// @throws SceneError if it is not flat
void add_flat_material(Mesh& mesh, const std::string& file) {
  Vec3<double> low = mesh.positions.front();
  Vec3<double> high = low;
  for (const Vec3<double>& x : mesh.positions)
    for (int k = 0; k < 3; ++k) {
      low[k] = std::min(low[k], x[k]);
      high[k] = std::max(high[k], x[k]);
    }
  const Vec3<double> centre = (low + high) * 0.5;
  Vec3<double> normal{};
  for (const Tri& tri : mesh.triangles) {
    const auto& a = mesh.positions[static_cast<std::size_t>(tri.v[0])];
    const auto& b = mesh.positions[static_cast<std::size_t>(tri.v[1])];
    const auto& c = mesh.positions[static_cast<std::size_t>(tri.v[2])];
    normal += cross(b - a, c - a);
  }
  const double size = length(high - low);
  const std::string allowed = "texture coordinates (vt, or s and t), or a mesh that is flat";
  if (!(length(normal) > 0)) throw SceneError(file, "vt", "missing on a closed mesh", allowed);
  normal *= 1.0 / length(normal);
  for (std::size_t v = 0; v < mesh.positions.size(); ++v)
    if (!(std::abs(dot(mesh.positions[v] - mesh.positions.front(), normal)) <= 1e-6 * size))
      throw SceneError(file, "vt",
                       "missing on a mesh that is not flat (vertex " + std::to_string(v) + ")",
                       allowed);
  // u is x projected into the plane, unless the plane faces along x.
  const Vec3<double> along =
      std::abs(normal[0]) < 0.9 ? Vec3<double>{1, 0, 0} : Vec3<double>{0, 1, 0};
  Vec3<double> u = along - normal * dot(along, normal);
  u *= 1.0 / length(u);
  const Vec3<double> v = cross(normal, u);
  for (const Vec3<double>& x : mesh.positions)
    mesh.material.push_back({dot(x - centre, u), dot(x - centre, v)});
}

ClothEntry read_entry(Fields& fields, std::size_t number, const std::vector<std::string>& names) {
  const std::string name = fields.name("name", "cloth_" + std::to_string(number));
  ClothEntry entry{name, fields.path_of(""), {}, fields, {}, {}, 0, {}, {}};
  if (fields.one_of({"grid", "mesh"}) == "grid") {
    entry.grid_fields = fields.object("grid", {"size", "cells", "diagonals"});
    entry.grid = read_grid(entry.grid_fields);
  } else {
    const std::filesystem::path path = read_path(fields, "mesh");
    entry.mesh = read_mesh(path);
    if (entry.mesh.material.empty()) {
      check_mesh(entry.mesh, {path.string(), "mesh", ""}, false);
      add_flat_material(entry.mesh, path.string());
    }
    // Here, where the message can name the mesh file rather than the scene.
    check_mesh(entry.mesh, {path.string(), "mesh", ""}, true);
  }
  Fields transform = fields.object("transform", transform_keys());
  entry.transform = read_transform(transform);
  entry.material = static_cast<Index>(fields.choice("material", names, {}));
  entry.velocity = fields.vector<3>("velocity", Vec3<double>{0, 0, 0});
  Fields copies = fields.object("copies", {"count", "translate", "rotate"});
  entry.copies.count = static_cast<Index>(copies.integer("count", 1, 1, 10000));
  entry.copies.step.translate = copies.vector<3>("translate", Vec3<double>{0, 0, 0});
  read_rotation(copies, entry.copies.step);
  return entry;
}

double triangle_count(const ClothEntry& entry) {
  const double one = entry.grid ? 2.0 * (*entry.grid->cells)[0] * (*entry.grid->cells)[1]
                                : static_cast<double>(entry.mesh.triangles.size());
  return one * entry.copies.count;
}

/// Gives the grids without cells square cells of one size in the world.
void share_triangles(std::vector<ClothEntry>& entries, double triangles) {
  double area = 0;
  for (const ClothEntry& entry : entries)
    if (entry.grid && !entry.grid->cells)
      area += entry.grid->size[0] * entry.grid->size[1] * entry.transform.scale *
              entry.transform.scale * entry.copies.count;
  const double cell = std::sqrt(2 * area / triangles);
  for (ClothEntry& entry : entries) {
    if (!entry.grid || entry.grid->cells) continue;
    std::array<Index, 2> cells{};
    for (std::size_t k = 0; k < 2; ++k) {
      const double count =
          std::round(entry.grid->size[static_cast<int>(k)] * entry.transform.scale / cell);
      // One row of a strip cannot use up more than the whole budget.
      cells[k] = static_cast<Index>(std::clamp(count, 1.0, triangles));
    }
    entry.grid->cells = cells;
    entry.grid_fields.record("cells", cells);
  }
}

/// Placement of copy k, which turns about the centre of the first.
void place_copy(const Mesh& source, const Vec3<double>& centre, const Copies& copies, Index k,
                Mesh& mesh) {
  mesh = source;
  if (k == 0) return;
  Transform step = copies.step;
  step.rotation_angle *= k;
  step.translate = centre + copies.step.translate * static_cast<double>(k);
  for (Vec3<double>& x : mesh.positions) x = apply(step, x - centre);
}

Vec3<double> box_centre(const Mesh& mesh) {
  Vec3<double> low = mesh.positions.front();
  Vec3<double> high = low;
  for (const Vec3<double>& x : mesh.positions)
    for (int k = 0; k < 3; ++k) {
      low[k] = std::min(low[k], x[k]);
      high[k] = std::max(high[k], x[k]);
    }
  return (low + high) * 0.5;
}

void add_cloths(ClothEntry& entry, Scene& scene) {
  Mesh mesh = entry.grid ? make_grid(entry.grid->size, *entry.grid->cells, entry.grid->diagonals)
                         : std::move(entry.mesh);
  const Vec3<double> centre = apply(entry.transform, box_centre(mesh));
  for (Vec3<double>& x : mesh.positions) x = apply(entry.transform, x);
  for (Vec2<double>& u : mesh.material) u *= entry.transform.scale;
  for (Index k = 0; k < entry.copies.count; ++k) {
    Cloth cloth;
    cloth.name = entry.copies.count == 1 ? entry.name : entry.name + "_" + std::to_string(k);
    cloth.material = entry.material;
    cloth.velocity = entry.velocity;
    place_copy(mesh, centre, entry.copies, k, cloth.mesh);
    scene.cloths.push_back(std::move(cloth));
  }
}

void check_names(const std::vector<ClothEntry>& entries, const Scene& scene) {
  std::set<std::string> taken;
  for (const Cloth& cloth : scene.cloths)
    if (!taken.insert(cloth.name).second)
      throw SceneError(scene.file, "cloths", "name \"" + cloth.name + "\" given twice",
                       "a name of its own for each cloth and each copy");
  for (const ClothEntry& entry : entries)
    if (entry.copies.count > 1 && !taken.insert(entry.name).second)
      throw SceneError(scene.file, "cloths", "name \"" + entry.name + "\" given twice",
                       "a name of its own for each cloth and each copy");
}

}  // namespace

double mean_cell_edge(const std::vector<Cloth>& cloths) {
  double twice_area = 0;
  std::size_t count = 0;
  for (const Cloth& cloth : cloths) {
    count += cloth.mesh.triangles.size();
    for (const Tri& tri : cloth.mesh.triangles) {
      const Vec3<double>& a = cloth.mesh.positions[static_cast<std::size_t>(tri.v[0])];
      const Vec3<double>& b = cloth.mesh.positions[static_cast<std::size_t>(tri.v[1])];
      const Vec3<double>& c = cloth.mesh.positions[static_cast<std::size_t>(tri.v[2])];
      twice_area += length(cross(b - a, c - a));
    }
  }
  return std::sqrt(twice_area / static_cast<double>(count));
}

std::vector<ClothGroup> read_cloths(Fields& root, double triangles, bool triangles_overridden,
                                    Scene& scene) {
  std::vector<std::string> materials;
  for (const Material& material : scene.materials) materials.push_back(material.name);
  std::vector<ClothEntry> entries;
  bool any_shared = false;
  for (Fields& fields : root.objects(
           "cloths", {"name", "grid", "mesh", "transform", "material", "velocity", "copies"})) {
    entries.push_back(read_entry(fields, entries.size(), materials));
    any_shared = any_shared || (entries.back().grid && !entries.back().grid->cells);
  }
  if (entries.empty()) root.refuse("cloths", "at least one cloth");
  if (triangles_overridden && !any_shared)
    root.refuse("triangles", "--set triangles only where a grid has no cells of its own");
  if (any_shared) share_triangles(entries, triangles);

  double total = 0;
  for (const ClothEntry& entry : entries) total += triangle_count(entry);
  if (!(total <= max_made_triangles))
    root.refuse("cloths", short_text(total) + " triangles",
                "up to " + std::to_string(static_cast<long long>(max_made_triangles)));
  std::vector<ClothGroup> groups;
  for (ClothEntry& entry : entries) {
    ClothGroup group{entry.name, static_cast<Index>(scene.cloths.size()), entry.copies.count, {}};
    if (entry.grid) group.cells = entry.grid->cells;
    groups.push_back(group);
    add_cloths(entry, scene);
  }
  check_names(entries, scene);
  return groups;
}

}  // namespace weft::io
