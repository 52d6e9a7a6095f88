#pragma once

#include <vector>

#include "host/asynchronous/window.hpp"
#include "host/model/model.hpp"
#include "tests/support/small_scenes.hpp"

namespace weft::test {

/// A scene for the asynchronous method, of a material without damping and no friction.
inline Scene asynchronous_scene() {
  Scene s;
  s.name = "asynchronous";
  s.method = "asynchronous";
  s.precision = Precision::double_precision;
  s.bending = Bending::plate;
  s.contact.thickness = 0.004;
  s.contact.friction = 0;
  Material m = cotton();
  m.stretch_stiffness = 50;
  m.damping_stiffness = 0;
  s.materials.push_back(m);
  s.asynchronous.restitution = 1;
  return s;
}

/// A model, and windows over it that have not moved yet.
struct WindowRun {
  Scene scene;
  Model model;
  Windows windows;
  std::vector<Vec3<double>> positions, velocities;
  StepReport total;

  explicit WindowRun(Scene s, int threads = 1)
      : scene(std::move(s)), model(make_model(scene)), windows(scene, model, threads) {
    positions = model.positions;
    velocities.assign(model.velocities.begin(),
                      model.velocities.begin() + model.cloth_vertex_count);
    windows.start(positions, velocities, 0);
  }
  /// Goes on to `end`, as one time step would.
  bool advance(double end) {
    const bool good = windows.advance(end, total);
    if (good) {
      windows.finish(positions, velocities);
      windows.start(positions, velocities, end, windows.driven());
    }
    return good;
  }
};

}  // namespace weft::test
