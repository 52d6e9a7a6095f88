#include <algorithm>
#include <cmath>
#include <cstddef>
#include <map>
#include <set>

#include "host/geometry/aabb.hpp"
#include "host/geometry/mesh_check.hpp"
#include "host/input/counted.hpp"
#include "host/io/scene/cloth_file.hpp"
#include "host/io/scene/cloth_pattern.hpp"
#include "host/io/scene/file_axes.hpp"
#include "host/io/scene/scene_parts.hpp"
#include "host/io/usd/surface_file.hpp"
#include "weft/error.hpp"

namespace weft::io {
namespace {

struct Copies {
  Index count = 1;
  Transform step;  ///< translation and rotation of each copy against the one before
};

/// One entry of "cloths" before its mesh is made, since patterns share the triangle budget.
struct ClothEntry {
  std::string name;
  std::string field;
  std::optional<ClothPattern> pattern;
  Fields pattern_fields;  ///< of the entry itself for a mesh file
  Mesh mesh;              ///< from a file
  Transform transform;
  Index material = 0;
  std::vector<Index> triangle_material;
  double pressure = 0;
  Vec3<double> velocity{};
  Vec3<double> angular_velocity{};
  Copies copies;
  bool rest_initial = false;  ///< it has no bending moments as it starts
  Mesh rest{};                ///< nor in this shape; empty: none
  std::string rest_file{};
};

/// Finds materials by name without a walk through all of them.
class MaterialNames {
 public:
  explicit MaterialNames(const std::vector<Material>& materials) {
    for (const Material& material : materials) {
      numbers_.emplace(material.name, static_cast<Index>(names_.size()));
      names_.push_back(material.name);
    }
  }

  /// @throws SceneError unless `key` names a material
  Index read(Fields& fields, const std::string& key) const {
    if (fields.is_text(key))
      if (const auto found = numbers_.find(fields.text(key)); found != numbers_.end())
        return found->second;
    return static_cast<Index>(fields.choice(key, names_, {}));
  }

 private:
  std::vector<std::string> names_;
  std::map<std::string, Index> numbers_;
};

/// A name for the whole cloth, or one for each group of its mesh.
void read_cloth_material(Fields& fields, const MaterialNames& names, ClothEntry& entry) {
  if (!fields.is_object("material")) {
    entry.material = names.read(fields, "material");
    return;
  }
  const Mesh& mesh = entry.mesh;
  if (mesh.group_names.empty())
    fields.refuse("material", "the name of one material, since the cloth has no groups of faces");
  std::vector<bool> used(mesh.group_names.size(), false);
  for (const Index group : mesh.group) used[static_cast<std::size_t>(group)] = true;
  Fields by_group = fields.object("material", mesh.group_names);
  std::vector<Index> of_group(mesh.group_names.size(), 0);
  for (std::size_t g = 0; g < of_group.size(); ++g)
    if (used[g] || by_group.has(mesh.group_names[g]))
      of_group[g] = names.read(by_group, mesh.group_names[g]);
  for (const Index group : mesh.group)
    entry.triangle_material.push_back(of_group[static_cast<std::size_t>(group)]);
  entry.material = entry.triangle_material.front();
}

/// "flat", "initial", or a mesh file.
void read_rest(Fields& fields, const ReadableFolders& folders, const FileAxes& axes,
               ClothEntry& entry) {
  const std::string rest = fields.text("rest", "flat");
  entry.rest_initial = rest == "initial";
  if (rest == "flat" || rest == "initial") return;
  entry.rest_file = read_path(fields, "rest", folders).string();
  entry.rest = read_surface(entry.rest_file, Uv::material, folders);
  if (!is_usd_file(entry.rest_file)) to_scene_axes(axes, entry.rest);
  check_mesh(entry.rest, {entry.rest_file, "mesh", ""}, false);
}

/// @throws SceneError unless the rest shape has the triangles of the cloth
void check_rest(const ClothEntry& entry, const Mesh& mesh) {
  const auto refuse = [&](const std::string& field, const std::string& value,
                          const std::string& wanted) {
    throw SceneError(entry.rest_file, field, value,
                     wanted + " of cloth \"" + entry.name + "\", whose rest shape it is");
  };
  if (entry.rest.positions.size() != mesh.positions.size())
    refuse("vertices", counted(entry.rest.positions.size(), "vertex"),
           "the " + counted(mesh.positions.size(), "vertex"));
  if (entry.rest.triangles.size() != mesh.triangles.size())
    refuse("triangles", counted(entry.rest.triangles.size(), "triangle"),
           "the " + counted(mesh.triangles.size(), "triangle"));
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    if (!std::equal(mesh.triangles[t].v, mesh.triangles[t].v + 3, entry.rest.triangles[t].v))
      refuse("triangles", "another triangle " + std::to_string(t),
             "the same triangles, in the order");
}

ClothEntry read_entry(Fields& fields, std::size_t number, const MaterialNames& names,
                      const ReadableFolders& folders, const FileAxes& usual, Scene& scene) {
  const std::string name = fields.name("name", "cloth_" + std::to_string(number));
  ClothEntry entry{name, fields.path_of(""), {}, fields, {}, {}, 0, {}, 0, {}, {}, {}, {}, {}};
  FileAxes axes = usual;
  std::vector<std::string> shapes = pattern_shapes();
  shapes.emplace_back("mesh");
  const std::string shape = fields.one_of(shapes);
  if (shape == "mesh") {
    const std::filesystem::path path = read_path(fields, "mesh", folders);
    axes = read_axes_of(path, fields, usual);
    entry.mesh = read_cloth_file(fields, path, folders, axes, scene);
  } else {
    entry.pattern = read_pattern(fields, shape, entry.pattern_fields);
  }
  for (const char* key : {"uv", "units", "up"})
    if (fields.has(key) && shape != "mesh") fields.refuse(key, "nothing beside " + shape);
  Fields transform = fields.object("transform", transform_keys());
  entry.transform = read_transform(transform);
  if (shape == "mesh") {
    warn_of_axes(entry.mesh, entry.transform, fields.path_of("mesh"), scene);
    warn_of_units(entry.mesh, entry.transform, fields.path_of("mesh"), scene);
  }
  read_cloth_material(fields, names, entry);
  entry.pressure = fields.number("pressure", quantity::pressure, 0);
  read_rest(fields, folders, axes, entry);
  const Vec3<double> none{0, 0, 0};
  entry.velocity = fields.vector<3>("velocity", quantity::velocity, none);
  entry.angular_velocity = fields.vector<3>("angular_velocity", quantity::angular_velocity, none);
  Fields copies = fields.object("copies", {"count", "translate", "rotate"});
  entry.copies.count = static_cast<Index>(copies.integer("count", 1, 1, 10000));
  entry.copies.step.translate = copies.vector<3>("translate", quantity::coordinate, none);
  read_rotation(copies, entry.copies.step);
  return entry;
}

double triangle_count(const ClothEntry& entry) {
  const double one =
      entry.pattern ? entry.pattern->triangles() : static_cast<double>(entry.mesh.triangles.size());
  return one * entry.copies.count;
}

/// Gives the patterns without cells triangles of one size in the world: square cells, or rings.
void share_triangles(std::vector<ClothEntry>& entries, double triangles) {
  double area = 0;
  for (const ClothEntry& entry : entries)
    if (entry.pattern && !entry.pattern->cells)
      area += entry.pattern->area() * entry.transform.scale * entry.transform.scale *
              entry.copies.count;
  const double cell = std::sqrt(2 * area / triangles);
  for (ClothEntry& entry : entries) {
    if (!entry.pattern || entry.pattern->cells) continue;
    ClothPattern& pattern = *entry.pattern;
    pattern.choose_cells(entry.transform.scale, cell, triangles);
    if (pattern.shape == ClothPattern::Shape::disc)
      entry.pattern_fields.record("cells", (*pattern.cells)[0]);
    else
      entry.pattern_fields.record("cells", *pattern.cells);
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

void add_cloths(ClothEntry& entry, Scene& scene) {
  Mesh mesh = entry.pattern ? entry.pattern->mesh() : std::move(entry.mesh);
  if (!entry.rest_file.empty()) check_rest(entry, mesh);
  const Vec3<double> centre = apply(entry.transform, aabb_of(mesh.positions).center());
  for (Vec3<double>& x : entry.rest.positions) x = apply(entry.transform, x);
  for (Vec3<double>& x : mesh.positions) x = apply(entry.transform, x);
  for (Vec2<double>& u : mesh.material) u *= entry.transform.scale;
  for (Index k = 0; k < entry.copies.count; ++k) {
    Cloth cloth;
    cloth.name = entry.copies.count == 1 ? entry.name : entry.name + "_" + std::to_string(k);
    cloth.material = entry.material;
    cloth.triangle_material = entry.triangle_material;
    cloth.pressure = entry.pressure;
    cloth.velocity = entry.velocity;
    cloth.angular_velocity = entry.angular_velocity;
    place_copy(mesh, centre, entry.copies, k, cloth.mesh);
    cloth.rest_positions = entry.rest_initial ? cloth.mesh.positions : entry.rest.positions;
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

std::vector<ClothGroup> read_cloths(Fields& root, const ReadableFolders& folders, double triangles,
                                    bool triangles_overridden, Scene& scene) {
  const MaterialNames materials(scene.materials);
  const FileAxes usual = read_file_axes(root, {});
  std::vector<ClothEntry> entries;
  bool any_shared = false;
  const std::vector<std::string> keys{
      "name",   "grid",     "panel",    "disc",  "cylinder", "ribbon",
      "mesh",   "repair",   "uv",       "units", "up",       "transform",
      "fabric", "material", "pressure", "rest",  "velocity", "angular_velocity",
      "copies"};
  for (Fields& fields : root.objects("cloths", keys)) {
    entries.push_back(read_entry(fields, entries.size(), materials, folders, usual, scene));
    any_shared = any_shared || (entries.back().pattern && !entries.back().pattern->cells);
  }
  if (triangles_overridden && !any_shared)
    root.refuse("triangles",
                "--set triangles only where a grid, panel, disc, cylinder or ribbon has no cells "
                "of its own");
  if (any_shared) share_triangles(entries, triangles);

  double total = 0;
  for (const ClothEntry& entry : entries) total += triangle_count(entry);
  if (!(total <= max_made_triangles))
    root.refuse("cloths", short_text(total) + " triangles",
                "up to " + std::to_string(static_cast<long long>(max_made_triangles)));
  std::vector<ClothGroup> groups;
  for (ClothEntry& entry : entries) {
    ClothGroup group{
        entry.name, static_cast<Index>(scene.cloths.size()), entry.copies.count, {}, {}};
    if (entry.pattern) entry.pattern->name_edges(group);
    groups.push_back(group);
    add_cloths(entry, scene);
  }
  check_names(entries, scene);
  return groups;
}

}  // namespace weft::io
