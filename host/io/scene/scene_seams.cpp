#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <set>
#include <utility>

#include "host/geometry/nearest_pairs.hpp"
#include "host/io/scene/scene_parts.hpp"
#include "host/io/scene/scene_selection.hpp"

namespace weft::io {
namespace {

constexpr std::int64_t most = std::numeric_limits<Index>::max();

/// The seams of one entry, one for each copy of the cloths that it names; values still to come.
using Pairing = std::vector<Seam>;

std::size_t at(Index i) {
  return static_cast<std::size_t>(i);
}

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

/// "cloth": both sides, or "cloths": one after the other.
std::array<NamedCloths, 2> read_sides(Fields& fields, const std::vector<ClothGroup>& groups,
                                      const Scene& scene) {
  if (fields.one_of({"cloth", "cloths"}) == "cloth") {
    const NamedCloths both = read_named_cloths(fields, groups, scene);
    return {both, both};
  }
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

Pairing read_chains(Fields& fields, const std::array<NamedCloths, 2>& sides, const Scene& scene) {
  Pairing pairing = make_pairing(fields, "cloths", sides);
  const auto chains = fields.integer_lists("chains", 0, most, 2, {});
  if (chains[0].size() != chains[1].size())
    fields.refuse(
        "chains",
        std::to_string(chains[0].size()) + " and " + std::to_string(chains[1].size()) + " vertices",
        "chains of one length");
  if (chains[0].empty()) fields.refuse("chains", "at least one vertex in each");
  for (Seam& seam : pairing)
    for (std::size_t side = 0; side < 2; ++side)
      for (std::size_t k = 0; k < chains[side].size(); ++k)
        seam.vertices[side].push_back(
            vertex_of(fields, place("chains", side, k), chains[side][k], seam.cloths[side], scene));
  return pairing;
}

std::vector<Vec3<double>> positions_of(const Cloth& cloth, const std::vector<Index>& vertices) {
  std::vector<Vec3<double>> positions;
  positions.reserve(vertices.size());
  for (const Index v : vertices) positions.push_back(cloth.mesh.positions[at(v)]);
  return positions;
}

/// Keeps only pairs of vertices that are nearest to each other.
/// @param seam holds what was selected on either side
void pair_nearest(const Fields& fields, const Scene& scene, Seam& seam) {
  const auto refuse = [&](const std::string& value) {
    fields.refuse("between", value,
                  "two selections of as many vertices, which all have a partner: one that is "
                  "nearest to them, and they to it");
  };
  const auto cloth = [&](std::size_t side) -> const Cloth& {
    return scene.cloths[at(seam.cloths[side])];
  };
  const auto pairs = nearest_pairs(positions_of(cloth(0), seam.vertices[0]),
                                   positions_of(cloth(1), seam.vertices[1]));
  std::array<std::vector<Index>, 2> paired;
  std::array<std::vector<bool>, 2> has_partner;
  for (std::size_t side = 0; side < 2; ++side)
    has_partner[side].assign(seam.vertices[side].size(), false);
  for (const auto& [i, j] : pairs) {
    paired[0].push_back(seam.vertices[0][at(i)]);
    paired[1].push_back(seam.vertices[1][at(j)]);
    has_partner[0][at(i)] = true;
    has_partner[1][at(j)] = true;
  }
  for (std::size_t side = 0; side < 2; ++side)
    for (std::size_t k = 0; k < has_partner[side].size(); ++k)
      if (!has_partner[side][k])
        refuse(std::to_string(seam.vertices[0].size()) + " and " +
               std::to_string(seam.vertices[1].size()) + " vertices, vertex " +
               std::to_string(seam.vertices[side][k]) + " of cloth \"" + cloth(side).name +
               "\" without a partner");
  for (std::size_t side = 0; side < 2; ++side) seam.vertices[side] = std::move(paired[side]);
}

Pairing read_between(Fields& fields, const std::vector<ClothGroup>& groups, const Scene& scene) {
  for (const char* key : {"cloth", "cloths"})
    if (fields.has(key)) fields.refuse(key, "each selection of between with a cloth of its own");
  std::vector<std::string> keys = selection_keys();
  keys.emplace_back("cloth");
  std::vector<Fields> ends = fields.objects("between", keys);
  if (ends.size() != 2) fields.refuse("between", "a list of two selections");
  std::array<NamedCloths, 2> sides;
  std::array<std::vector<std::vector<Index>>, 2> selected;
  for (std::size_t side = 0; side < 2; ++side) {
    sides[side] = read_named_cloths(ends[side], groups, scene);
    selected[side] =
        read_selection(ends[side], ends[side].one_of(selection_keys()), sides[side], scene);
    for (std::vector<Index>& vertices : selected[side]) {
      std::sort(vertices.begin(), vertices.end());
      vertices.erase(std::unique(vertices.begin(), vertices.end()), vertices.end());
    }
  }
  Pairing pairing = make_pairing(fields, "between", sides);
  for (std::size_t k = 0; k < pairing.size(); ++k) {
    for (std::size_t side = 0; side < 2; ++side)
      pairing[k].vertices[side] = std::move(selected[side][k]);
    pair_nearest(fields, scene, pairing[k]);
  }
  // A box may miss some of the copies on both sides.
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

}  // namespace

void read_seams(Fields& root, const std::vector<ClothGroup>& groups, Scene& scene) {
  std::set<SewnPair> sewn;
  for (Fields& fields :
       root.objects("seams", {"pairs", "chains", "between", "cloth", "cloths", "stiffness",
                              "start_time", "ramp_time", "weld_distance", "may_stay_open"})) {
    const std::string kind = fields.one_of({"pairs", "chains", "between"});
    Pairing pairing;
    if (kind == "between")
      pairing = read_between(fields, groups, scene);
    else if (kind == "pairs")
      pairing = read_pairs(fields, read_sides(fields, groups, scene), scene);
    else
      pairing = read_chains(fields, read_sides(fields, groups, scene), scene);
    Seam values;
    values.stiffness = fields.number("stiffness", quantity::stiffness, values.stiffness);
    values.start_time = fields.number("start_time", values.start_time);
    values.ramp_time = fields.number("ramp_time", values.ramp_time);
    values.weld_distance = fields.number("weld_distance", scene.contact.thickness);
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
      scene.seams.push_back(std::move(seam));
    }
  }
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
