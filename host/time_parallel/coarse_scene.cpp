#include "host/time_parallel/coarse_scene.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <optional>
#include <set>
#include <string>
#include <utility>

#include "host/scene/seams/sewing.hpp"
#include "host/scene/surfaces.hpp"
#include "host/untangle/untangle_scene.hpp"
#include "weft/core/at.hpp"
#include "weft/error.hpp"
#include "weft/shapes.hpp"

namespace weft {
namespace {

constexpr double infinite = std::numeric_limits<double>::infinity();

/// A divisor of the number of cells is taken if it is within this factor of the wanted one.
constexpr double divisor_range = 1.7;
/// Collapses end where edges are somewhat shorter than the sizing field allows.
constexpr double size_over_edge = 1.4;
/// Most triangles of a cloth's coarse mesh. More come of a smallest size that is a mistake, and
/// take minutes to make.
constexpr int triangles_max = 2'000'000;
/// A pin of more vertices is a line or an area, of which the coarse mesh has its own vertices.
constexpr std::size_t points_max = 2;

bool same(const Tri& a, const Tri& b) {
  return std::equal(a.v, a.v + 3, b.v);
}

/// A mesh as make_grid() makes them, but for its positions.
struct GridShape {
  Vec2<double> low, size;
  std::array<Index, 2> cells;
  Diagonals diagonals;
};

std::optional<GridShape> grid_shape(const Mesh& mesh) {
  if (!mesh.material_triangles.empty() || !mesh.group.empty() || mesh.material.size() < 4)
    return {};
  const std::size_t count = mesh.material.size();
  std::size_t nx = 0;
  while (nx + 1 < count && mesh.material[nx + 1][1] == mesh.material[0][1]) ++nx;
  if (nx < 1 || count % (nx + 1) != 0 || count / (nx + 1) < 2) return {};
  const std::size_t ny = count / (nx + 1) - 1;
  if (mesh.triangles.size() != 2 * nx * ny) return {};
  GridShape shape{mesh.material.front(),
                  mesh.material.back() - mesh.material.front(),
                  {static_cast<Index>(nx), static_cast<Index>(ny)},
                  Diagonals::alternating};
  if (!(shape.size[0] > 0) || !(shape.size[1] > 0)) return {};
  const double tolerance = 1e-9 * (shape.size[0] + shape.size[1]);
  for (const Diagonals diagonals : {Diagonals::alternating, Diagonals::same}) {
    const Mesh grid = make_grid(shape.size, shape.cells, diagonals);
    if (!std::equal(grid.triangles.begin(), grid.triangles.end(), mesh.triangles.begin(), same))
      continue;
    const Vec2<double> shift = shape.low - grid.material.front();
    for (std::size_t v = 0; v < count; ++v)
      if (length(grid.material[v] + shift - mesh.material[v]) > tolerance) return {};
    shape.diagonals = diagonals;
    return shape;
  }
  return {};
}

/// How many cells a coarse grid has along a side.
Index coarse_cells(Index cells, double factor) {
  Index best = 0;
  double best_miss = std::log(divisor_range);
  for (Index d = 1; d <= cells; ++d) {
    if (cells % d != 0) continue;
    const double miss = std::abs(std::log(static_cast<double>(d) / factor));
    if (miss <= best_miss) {
      best = cells / d;
      best_miss = miss;
    }
  }
  if (best > 0) return best;
  return std::max<Index>(1, static_cast<Index>(std::llround(static_cast<double>(cells) / factor)));
}

Mesh coarse_grid(const GridShape& shape, const Mesh& fine, double factor) {
  Mesh grid = make_grid(
      shape.size, {coarse_cells(shape.cells[0], factor), coarse_cells(shape.cells[1], factor)},
      shape.diagonals);
  const Vec2<double> shift = shape.low - grid.material.front();
  for (Vec2<double>& u : grid.material) u += shift;
  grid.positions = interpolated(map_material(grid, fine), fine.positions.data());
  return grid;
}

/// Sizes that remeshing takes from a mesh alone, whatever the scene says of its cloth.
Remeshing sizes_of(const Mesh& mesh) {
  Cloth cloth;
  cloth.mesh = mesh;
  const Scene defaults;
  return remeshing_of(defaults, cloth);
}

/// Edges of a coarse mesh over those of the fine scene's mesh, which for slices that remesh may be
/// far longer than the shortest that they make of it. Below 1: the coarse mesh is the finer one.
double edge_ratio(const Scene& fine, const Cloth& cloth) {
  const double coarsening = fine.time_parallel.coarsening;
  if (!slices_remesh(fine)) return coarsening;
  return coarsening * remeshing_of(fine, cloth).size_min / sizes_of(cloth.mesh).size_min;
}

/// Sizes of a coarse mesh that adapts, by the criteria of the fine one.
Remeshing coarse_remeshing(const Scene& fine, const Cloth& cloth) {
  Remeshing coarse = remeshing_of(fine, cloth);
  if (!slices_remesh(fine)) {
    const Remeshing own = sizes_of(cloth.mesh);
    coarse.size_min = own.size_min;
    coarse.size_max = own.size_max;
  }
  coarse.size_min *= fine.time_parallel.coarsening;
  coarse.size_max = std::max(coarse.size_max, coarse.size_min);
  return coarse;
}

/// Remeshes one cloth to edges of one length. Named points stay.
/// @param ratio of edges
void coarsen_mesh(const Scene& fine, std::size_t c, double ratio, Cloth& cloth) {
  Scene one;
  one.file = fine.file;
  one.materials = fine.materials;
  one.cloths = {cloth};
  one.precision = Precision::double_precision;
  one.contact = fine.contact;
  one.contact.self = false;  // the coarse run refuses an intersecting start, or parts it
  one.cloths[0].remeshing = even_sizes(cloth.mesh, ratio);
  const std::size_t count = cloth.mesh.positions.size();
  std::vector<Index> joined(count);
  for (std::size_t v = 0; v < count; ++v) joined[v] = static_cast<Index>(v);
  std::vector<unsigned char> kept(count, 0);
  const auto keep = [&](Index of, const std::vector<Index>& vertices) {
    if (at(of) == c && (vertices.size() <= points_max || ratio <= 1))
      for (const Index v : vertices) kept[at(v)] = 1;
  };
  for (const Pin& pin : fine.pins) keep(pin.cloth, pin.vertices);
  for (const Handle& handle : fine.handles) keep(handle.cloth, handle.vertices);
  SceneRemesh done = remesh_scene(
      one, joined, kept, {cloth.mesh.positions, std::vector<Vec3<double>>(count)}, {}, {infinite});
  if (done.changed()) cloth = std::move(done.scene.cloths[0]);
  cloth.remeshing.reset();
}

/// [coarse vertices] the fine ones that each stands for: it is held where all of them are.
using StandsFor = std::vector<std::vector<Index>>;

/// @param finer the coarse mesh has the shorter edges: each stands for all corners that it is
///              between. Else for the nearest one in its triangle
StandsFor stands_for(const MaterialMap& of_coarse, bool finer) {
  StandsFor result;
  for (std::size_t v = 0; v < of_coarse.corner.size(); ++v) {
    const auto& w = of_coarse.weight[v];
    const auto& corner = of_coarse.corner[v];
    result.emplace_back();
    if (!finer)
      result.back() = {
          corner[static_cast<std::size_t>(std::max_element(w.begin(), w.end()) - w.begin())]};
    for (std::size_t k = 0; finer && k < 3; ++k)
      if (w[k] != 0) result.back().push_back(corner[k]);
  }
  return result;
}

/// Vertices of the coarse mesh that stand for some of the fine one.
std::vector<Index> coarse_vertices(const std::vector<Index>& fine, const MaterialMap& of_fine,
                                   const StandsFor& stands, bool each) {
  std::vector<Index> result;
  if (!each) {
    const std::set<Index> named(fine.begin(), fine.end());
    for (std::size_t v = 0; v < stands.size(); ++v)
      if (std::all_of(stands[v].begin(), stands[v].end(),
                      [&](Index f) { return named.count(f) > 0; }))
        result.push_back(static_cast<Index>(v));
  }
  if (!result.empty()) return result;
  for (const Index v : fine) {
    const auto& w = of_fine.weight[at(v)];
    const Index coarse =
        of_fine.corner[at(v)]
                      [static_cast<std::size_t>(std::max_element(w.begin(), w.end()) - w.begin())];
    if (std::find(result.begin(), result.end(), coarse) == result.end()) result.push_back(coarse);
  }
  return result;
}

/// Gives pins and handles the coarse vertices that stand for theirs.
void rename_vertices(CoarseScene& level, const std::vector<StandsFor>& stands) {
  std::set<std::pair<Index, Index>> pinned;
  for (Pin& pin : level.scene.pins) {
    const auto c = at(pin.cloth);
    pin.vertices =
        coarse_vertices(pin.vertices, level.maps[c], stands[c], pin.vertices.size() <= points_max);
    // No vertex belongs to two pins.
    std::erase_if(pin.vertices, [&](Index v) { return !pinned.insert({pin.cloth, v}).second; });
  }
  std::erase_if(level.scene.pins, [](const Pin& pin) { return pin.vertices.empty(); });
  for (Handle& handle : level.scene.handles) {
    const auto c = at(handle.cloth);
    const auto before = static_cast<double>(handle.vertices.size());
    handle.vertices = coarse_vertices(handle.vertices, level.maps[c], stands[c],
                                      handle.vertices.size() <= points_max);
    handle.stiffness *= before / static_cast<double>(handle.vertices.size());
  }
  std::erase_if(level.scene.handles, [](const Handle& handle) {
    return handle.shape == Handle::Shape::glue && handle.vertices.size() != 2;
  });
}

}  // namespace

Remeshing even_sizes(const Mesh& mesh, double ratio) {
  Remeshing sizes;
  const double edge = sizes_of(mesh).size_min / 1.5;
  sizes.size_min = sizes.size_max = size_over_edge * ratio * edge;
  sizes.refine_angle = sizes.refine_compression = sizes.refine_velocity = infinite;
  return sizes;
}

CoarseScene make_coarse_scene(const Scene& fine) {
  const TimeParallelSettings& settings = fine.time_parallel;
  CoarseScene level{fine, {}, {}};
  Scene& scene = level.scene;
  scene.method = settings.coarse_adaptive ? "adaptive" : "implicit";
  scene.output.format = FrameFormat::obj;  // it has no frames, and its meshes may change
  scene.name += " (coarse)";
  scene.time.step = settings.coarse_step;
  // A step that long by the linearly implicit formula brakes whatever turns: by Newton's method a
  // sheet that swings ends a fifth as far from the fine one. BDF2 comes nearer still while the
  // sheet swings freely, but its velocities ring, and recovery takes their differences for forces:
  // it leaves larger jumps at seams. Two iterations do as well as eight: the rest is far below what
  // the coarse mesh misses, and where cloth is pressed together eight leave larger jumps.
  scene.integrator = settings.coarse_integrator;
  scene.contact.thickness = settings.coarse_thickness * contact_thickness(scene.contact);
  scene.solver.newton_iterations = settings.coarse_newton_iterations;
  scene.solver.newton_tolerance = settings.coarse_newton_tolerance;
  scene.solver.tolerance = std::max(scene.solver.tolerance, settings.coarse_tolerance);
  std::vector<StandsFor> stands;
  for (std::size_t c = 0; c < fine.cloths.size(); ++c) {
    const Cloth& before = fine.cloths[c];
    Cloth& cloth = scene.cloths[c];
    const double ratio = edge_ratio(fine, before);
    // Edges of a half have four times the triangles.
    const double expected = static_cast<double>(before.mesh.triangles.size()) / (ratio * ratio);
    if (expected > triangles_max)
      throw SceneError(fine.file, "remeshing.size[0]",
                       "a coarse mesh of cloth \"" + before.name + "\" with some " +
                           std::to_string(std::llround(expected)) + " triangles",
                       "at most " + std::to_string(triangles_max) +
                           ": the edges of a coarse mesh are several times as long as size[0]");
    const auto grid =
        before.triangle_material.empty() && ratio > 1 ? grid_shape(before.mesh) : std::nullopt;
    if (grid)
      cloth.mesh = coarse_grid(*grid, before.mesh, ratio);
    else
      coarsen_mesh(fine, c, ratio, cloth);
    if (!slices_remesh(fine) && cloth.mesh.triangles.size() >= before.mesh.triangles.size())
      throw SceneError(
          fine.file, title_of(fine, c),
          std::to_string(before.mesh.triangles.size()) +
              " triangles, of which no coarser mesh can be made",
          "a finer mesh, or another method than \"time_parallel\", which starts on coarse meshes");
    level.maps.push_back(map_material(before.mesh, cloth.mesh));
    const MaterialMap of_coarse = map_material(cloth.mesh, before.mesh);
    stands.push_back(stands_for(of_coarse, ratio <= 1));
    if (!before.rest_positions.empty())
      cloth.rest_positions = interpolated(of_coarse, before.rest_positions.data());
    if (settings.coarse_adaptive) cloth.remeshing = coarse_remeshing(fine, before);
  }
  level.schwarz_offset = input_offsets(scene);
  rename_vertices(level, stands);
  // Chords of a coarse mesh may cut what the fine one goes around.
  untangle_start(scene, {});
  scene.contact.untangle = false;
  return level;
}

std::vector<Vec3<double>> upsampled(const CoarseScene& level,
                                    const std::vector<Vec3<double>>& coarse) {
  std::vector<Vec3<double>> fine;
  for (std::size_t c = 0; c < level.maps.size(); ++c) {
    const auto part = interpolated(level.maps[c], coarse.data() + level.schwarz_offset[c]);
    fine.insert(fine.end(), part.begin(), part.end());
  }
  return fine;
}

Tracking make_tracking(const Scene& fine, const CoarseScene& level) {
  const std::vector<Index> offsets = input_offsets(fine);
  std::vector<double> area(at(offsets.back()), 0);
  for (std::size_t c = 0; c < fine.cloths.size(); ++c) {
    const Mesh& mesh = fine.cloths[c].mesh;
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
      const Tri& u =
          mesh.material_triangles.empty() ? mesh.triangles[t] : mesh.material_triangles[t];
      const Vec2<double> a = mesh.material[at(u.v[1])] - mesh.material[at(u.v[0])];
      const Vec2<double> b = mesh.material[at(u.v[2])] - mesh.material[at(u.v[0])];
      for (const Index v : mesh.triangles[t].v)
        area[at(offsets[c] + v)] += std::abs(a[0] * b[1] - a[1] * b[0]) / 6;
    }
  }
  std::vector<std::vector<std::pair<Index, double>>> rows(at(level.schwarz_offset.back()));
  for (std::size_t c = 0; c < level.maps.size(); ++c)
    for (std::size_t v = 0; v < level.maps[c].corner.size(); ++v)
      for (std::size_t k = 0; k < 3; ++k) {
        const double w = level.maps[c].weight[v][k];
        const Index input = offsets[c] + static_cast<Index>(v);
        if (w != 0)
          rows[at(level.schwarz_offset[c] + level.maps[c].corner[v][k])].emplace_back(
              input, w * area[at(input)]);
      }
  Tracking tracking;
  tracking.offset.push_back(0);
  for (const auto& row : rows) {
    for (const auto& [input, weight] : row) {
      tracking.input.push_back(input);
      tracking.weight.push_back(weight);
    }
    tracking.offset.push_back(static_cast<Offset>(tracking.input.size()));
  }
  tracking.free_from.assign(rows.size(), 0);
  for (const Pin& pin : level.scene.pins)
    for (const Index v : pin.vertices)
      tracking.free_from[at(level.schwarz_offset[at(pin.cloth)] + v)] = pin.release_time;
  return tracking;
}

}  // namespace weft
