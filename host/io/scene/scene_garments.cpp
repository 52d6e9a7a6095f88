#include "host/io/scene/scene_garments.hpp"

#include <algorithm>
#include <cstddef>
#include <limits>
#include <numeric>
#include <utility>

#include "host/base/file_bytes.hpp"
#include "host/geometry/attachment.hpp"
#include "host/input/nearest_word.hpp"
#include "host/input/quantity.hpp"
#include "host/io/pattern/arm_clearance.hpp"
#include "host/io/pattern/panel_placement.hpp"
#include "host/io/pattern/pattern_file.hpp"
#include "host/io/pattern/start_shape.hpp"
#include "host/io/scene/file_axes.hpp"
#include "host/scene/seams/sewing.hpp"
#include "host/scene/surfaces.hpp"
#include "host/scene/tangled_start.hpp"
#include "host/untangle/untangle_scene.hpp"
#include "weft/core/at.hpp"
#include "weft/error.hpp"

namespace weft::io {
namespace {

constexpr std::int64_t most_layers = 1000;

/// [edges] Springs that close a seam leave a pair open where contacts hold it a thickness apart.
constexpr double weld_share = 0.1;

/// [s] in which edges reach the place where they are held.
constexpr double time_to_place = 1;

/// Patterns have y up, in metres once they are read.
constexpr FileAxes pattern_axes{1, true};

/// The number of a material by its name.
Index material_of(Fields& fields, const std::string& key, const Scene& scene) {
  std::vector<std::string> names;
  for (const Material& material : scene.materials) names.push_back(material.name);
  return static_cast<Index>(fields.choice(key, names, {}));
}

/// @throws SceneError if a panel has no name of its own, and none is there for the others
void require_all_panels(const Fields& by_panel, const Garment& garment) {
  if (by_panel.has("*")) return;
  for (const GarmentPanel& panel : garment.panels)
    if (!by_panel.has(panel.name))
      by_panel.refuse(panel.name, "missing",
                      "a name for each panel, or \"*\" for those that are not named");
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
  // "fabric" has become "material", and is still there for messages.
  if (fields.has("fabric")) {
    require_all_panels(fields.object("fabric", keys), garment);
    fields.leave_out("fabric");
  }
  Fields by_panel = fields.object("material", keys);
  require_all_panels(by_panel, garment);
  for (const GarmentPanel& panel : garment.panels) {
    const std::string key = by_panel.has(panel.name) ? panel.name : "*";
    cloth.triangle_material.insert(cloth.triangle_material.end(), at(panel.triangle_count),
                                   material_of(by_panel, key, scene));
  }
  cloth.material = cloth.triangle_material.front();
}

/// Names for a message, the first of many.
std::string listed(const std::vector<std::string>& names) {
  constexpr std::size_t shown_max = 8;
  std::string text;
  for (std::size_t k = 0; k < std::min(names.size(), shown_max); ++k)
    text += (k > 0 ? ", \"" : "\"") + names[k] + "\"";
  return text + (names.size() > shown_max ? ", ..." : "");
}

/// The vertices along an edge of a panel.
std::vector<Index> read_panel_edge(Fields& fields, const Garment& garment) {
  std::vector<std::string> names;
  for (const GarmentPanel& panel : garment.panels) names.push_back(panel.name);
  const std::size_t panel = fields.choice("panel", names, {});
  const auto last = static_cast<std::int64_t>(garment.panels[panel].edges.size()) - 1;
  return garment.panels[panel].edges[static_cast<std::size_t>(fields.integer("edge", {}, 0, last))];
}

/// The vertices of all edges with a label.
std::vector<Index> read_label(Fields& fields, const Garment& garment) {
  const std::string label = fields.text("label");
  std::vector<std::string> names;
  for (const GarmentLabel& known : garment.labels) {
    if (known.label == label) return known.vertices;
    names.push_back(known.label);
  }
  if (names.empty()) fields.refuse("label", "\"panel\" and \"edge\": the pattern labels no edge");
  const auto nearest = nearest_word(label, names);
  fields.refuse("label", "a label of the pattern's edges: " + listed(names) +
                             (nearest ? "; did you mean \"" + *nearest + "\"?" : ""));
}

/// What holds a garment until it is let go.
std::vector<Attachment> read_attachments(Fields& garment_fields, const Garment& garment,
                                         Index cloth) {
  std::vector<Attachment> attachments;
  for (Fields& fields :
       garment_fields.objects("attach", {"label", "panel", "edge", "along", "at", "end_time"})) {
    Attachment attachment;
    Handle& handle = attachment.handle;
    handle.cloth = cloth;
    if (fields.one_of({"label", "panel"}) == "panel") {
      handle.vertices = read_panel_edge(fields, garment);
    } else {
      if (fields.has("edge")) fields.refuse("edge", "an edge only beside \"panel\"");
      handle.vertices = read_label(fields, garment);
    }
    if (fields.is_null("along"))
      fields.record("along", nullptr);
    else
      handle.along = fields.direction("along", {0, 0, 1});
    if (fields.has("at")) {
      if (fields.is_null("along")) fields.refuse("at", "no place along all directions");
      attachment.place = fields.number("at", quantity::coordinate);
    }
    if (const auto end = fields.number_or_null("end_time")) {
      if (!(*end > 0) || !quantity::instant_from_zero.holds(*end))
        fields.refuse("end_time", "a time > 0, or null for never");
      handle.end_time = *end;
    }
    attachments.push_back(std::move(attachment));
  }
  return attachments;
}

/// All obstacles at time 0, as patterns see them.
Mesh bodies_at_start(const Scene& scene) {
  Mesh all;
  for (const Obstacle& obstacle : scene.obstacles) {
    const auto first = static_cast<Index>(all.positions.size());
    const Transform start =
        obstacle.motion.empty() ? obstacle.transform : transform_at(obstacle.motion, 0);
    for (const Vec3<double>& p : obstacle.mesh.positions) {
      const Vec3<double> x = apply(start, p);
      all.positions.push_back({x[0], x[2], -x[1]});
    }
    for (const Tri& t : obstacle.mesh.triangles)
      all.triangles.push_back({{t.v[0] + first, t.v[1] + first, t.v[2] + first}});
  }
  return all;
}

void add_seams(const GarmentCloth& entry, Index cloth, Scene& scene) {
  for (const GarmentSeam& sewn : entry.garment.seams) {
    if (sewn.pairs.empty()) continue;
    Seam seam;
    seam.cloths[0] = seam.cloths[1] = cloth;
    for (const auto& pair : sewn.pairs)
      for (std::size_t side = 0; side < 2; ++side) seam.vertices[side].push_back(pair[side]);
    seam.weld_distance = std::max(contact_thickness(scene.contact), weld_share * entry.edge);
    scene.seams.push_back(std::move(seam));
  }
}

Mesh in_scene_axes(Mesh mesh) {
  to_scene_axes(pattern_axes, mesh);
  return mesh;
}

/// [m] Where the vertices of an attachment are along its direction, on average.
double mean_place(const Attachment& attachment, const std::vector<Vec3<double>>& positions) {
  double sum = 0;
  for (const Index v : attachment.handle.vertices)
    sum += dot(positions[at(v)], attachment.handle.along);
  return sum / static_cast<double>(attachment.handle.vertices.size());
}

/// Moves the panels with edges that are held at a place, so that these edges stand there.
void take_to_places(GarmentCloth& entry) {
  Mesh& mesh = entry.garment.mesh;
  for (const Attachment& attachment : entry.attachments) {
    if (!attachment.place) continue;
    const Vec3<double> way =
        attachment.handle.along *
        (*attachment.place - mean_place(attachment, in_scene_axes(entry.garment.mesh).positions));
    const std::vector<Index>& held = attachment.handle.vertices;
    for (const GarmentPanel& panel : entry.garment.panels) {
      const auto begin = mesh.positions.begin() + panel.first_vertex;
      const bool any = std::any_of(held.begin(), held.end(), [&](Index v) {
        return v >= panel.first_vertex && v < panel.first_vertex + panel.vertex_count;
      });
      for (auto p = begin; any && p != begin + panel.vertex_count; ++p)
        *p += Vec3<double>{way[0], way[2], -way[1]};
    }
  }
}

/// Moves a garment out of the body and what is worn beneath it, neither of which moves. What cannot
/// be resolved is left to the start of the run, which moves all garments.
/// @param self also resolves intersections of the garment with itself
/// @return whether it could be
bool clear_alone(GarmentCloth& entry, const std::vector<const GarmentCloth*>& beneath,
                 const Scene& scene, bool self) {
  Scene alone;
  alone.file = scene.file;
  alone.materials = scene.materials;
  alone.contact = scene.contact;
  alone.contact.self = alone.contact.self && self;
  alone.obstacles = scene.obstacles;
  for (const GarmentCloth* inner : beneath) {
    Obstacle obstacle;
    obstacle.name = scene.cloths[at(inner->cloth)].name;
    obstacle.mesh.positions = in_scene_axes(inner->garment.mesh).positions;
    obstacle.mesh.triangles = inner->garment.mesh.triangles;
    alone.obstacles.push_back(std::move(obstacle));
  }
  alone.cloths.push_back(scene.cloths[at(entry.cloth)]);
  std::vector<Vec3<double>>& x = alone.cloths[0].mesh.positions;
  x = in_scene_axes(entry.garment.mesh).positions;
  add_seams(entry, 0, alone);
  try {
    untangle_start(alone, std::vector<unsigned char>(seam_pairs(alone).size(), 1));
  } catch (const TangledStart&) {
    return false;
  }
  for (std::size_t v = 0; v < x.size(); ++v)
    entry.garment.mesh.positions[v] = {x[v][0], x[v][2], -x[v][1]};
  return true;
}

}  // namespace

std::vector<GarmentCloth> read_garments(Fields& root, const ReadableFolders& folders, Scene& scene,
                                        std::vector<ClothGroup>& groups) {
  std::vector<GarmentCloth> garments;
  for (Fields& fields : root.objects("garments", {"name", "pattern", "edge", "fabric", "material",
                                                  "layer", "start", "attach"})) {
    const std::string name = fields.name("name", "garment_" + std::to_string(garments.size()));
    for (const Cloth& other : scene.cloths)
      if (other.name == name) fields.refuse("name", "a name of its own for each cloth and garment");
    const double edge = fields.number("edge", quantity::length, default_garment_edge);
    const auto layer = fields.integer("layer", 0, 0, most_layers);
    const auto start =
        static_cast<SewnStart>(fields.choice("start", {"auto", "welded", "springs"}, 0));
    const std::filesystem::path path = read_path(fields, "pattern", folders);
    const nlohmann::json document = parse_json(read_file_bytes(path), path.string());
    require_sewing_pattern(document, path.string());
    Garment garment = make_garment(read_sewing_pattern(document, path.string()), edge,
                                   {fields.file(), fields.path_of("edge")});
    for (const std::string& note : garment.notes)
      scene.warnings.push_back(path.string() + ": " + note);
    Cloth cloth;
    cloth.name = name;
    read_garment_material(fields, garment, scene, cloth);
    cloth.mesh = garment.mesh;
    to_scene_axes(pattern_axes, cloth.mesh);
    const auto number = static_cast<Index>(scene.cloths.size());
    groups.push_back({name, number, 1, {}, {}});
    std::vector<Attachment> attachments = read_attachments(fields, garment, number);
    garments.push_back({number, edge, static_cast<int>(layer), path.string(), std::move(garment),
                        start, std::move(attachments)});
    scene.cloths.push_back(std::move(cloth));
  }
  // Panels come to lie on each other and on the body.
  if (!garments.empty()) scene.contact.untangle = true;
  return garments;
}

void sew_garments(std::vector<GarmentCloth>& garments, Scene& scene) {
  if (garments.empty()) return;
  const Mesh body = bodies_at_start(scene);
  std::vector<std::size_t> order(garments.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return garments[a].layer < garments[b].layer;
  });
  const int lowest = garments[order.front()].layer;
  const bool layered = garments[order.back()].layer > lowest;
  // As they are sewn, and as their panels stand before that.
  InnerLayers inner(body), standing(body);
  std::vector<const GarmentCloth*> beneath, beside;
  std::vector<Garment> apart(garments.size());
  for (std::size_t k = 0; k < order.size(); ++k) {
    GarmentCloth& entry = garments[order[k]];
    if (!beside.empty() && entry.layer > beside.back()->layer) {
      for (const GarmentCloth* other : beside) {
        inner.add(other->garment);
        standing.add(apart[static_cast<std::size_t>(other - garments.data())]);
      }
      beneath.insert(beneath.end(), beside.begin(), beside.end());
      beside.clear();
    }
    take_to_places(entry);
    for (const std::string& line : misplaced_panels(entry.garment, body))
      scene.warnings.push_back(entry.file + ": " + line);
    refuse_far_panels(entry.garment, body, entry.file);
    if (entry.start != SewnStart::welded) {
      apart[order[k]] = entry.garment;
      clear_arms(apart[order[k]], body);
      standing.stand_outside(apart[order[k]]);
    }
    relax_start(entry.garment, entry.edge, body, inner);
    if (layered || entry.start != SewnStart::springs) {
      // Contracting moves all of the cloth, so its intersections with itself are resolved later.
      if (clear_alone(entry, beneath, scene, false))
        tighten_start(entry.garment, entry.edge, body, inner);
      // Outer layers are placed around this one, which must not intersect itself then.
      if (layered) clear_alone(entry, beneath, scene, true);
    }
    beside.push_back(&entry);
  }
  for (std::size_t k = 0; k < garments.size(); ++k) {
    GarmentCloth& entry = garments[k];
    add_seams(entry, entry.cloth, scene);
    to_scene_axes(pattern_axes, entry.garment.mesh);
    scene.cloths[at(entry.cloth)].mesh.positions = std::move(entry.garment.mesh.positions);
    to_scene_axes(pattern_axes, apart[k].mesh);
    scene.garment_starts.push_back(
        {entry.cloth, entry.start, std::move(apart[k].mesh.positions), {}});
  }
}

namespace {

/// [m] Where the vertices of a handle are drawn to, on the whole.
std::vector<Vec3<double>> held_places(const Handle& handle, double place,
                                      const std::vector<Vec3<double>>& positions) {
  std::vector<Vec3<double>> places;
  for (const Index v : handle.vertices) {
    const Vec3<double>& x = positions[at(v)];
    places.push_back(x + handle.along * (place - dot(handle.along, x)));
  }
  return places;
}

/// The part of the nearest obstacle that is nearest to some places; none if it never moves.
Handle::Carrier carrier_of(const std::vector<Vec3<double>>& places, const Scene& scene) {
  const auto moves = [](const Obstacle& o) {
    return (o.live || o.deformation || !o.motion.empty()) && !o.driven;
  };
  Handle::Carrier carrier;
  if (std::none_of(scene.obstacles.begin(), scene.obstacles.end(), moves)) return carrier;
  const Surfaces all = surfaces_at_start(scene, {});
  double least = std::numeric_limits<double>::infinity();
  std::vector<Index> corners;
  for (std::size_t o = 0; o < scene.obstacles.size(); ++o) {
    const std::size_t mesh = scene.cloths.size() + o;
    const std::vector<Tri> surface(all.triangles.begin() + all.first_triangle[mesh],
                                   all.triangles.begin() + all.first_triangle[mesh + 1]);
    double distance = 0;
    std::vector<Index> found;
    for (const weft::Attachment& nearest : attach(places, surface, all.points)) {
      distance += length(nearest.offset);
      for (const Index v : nearest.corners.v) found.push_back(v - all.first_point[mesh]);
    }
    if (!(distance < least)) continue;
    least = distance;
    carrier.obstacle = static_cast<Index>(o);
    corners = std::move(found);
  }
  if (!moves(scene.obstacles[at(carrier.obstacle)])) return {};
  std::sort(corners.begin(), corners.end());
  corners.erase(std::unique(corners.begin(), corners.end()), corners.end());
  const Index first = all.first_point[scene.cloths.size() + at(carrier.obstacle)];
  for (const Index v : corners) carrier.start.push_back(all.points[at(first + v)]);
  carrier.vertices = std::move(corners);
  return carrier;
}

}  // namespace

void attach_garments(const std::vector<GarmentCloth>& garments, Scene& scene) {
  for (const GarmentCloth& entry : garments)
    for (const Attachment& attachment : entry.attachments) {
      Handle handle = attachment.handle;
      const std::vector<Vec3<double>>& positions = scene.cloths[at(entry.cloth)].mesh.positions;
      const double place = attachment.place.value_or(mean_place(attachment, positions));
      handle.carrier = carrier_of(held_places(handle, place, positions), scene);
      if (length(handle.along) > 0) {
        // Shrunk to a point, which stands for a plane: springs see nothing of it but its height.
        handle.motion = {{0, {}}, {time_to_place, {}}};
        handle.motion[1].transform.scale = quantity::scale.least;
        handle.motion[1].transform.translate = handle.along * place;
      }
      scene.handles.push_back(std::move(handle));
    }
}

}  // namespace weft::io
