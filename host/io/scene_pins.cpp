#include <algorithm>
#include <cstddef>
#include <limits>

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

/// Which vertices one pin holds in each cloth that it names.
std::vector<std::vector<Index>> read_selection(Fields& fields, const PinnedCloths& cloths,
                                               const Scene& scene) {
  const auto count = static_cast<std::size_t>(cloths.count);
  const std::string key = fields.one_of({"vertices", "corners", "edge", "box"});
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

}  // namespace

void read_pins(Fields& root, const std::vector<ClothGroup>& groups, Scene& scene) {
  for (Fields& fields : root.objects(
           "pins", {"cloth", "vertices", "corners", "edge", "box", "motion", "release_time"})) {
    const PinnedCloths cloths = read_pinned_cloths(fields, groups, scene);
    const std::vector<std::vector<Index>> selection = read_selection(fields, cloths, scene);
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

}  // namespace weft::io
