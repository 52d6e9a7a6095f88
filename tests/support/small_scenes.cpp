#include "tests/support/small_scenes.hpp"

#include <cmath>

#include "weft/shapes.hpp"

namespace weft::test {

Cloth sheet(int cells, double z) {
  Cloth c;
  c.name = "sheet";
  c.mesh = make_grid({0.4, 0.4}, {cells, cells}, Diagonals::alternating);
  for (auto& p : c.mesh.positions) p[2] = z;
  return c;
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

namespace {

Scene empty_scene(Precision precision) {
  Scene s;
  s.precision = precision;
  s.materials.push_back(cotton());
  s.contact.thickness = 0.002;
  s.solver.partial_rows = 8;
  s.time.frames = 5;
  return s;
}

}  // namespace

Scene sheet_on_sphere(Precision precision, int cells) {
  Scene s = empty_scene(precision);
  s.name = "sheet on sphere";
  s.cloths.push_back(sheet(cells, 0.108));
  Obstacle o;
  o.name = "sphere";
  o.mesh = make_icosphere(0.1, 2);
  s.obstacles.push_back(o);
  return s;
}

Scene two_sheets(Precision precision) {
  Scene s = empty_scene(precision);
  s.name = "two sheets";
  s.cloths.push_back(sheet(10, 0.0));
  s.cloths.push_back(sheet(9, 0.006));
  s.cloths[1].velocity = {0.1, 0.05, -0.3};
  Obstacle o;
  o.name = "box";
  o.mesh = make_box({0.2, 0.2, 0.1}, {3, 3, 2});
  o.transform.translate = {0, 0, -0.054};
  s.obstacles.push_back(o);
  return s;
}

Scene thrown_sheet(double speed) {
  Scene s;
  s.precision = Precision::double_precision;
  s.gravity = {0, 0, 0};
  s.materials.push_back(cotton());
  s.contact.thickness = 0.002;
  s.solver.partial_rows = 8;
  s.time.step = 0.005;
  s.cloths.push_back(sheet(8, 0));
  s.cloths.push_back(sheet(7, 0.02));
  for (Vec3<double>& x : s.cloths[1].mesh.positions)
    x = apply({{0, 0, 0}, {0.6, 0.8, 0}, 0.06, 1}, x);
  s.cloths[1].velocity = {0.3 * speed, 0.1 * speed, -speed};
  return s;
}

Scene hanging_sheet(Precision precision, Integrator integrator) {
  Scene s = empty_scene(precision);
  s.name = "hanging sheet";
  s.integrator = integrator;
  s.cloths.push_back(sheet(10, 0.0));
  Pin still;
  still.vertices = {0};
  Pin moving;
  moving.vertices = {10};
  moving.motion = {{0, {}}, {0.1, {{0, -0.05, 0.02}, {0, 0, 1}, 0, 1}}, {0.2, {}}};
  s.pins = {still, moving};
  return s;
}

Scene released_sheet(Precision precision) {
  Scene s = empty_scene(precision);
  s.name = "released sheet";
  s.materials[0].bending_stiffness = 1e-3;
  s.cloths.push_back(sheet(10, 0.0));
  Pin pin;
  for (Index v = 0; v < 22; ++v) pin.vertices.push_back(v);
  pin.release_time = 0.06;
  s.pins = {pin};
  return s;
}

Scene curled_sheet(Precision precision, Bending bending) {
  Scene s = released_sheet(precision);
  s.name = "curled sheet";
  s.bending = bending;
  Cloth& cloth = s.cloths[0];
  const double r = 0.15;
  for (const auto& u : cloth.mesh.material)
    cloth.rest_positions.push_back({r * std::sin(u[0] / r), u[1], r * std::cos(u[0] / r)});
  return s;
}

Scene folded_napkin(Precision precision) {
  constexpr int cells = 4;
  Scene s = empty_scene(precision);
  s.name = "folded napkin";
  s.cloths.push_back(sheet(cells, 0));
  s.time.step = 0.01;
  Pin fixed, carried;
  for (Index v = 0; v <= cells; ++v) {
    fixed.vertices.push_back(v * (cells + 1));
    carried.vertices.push_back(v * (cells + 1) + cells);
  }
  carried.motion = {{0, {}}, {0.05, {{-0.2, 0, 0.2}}}, {0.1, {{-0.4, 0, 0}}}};
  s.pins = {fixed, carried};
  return s;
}

}  // namespace weft::test
