// Meshes that no simulation likes, and starts that intersect.
#include <cmath>
#include <utility>

#include "benchmarks/stability/run.hpp"

namespace weft::stability {
namespace {

Mesh& mesh_of(Scene& scene) {
  return scene.cloths[0].mesh;
}

/// One row of cells of a curtain is a millionth as wide as it is high.
void slivers(const Setup& setup, Precision precision) {
  Scene scene = curtain(setup, 0.005, 8);
  if (setup.method != "asynchronous") scene.precision = precision;
  Mesh& mesh = mesh_of(scene);
  const double cell = side / 8;
  for (std::size_t v = 0; v < mesh.positions.size(); ++v)
    if (std::abs(mesh.material[v][0] - cell) < cell / 2) {
      mesh.material[v][0] = 1e-6 * cell;
      mesh.positions[v][0] = 1e-6 * cell;
    }
  jitter(scene, setup, 1e-8);
  const double scale = weight_energy(scene);
  Run simulation = start(std::move(scene), setup);
  const double before = total_energy(simulation);
  simulation.watch(40);
  require_no_energy_gain(before, total_energy(simulation), scale);
}

/// Refused, or simulated right.
void accepted_or_refused(const Setup& setup, Scene scene) {
  jitter(scene, setup);
  run(std::move(scene), setup, 20);
}

void zero_area(const Setup& setup, bool in_material) {
  Scene scene = curtain(setup, 0.005, 8);
  Mesh& mesh = mesh_of(scene);
  const Tri t = mesh.triangles[20];
  const auto at = [&](int c) { return static_cast<std::size_t>(t.v[c]); };
  if (in_material)
    mesh.material[at(2)] = 0.5 * (mesh.material[at(0)] + mesh.material[at(1)]);
  else
    mesh.positions[at(2)] = mesh.positions[at(1)];
  must_be_refused([&] { run(std::move(scene), setup, 20); }, "a triangle without area");
}

/// Every triangle of the right half has vertices of its own along the middle.
void torn(const Setup& setup) {
  Scene scene = curtain(setup, 0.005, 8);
  jitter(scene, setup);
  Mesh& mesh = mesh_of(scene);
  std::vector<Index> twin(mesh.positions.size(), -1);
  for (Tri& t : mesh.triangles) {
    double middle = 0;
    for (const Index v : t.v) middle += mesh.material[static_cast<std::size_t>(v)][0];
    if (middle < 0) continue;
    for (Index& v : t.v) {
      const auto i = static_cast<std::size_t>(v);
      if (std::abs(mesh.material[i][0]) > 1e-9) continue;
      if (twin[i] < 0) {
        twin[i] = static_cast<Index>(mesh.positions.size());
        mesh.positions.push_back(Vec3<double>(mesh.positions[i]));
        mesh.material.push_back(Vec2<double>(mesh.material[i]));
      }
      v = twin[i];
    }
  }
  run(std::move(scene), setup, 20);
}

void isolated_vertex(const Setup& setup) {
  Scene scene = curtain(setup, 0.005, 8);
  mesh_of(scene).positions.push_back({0, 0.3, 0});
  mesh_of(scene).material.push_back({1, 1});
  must_be_refused([&] { run(std::move(scene), setup, 20); }, "a vertex without a triangle");
}

void three_on_an_edge(const Setup& setup) {
  Scene scene = curtain(setup, 0.005, 8);
  Mesh& mesh = mesh_of(scene);
  const Tri t = mesh.triangles[40];
  mesh.positions.push_back(mesh.positions[static_cast<std::size_t>(t.v[0])] +
                           Vec3<double>{0.01, 0.05, 0.01});
  mesh.material.push_back({1, 1});
  mesh.triangles.push_back({{t.v[1], t.v[0], static_cast<Index>(mesh.positions.size() - 1)}});
  must_be_refused([&] { run(std::move(scene), setup, 20); }, "an edge with three triangles");
}

/// Two sheets that share one vertex only.
void bow_tie(const Setup& setup) {
  Scene scene = curtain(setup, 0.005, 8);
  Mesh& mesh = mesh_of(scene);
  const auto count = static_cast<Index>(mesh.positions.size());
  const Vec3<double> corner = mesh.positions[0];
  const Vec2<double> corner_material = mesh.material[0];
  for (const auto& [dx, dz] : {std::pair{-0.05, -0.02}, std::pair{-0.02, -0.05}}) {
    mesh.positions.push_back(corner + Vec3<double>{dx, 0, dz});
    mesh.material.push_back(corner_material + Vec2<double>{dx, dz});
  }
  mesh.triangles.push_back({{0, count, count + 1}});
  accepted_or_refused(setup, std::move(scene));
}

void triangle_twice(const Setup& setup) {
  Scene scene = curtain(setup, 0.005, 8);
  mesh_of(scene).triangles.push_back(Tri(mesh_of(scene).triangles[7]));
  must_be_refused([&] { run(std::move(scene), setup, 20); }, "a triangle that is there twice");
}

/// A sheet that runs through the middle of another.
Scene crossing(const Setup& setup) {
  Scene scene = empty_scene(setup, 0.005);
  scene.gravity = {0, 0, 0};
  scene.cloths.push_back(square(8, 0));
  scene.cloths.push_back(square(7, 0));
  for (auto& x : scene.cloths[1].mesh.positions) x = {0.05 + x[0] / 3, x[1] / 2, x[0] / 2 + 0.03};
  for (auto& m : scene.cloths[1].mesh.material) m = {m[0] * std::hypot(1.0 / 2, 1.0 / 3), m[1] / 2};
  jitter(scene, setup);
  return scene;
}

void tangled(const Setup& setup) {
  must_be_refused([&] { run(crossing(setup), setup, 5); }, "a start that intersects");
}

void untangled(const Setup& setup) {
  Scene scene = crossing(setup);
  scene.contact.untangle = true;
  run(std::move(scene), setup, 20);
}

void inside_obstacle(const Setup& setup) {
  Scene scene = sheet_on_sphere(setup, 0.005);
  for (auto& x : scene.cloths[0].mesh.positions) x[2] -= 0.03;
  jitter(scene, setup);
  must_be_refused([&] { run(std::move(scene), setup, 5); }, "a start inside of an obstacle");
}

}  // namespace

std::vector<Case> mesh_cases() {
  return {
      {"slivers", "a row of triangles of 1 : 1,000,000 in a curtain; energy does not grow",
       [](const Setup& s) { slivers(s, Precision::single_precision); }},
      {"slivers_double", "the same in double precision",
       [](const Setup& s) { slivers(s, Precision::double_precision); }},
      {"zero_area_at_rest", "a triangle without area in material space is refused",
       [](const Setup& s) { zero_area(s, true); }},
      {"zero_area_at_start", "a triangle without area in space is refused",
       [](const Setup& s) { zero_area(s, false); }},
      {"duplicate_vertices", "two halves that meet in a row of vertices at the same places", torn},
      {"isolated_vertex", "a vertex without a triangle is refused", isolated_vertex},
      {"three_on_an_edge", "an edge with three triangles is refused", three_on_an_edge},
      {"bow_tie", "two sheets that share one vertex", bow_tie},
      {"triangle_twice", "a triangle that is there twice is refused", triangle_twice},
      {"tangled", "two sheets that cross are refused", tangled},
      {"untangled", "with contact.untangle they are parted first", untangled},
      {"inside_obstacle", "a sheet that cuts a sphere is refused", inside_obstacle},
  };
}

}  // namespace weft::stability
