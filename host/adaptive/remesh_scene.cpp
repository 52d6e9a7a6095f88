#include "host/adaptive/remesh_scene.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <map>
#include <utility>

#include "host/adaptive/remesh.hpp"
#include "weft/core/at.hpp"

namespace weft {
namespace {

/// Sizes that a scene leaves open, in mean edges of its mesh.
constexpr double default_min = 1.5;
constexpr double default_max = 8 * default_min;

/// Whether a pin also holds what is put between its vertices. One or two are points by which a
/// cloth hangs, even where an edge of a coarse mesh happens to join them.
bool holds_between(const Pin& pin) {
  return pin.vertices.size() > 2;
}

/// The scene's cloths as one surface, and back.
class Assembly {
 public:
  Assembly(const Scene& scene, const std::vector<Index>& joined,
           const std::vector<unsigned char>& kept, InputState state)
      : scene_(scene), offsets_(input_offsets(scene)) {
    m.positions = std::move(state.positions);
    m.velocities = std::move(state.velocities);
    m.previous_velocities = std::move(state.previous_velocities);
    m.kept = kept;
    m.place = joined;
    const std::size_t count = m.positions.size();
    m.heavy.assign(count, 0);
    for (std::size_t i = 0; i < count; ++i) {
      m.parents.push_back({static_cast<Index>(i), static_cast<Index>(i)});
      if (joined[i] != static_cast<Index>(i)) m.heavy[i] = m.heavy[at(joined[i])] = 1;
    }
    for (std::size_t c = 0; c < scene.cloths.size(); ++c) add_cloth(c);
    add_holds();
    connect(m);
    lock_seams();
  }

  SurfaceMesh m;
  PinSets pins;

  /// The scene with the surface as it is now.
  SceneRemesh finish(const RemeshCounts& counts) const;

 private:
  void add_cloth(std::size_t c);
  void add_holds();
  void lock_seams();
  Index kind_of(const TriangleKind& kind);
  Mesh mesh_of(std::size_t c, const std::vector<Index>& local) const;

  const Scene& scene_;
  std::vector<Index> offsets_;
  std::map<std::array<Index, 3>, Index> kind_numbers_;
};

Index Assembly::kind_of(const TriangleKind& kind) {
  const auto [place, fresh] = kind_numbers_.try_emplace({kind.cloth, kind.material, kind.group},
                                                        static_cast<Index>(m.kinds.size()));
  if (fresh) m.kinds.push_back(kind);
  return place->second;
}

void Assembly::add_cloth(std::size_t c) {
  const Cloth& cloth = scene_.cloths[c];
  const Mesh& mesh = cloth.mesh;
  m.starts.insert(m.starts.end(), mesh.positions.begin(), mesh.positions.end());
  const auto first_corner = static_cast<Index>(m.material.size());
  m.material.insert(m.material.end(), mesh.material.begin(), mesh.material.end());
  const bool own = !mesh.material_triangles.empty();
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    Tri tri = mesh.triangles[t];
    Tri corner = own ? mesh.material_triangles[t] : tri;
    for (int j = 0; j < 3; ++j) {
      tri.v[j] += offsets_[c];
      corner.v[j] += first_corner;
    }
    const Index material =
        cloth.triangle_material.empty() ? cloth.material : cloth.triangle_material[t];
    m.triangles.push_back(tri);
    m.corners.push_back(corner);
    m.kind.push_back(
        kind_of({static_cast<Index>(c), material, mesh.group.empty() ? -1 : mesh.group[t],
                 scene_.materials[at(material)].density}));
  }
}

void Assembly::add_holds() {
  std::vector<std::vector<Index>> holding(m.positions.size());
  for (std::size_t p = 0; p < scene_.pins.size(); ++p)
    for (const Index v : scene_.pins[p].vertices) {
      const auto input = at(offsets_[at(scene_.pins[p].cloth)] + v);
      m.heavy[input] = 1;
      if (!holds_between(scene_.pins[p])) continue;
      auto& list = holding[input];
      if (list.empty() || list.back() != static_cast<Index>(p))
        list.push_back(static_cast<Index>(p));
    }
  for (const std::vector<Index>& list : holding) m.hold.push_back(pins.number(list));
}

/// Edges of the outline that run along a seam to another vertex stay as they are.
void Assembly::lock_seams() {
  std::vector<SeamPair> pairs = seam_pairs(scene_);
  std::vector<unsigned char> sewn(m.positions.size(), 0);
  for (const SeamPair& pair : pairs)
    for (const Index v : pair.v) sewn[at(v)] = 1;
  for (Index h = 0; h < static_cast<Index>(m.twin.size()); ++h)
    m.locked[at(h)] = m.twin[at(h)] < 0 && sewn[at(m.from(h))] != 0 && sewn[at(m.to(h))] != 0;
  std::erase_if(pairs, [](const SeamPair& pair) { return !(pair.weld_distance > 0); });
  const std::vector<Index> places = grouped(m.positions.size(), pairs);
  m.sewn.assign(m.positions.size(), -1);
  for (const SeamPair& pair : pairs)
    for (const Index v : pair.v) m.sewn[at(v)] = places[at(v)];
}

/// @param local [vertices] number within its cloth, -1: it is gone
Mesh Assembly::mesh_of(std::size_t c, const std::vector<Index>& local) const {
  const Mesh& before = scene_.cloths[c].mesh;
  Mesh mesh;
  mesh.group_names = before.group_names;
  const bool own = !before.material_triangles.empty();
  for (std::size_t t = 0; t < m.triangles.size(); ++t) {
    if (m.kind[t] < 0 || m.kinds[at(m.kind[t])].cloth != static_cast<Index>(c)) continue;
    Tri tri = m.triangles[t];
    for (Index& v : tri.v) {
      v = local[at(v)];
      mesh.positions.resize(std::max(mesh.positions.size(), at(v) + 1));
    }
    mesh.triangles.push_back(tri);
    if (!before.group.empty()) mesh.group.push_back(m.kinds[at(m.kind[t])].group);
    for (int j = 0; j < 3; ++j) mesh.positions[at(tri.v[j])] = m.starts[at(m.triangles[t].v[j])];
    if (own) {
      mesh.material_triangles.push_back(m.corners[t]);
      continue;
    }
    mesh.material.resize(mesh.positions.size());
    for (int j = 0; j < 3; ++j) mesh.material[at(tri.v[j])] = m.material[at(m.corners[t].v[j])];
  }
  if (!own) return mesh;
  // Corners in use, in their order.
  std::vector<Index> number(m.material.size(), -1);
  for (const Tri& t : mesh.material_triangles)
    for (const Index u : t.v) number[at(u)] = 0;
  for (std::size_t u = 0; u < number.size(); ++u) {
    if (number[u] < 0) continue;
    number[u] = static_cast<Index>(mesh.material.size());
    mesh.material.push_back(m.material[u]);
  }
  for (Tri& t : mesh.material_triangles)
    for (Index& u : t.v) u = number[at(u)];
  return mesh;
}

SceneRemesh Assembly::finish(const RemeshCounts& counts) const {
  // The cloth of each vertex, by its parents, which come before it.
  std::vector<Index> cloth(m.positions.size());
  for (std::size_t v = 0; v < cloth.size(); ++v) {
    const Index parent = m.parents[v][0];
    cloth[v] = parent == static_cast<Index>(v)
                   ? static_cast<Index>(std::upper_bound(offsets_.begin(), offsets_.end(), parent) -
                                        offsets_.begin() - 1)
                   : cloth[at(parent)];
  }
  SceneRemesh result{counts, scene_};
  Scene& scene = result.scene;
  std::vector<Index> local(m.positions.size(), -1);
  std::vector<std::vector<Index>> held(scene.pins.size());
  for (std::size_t c = 0; c < scene.cloths.size(); ++c) {
    Index next = 0;
    for (std::size_t v = 0; v < cloth.size(); ++v) {
      if (cloth[v] != static_cast<Index>(c) || m.leaving[v] < 0) continue;
      local[v] = next++;
      result.state.positions.push_back(m.positions[v]);
      result.state.velocities.push_back(m.velocities[v]);
      if (!m.previous_velocities.empty())
        result.state.previous_velocities.push_back(m.previous_velocities[v]);
      result.input_before.push_back(m.parents[v][0] == static_cast<Index>(v) ? static_cast<Index>(v)
                                                                             : -1);
      result.kept.push_back(m.kept[v]);
      for (const Index p : pins.pins(m.hold[v])) held[at(p)].push_back(local[v]);
    }
  }
  const auto renumber = [&](Index of_cloth, std::vector<Index>& vertices) {
    for (Index& v : vertices) v = local[at(offsets_[at(of_cloth)] + v)];
  };
  for (std::size_t p = 0; p < held.size(); ++p)
    if (holds_between(scene.pins[p]))
      scene.pins[p].vertices = std::move(held[p]);
    else
      renumber(scene.pins[p].cloth, scene.pins[p].vertices);
  for (Handle& handle : scene.handles) renumber(handle.cloth, handle.vertices);
  for (Seam& seam : scene.seams)
    for (int side = 0; side < 2; ++side) renumber(seam.cloths[side], seam.vertices[side]);
  for (std::size_t c = 0; c < scene.cloths.size(); ++c) {
    Cloth& owner = scene.cloths[c];
    owner.mesh = mesh_of(c, local);
    if (owner.triangle_material.empty()) continue;
    owner.triangle_material.clear();
    for (std::size_t t = 0; t < m.triangles.size(); ++t)
      if (m.kind[t] >= 0 && m.kinds[at(m.kind[t])].cloth == static_cast<Index>(c))
        owner.triangle_material.push_back(m.kinds[at(m.kind[t])].material);
  }
  return result;
}

}  // namespace

std::vector<unsigned char> named_inputs(const Scene& scene) {
  const std::vector<Index> offsets = input_offsets(scene);
  std::vector<unsigned char> named(at(offsets.back()), free_to_go);
  const auto name = [&](Index cloth, const std::vector<Index>& vertices,
                        Keeping keeping = always_kept) {
    for (const Index v : vertices) {
      unsigned char& own = named[at(offsets[at(cloth)] + v)];
      if (own != always_kept) own = keeping;
    }
  };
  // What a pin attaches to an obstacle follows that vertex by vertex.
  for (const Pin& pin : scene.pins)
    name(pin.cloth, pin.vertices,
         holds_between(pin) && pin.obstacle < 0 ? kept_as_corner : always_kept);
  for (const Handle& handle : scene.handles) name(handle.cloth, handle.vertices);
  for (const Seam& seam : scene.seams)
    for (int side = 0; side < 2; ++side) name(seam.cloths[side], seam.vertices[side]);
  return named;
}

Remeshing remeshing_of(const Scene& scene, const Cloth& cloth) {
  Remeshing result = cloth.remeshing.value_or(scene.adaptive.remeshing);
  if (result.size_min > 0) return result;
  const Mesh& mesh = cloth.mesh;
  double area = 0;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const Tri& c = mesh.material_triangles.empty() ? mesh.triangles[t] : mesh.material_triangles[t];
    const Vec2<double> a = mesh.material[at(c.v[1])] - mesh.material[at(c.v[0])];
    const Vec2<double> b = mesh.material[at(c.v[2])] - mesh.material[at(c.v[0])];
    area += std::abs(a[0] * b[1] - a[1] * b[0]) / 2;
  }
  const double edge = std::sqrt(2 * area / static_cast<double>(mesh.triangles.size()));
  result.size_min = default_min * edge;
  result.size_max = default_max * edge;
  return result;
}

SceneRemesh remesh_scene(const Scene& scene, const std::vector<Index>& joined,
                         const std::vector<unsigned char>& kept, InputState state,
                         const Surroundings& around, const EnergyBudget& budget,
                         const ViewField* view) {
  Assembly assembly(scene, joined, kept, std::move(state));
  RemeshOptions options;
  for (const Cloth& cloth : scene.cloths) options.settings.push_back(remeshing_of(scene, cloth));
  options.flip_threshold = scene.adaptive.flip_threshold;
  options.reach = 10 * contact_thickness(scene.contact);
  options.budget = budget;
  options.bending = bending_laws(scene);
  options.single = scene.precision == Precision::single_precision;
  Clearance clearance(assembly.m, around, options.reach);
  set_metric(assembly.m, options.settings, clearance, options.reach, view);
  const RemeshCounts counts = remesh(assembly.m, assembly.pins, clearance, options);
  if (counts.splits + counts.flips + counts.collapses == 0) return {counts};
  return assembly.finish(counts);
}

}  // namespace weft
