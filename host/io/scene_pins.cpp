#include <algorithm>
#include <cstddef>
#include <limits>
#include <utility>

#include "host/io/scene_parts.hpp"
#include "host/scene/procedural.hpp"
#include "weft/error.hpp"

namespace weft::io {
namespace {

/// The cloths that a pin names: all copies of an entry, or one of them.
struct PinnedCloths {
  const ClothGroup* group = nullptr;
  Index first = 0;
  Index count = 0;
};

PinnedCloths read_pinned_cloths(Fields& fields, const std::vector<ClothGroup>& groups,
                                const Scene& scene) {
  const std::string name = fields.text("cloth");
  std::vector<std::string> known;
  for (const ClothGroup& group : groups) {
    if (group.name == name) return {&group, group.first, group.count};
    for (Index k = group.first; k < group.first + group.count; ++k) {
      known.push_back(scene.cloths[static_cast<std::size_t>(k)].name);
      if (known.back() == name) return {&group, k, 1};
    }
  }
  const auto nearest = nearest_word(name, known);
  std::string allowed = "the name of a cloth: ";
  for (std::size_t k = 0; k < std::min<std::size_t>(known.size(), 8); ++k)
    allowed += (k > 0 ? ", \"" : "\"") + known[k] + "\"";
  if (known.size() > 8) allowed += ", ...";
  fields.refuse("cloth", allowed + (nearest ? "; did you mean \"" + *nearest + "\"?" : ""));
}

const std::array<Index, 2>& cells_of(const Fields& fields, const std::string& key,
                                     const PinnedCloths& cloths) {
  if (!cloths.group->cells)
    fields.refuse(key, "vertices or box, since cloth \"" + cloths.group->name + "\" is no grid");
  return *cloths.group->cells;
}

std::vector<Index> read_corners(Fields& fields, const std::array<Index, 2>& cells) {
  const auto [nx, ny] = cells;
  const std::array<Index, 4> corners{grid_vertex(nx, 0, 0), grid_vertex(nx, nx, 0),
                                     grid_vertex(nx, 0, ny), grid_vertex(nx, nx, ny)};
  std::vector<Index> vertices;
  for (const std::size_t k :
       fields.choices("corners", {"min_min", "max_min", "min_max", "max_max"}))
    vertices.push_back(corners[k]);
  return vertices;
}

std::vector<Index> read_edge(Fields& fields, const std::array<Index, 2>& cells) {
  const auto [nx, ny] = cells;
  const std::size_t edge = fields.choice("edge", {"left", "right", "bottom", "top"}, {});
  std::vector<Index> vertices;
  if (edge < 2)
    for (Index j = 0; j <= ny; ++j) vertices.push_back(grid_vertex(nx, edge == 0 ? 0 : nx, j));
  else
    for (Index i = 0; i <= nx; ++i) vertices.push_back(grid_vertex(nx, i, edge == 2 ? 0 : ny));
  return vertices;
}

struct Box {
  Vec3<double> low{};
  Vec3<double> high{};

  std::vector<Index> inside(const Mesh& mesh) const {
    std::vector<Index> vertices;
    for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
      bool in = true;
      for (int k = 0; k < 3; ++k)
        in = in && mesh.positions[v][k] >= low[k] && mesh.positions[v][k] <= high[k];
      if (in) vertices.push_back(static_cast<Index>(v));
    }
    return vertices;
  }
};

Box read_box(Fields& fields) {
  Fields box = fields.object("box", {"min", "max"});
  const Box result{box.vector<3>("min"), box.vector<3>("max")};
  for (int k = 0; k < 3; ++k)
    if (!(result.low[k] <= result.high[k]))
      box.refuse("max", "three numbers, none below those of min");
  return result;
}

std::vector<std::string> selection_keys() {
  return {"vertices", "corners", "edge", "box"};
}

/// Which vertices one pin or handle holds in each cloth that it names.
/// @param key which of selection_keys() is there
std::vector<std::vector<Index>> read_selection(Fields& fields, const std::string& key,
                                               const PinnedCloths& cloths, const Scene& scene) {
  const auto count = static_cast<std::size_t>(cloths.count);
  const auto in_each = [&](const std::vector<Index>& vertices) {
    return std::vector<std::vector<Index>>(count, vertices);
  };
  if (key == "corners") return in_each(read_corners(fields, cells_of(fields, key, cloths)));
  if (key == "edge") return in_each(read_edge(fields, cells_of(fields, key, cloths)));
  if (key == "vertices") {
    const auto& mesh = scene.cloths[static_cast<std::size_t>(cloths.first)].mesh;
    std::vector<Index> vertices;
    for (const std::int64_t v :
         fields.integers("vertices", 0, static_cast<std::int64_t>(mesh.positions.size()) - 1, {}))
      vertices.push_back(static_cast<Index>(v));
    if (vertices.empty()) fields.refuse("vertices", "at least one vertex");
    return in_each(vertices);
  }
  const Box box = read_box(fields);
  std::vector<std::vector<Index>> result;
  bool any = false;
  for (Index k = 0; k < cloths.count; ++k) {
    result.push_back(box.inside(scene.cloths[static_cast<std::size_t>(cloths.first + k)].mesh));
    any = any || !result.back().empty();
  }
  if (!any)
    fields.refuse("box", "a box with at least one vertex of cloth \"" + cloths.group->name + "\"");
  return result;
}

void read_circle(Fields& fields, Handle& handle) {
  Fields circle =
      fields.object("circle", {"circumference", "direction", "center", "axis0", "axis1"});
  handle.shape = Handle::Shape::circle;
  handle.circumference = circle.positive("circumference");
  handle.direction = circle.vector<2>("direction", handle.direction);
  handle.center = circle.vector<3>("center", handle.center);
  handle.axis0 = circle.vector<3>("axis0", handle.axis0);
  handle.axis1 = circle.vector<3>("axis1", handle.axis1);
}

}  // namespace

void read_pins(Fields& root, const std::vector<ClothGroup>& groups, Scene& scene) {
  for (Fields& fields : root.objects(
           "pins", {"cloth", "vertices", "corners", "edge", "box", "motion", "release_time"})) {
    const PinnedCloths cloths = read_pinned_cloths(fields, groups, scene);
    const std::vector<std::vector<Index>> selection =
        read_selection(fields, fields.one_of(selection_keys()), cloths, scene);
    const Motion motion = read_motion(fields, "motion");
    const double release_time =
        fields.number_or_null("release_time").value_or(std::numeric_limits<double>::infinity());
    if (!(release_time > 0)) fields.refuse("release_time", "a time > 0, or null for never");
    for (Index k = 0; k < cloths.count; ++k) {
      const std::vector<Index>& vertices = selection[static_cast<std::size_t>(k)];
      if (!vertices.empty())
        scene.pins.push_back({cloths.first + k, vertices, motion, release_time});
    }
  }
}

void read_handles(Fields& root, const std::vector<ClothGroup>& groups, Scene& scene) {
  std::vector<std::string> selections = selection_keys();
  selections.emplace_back("glue");
  std::vector<std::string> keys = selections;
  keys.insert(keys.end(),
              {"cloth", "circle", "motion", "stiffness", "start_time", "end_time", "fade_time"});
  for (Fields& fields : root.objects("handles", keys)) {
    const PinnedCloths cloths = read_pinned_cloths(fields, groups, scene);
    const std::string key = fields.one_of(selections);
    Handle handle;
    std::vector<std::vector<Index>> selection;
    if (key == "glue") {
      handle.shape = Handle::Shape::glue;
      const auto& mesh = scene.cloths[static_cast<std::size_t>(cloths.first)].mesh;
      const auto pair =
          fields.integers("glue", 0, static_cast<std::int64_t>(mesh.positions.size()) - 1, 2);
      selection.assign(static_cast<std::size_t>(cloths.count),
                       {static_cast<Index>(pair[0]), static_cast<Index>(pair[1])});
      if (fields.has("circle")) fields.refuse("circle", "no circle beside glue");
    } else {
      selection = read_selection(fields, key, cloths, scene);
    }
    if (fields.has("circle")) read_circle(fields, handle);
    handle.motion = read_motion(fields, "motion");
    handle.stiffness = fields.positive("stiffness", handle.stiffness);
    handle.start_time = fields.number("start_time", handle.start_time);
    handle.end_time = fields.number_or_null("end_time").value_or(handle.end_time);
    handle.fade_time = fields.number("fade_time", handle.fade_time);
    for (Index k = 0; k < cloths.count; ++k) {
      handle.cloth = cloths.first + k;
      handle.vertices = std::move(selection[static_cast<std::size_t>(k)]);
      if (!handle.vertices.empty()) scene.handles.push_back(handle);
    }
  }
}

void read_wind(Fields& root, Scene& scene) {
  Fields fields = root.object("wind", {"density", "velocity", "drag"});
  scene.wind.density = fields.number("density", scene.wind.density);
  scene.wind.velocity = fields.vector<3>("velocity", scene.wind.velocity);
  scene.wind.drag = fields.number("drag", scene.wind.drag);
}

}  // namespace weft::io
