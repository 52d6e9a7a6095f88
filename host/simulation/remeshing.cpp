#include "host/simulation/remeshing.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <optional>
#include <utility>

#include "host/base/bytes.hpp"
#include "host/base/checksum.hpp"
#include "host/model/material_rows.hpp"
#include "host/simulation/compression.hpp"
#include "host/state/contact_transfer.hpp"
#include "host/state/rank_geometry.hpp"
#include "weft/core/at.hpp"
#include "weft/error.hpp"

namespace weft {
namespace {

/// Energy below which a change is rounding, as a share of stiffness times area.
constexpr double rounding_share = 1e-12;
/// Share of its velocity that motion keeps which pays for a remesh.
constexpr double slowest = 0.5;
/// What a remesh may change the energy by, over what its flips and collapses may.
constexpr double jump_over_share = 5;
/// The same for the splits of a second try.
constexpr double splits_over_share = 2;
/// Gap that new triangles keep to others, as a share of the thickness of contacts.
constexpr double gap_share = 0.1;

template <class T>
Surroundings surroundings_of(const Scene& scene, const Model& model,
                             const StateSnapshot<T>& state) {
  Surroundings around;
  const Index first = model.cloth_vertex_count;
  for (std::size_t v = at(first); v < state.positions.size(); ++v)
    around.positions.push_back(vec_cast<double>(state.positions[v]));
  for (std::size_t t = at(model.cloth_triangle_count); t < model.triangles.size(); ++t) {
    Tri tri = model.triangles[t];
    for (Index& v : tri.v) v -= first;
    around.triangles.push_back(tri);
  }
  around.self = scene.contact.self;
  around.gap = gap_share * contact_thickness(scene.contact);
  return around;
}

template <class T>
InputState inputs_of(const Model& model, const StateSnapshot<T>& state) {
  InputState inputs;
  for (const Index v : model.to_internal) {
    inputs.positions.push_back(vec_cast<double>(state.positions[at(v)]));
    inputs.velocities.push_back(vec_cast<double>(state.velocities[at(v)]));
    inputs.previous_velocities.push_back(vec_cast<double>(state.previous_velocities[at(v)]));
  }
  return inputs;
}

/// What rounding alone makes of the stretching energy. [J]
double rounding_energy(const Scene& scene, const Model& model) {
  double sum = 0;
  for (std::size_t t = 0; t < model.area.size(); ++t)
    sum += scene.materials[at(model.material[t])].stretch_stiffness * model.area[t];
  return rounding_share * sum;
}

// ---- bytes

/// Visits all that a remesh changes, in one order for writing and reading.
template <class SceneLike, class RunLike, class Visit>
void visit_adapted(SceneLike& scene, RunLike& run, Visit visit) {
  visit(run.origin);
  visit(run.peak_kinetic);
  visit(run.kept);
  visit(run.compression);
  for (auto& cloth : scene.cloths) {
    visit(cloth.mesh.positions);
    visit(cloth.mesh.material);
    visit(cloth.mesh.triangles);
    visit(cloth.mesh.material_triangles);
    visit(cloth.mesh.group);
    visit(cloth.triangle_material);
  }
  for (auto& pin : scene.pins) visit(pin.vertices);
  for (auto& handle : scene.handles) visit(handle.vertices);
  for (auto& seam : scene.seams)
    for (auto& side : seam.vertices) visit(side);
}

}  // namespace

AdaptiveRun begin_adaptive(Scene& scene) {
  for (Cloth& cloth : scene.cloths) cloth.remeshing = remeshing_of(scene, cloth);
  AdaptiveRun run;
  run.kept = named_inputs(scene);
  run.origin = checksum_of(adaptive_bytes(scene, run));
  return run;
}

double allowed_joules(const Scene& scene, const Model& model, const AdaptiveRun& run,
                      std::int64_t step_number) {
  // A start has no motion to spoil, and coarse meshes may start far from rest.
  if (step_number == 0) return std::numeric_limits<double>::infinity();
  return scene.adaptive.energy_share * run.peak_kinetic + rounding_energy(scene, model);
}

double largest_jump(const Scene& scene, const Model& model, const AdaptiveRun& run,
                    std::int64_t step_number) {
  return jump_over_share * allowed_joules(scene, model, run, step_number);
}

template <class T>
SceneRemesh remesh_run(const Scene& scene, const std::vector<unsigned char>& welded,
                       const AdaptiveRun& run, const Store<T>& store, int tries) {
  const Model& model = store.model();
  const StateSnapshot<T> state = store.snapshot();
  InputState inputs = inputs_of(model, state);
  const Surroundings around = surroundings_of(scene, model, state);
  EnergyBudget budget{allowed_joules(scene, model, run, state.step_number), &model.laws->rows};
  if (tries > 0) budget.splits = splits_over_share * budget.joules;
  std::optional<ViewField> view;
  if (scene.method == "view")
    view = look_at_scene(scene, model, scene_surface(scene), {inputs.positions, around.positions},
                         state.time);
  return remesh_scene(scene, joined_inputs(scene, welded), run.kept, std::move(inputs), around,
                      budget, view ? &*view : nullptr);
}

template <class T>
SceneView validate_run(const Scene& scene, AdaptiveRun& run, Store<T>& store, double joules) {
  const StateSnapshot<T> state = store.snapshot();
  ViewPlaces places{inputs_of(store.model(), state).positions, {}};
  for (std::size_t v = at(store.model().cloth_vertex_count); v < state.positions.size(); ++v)
    places.obstacles.push_back(vec_cast<double>(state.positions[v]));
  SceneView view = evaluate_view(scene, scene_surface(scene), places, state.time);
  run.compression = std::isfinite(joules)
                        ? limited_compression(store.model(), cast_all<double>(state.positions),
                                              run.compression, view.compression, joules)
                        : view.compression;
  store.set_compression(run.compression);
  return view;
}

template <class T>
StateSnapshot<T> remeshed_state(const Model& from, const StateSnapshot<T>& state,
                                const SceneRemesh& remesh, const Model& to) {
  StateSnapshot<T> result;
  result.time = state.time;
  result.step_number = state.step_number;
  result.backoff = state.backoff;
  result.next_step = state.next_step;
  for (const Index input : to.to_input) {
    result.positions.push_back(vec_cast<T>(remesh.state.positions[at(input)]));
    result.velocities.push_back(vec_cast<T>(remesh.state.velocities[at(input)]));
    // Without previous_step no history: it tells the search what velocities are likely to do.
    result.previous_velocities.push_back(vec_cast<T>(remesh.state.previous_velocities[at(input)]));
  }
  result.positions.insert(result.positions.end(), state.positions.begin() + from.cloth_vertex_count,
                          state.positions.end());
  result.previous_positions = result.positions;
  result.touched.assign(result.positions.size(), 0);
  std::vector<Index> vertex(at(from.vertex_count), -1);
  for (std::size_t i = 0; i < remesh.input_before.size(); ++i)
    if (remesh.input_before[i] >= 0)
      vertex[at(from.to_internal[at(remesh.input_before[i])])] = to.to_internal[i];
  for (Index v = from.cloth_vertex_count; v < from.vertex_count; ++v)
    vertex[at(v)] = v - from.cloth_vertex_count + to.cloth_vertex_count;
  transfer_contacts(from, state, vertex, to, true, result);
  return result;
}

template <class T>
double surface_kinetic(const Scene& scene, const Model& model,
                       const std::vector<Vec3<T>>& velocities) {
  double energy = 0;
  for (std::size_t t = 0; t < model.area.size(); ++t) {
    Vec3<double> sum{0, 0, 0};
    double squares = 0;
    for (const Index v : model.triangles[t].v) {
      const auto u = vec_cast<double>(velocities[at(v)]);
      sum += u;
      squares += length_sq(u);
    }
    const double mass = scene.materials[at(model.material[t])].density * model.area[t];
    energy += mass / 24 * (squares + length_sq(sum));
  }
  return energy;
}

template <class T>
double pay_from_motion(const Scene& scene, const Model& model, const SceneRemesh& remesh,
                       double added, StateSnapshot<T>& state) {
  const auto cloth = at(model.cloth_vertex_count);
  std::vector<unsigned char> fresh(cloth, 0), pays(cloth, 0);
  for (std::size_t i = 0; i < remesh.input_before.size(); ++i)
    if (remesh.input_before[i] < 0) fresh[at(model.to_internal[i])] = 1;
  for (Index e = 0; e < model.cloth_edge_count; ++e) {
    const Index* v = model.edges[at(e)].v;
    if (fresh[at(v[0])] != 0 || fresh[at(v[1])] != 0) pays[at(v[0])] = pays[at(v[1])] = 1;
  }
  const std::vector<unsigned char> fixed = fixed_vertices(scene, model, state.time);
  std::vector<double> mass(scene.cloths.size(), 0);
  std::vector<Vec3<double>> mean(scene.cloths.size(), Vec3<double>{0, 0, 0});
  for (std::size_t v = 0; v < cloth; ++v) {
    if (fixed[v] != 0) pays[v] = 0;
    if (pays[v] == 0) continue;
    const auto c = at(model.cloth_of_vertex[v]);
    mass[c] += model.mass[v];
    mean[c] += model.mass[v] * vec_cast<double>(state.velocities[v]);
  }
  for (std::size_t c = 0; c < mass.size(); ++c)
    if (mass[c] > 0) mean[c] *= 1 / mass[c];
  // Relative velocities times s: the energy is a quadratic of s.
  const auto scaled = [&](double s) {
    std::vector<Vec3<double>> velocities = cast_all<double>(state.velocities);
    for (std::size_t v = 0; v < cloth; ++v)
      if (pays[v] != 0) {
        const Vec3<double>& about = mean[at(model.cloth_of_vertex[v])];
        velocities[v] = about + s * (velocities[v] - about);
      }
    return velocities;
  };
  const auto energy_at = [&](double s) { return surface_kinetic(scene, model, scaled(s)); };
  const double now = energy_at(1), none = energy_at(0), back = energy_at(-1);
  const double a = (now + back) / 2 - none, b = (now - back) / 2;
  const double under = b * b - 4 * a * (none + added - now);
  if (!(a > 0) || !(2 * a + b > 0)) return 0;
  const double least = std::max(slowest, -b / (2 * a));
  const double s = under > 0 ? std::max(least, (-b + std::sqrt(under)) / (2 * a)) : least;
  state.velocities = cast_all<T>(scaled(s));
  return now - (a * s * s + b * s + none);
}

std::string adaptive_bytes(const Scene& scene, const AdaptiveRun& run) {
  Packer packer;
  visit_adapted(scene, run, [&](const auto& values) { packer.put(values); });
  return packer.bytes;
}

void read_adaptive_bytes(const std::string& bytes, const std::string& file, Scene& scene,
                         AdaptiveRun& run) {
  Unpacker unpacker(bytes, file, "checkpoint adaptive", "the meshes of the scene's cloths");
  AdaptiveRun read;
  visit_adapted(scene, read, [&](auto& values) { unpacker.get(values); });
  unpacker.end();
  if (read.origin != run.origin) unpacker.refuse("belongs to another scene");
  if (read.kept.size() != at(input_offsets(scene).back()) || !std::isfinite(read.peak_kinetic))
    unpacker.refuse("makes no sense");
  std::size_t triangles = 0;
  for (const Cloth& cloth : scene.cloths) triangles += cloth.mesh.triangles.size();
  if (!read.compression.empty() && read.compression.size() != triangles)
    unpacker.refuse("makes no sense");
  run = std::move(read);
}

template double surface_kinetic(const Scene&, const Model&, const std::vector<Vec3<float>>&);
template double surface_kinetic(const Scene&, const Model&, const std::vector<Vec3<double>>&);
template double pay_from_motion(const Scene&, const Model&, const SceneRemesh&, double,
                                StateSnapshot<float>&);
template double pay_from_motion(const Scene&, const Model&, const SceneRemesh&, double,
                                StateSnapshot<double>&);
template SceneView validate_run(const Scene&, AdaptiveRun&, Store<float>&, double);
template SceneView validate_run(const Scene&, AdaptiveRun&, Store<double>&, double);
template SceneRemesh remesh_run(const Scene&, const std::vector<unsigned char>&, const AdaptiveRun&,
                                const Store<float>&, int);
template SceneRemesh remesh_run(const Scene&, const std::vector<unsigned char>&, const AdaptiveRun&,
                                const Store<double>&, int);
template StateSnapshot<float> remeshed_state(const Model&, const StateSnapshot<float>&,
                                             const SceneRemesh&, const Model&);
template StateSnapshot<double> remeshed_state(const Model&, const StateSnapshot<double>&,
                                              const SceneRemesh&, const Model&);

}  // namespace weft
