#include "host/app/worn_check.hpp"

#include <algorithm>
#include <cstddef>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <numeric>
#include <optional>
#include <set>
#include <utility>

#include "host/app/render/run_scene.hpp"
#include "host/base/file_bytes.hpp"
#include "host/input/counted.hpp"
#include "host/io/animation/mesh_sequence.hpp"
#include "host/io/mesh/mesh_file.hpp"
#include "host/io/mesh/split_objects.hpp"
#include "host/io/mesh/welded_mesh.hpp"
#include "weft/core/at.hpp"
#include "weft/error.hpp"

namespace weft::app {
namespace {

namespace fs = std::filesystem;
using io::NamedMesh;

/// Obstacles of a frame one by one, in world places.
std::vector<NamedMesh> bodies_of(const io::FrameMeshes& frame) {
  std::vector<NamedMesh> bodies = frame.obstacles;
  if (bodies.size() == 1) bodies = io::split_objects(std::move(bodies[0]));
  return bodies;
}

/// Cloths of a frame one by one.
std::vector<NamedMesh> cloths_of(const io::FrameMeshes& frame) {
  return frame.joined ? io::split_objects(frame.cloths.front()) : frame.cloths;
}

/// The one that wears: as named, else "body", else the only one.
Mesh body_of(std::vector<NamedMesh> bodies, const std::string& name, const std::string& input) {
  if (bodies.empty())
    throw SceneError(input, "--worn", "no obstacle", "frames with a body, or --obstacle MESH");
  std::string names;
  for (NamedMesh& b : bodies) {
    if (b.name == (name.empty() ? "body" : name)) return std::move(b.mesh);
    names += (names.empty() ? "" : ", ") + b.name;
  }
  if (name.empty() && bodies.size() == 1) return std::move(bodies[0].mesh);
  throw SceneError(input, "--body", name.empty() ? "nothing" : name, "one of " + names);
}

lab::BodySegmentation read_segmentation(const std::string& file, std::size_t vertices) {
  lab::BodySegmentation result;
  if (file.empty()) return result;
  const nlohmann::json json = nlohmann::json::parse(read_file_bytes(file), nullptr, false);
  const std::string allowed = "an object of lists of vertex numbers below " +
                              std::to_string(vertices) + ", by name of the part";
  if (!json.is_object() || json.empty())
    throw SceneError(file, "--segmentation", "no object", allowed);
  for (const auto& [name, list] : json.items()) {
    if (!list.is_array()) throw SceneError(file, name, "no list", allowed);
    result.emplace_back(name, std::vector<Index>());
    for (const nlohmann::json& v : list) {
      const bool whole = v.is_number_integer();
      const bool in_range =
          whole && v.get<double>() >= 0 && v.get<double>() < static_cast<double>(vertices);
      if (!in_range) throw SceneError(file, name, v.dump(), allowed);
      result.back().second.push_back(v.get<Index>());
    }
  }
  return result;
}

/// All cloths as one mesh whose parts are their panels: the labels of these, else parts, else
/// groups, else the cloths. Its groups are called by all names of a panel.
Mesh with_panels(const std::vector<NamedMesh>& cloths) {
  Mesh all = io::joined(cloths);
  for (const auto& [name, mesh] : cloths) {
    const std::size_t count = mesh.triangles.size();
    const bool parts = mesh.part.size() == count;
    const bool any = parts || mesh.group.size() == count;
    std::vector<std::string> names = !any    ? std::vector{name.empty() ? "cloth" : name}
                                     : parts ? mesh.part_names
                                             : mesh.group_names;
    for (std::size_t t = 0; t < count; ++t) {
      std::string called = mesh.group.size() == count ? mesh.group_names[at(mesh.group[t])] : "";
      if (parts) called += " " + mesh.part_names[at(mesh.part[t])];
      if (t == 0 || called != all.group_names.back()) all.group_names.push_back(called);
      all.group.push_back(static_cast<Index>(all.group_names.size()) - 1);
    }
    for (std::size_t p = 0; parts && p < mesh.part_labels.size(); ++p)
      if (!mesh.part_labels[p].empty()) names[p] = mesh.part_labels[p];
    // Panels of one label count as one.
    std::vector<Index> number;
    const std::size_t first = all.part_names.size();
    for (const std::string& own : names) {
      const auto begin = all.part_names.begin() + static_cast<std::ptrdiff_t>(first);
      const auto found = std::find(begin, all.part_names.end(), own);
      number.push_back(static_cast<Index>(found - all.part_names.begin()));
      if (found == all.part_names.end()) all.part_names.push_back(own);
    }
    for (std::size_t t = 0; t < count; ++t)
      all.part.push_back(number[any ? at((parts ? mesh.part : mesh.group)[t]) : 0]);
  }
  return all;
}

/// Gives a frame the panels of the scene's cloths if these are the same meshes with more names.
void take_panels(const Scene& scene, Mesh& frame) {
  std::vector<NamedMesh> cloths;
  for (const Cloth& c : scene.cloths) cloths.push_back({c.name, c.mesh});
  Mesh given = with_panels(cloths);
  const auto same = [](const Tri& a, const Tri& b) {
    return a.v[0] == b.v[0] && a.v[1] == b.v[1] && a.v[2] == b.v[2];
  };
  if (given.part_names.size() <= frame.part_names.size() ||
      !std::equal(given.triangles.begin(), given.triangles.end(), frame.triangles.begin(),
                  frame.triangles.end(), same))
    return;
  frame.part = std::move(given.part);
  frame.part_names = std::move(given.part_names);
  frame.group = std::move(given.group);
  frame.group_names = std::move(given.group_names);
}

/// Calls garments as the cloths that they are, with their panels where a cloth is several garments.
/// @param cloth    all of them as one mesh
/// @param garments in the order of their first triangles
void name_garments(const std::vector<NamedMesh>& cloths, const Mesh& cloth, bool sewn,
                   std::vector<lab::GarmentVerdict>& garments) {
  io::Weld weld;
  if (sewn) weld.add(cloth.positions);
  const auto place = [&](Index v) { return sewn ? weld.numbers()[at(v)] : v; };
  std::vector<Index> parent(cloth.positions.size());
  std::iota(parent.begin(), parent.end(), Index{0});
  const auto root = [&](Index v) {
    while (parent[at(v)] != v) v = parent[at(v)] = parent[at(parent[at(v)])];
    return v;
  };
  for (const Tri& t : cloth.triangles)
    for (int k = 1; k < 3; ++k) {
      const Index a = root(place(t.v[0])), b = root(place(t.v[k]));
      parent[at(std::max(a, b))] = std::min(a, b);
    }
  std::set<Index> found;
  std::vector<std::size_t> owner;            // [garments] cloth
  std::vector<int> count(cloths.size(), 0);  // of garments
  std::size_t c = 0, end = cloths.empty() ? 0 : cloths[0].mesh.triangles.size();
  for (std::size_t t = 0; t < cloth.triangles.size(); ++t) {
    while (t >= end && c + 1 < cloths.size()) end += cloths[++c].mesh.triangles.size();
    if (!found.insert(root(place(cloth.triangles[t].v[0]))).second) continue;
    owner.push_back(c);
    ++count[c];
  }
  if (owner.size() != garments.size()) return;
  for (std::size_t g = 0; g < garments.size(); ++g) {
    const std::string& name = cloths[owner[g]].name;
    if (!name.empty())
      garments[g].name = count[owner[g]] == 1 ? name : name + " (" + garments[g].name + ")";
  }
}

bool moves(const Obstacle& o) {
  return !o.motion.empty() || o.deformation || o.driven || o.live;
}

}  // namespace

WornOutcome check_worn(const WornRequest& request) {
  const auto sequence = io::open_sequence(request.input, io::Uv::material, request.allowed);
  const auto& numbers = sequence->frames();
  io::FrameMeshes last = io::in_world(sequence->read(numbers.size() - 1));
  Mesh cloth = with_panels(cloths_of(last));
  const auto other = [&]() -> std::vector<NamedMesh> {
    return {{"body", io::read_mesh(request.obstacle, io::Uv::ignore,
                                   ReadableFolders(request.obstacle, request.allowed))}};
  };
  const Mesh body =
      body_of(request.obstacle.empty() ? bodies_of(last) : other(), request.body, request.input);
  const std::optional<Scene> scene = fs::is_directory(request.input)
                                         ? scene_of_run(request.input, request.allowed).scene
                                         : std::nullopt;
  if (scene) take_panels(*scene, cloth);
  std::vector<Vec3<double>> cloth_start, body_start;
  if (!request.start.empty()) {
    cloth_start = io::read_mesh(request.start, io::Uv::ignore,
                                ReadableFolders(request.start, request.allowed))
                      .positions;
    if (cloth_start.size() != cloth.positions.size())
      throw SceneError(request.start, "--start", counted(cloth_start.size(), "vertex"),
                       std::to_string(cloth.positions.size()) + ", as the cloth has");
  } else if (numbers.front() == 0 && numbers.size() > 1) {
    const io::FrameMeshes first = io::in_world(sequence->read(0));
    cloth_start = io::joined(first.cloths).positions;
    if (request.obstacle.empty())
      body_start = body_of(bodies_of(first), request.body, request.input).positions;
  } else if (scene && std::none_of(scene->obstacles.begin(), scene->obstacles.end(), moves)) {
    for (const Cloth& c : scene->cloths)
      cloth_start.insert(cloth_start.end(), c.mesh.positions.begin(), c.mesh.positions.end());
  }
  const lab::BodySegmentation segmentation =
      read_segmentation(request.segmentation, body.positions.size());
  lab::WornInput input{cloth, body, nullptr, nullptr, {0, 0, 1}, true, segmentation, {}};
  if (!cloth_start.empty()) input.cloth_start = &cloth_start;
  if (!body_start.empty()) input.body_start = &body_start;
  input.sewn = request.sewn;
  if (scene && length(scene->gravity) > 0)
    input.up = scene->gravity * (-1 / length(scene->gravity));
  WornOutcome outcome{lab::worn(input), input.cloth_start != nullptr};
  name_garments(cloths_of(last), cloth, request.sewn, outcome.garments);
  return outcome;
}

}  // namespace weft::app
