#include "host/io/scene/scene_selection.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

#include "host/geometry/mesh_groups.hpp"
#include "host/input/nearest_word.hpp"
#include "weft/shapes.hpp"

namespace weft::io {
namespace {

const std::array<Index, 2>& cells_of(const Fields& fields, const std::string& key,
                                     const NamedCloths& cloths) {
  if (!cloths.group->cells)
    fields.refuse(key,
                  "vertices, box or group, since cloth \"" + cloths.group->name + "\" is no grid");
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

const ClothEdge& read_edge_name(Fields& fields, const std::string& key, const NamedCloths& cloths) {
  const ClothGroup& group = *cloths.group;
  if (group.edges.empty())
    fields.refuse(key,
                  "vertices, box or group, since cloth \"" + group.name + "\" has no named edges");
  std::vector<std::string> names;
  for (const auto& [name, edge] : group.edges) names.push_back(name);
  return group.edges.at(names[fields.choice(key, names, {})]);
}

std::vector<Index> read_edge(Fields& fields, const NamedCloths& cloths, const Scene& scene) {
  const EdgePart part = read_edge_part(fields, cloths);
  const std::vector<double> along =
      lengths_along(scene.cloths[static_cast<std::size_t>(cloths.first)].mesh, *part.edge);
  const double whole = along.back();
  const double to = part.to.value_or(whole);
  // What is meant as the end of a cell must not miss it by rounding.
  const double slack = 1e-6 * whole;
  std::vector<Index> vertices;
  for (std::size_t i = 0; i < part.edge->vertices.size(); ++i)
    if (along[i] >= part.from - slack && along[i] <= to + slack)
      vertices.push_back(part.edge->vertices[i]);
  if (vertices.empty())
    fields.refuse("edge", "a part with at least one vertex of the edge, which is " +
                              short_text(whole) + " m long");
  return vertices;
}

std::vector<Index> read_group(Fields& fields, const Mesh& mesh) {
  const std::string name = fields.text("group");
  const std::optional<std::vector<Index>> vertices = vertices_in_group(mesh, name);
  if (vertices && !vertices->empty()) return *vertices;
  const std::vector<std::string> known = names_of_groups(mesh);
  if (known.empty())
    fields.refuse("group", "vertices or box, since the mesh of the cloth has no groups");
  std::string allowed = "a group of the mesh with faces: ";
  for (std::size_t k = 0; k < std::min<std::size_t>(known.size(), 8); ++k)
    allowed += (k > 0 ? ", \"" : "\"") + known[k] + "\"";
  const auto nearest = nearest_word(name, known);
  fields.refuse("group", allowed + (known.size() > 8 ? ", ..." : "") +
                             (nearest ? "; did you mean \"" + *nearest + "\"?" : ""));
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

}  // namespace

EdgePart read_edge_part(Fields& fields, const NamedCloths& cloths) {
  if (!fields.is_object("edge")) return {&read_edge_name(fields, "edge", cloths), 0, {}};
  Fields part = fields.object("edge", {"name", "from", "to"});
  EdgePart result{&read_edge_name(part, "name", cloths), 0, {}};
  result.from = part.number("from", 0);
  if (part.has("to")) result.to = part.number("to");
  return result;
}

std::vector<double> lengths_along(const Mesh& mesh, const ClothEdge& edge) {
  const auto position = [&](std::size_t i) {
    return mesh.positions[static_cast<std::size_t>(edge.vertices[i])];
  };
  std::vector<double> along{0};
  for (std::size_t i = 1; i < edge.vertices.size(); ++i)
    along.push_back(along.back() + length(position(i) - position(i - 1)));
  if (edge.closed)
    along.push_back(along.back() + length(position(0) - position(edge.vertices.size() - 1)));
  return along;
}

NamedCloths named_cloths(const Fields& fields, const std::string& key, const std::string& name,
                         const std::vector<ClothGroup>& groups, const Scene& scene) {
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
  fields.refuse(key, "\"" + name + "\"",
                allowed + (nearest ? "; did you mean \"" + *nearest + "\"?" : ""));
}

NamedCloths read_named_cloths(Fields& fields, const std::vector<ClothGroup>& groups,
                              const Scene& scene) {
  return named_cloths(fields, "cloth", fields.text("cloth"), groups, scene);
}

std::vector<std::string> selection_keys() {
  return {"vertices", "corners", "edge", "box", "group"};
}

std::vector<std::vector<Index>> read_selection(Fields& fields, const std::string& key,
                                               const NamedCloths& cloths, const Scene& scene) {
  const auto count = static_cast<std::size_t>(cloths.count);
  const auto in_each = [&](const std::vector<Index>& vertices) {
    return std::vector<std::vector<Index>>(count, vertices);
  };
  if (key == "corners") return in_each(read_corners(fields, cells_of(fields, key, cloths)));
  if (key == "edge") return in_each(read_edge(fields, cloths, scene));
  if (key == "group")
    return in_each(read_group(fields, scene.cloths[static_cast<std::size_t>(cloths.first)].mesh));
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

}  // namespace weft::io
