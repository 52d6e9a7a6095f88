#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdio>
#include <limits>
#include <map>
#include <numbers>
#include <set>

#include "host/geometry/mesh_check.hpp"
#include "host/geometry/mesh_repair.hpp"
#include "host/geometry/outline.hpp"
#include "host/geometry/unfold.hpp"
#include "host/io/scene/file_axes.hpp"
#include "host/io/scene/scene_parts.hpp"
#include "host/io/scene/scene_ribbon.hpp"
#include "host/io/usd/surface_file.hpp"
#include "weft/error.hpp"
#include "weft/shapes.hpp"

namespace weft::io {
namespace {

/// A cloth that is made from numbers.
struct Pattern {
  enum class Shape { grid, panel, disc, cylinder, ribbon };
  Shape shape = Shape::grid;
  /// grid, panel: (mean) width and height; cylinder: around and height; ribbon: length and width
  Vec2<double> size{};
  double radius = 0;                ///< disc and cylinder
  double inner_radius = 0;          ///< disc; 0: no hole
  std::vector<PanelWidth> outline;  ///< panel
  Ribbon ribbon;
  std::optional<std::array<Index, 2>> cells;  ///< disc: the number of rings, twice
  Diagonals diagonals = Diagonals::alternating;

  double area() const {
    return shape == Shape::disc ? std::numbers::pi * (radius * radius - inner_radius * inner_radius)
                                : size[0] * size[1];
  }
  double triangles() const {
    const double n = (*cells)[0];
    if (shape != Shape::disc) return 2 * n * (*cells)[1];
    return 6 * n * (n + (inner_radius > 0 ? 2.0 * start() : 0));
  }
  /// Sixths of the ring around the hole.
  Index start() const { return annulus_start(inner_radius, radius, (*cells)[0]); }
  Mesh mesh() const {
    if (shape == Shape::disc)
      return inner_radius > 0 ? make_annulus(inner_radius, radius, (*cells)[0])
                              : make_disc(radius, (*cells)[0]);
    if (shape == Shape::panel) return make_panel(outline, *cells);
    if (shape == Shape::cylinder) return make_tube(radius, size[1], *cells);
    if (shape == Shape::ribbon) return make_ribbon(ribbon, *cells);
    return make_grid(size, *cells, diagonals);
  }
};

struct Copies {
  Index count = 1;
  Transform step;  ///< translation and rotation of each copy against the one before
};

/// One entry of "cloths" before its mesh is made, since patterns share the triangle budget.
struct ClothEntry {
  std::string name;
  std::string field;
  std::optional<Pattern> pattern;
  Fields pattern_fields;  ///< of the entry itself for a mesh file
  Mesh mesh;              ///< from a file
  Transform transform;
  Index material = 0;
  std::vector<Index> triangle_material;
  double pressure = 0;
  Vec3<double> velocity{};
  Vec3<double> angular_velocity{};
  Vec3<double> velocity_origin{};
  Copies copies;
  bool rest_initial = false;  ///< it has no bending moments as it starts
  Mesh rest{};                ///< nor in this shape; empty: none
  std::string rest_file{};
  std::optional<Remeshing> remeshing{};
};

Pattern read_grid(Fields& fields) {
  Pattern grid;
  grid.size = fields.vector<2>("size", quantity::length);
  if (fields.has("cells")) {
    const auto cells = fields.integers("cells", 1, std::numeric_limits<Index>::max(), 2);
    grid.cells = {static_cast<Index>(cells[0]), static_cast<Index>(cells[1])};
  }
  grid.diagonals = fields.choice("diagonals", {"alternating", "same"}, 0) == 0
                       ? Diagonals::alternating
                       : Diagonals::same;
  return grid;
}

Pattern read_disc(Fields& fields) {
  Pattern disc;
  disc.shape = Pattern::Shape::disc;
  disc.radius = fields.number("radius", quantity::length);
  disc.inner_radius = fields.number("inner_radius", quantity::length_or_zero, 0);
  if (!(disc.inner_radius >= 0 && disc.inner_radius < disc.radius))
    fields.refuse("inner_radius", "a number >= 0 and < radius");
  if (fields.has("cells")) {
    const auto rings = static_cast<Index>(fields.integer("cells", {}, 1, 10000));
    disc.cells = {rings, rings};
  }
  return disc;
}

/// Of a panel: no more than any resolution has rows for.
constexpr std::size_t max_panel_heights = 100;

/// Entries [height, half width] or [height, left, right].
Pattern read_panel(Fields& fields) {
  Pattern panel;
  panel.shape = Pattern::Shape::panel;
  for (const std::vector<double>& entry : fields.number_lists("outline", 2, 3))
    panel.outline.push_back(entry.size() == 2 ? PanelWidth{entry[0], -entry[1], entry[1]}
                                              : PanelWidth{entry[0], entry[1], entry[2]});
  if (panel.outline.size() < 2 || panel.outline.size() > max_panel_heights)
    fields.refuse("outline", std::to_string(panel.outline.size()) + " heights",
                  "2 to " + std::to_string(max_panel_heights) + " heights");
  for (std::size_t k = 0; k < panel.outline.size(); ++k) {
    const std::string entry = "outline[" + std::to_string(k) + "]";
    const PanelWidth& at = panel.outline[k];
    for (const double x : {at.height, at.left, at.right})
      if (!quantity::coordinate.holds(x))
        fields.refuse(entry, short_text(x), quantity::coordinate.allowed());
    if (!(at.right - at.left >= quantity::least_length))
      fields.refuse(entry, short_text(at.right - at.left) + " wide",
                    "a width > 0, " + quantity::length.allowed());
    if (k > 0 && !(at.height - panel.outline[k - 1].height >= quantity::least_length))
      fields.refuse(entry, short_text(at.height), "heights that increase from entry to entry");
  }
  const double height = panel.outline.back().height - panel.outline.front().height;
  panel.size = {panel_area(panel.outline) / height, height};
  if (fields.has("cells")) {
    const auto cells = fields.integers("cells", 1, std::numeric_limits<Index>::max(), 2);
    panel.cells = {static_cast<Index>(cells[0]), static_cast<Index>(cells[1])};
    if (cells[1] + 1 < static_cast<std::int64_t>(panel.outline.size()))
      fields.refuse("cells", "at least one row between two heights of the outline");
  }
  return panel;
}

Pattern read_cylinder(Fields& fields) {
  Pattern tube;
  tube.shape = Pattern::Shape::cylinder;
  tube.radius = fields.number("radius", quantity::length);
  tube.size = {2 * std::numbers::pi * tube.radius, fields.number("height", quantity::length)};
  if (fields.has("cells")) {
    const auto cells = fields.integers("cells", 1, std::numeric_limits<Index>::max(), 2);
    if (cells[0] < 3) fields.refuse("cells", "at least 3 around");
    tube.cells = {static_cast<Index>(cells[0]), static_cast<Index>(cells[1])};
  }
  return tube;
}

Pattern read_ribbon_pattern(Fields& fields) {
  Pattern pattern;
  pattern.shape = Pattern::Shape::ribbon;
  pattern.ribbon = read_ribbon(fields);
  pattern.size = {ribbon_length(pattern.ribbon), pattern.ribbon.width};
  if (fields.has("cells")) {
    const auto cells = fields.integers("cells", 1, std::numeric_limits<Index>::max(), 2);
    pattern.cells = {static_cast<Index>(cells[0]), static_cast<Index>(cells[1])};
  }
  return pattern;
}

/// Median stretches between these are as garments start that are put on a body.
constexpr double least_plain_stretch = 0.8;
constexpr double most_plain_stretch = 1.25;

/// Three digits, for messages.
std::string rounded_text(double value) {
  char buffer[32];
  std::snprintf(buffer, sizeof buffer, "%.3g", value);
  return buffer;
}

/// [m] along x, y and z
Vec3<double> box_size(const Mesh& mesh) {
  Vec3<double> low = mesh.positions.front();
  Vec3<double> high = low;
  for (const Vec3<double>& x : mesh.positions)
    for (int k = 0; k < 3; ++k) {
      low[k] = std::min(low[k], x[k]);
      high[k] = std::max(high[k], x[k]);
    }
  return high - low;
}

/// Material coordinates of a flat mesh are coordinates in its own plane, those of a curved one in
/// the plane that it unfolds into.
/// @throws SceneError if it is curved and may not be
void add_material(Mesh& mesh, const std::string& file, bool may_be_curved) {
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
    refuse("vertices", std::to_string(entry.rest.positions.size()) + " vertices",
           "the " + std::to_string(mesh.positions.size()) + " vertices");
  if (entry.rest.triangles.size() != mesh.triangles.size())
    refuse("triangles", std::to_string(entry.rest.triangles.size()) + " triangles",
           "the " + std::to_string(mesh.triangles.size()) + " triangles");
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
  const std::string shape = fields.one_of({"grid", "panel", "disc", "cylinder", "ribbon", "mesh"});
  if (shape == "grid") {
    entry.pattern_fields = fields.object("grid", {"size", "cells", "diagonals"});
    entry.pattern = read_grid(entry.pattern_fields);
  } else if (shape == "panel") {
    entry.pattern_fields = fields.object("panel", {"outline", "cells"});
    entry.pattern = read_panel(entry.pattern_fields);
  } else if (shape == "disc") {
    entry.pattern_fields = fields.object("disc", {"radius", "inner_radius", "cells"});
    entry.pattern = read_disc(entry.pattern_fields);
  } else if (shape == "cylinder") {
    entry.pattern_fields = fields.object("cylinder", {"radius", "height", "cells"});
    entry.pattern = read_cylinder(entry.pattern_fields);
  } else if (shape == "ribbon") {
    entry.pattern_fields = fields.object("ribbon", {"width", "path", "across", "cells"});
    entry.pattern = read_ribbon_pattern(entry.pattern_fields);
  } else {
    const std::filesystem::path path = read_path(fields, "mesh", folders);
    axes = read_axes_of(path, fields, usual);
    entry.mesh = read_surface(path, Uv::material, folders, &scene.warnings);
    to_scene_axes(axes, entry.mesh);
    if (fields.boolean("repair", false)) repair_from_file(entry.mesh, path, repaired_height, scene);
    if (entry.mesh.material.empty()) {
      check_mesh(entry.mesh, {path.string(), "mesh", ""}, false);
      add_material(entry.mesh, path.string(), fields.text("rest", "flat") == "initial");
    }
    // Here, where the message can name the mesh file rather than the scene.
    check_mesh(entry.mesh, {path.string(), "mesh", ""}, true);
    read_uv(fields, entry.mesh, scene);
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
  entry.velocity_origin = fields.vector<3>("velocity_origin", quantity::coordinate, none);
  if (fields.has("remeshing")) entry.remeshing = read_remeshing(fields, scene.adaptive.remeshing);
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
    Pattern& pattern = *entry.pattern;
    const auto count_of = [&](double length, double least) {
      // One row of a strip cannot use up more than the whole budget. In this order because areas
      // may overflow: of inf / inf, `least` is taken.
      return static_cast<Index>(
          std::max(least, std::min(std::round(length * entry.transform.scale / cell), triangles)));
    };
    if (pattern.shape == Pattern::Shape::disc) {
      // So that 6 rings^2 triangles have the area of half a cell each.
      const double width = pattern.radius - pattern.inner_radius;
      const Index rings = count_of(width * std::sqrt(std::numbers::pi / 3), 1);
      pattern.cells = {rings, rings};
      entry.pattern_fields.record("cells", rings);
    } else {
      const double around = pattern.shape == Pattern::Shape::cylinder ? 3 : 1;
      const double along = std::max<double>(1, static_cast<double>(pattern.outline.size()) - 1);
      pattern.cells = {count_of(pattern.size[0], around), count_of(pattern.size[1], along)};
      entry.pattern_fields.record("cells", *pattern.cells);
    }
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
  Mesh mesh = entry.pattern ? entry.pattern->mesh() : std::move(entry.mesh);
  if (!entry.rest_file.empty()) check_rest(entry, mesh);
  const Vec3<double> centre = apply(entry.transform, box_centre(mesh));
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
    cloth.velocity_origin = entry.velocity_origin;
    cloth.remeshing = entry.remeshing;
    place_copy(mesh, centre, entry.copies, k, cloth.mesh);
    cloth.rest_positions = entry.rest_initial ? cloth.mesh.positions : entry.rest.positions;
    scene.cloths.push_back(std::move(cloth));
  }
}

/// Vertices from `first` on, `step` apart.
std::vector<Index> run_of(Index first, Index count, Index step = 1) {
  std::vector<Index> run;
  for (Index i = 0; i < count; ++i) run.push_back(first + i * step);
  return run;
}

/// What pins, handles and seams may call by name.
void name_edges(const Pattern& pattern, ClothGroup& group) {
  const auto [nx, ny] = *pattern.cells;
  if (pattern.shape == Pattern::Shape::disc) {
    constexpr Index sectors = 6;
    if (pattern.inner_radius > 0) {
      const Index start = pattern.start();
      group.edges["inner"] = {run_of(0, sectors * start), true};
      // Rings start .. start + nx - 1 stand before the last one.
      group.edges["outer"] = {
          run_of(sectors * (nx * start + nx * (nx - 1) / 2), sectors * (start + nx)), true};
    } else {
      group.edges["outer"] = {run_of(1 + sectors * (nx * (nx - 1) / 2), sectors * nx), true};
    }
  } else if (pattern.shape == Pattern::Shape::cylinder) {
    group.edges["bottom"] = {run_of(0, nx), true};
    group.edges["top"] = {run_of(nx * ny, nx), true};
  } else {
    group.cells = pattern.cells;
    group.edges["left"] = {run_of(0, ny + 1, nx + 1), false};
    group.edges["right"] = {run_of(nx, ny + 1, nx + 1), false};
    group.edges["bottom"] = {run_of(0, nx + 1), false};
    group.edges["top"] = {run_of(grid_vertex(nx, 0, ny), nx + 1), false};
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
  const bool falls_along_z = std::abs(g[2]) > std::max(std::abs(g[0]), std::abs(g[1]));
  const Vec3<double> size = box_size(mesh);
  const bool upright = size[1] >= 1.5 * size[0] && size[1] >= 2.5 * size[2] &&
                       std::min(size[0], size[2]) >= 0.08 * size[1];
  if (!falls_along_z || !upright || transform.rotation_angle != 0) return;
  scene.warnings.push_back(field + ": it is " + rounded_text(size[1]) + " m long along y and " +
                           rounded_text(size[2]) +
                           " m along z, while gravity acts along z; if y is up in its file, "
                           "\"up\": \"y\" puts it upright");
}

void warn_of_units(const Mesh& mesh, const Transform& transform, const std::string& field,
                   Scene& scene) {
  const Vec3<double> extents = box_size(mesh);
  const double size = std::max({extents[0], extents[1], extents[2]});
  if (transform.scale != 1 || !(size >= 30 && size <= 3000)) return;
  const bool centimetres = size < 300;
  scene.warnings.push_back(field + ": it is " + rounded_text(size) +
                           " m large; if its file is in " +
                           (centimetres ? "centimetres" : "millimetres") + ", \"units\": \"" +
                           (centimetres ? "cm" : "mm") + "\" makes metres of them");
}

std::vector<ClothGroup> read_cloths(Fields& root, const ReadableFolders& folders, double triangles,
                                    bool triangles_overridden, Scene& scene) {
  const MaterialNames materials(scene.materials);
  const FileAxes usual = read_file_axes(root, {});
  std::vector<ClothEntry> entries;
  bool any_shared = false;
  const std::vector<std::string> keys{"name",
                                      "grid",
                                      "panel",
                                      "disc",
                                      "cylinder",
                                      "ribbon",
                                      "mesh",
                                      "repair",
                                      "uv",
                                      "units",
                                      "up",
                                      "transform",
                                      "fabric",
                                      "material",
                                      "pressure",
                                      "rest",
                                      "velocity",
                                      "angular_velocity",
                                      "velocity_origin",
                                      "copies",
                                      "remeshing"};
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
    if (entry.pattern) name_edges(*entry.pattern, group);
    groups.push_back(group);
    add_cloths(entry, scene);
  }
  check_names(entries, scene);
  return groups;
}

}  // namespace weft::io
