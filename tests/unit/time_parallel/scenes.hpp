#pragma once

#include <utility>

#include "weft/scene.hpp"
#include "weft/shapes.hpp"

namespace weft::test {

/// A sheet of 0.6 m that hangs by two corners of its far side, over a ball that it swings against.
inline Scene hanging_sheet(Index cells, Precision precision = Precision::double_precision) {
  Scene scene;
  scene.name = "sheet";
  scene.method = "time_parallel";
  scene.precision = precision;
  scene.time = {0.005, 25, 8};
  scene.output.checkpoint_every = 1;
  Material cotton;
  cotton.stretch_stiffness = 300;
  scene.materials.push_back(cotton);
  Cloth sheet;
  sheet.name = "sheet";
  sheet.mesh = make_grid({0.6, 0.6}, {cells, cells}, Diagonals::alternating);
  scene.cloths.push_back(std::move(sheet));
  Obstacle ball;
  ball.name = "ball";
  ball.mesh = make_icosphere(0.1, 2);
  ball.transform.translate = {0.02, -0.05, -0.12};
  scene.obstacles.push_back(std::move(ball));
  Pin pin;
  pin.vertices = {grid_vertex(cells, 0, cells), grid_vertex(cells, cells, cells)};
  scene.pins.push_back(pin);
  scene.contact.thickness = 0.004;
  return scene;
}

}  // namespace weft::test
