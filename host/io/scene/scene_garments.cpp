#include "host/io/scene/scene_garments.hpp"

#include <algorithm>
#include <cstddef>
#include <utility>

#include "host/base/file_bytes.hpp"
#include "host/io/pattern/pattern_file.hpp"
#include "host/io/pattern/start_shape.hpp"
#include "host/io/scene/file_axes.hpp"
#include "weft/core/at.hpp"
#include "weft/error.hpp"

namespace weft::io {
namespace {

/// Patterns have y up, in metres once they are read.
constexpr FileAxes pattern_axes{1, true};

/// The number of a material by its name.
Index material_of(Fields& fields, const std::string& key, const Scene& scene) {
  std::vector<std::string> names;
  for (const Material& material : scene.materials) names.push_back(material.name);
  return static_cast<Index>(fields.choice(key, names, {}));
}

/// A name for the whole garment, or names by panel, with "*" for those that are not named.
void read_garment_material(Fields& fields, const Garment& garment, const Scene& scene,
                           Cloth& cloth) {
  if (!fields.is_object("material")) {
    cloth.material = material_of(fields, "material", scene);
    return;
  }
  std::vector<std::string> keys{"*"};
  for (const GarmentPanel& panel : garment.panels) keys.push_back(panel.name);
  Fields by_panel = fields.object("material", keys);
  for (const GarmentPanel& panel : garment.panels) {
    const std::string key = by_panel.has(panel.name) ? panel.name : "*";
    cloth.triangle_material.insert(cloth.triangle_material.end(), at(panel.triangle_count),
                                   material_of(by_panel, key, scene));
  }
  cloth.material = cloth.triangle_material.front();
}

/// A body as patterns see it, in the world at time 0.
Mesh body_of(const Obstacle& obstacle) {
  Mesh body = obstacle.mesh;
  const Transform& start =
      obstacle.motion.empty() ? obstacle.transform : obstacle.motion.front().transform;
  for (Vec3<double>& x : body.positions) {
    x = apply(start, x);
    x = {x[0], x[2], -x[1]};
  }
  return body;
}

}  // namespace

std::vector<GarmentEntry> read_garments(Fields& root, const ReadableFolders& folders, Scene& scene,
                                        std::vector<ClothGroup>& groups) {
  std::vector<GarmentEntry> entries;
  for (Fields& fields :
       root.objects("garments", {"name", "pattern", "body", "edge", "fabric", "material"})) {
    GarmentEntry entry;
    entry.field = fields.path_of("body");
    const std::string name = fields.name("name", "garment_" + std::to_string(entries.size()));
    const std::filesystem::path path = read_path(fields, "pattern", folders);
    const nlohmann::json document = parse_json(read_file_bytes(path), path.string());
    if (!is_sewing_pattern(document))
      throw SceneError(path.string(), "pattern", "missing",
                       "a specification of GarmentCode, with \"pattern\" and its \"panels\"");
    const double edge = fields.number("edge", quantity::length, default_garment_edge);
    entry.garment = make_garment(read_sewing_pattern(document, path.string()), edge);
    for (const std::string& note : entry.garment.notes)
      scene.warnings.push_back(path.string() + ": " + note);
    entry.body = fields.text("body", "");
    Cloth cloth;
    cloth.name = name;
    cloth.mesh = entry.garment.mesh;
    to_scene_axes(pattern_axes, cloth.mesh);
    read_garment_material(fields, entry.garment, scene, cloth);
    entry.cloth = static_cast<Index>(scene.cloths.size());
    for (const Cloth& other : scene.cloths)
      if (other.name == name) fields.refuse("name", "a name of its own for each cloth and garment");
    groups.push_back({name, entry.cloth, 1, {}, {}});
    scene.cloths.push_back(std::move(cloth));
    entries.push_back(std::move(entry));
  }
  // Panels of different sides of a body come to lie on each other and on it.
  if (!entries.empty()) scene.contact.untangle = true;
  return entries;
}

void place_garments(std::vector<GarmentEntry>& garments, Scene& scene) {
  for (GarmentEntry& entry : garments) {
    Mesh body;
    if (!entry.body.empty()) {
      const auto found =
          std::find_if(scene.obstacles.begin(), scene.obstacles.end(),
                       [&](const Obstacle& obstacle) { return obstacle.name == entry.body; });
      if (found == scene.obstacles.end())
        throw SceneError(scene.file, entry.field, "\"" + entry.body + "\"",
                         "the name of an obstacle");
      body = body_of(*found);
    }
    relax_start(entry.garment, body);
    Mesh mesh = entry.garment.mesh;
    to_scene_axes(pattern_axes, mesh);
    scene.cloths[at(entry.cloth)].mesh.positions = std::move(mesh.positions);
    for (const GarmentSeam& sewn : entry.garment.seams) {
      if (sewn.pairs.empty()) continue;
      Seam seam;
      seam.cloths[0] = seam.cloths[1] = entry.cloth;
      for (const auto& pair : sewn.pairs)
        for (std::size_t side = 0; side < 2; ++side) seam.vertices[side].push_back(pair[side]);
      seam.weld_distance = contact_thickness(scene.contact);
      scene.seams.push_back(std::move(seam));
    }
  }
}

}  // namespace weft::io
