#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <map>
#include <optional>
#include <set>
#include <utility>

#include "host/geometry/nearest_pairs.hpp"
#include "host/input/counted.hpp"
#include "host/io/scene/scene_parts.hpp"
#include "host/io/scene/scene_selection.hpp"
#include "host/scene/seams/flat_seam.hpp"
#include "host/scene/seams/seam_pairing.hpp"
#include "host/scene/seams/sewn_mesh.hpp"
#include "host/scene/seams/stacked_triangles.hpp"
#include "weft/core/at.hpp"

namespace weft::io {
namespace {

constexpr std::int64_t most = std::numeric_limits<Index>::max();

/// The seams of one entry, one for each copy of the cloths that it names; values still to come.
using Pairing = std::vector<Seam>;

/// Meshes of the cloths that have seams.
class SewnMeshes {
 public:
  explicit SewnMeshes(Scene& scene) : scene_(scene) {}

  SewnMesh& of(Index cloth) {
    return meshes_.try_emplace(cloth, scene_.cloths[at(cloth)]).first->second;
  }
  std::map<Index, SewnMesh>& all() { return meshes_; }

 private:
  Scene& scene_;
  std::map<Index, SewnMesh> meshes_;
};

/// @param sides as the entry names them: cloths with copies are sewn copy by copy
Pairing make_pairing(const Fields& fields, const std::string& key,
                     const std::array<NamedCloths, 2>& sides) {
  if (sides[0].count != sides[1].count)
    fields.refuse(
        key, std::to_string(sides[0].count) + " and " + std::to_string(sides[1].count) + " cloths",
        "as many copies of one as of the other");
  Pairing pairing(at(sides[0].count));
  for (Index k = 0; k < sides[0].count; ++k)
    for (std::size_t side = 0; side < 2; ++side)
      pairing[at(k)].cloths[side] = sides[side].first + k;
  return pairing;
}

/// One after the other.
std::array<NamedCloths, 2> read_sides(Fields& fields, const std::vector<ClothGroup>& groups,
                                      const Scene& scene) {
  const std::vector<std::string> names = fields.texts("cloths", 2);
  return {named_cloths(fields, "cloths[0]", names[0], groups, scene),
          named_cloths(fields, "cloths[1]", names[1], groups, scene)};
}

/// @param key where the number stands, for messages
Index vertex_of(const Fields& fields, const std::string& key, std::int64_t number, Index cloth,
                const Scene& scene) {
  const Cloth& in = scene.cloths[at(cloth)];
  const auto count = static_cast<std::int64_t>(in.mesh.positions.size());
  if (number >= count)
    fields.refuse(
        key, std::to_string(number),
        "0 to " + std::to_string(count - 1) + ", the vertices of cloth \"" + in.name + "\"");
  return static_cast<Index>(number);
}

std::string place(const std::string& key, std::size_t i, std::size_t j) {
  return key + "[" + std::to_string(i) + "][" + std::to_string(j) + "]";
}

Pairing read_pairs(Fields& fields, const std::array<NamedCloths, 2>& sides, const Scene& scene) {
  Pairing pairing = make_pairing(fields, "cloths", sides);
  const auto pairs = fields.integer_lists("pairs", 0, most, {}, 2);
  if (pairs.empty()) fields.refuse("pairs", "at least one pair");
  for (Seam& seam : pairing)
    for (std::size_t k = 0; k < pairs.size(); ++k)
      for (std::size_t side = 0; side < 2; ++side)
        seam.vertices[side].push_back(
            vertex_of(fields, place("pairs", k, side), pairs[k][side], seam.cloths[side], scene));
  return pairing;
}

/// The two sides of a seam, and their meshes.
struct SewnRows {
  SewnRows(const Seam& s, SewnMeshes& meshes)
      : seam(s), mesh{&meshes.of(s.cloths[0]), &meshes.of(s.cloths[1])} {
    std::array<std::vector<Index>, 2> vertices{seam.vertices[0], seam.vertices[1]};
    if (mesh[0] == mesh[1]) {
      vertices[0].insert(vertices[0].end(), vertices[1].begin(), vertices[1].end());
      mesh[0]->look_at(vertices[0]);
    } else {
      for (std::size_t side = 0; side < 2; ++side) mesh[side]->look_at(vertices[side]);
    }
  }
  /// Such as: cloth "front"
  std::string name(std::size_t side) const { return "cloth \"" + mesh[side]->cloth().name + "\""; }

  const Seam& seam;
  std::array<SewnMesh*, 2> mesh;
};

/// Pairs the sides of a seam by their lengths.
/// @param key   for messages
/// @param given the order of the vertices on both sides, if that says what is a pair: the first and
///              the last ones are. The first one again at the end: a closed chain
void pair_lengths(const Fields& fields, const std::string& key, SewnMeshes& meshes, Seam& seam,
                  const std::array<std::vector<Index>, 2>* given = nullptr) {
  const SewnRows sides(seam, meshes);
  const std::string counts = std::to_string(seam.vertices[0].size()) + " and " +
                             counted(seam.vertices[1].size(), "vertex");
  std::array<VertexChain, 2> chains;
  for (std::size_t side = 0; side < 2; ++side) {
    std::optional<VertexChain> chain = chain_of(*sides.mesh[side], seam.vertices[side]);
    if (chain && given != nullptr) chain = in_order((*given)[side], std::move(*chain));
    if (!chain)
      fields.refuse(key, counts + ", those of " + sides.name(side) + " in no row",
                    "on either side two or more vertices that follow each other along edges of "
                    "triangles, or pairs of vertices that start nearest to each other");
    if (!(rest_length(*sides.mesh[side], *chain) > 0))
      fields.refuse(key, counts + ", those of " + sides.name(side) + " at one place",
                    "rows of a length > 0");
    chains[side] = std::move(*chain);
  }
  if (sides.mesh[0] == sides.mesh[1] && overlap(chains[0], chains[1]))
    fields.refuse(key, counts + ", some of them on both sides",
                  "rows that have no vertices in common but their ends");
  std::array<std::vector<Index>, 2> pairs =
      pair_by_length(sides.mesh, std::move(chains), given != nullptr);
  for (std::size_t side = 0; side < 2; ++side) seam.vertices[side] = std::move(pairs[side]);
}

Pairing read_chains(Fields& fields, const std::array<NamedCloths, 2>& sides, const Scene& scene,
                    SewnMeshes& meshes) {
  Pairing pairing = make_pairing(fields, "cloths", sides);
  const auto chains = fields.integer_lists("chains", 0, most, 2, {});
  if (chains[0].empty() || chains[1].empty())
    fields.refuse("chains", "at least one vertex in each");
  for (Seam& seam : pairing) {
    std::array<std::vector<Index>, 2> given;
    for (std::size_t side = 0; side < 2; ++side)
      for (std::size_t k = 0; k < chains[side].size(); ++k)
        given[side].push_back(
            vertex_of(fields, place("chains", side, k), chains[side][k], seam.cloths[side], scene));
    for (std::size_t side = 0; side < 2; ++side) seam.vertices[side] = given[side];
    if (given[0].size() == given[1].size()) continue;
    for (std::size_t side = 0; side < 2; ++side) {
      std::vector<Index>& vertices = seam.vertices[side];
      if (vertices.size() > 2 && vertices.front() == vertices.back()) vertices.pop_back();
      vertices = meshes.of(seam.cloths[side]).with_added(vertices);
    }
    pair_lengths(fields, "chains", meshes, seam, &given);
  }
  return pairing;
}

std::vector<Vec3<double>> positions_of(const Cloth& cloth, const std::vector<Index>& vertices) {
  std::vector<Vec3<double>> positions;
  positions.reserve(vertices.size());
  for (const Index v : vertices) positions.push_back(cloth.mesh.positions[at(v)]);
  return positions;
}

/// Pairs vertices that are nearest to each other. A vertex of both sides is a pair with itself,
/// which is left out: so is the tip of a dart.
/// @param seam holds what was selected on either side; it is changed only if all have a partner
/// @return     whether they have
bool pair_nearest(const Scene& scene, Seam& seam) {
  const auto cloth = [&](std::size_t side) -> const Cloth& {
    return scene.cloths[at(seam.cloths[side])];
  };
  const auto pairs = nearest_pairs(positions_of(cloth(0), seam.vertices[0]),
                                   positions_of(cloth(1), seam.vertices[1]));
  // No vertex is in two of them.
  if (pairs.size() != seam.vertices[0].size() || pairs.size() != seam.vertices[1].size())
    return false;
  std::array<std::vector<Index>, 2> paired;
  for (const auto& [i, j] : pairs) {
    const Index v = seam.vertices[0][at(i)], w = seam.vertices[1][at(j)];
    if (seam.cloths[0] == seam.cloths[1] && v == w) continue;
    paired[0].push_back(v);
    paired[1].push_back(w);
  }
  for (std::size_t side = 0; side < 2; ++side) seam.vertices[side] = std::move(paired[side]);
  return true;
}

/// An edge with the vertices that seams have put on it.
ClothEdge edge_now(SewnMesh& mesh, const ClothEdge& edge) {
  std::vector<Index> vertices = mesh.with_added(edge.vertices);
  if (vertices.size() == edge.vertices.size()) return edge;
  mesh.look_at(vertices);
  std::vector<Index> given = edge.vertices;
  if (edge.closed) given.push_back(given.front());
  std::optional<VertexChain> chain = chain_of(mesh, vertices);
  if (chain) chain = in_order(given, std::move(*chain));
  return chain ? ClothEdge{std::move(chain->vertices), edge.closed} : edge;
}

/// The vertices of a part of an edge. It ends at the vertices nearest to where it is to end, so
/// that parts of seams that end at one place meet in one vertex.
std::vector<Index> vertices_of(const Fields& fields, const EdgePart& part, SewnMesh& mesh) {
  const ClothEdge edge = edge_now(mesh, *part.edge);
  const std::vector<double> along = lengths_along(mesh.cloth().mesh, edge);
  const double to = part.to.value_or(along.back());
  if (part.from <= 0 && to >= along.back()) return edge.vertices;
  if (!(part.from <= to) || part.from > along.back() || to < 0)
    fields.refuse("edge", "a part of the edge, which is " + short_text(along.back()) + " m long");
  const auto nearest = [&](double length) {
    const auto after = std::lower_bound(along.begin() + 1, along.end() - 1, length);
    const auto i = static_cast<std::size_t>(after - along.begin());
    return length - along[i - 1] <= along[i] - length ? i - 1 : i;
  };
  std::vector<Index> vertices;
  for (std::size_t i = nearest(part.from); i <= nearest(to); ++i)
    vertices.push_back(edge.vertices[i % edge.vertices.size()]);
  return vertices;
}

/// What a selection means in each of the cloths, with what seams have put between its vertices.
std::vector<std::vector<Index>> read_seam_selection(Fields& fields, const NamedCloths& cloths,
                                                    const Scene& scene, SewnMeshes& meshes) {
  const std::string key = fields.one_of(selection_keys());
  std::vector<std::vector<Index>> selected;
  if (key == "edge") {
    const EdgePart part = read_edge_part(fields, cloths);
    for (Index k = 0; k < cloths.count; ++k)
      selected.push_back(vertices_of(fields, part, meshes.of(cloths.first + k)));
  } else {
    selected = read_selection(fields, key, cloths, scene);
  }
  for (std::size_t k = 0; k < selected.size(); ++k) {
    std::vector<Index>& vertices = selected[k];
    vertices = meshes.of(cloths.first + static_cast<Index>(k)).with_added(std::move(vertices));
    std::sort(vertices.begin(), vertices.end());
    vertices.erase(std::unique(vertices.begin(), vertices.end()), vertices.end());
  }
  return selected;
}

Pairing read_between(Fields& fields, const std::vector<ClothGroup>& groups, const Scene& scene,
                     SewnMeshes& meshes) {
  if (fields.has("cloths"))
    fields.refuse("cloths", "each selection of between with a cloth of its own");
  std::vector<std::string> keys = selection_keys();
  keys.emplace_back("cloth");
  std::vector<Fields> ends = fields.objects("between", keys);
  if (ends.size() != 2) fields.refuse("between", "a list of two selections");
  std::array<NamedCloths, 2> sides;
  std::array<std::vector<std::vector<Index>>, 2> selected;
  for (std::size_t side = 0; side < 2; ++side) {
    sides[side] = read_named_cloths(ends[side], groups, scene);
    selected[side] = read_seam_selection(ends[side], sides[side], scene, meshes);
  }
  Pairing pairing = make_pairing(fields, "between", sides);
  for (std::size_t k = 0; k < pairing.size(); ++k) {
    Seam& seam = pairing[k];
    for (std::size_t side = 0; side < 2; ++side) seam.vertices[side] = std::move(selected[side][k]);
    // A box may miss some of the copies on both sides.
    if (seam.vertices[0].empty() && seam.vertices[1].empty()) continue;
    if (!pair_nearest(scene, seam)) pair_lengths(fields, "between", meshes, seam);
    if (seam.vertices[0].empty())
      fields.refuse("between", "the same vertices on both sides", "two different rows of vertices");
  }
  std::erase_if(pairing, [](const Seam& seam) { return seam.vertices[0].empty(); });
  return pairing;
}

/// Cloth and vertex, twice, the smaller first.
using SewnPair = std::array<std::array<Index, 2>, 2>;

SewnPair pair_of(const Seam& seam, std::size_t k) {
  SewnPair pair{{{seam.cloths[0], seam.vertices[0][k]}, {seam.cloths[1], seam.vertices[1][k]}}};
  if (pair[1] < pair[0]) std::swap(pair[0], pair[1]);
  return pair;
}

/// Leaves out pairs that are sewn already, as the corner of two edges is.
void drop_sewn(const std::set<SewnPair>& sewn, Seam& seam) {
  std::array<std::vector<Index>, 2> left;
  for (std::size_t k = 0; k < seam.vertices[0].size(); ++k) {
    if (sewn.contains(pair_of(seam, k))) continue;
    for (std::size_t side = 0; side < 2; ++side) left[side].push_back(seam.vertices[side][k]);
  }
  for (std::size_t side = 0; side < 2; ++side) seam.vertices[side] = std::move(left[side]);
}

/// Parts triangles that welding would lay on each other, as at the corners of two panels whose
/// diagonals meet: the inner edge of one of them gets a vertex that is not sewn.
void part_stacked_triangles(const Scene& scene, SewnMeshes& meshes) {
  const std::vector<StackedTriangles> stacked = stacked_triangles(scene);
  std::map<Index, std::vector<Index>> corners;  // by cloth
  for (const StackedTriangles& pair : stacked)
    for (std::size_t k = 0; k < 2; ++k)
      for (const Index v : scene.cloths[at(pair.cloth[k])].mesh.triangles[at(pair.triangle[k])].v)
        corners[pair.cloth[k]].push_back(v);
  for (const auto& [cloth, vertices] : corners) meshes.of(cloth).look_at(vertices);
  const auto part = [&](Index cloth, Index triangle) {
    SewnMesh& mesh = meshes.of(cloth);
    const Tri t = mesh.cloth().mesh.triangles[at(triangle)];
    std::vector<std::array<Index, 2>> inner;
    for (int j = 0; j < 3; ++j) {
      const std::array<Index, 2> edge{std::min(t.v[j], t.v[(j + 1) % 3]),
                                      std::max(t.v[j], t.v[(j + 1) % 3])};
      if (mesh.edges().at(edge).size() == 2) inner.push_back(edge);
    }
    if (inner.size() != 1) return false;
    mesh.split(inner[0][0], inner[0][1], 0.5);
    return true;
  };
  for (const StackedTriangles& pair : stacked)
    if (!part(pair.cloth[1], pair.triangle[1])) part(pair.cloth[0], pair.triangle[0]);
}

/// Vertices that were put between two others are held and drawn as both of these are.
void follow(const SewnMesh& mesh, std::vector<Index>& vertices) {
  vertices = mesh.with_added(std::move(vertices));
}

void follow_added(SewnMeshes& meshes, Scene& scene) {
  for (Pin& pin : scene.pins) follow(meshes.of(pin.cloth), pin.vertices);
  for (Handle& handle : scene.handles)
    if (handle.shape != Handle::Shape::glue) follow(meshes.of(handle.cloth), handle.vertices);
  for (const auto& [cloth, mesh] : meshes.all())
    if (!mesh.added().empty())
      scene.warnings.push_back("cloth \"" + mesh.cloth().name + "\" gets " +
                               std::to_string(mesh.added().size()) +
                               (mesh.added().size() == 1 ? " vertex" : " vertices") +
                               " more, so that all vertices of its seams have partners and no "
                               "triangles lie on each other");
}

/// @param path of the seam, for the message
void warn_of_flat_cloth(const std::string& path, const Seam& seam, Scene& scene) {
  const Cloth& cloth = scene.cloths[at(seam.cloths[0])];
  if (!crushes_flat_cloth(cloth, seam)) return;
  scene.warnings.push_back(path + ": it sews cloth \"" + cloth.name +
                           "\", which starts flat, to itself across its own plane, and so crushes "
                           "it; use a \"cylinder\", or a mesh that is rolled already");
}

}  // namespace

void read_seams(Fields& root, const std::vector<ClothGroup>& groups, Scene& scene) {
  std::set<SewnPair> sewn;
  SewnMeshes meshes(scene);
  for (Fields& fields :
       root.objects("seams", {"pairs", "chains", "between", "cloths", "stiffness", "start_time",
                              "ramp_time", "weld_distance", "may_stay_open"})) {
    const std::string kind = fields.one_of({"pairs", "chains", "between"});
    Pairing pairing;
    if (kind == "between")
      pairing = read_between(fields, groups, scene, meshes);
    else if (kind == "pairs")
      pairing = read_pairs(fields, read_sides(fields, groups, scene), scene);
    else
      pairing = read_chains(fields, read_sides(fields, groups, scene), scene, meshes);
    Seam values;
    values.stiffness = fields.number_or_null("stiffness");
    if (values.stiffness) fields.number("stiffness", quantity::stiffness);
    values.start_time = fields.number("start_time", values.start_time);
    values.ramp_time = fields.number("ramp_time", values.ramp_time);
    values.weld_distance = fields.number("weld_distance", contact_thickness(scene.contact));
    values.may_stay_open = fields.boolean("may_stay_open", values.may_stay_open);
    for (Seam& seam : pairing) {
      if (kind == "between") drop_sewn(sewn, seam);
      if (seam.vertices[0].empty())
        fields.refuse("between", "only pairs that are sewn already", "at least one other");
      for (std::size_t k = 0; k < seam.vertices[0].size(); ++k) sewn.insert(pair_of(seam, k));
      seam.stiffness = values.stiffness;
      seam.start_time = values.start_time;
      seam.ramp_time = values.ramp_time;
      seam.weld_distance = values.weld_distance;
      seam.may_stay_open = values.may_stay_open;
      warn_of_flat_cloth(fields.path_of(kind), seam, scene);
      scene.seams.push_back(std::move(seam));
    }
  }
  if (scene.seams.empty()) return;
  part_stacked_triangles(scene, meshes);
  follow_added(meshes, scene);
}

void read_refinement(Fields& root, Scene& scene) {
  const bool given = root.has("refine");
  Fields fields = root.object("refine", {"when", "levels"});
  // What is given must say when; only what is not given means never.
  const auto fallback = given ? std::optional<std::size_t>{} : std::optional<std::size_t>{0};
  scene.refinement.when = fields.choice("when", {"never", "sewn"}, fallback) == 0
                              ? Refinement::When::never
                              : Refinement::When::sewn;
  scene.refinement.levels =
      static_cast<int>(fields.integer("levels", scene.refinement.levels, 1, 6));
}

}  // namespace weft::io
