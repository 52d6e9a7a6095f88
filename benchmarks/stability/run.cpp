#include "benchmarks/stability/run.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "host/base/random.hpp"
#include "host/io/mesh/mesh_file.hpp"
#include "host/lab/chart/compare.hpp"
#include "weft/error.hpp"
#include "weft/shapes.hpp"

namespace weft::stability {
namespace {

double mean_edge(const Mesh& mesh) {
  double sum = 0;
  for (const Tri& t : mesh.triangles)
    for (int k = 0; k < 3; ++k)
      sum += length(mesh.positions[static_cast<std::size_t>(t.v[k])] -
                    mesh.positions[static_cast<std::size_t>(t.v[(k + 1) % 3])]);
  return sum / static_cast<double>(3 * mesh.triangles.size());
}

std::vector<Index> vertices_where(const Mesh& mesh, double sign, double width) {
  std::vector<Index> found;
  for (std::size_t v = 0; v < mesh.material.size(); ++v)
    if (sign * mesh.material[v][0] > side / 2 - width) found.push_back(static_cast<Index>(v));
  return found;
}

}  // namespace

Cloth square(int cells, double z) {
  Cloth cloth;
  cloth.name = "sheet";
  cloth.mesh = make_grid({side, side}, {cells, cells}, Diagonals::alternating);
  for (auto& x : cloth.mesh.positions) x[2] = z;
  return cloth;
}

Material cotton() {
  Material m;
  m.name = "cotton";
  m.density = 0.15;
  m.stretch_stiffness = 200;
  m.bending_stiffness = 1e-5;
  m.damping_stiffness = 5e-4;
  return m;
}

Scene empty_scene(const Setup& setup, double step) {
  Scene scene;
  scene.name = "stability";
  scene.method = setup.method;
  scene.precision =
      setup.method == "asynchronous" ? Precision::double_precision : Precision::single_precision;
  scene.time.step = step;
  scene.time.frame_rate = 1 / step;
  scene.materials.push_back(cotton());
  scene.contact.thickness = 0.002;
  scene.solver.partial_rows = 8;
  scene.time_parallel.coarse_step = std::max(0.02, step);
  // The left half of anything at the origin is out of view.
  scene.camera.keys.push_back({0, {0.3, -0.6, 0.5}, {0.15, 0, 0}, {0, 0, 1}, 0.4, false});
  return scene;
}

Scene sheet_on_sphere(const Setup& setup, double step) {
  Scene scene = empty_scene(setup, step);
  scene.cloths.push_back(square(10, 0.108));
  Obstacle sphere;
  sphere.name = "sphere";
  sphere.mesh = make_icosphere(0.1, 2);
  scene.obstacles.push_back(sphere);
  return scene;
}

Scene curtain(const Setup& setup, double step, int cells) {
  Scene scene = empty_scene(setup, step);
  scene.cloths.push_back(square(cells, 0));
  Pin pin;
  for (std::size_t v = 0; v < scene.cloths[0].mesh.positions.size(); ++v) {
    Vec3<double>& x = scene.cloths[0].mesh.positions[v];
    if (x[1] > side / 2 * (1 - 1e-9)) pin.vertices.push_back(static_cast<Index>(v));
    x = {x[0], 0, x[1]};
  }
  scene.pins.push_back(pin);
  return scene;
}

std::vector<Index> left_vertices(const Mesh& mesh, double width) {
  return vertices_where(mesh, -1, width);
}

std::vector<Index> right_vertices(const Mesh& mesh, double width) {
  return vertices_where(mesh, 1, width);
}

void jitter(Scene& scene, const Setup& setup, double share) {
  std::uint64_t state = setup.seed;
  for (Cloth& cloth : scene.cloths) {
    const double amplitude = share * mean_edge(cloth.mesh);
    for (Vec3<double>& x : cloth.mesh.positions)
      for (int c = 0; c < 3; ++c) x[c] += amplitude * next_random(state);
  }
}

Run start(Scene scene, const Setup& setup) {
  return {std::move(scene), [device = setup.device] { return parse_devices(device); }};
}

Run run(Scene scene, const Setup& setup, int steps) {
  Run run = start(std::move(scene), setup);
  run.watch(steps);
  return run;
}

double total_energy(const Run& run) {
  const Energy e = run.now().energy();
  return e.kinetic + e.elastic + e.gravitational;
}

double weight_energy(const Scene& scene) {
  double mass = 0;
  for (const Cloth& cloth : scene.cloths)
    for (std::size_t k = 0; k < cloth.mesh.triangles.size(); ++k) {
      const Tri& t = cloth.mesh.triangles[k];
      const auto at = [&](int c) { return cloth.mesh.material[static_cast<std::size_t>(t.v[c])]; };
      const Vec2<double> a = at(1) - at(0), b = at(2) - at(0);
      const Index material =
          cloth.triangle_material.empty() ? cloth.material : cloth.triangle_material[k];
      mass += std::abs(a[0] * b[1] - a[1] * b[0]) / 2 *
              scene.materials[static_cast<std::size_t>(material)].density;
    }
  return mass * 9.81 * side;
}

void require_no_energy_gain(double before, double after, double scale) {
  if (!(after <= before + 0.01 * scale))
    throw Wrong(fmt::format("energy grew from {:.4g} J to {:.4g} J", before, after));
}

void require_at_most(double value, double limit, const std::string& what) {
  if (!(value <= limit))
    throw Wrong(fmt::format("{} is {:.4g}, not {:.4g} at most", what, value, limit));
}

Mesh cloth_mesh(const Run& run) {
  const Simulation& simulation = run.now();
  const Frame frame = simulation.frame();
  std::vector<io::NamedMesh> meshes;
  for (std::size_t c = 0; c < frame.cloth_positions.size(); ++c) {
    meshes.push_back({simulation.scene().cloths[c].name, simulation.scene().cloths[c].mesh});
    meshes.back().mesh.positions = frame.cloth_positions[c];
  }
  return io::joined(meshes);
}

double largest_distance(const Mesh& a, const Mesh& b) {
  const lab::Resampling resampling(b, a);
  if (!resampling.known()) throw Wrong("the meshes of the two runs have nothing in common");
  const auto there = resampling.positions(b.positions);
  double largest = 0;
  for (std::size_t v = 0; v < there.size(); ++v)
    largest = std::max(largest, length(a.positions[v] - there[v]));
  return largest;
}

}  // namespace weft::stability
