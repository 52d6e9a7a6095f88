#include "host/state/rank_geometry.hpp"

#include <algorithm>
#include <numeric>

#include "host/model/model_part.hpp"
#include "host/model/surface_tables.hpp"
#include "weft/kernels/integrate/moving_frame.hpp"

namespace weft {
namespace {

/// Vertices at equal distances in the order of each piece. [moving_frame_samples * pieces]
std::vector<Index> moving_frame_sample_of(const std::vector<Index>& component_of_vertex) {
  std::vector<std::vector<Index>> of_piece;
  for (std::size_t v = 0; v < component_of_vertex.size(); ++v) {
    const auto p = static_cast<std::size_t>(component_of_vertex[v]);
    of_piece.resize(std::max(of_piece.size(), p + 1));
    of_piece[p].push_back(static_cast<Index>(v));
  }
  std::vector<Index> sample;
  for (const std::vector<Index>& piece : of_piece)
    for (std::size_t k = 0; k < std::size_t{moving_frame_samples}; ++k)
      sample.push_back(piece[k * piece.size() / moving_frame_samples]);
  return sample;
}

/// [components] [1/kg]
std::vector<double> inverse_masses(const std::vector<Index>& component_of_vertex,
                                   const std::vector<double>& mass) {
  std::vector<double> result;
  for (std::size_t v = 0; v < component_of_vertex.size(); ++v) {
    const auto c = static_cast<std::size_t>(component_of_vertex[v]);
    result.resize(std::max(result.size(), c + 1));
    result[c] += mass[v];
  }
  for (double& m : result) m = 1 / m;
  return result;
}

/// The same for each rank.
struct CommonGeometry {
  std::vector<Index> component_of_vertex;
  SurfaceTables tables;
};

template <class T>
RankGeometry<T> make_geometry(const Store<T>& store, const CommonGeometry& common, int rank) {
  const Model& model = store.model();
  Device& device = store.devices()[rank];
  Queue& queue = device.compute();
  const MemoryName name("mesh");
  std::vector<T> friction(static_cast<std::size_t>(model.vertex_count),
                          static_cast<T>(store.scene().contact.friction));
  for (std::size_t i = 0; i < model.obstacle_of_vertex.size(); ++i)
    friction[static_cast<std::size_t>(model.cloth_vertex_count) + i] = static_cast<T>(
        store.scene().obstacles[static_cast<std::size_t>(model.obstacle_of_vertex[i])].friction);
  RankGeometry<T> g{
      Buffer<Edge>(device),      Buffer<Tri>(device),           Buffer<T>(device),
      Buffer<T>(device),         Buffer<unsigned char>(device), Buffer<Vec2<T>>(device),
      Buffer<Index>(device),     Buffer<Index>(device),         Buffer<double>(device),
      Buffer<Index>(device),     Buffer<Index>(device),         Buffer<T>(device),
      Buffer<T>(device),         Buffer<unsigned char>(device), Buffer<Index>(device),
      Buffer<EdgeWings>(device), Buffer<Tri>(device),           Buffer<Offset>(device),
      Buffer<Index>(device),     Buffer<Index>(device)};
  upload(queue, g.edges, model.edges);
  upload(queue, g.triangles, model.triangles);
  upload(queue, g.mass, cast_all<T>(model.mass));
  upload(queue, g.damping_mass, cast_all<T>(model.damping_mass));
  upload(queue, g.fixed, fixed_vertices(store.scene(), model, store.time));
  upload(queue, g.material_points, cast_all<T>(model.material_points));
  upload(queue, g.cloth_of_vertex, model.cloth_of_vertex);
  upload(queue, g.component_of_vertex, common.component_of_vertex);
  upload(queue, g.component_inverse_mass, inverse_masses(common.component_of_vertex, model.mass));
  upload(queue, g.moving_frame_sample, moving_frame_sample_of(common.component_of_vertex));
  std::vector<Index> alone(model.tied.size());
  std::iota(alone.begin(), alone.end(), 0);
  if (model.tied != alone) upload(queue, g.tied, model.tied);
  upload(queue, g.friction_of_vertex, friction);
  if (!model.start_thickness.empty())
    upload(queue, g.start_thickness, cast_all<T>(model.start_thickness));
  if (!model.cut.empty()) upload(queue, g.cut, model.cut);
  upload(queue, g.row_begin, store.partition().row_begin);
  upload(queue, g.wings, common.tables.wings);
  upload(queue, g.edges_of_face, common.tables.edges_of_face);
  upload(queue, g.ring_offset, common.tables.ring_offset);
  upload(queue, g.ring, common.tables.ring);
  upload(queue, g.face_of_vertex, common.tables.face_of_vertex);
  return g;
}

}  // namespace

std::vector<unsigned char> fixed_vertices(const Scene& scene, const Model& model, double time) {
  std::vector<unsigned char> fixed(static_cast<std::size_t>(model.vertex_count), 0);
  for (std::size_t v = static_cast<std::size_t>(model.cloth_vertex_count); v < fixed.size(); ++v)
    fixed[v] = 1;
  for (const auto& p : model.pinned)
    if (pin_holds(scene.pins[static_cast<std::size_t>(p.pin)], time))
      fixed[static_cast<std::size_t>(p.vertex)] = 1;
  return fixed;
}

template <class T>
std::vector<RankGeometry<T>> make_geometry(const Store<T>& store) {
  const CommonGeometry common{cloth_components(store.model()), make_surface_tables(store.model())};
  std::vector<RankGeometry<T>> ranks;
  for (int r = 0; r < store.devices().size(); ++r) ranks.push_back(make_geometry(store, common, r));
  return ranks;
}

template <class T>
RankMotion<T> make_motion(const Store<T>& store, int rank) {
  Device& device = store.devices()[rank];
  const MemoryName name("state");
  const auto cloth = static_cast<std::size_t>(store.model().cloth_vertex_count);
  const auto all = static_cast<std::size_t>(store.model().vertex_count);
  return {Buffer<Vec3<T>>(device, all),       Buffer<Vec3<T>>(device, cloth),
          Buffer<Vec3<T>>(device, cloth),     Buffer<Vec3<T>>(device, cloth),
          Buffer<unsigned char>(device, all), Buffer<unsigned char>(device, all),
          Buffer<unsigned char>(device, all), Buffer<unsigned char>(device, all),
          Buffer<ContactMemory<T>>(device)};
}

template std::vector<RankGeometry<float>> make_geometry(const Store<float>&);
template std::vector<RankGeometry<double>> make_geometry(const Store<double>&);
template RankMotion<float> make_motion(const Store<float>&, int);
template RankMotion<double> make_motion(const Store<double>&, int);

}  // namespace weft
