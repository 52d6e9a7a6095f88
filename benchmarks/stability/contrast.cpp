// Stiff beside soft, heavy on light.
#include <fmt/format.h>

#include <utility>

#include "benchmarks/stability/run.hpp"
#include "weft/shapes.hpp"

namespace weft::stability {
namespace {

/// A curtain whose left half is `ratio` times as stiff as its right half.
void stiffness_ratio(const Setup& setup, double ratio, Precision precision) {
  Scene scene = curtain(setup, 0.005, 8);
  if (setup.method != "asynchronous") scene.precision = precision;
  scene.materials[0].stretch_stiffness = 20;
  scene.materials.push_back(scene.materials[0]);
  scene.materials[1].name = "stiff";
  scene.materials[1].stretch_stiffness *= ratio;
  Cloth& cloth = scene.cloths[0];
  for (const Tri& t : cloth.mesh.triangles) {
    double middle = 0;
    for (const Index v : t.v) middle += cloth.mesh.material[static_cast<std::size_t>(v)][0];
    cloth.triangle_material.push_back(middle < 0 ? 1 : 0);
  }
  jitter(scene, setup, 1e-3 / ratio);  // what is stiff must not start stretched
  const double scale = weight_energy(scene);
  Run simulation = start(std::move(scene), setup);
  const double before = total_energy(simulation);
  simulation.watch(40);
  require_no_energy_gain(before, total_energy(simulation), scale);
}

/// A heavy sheet falls on a light one that lies on a box.
void mass_ratio(const Setup& setup, double ratio) {
  Scene scene = empty_scene(setup, 0.005);
  scene.materials[0].density = 0.01;
  scene.materials.push_back(scene.materials[0]);
  scene.materials[1].name = "heavy";
  scene.materials[1].density *= ratio;
  scene.materials[1].stretch_stiffness *= ratio;
  scene.cloths.push_back(square(8, 0.003));
  scene.cloths.push_back(square(7, 0.01));
  scene.cloths[1].material = 1;
  Obstacle box;
  box.name = "box";
  box.mesh = make_box({0.3, 0.3, 0.1}, {3, 3, 1});
  box.transform.translate = {0, 0, -0.05};
  scene.obstacles.push_back(box);
  jitter(scene, setup);
  const double scale = weight_energy(scene);
  Run simulation = start(std::move(scene), setup);
  const double before = total_energy(simulation);
  simulation.watch(40);
  require_no_energy_gain(before, total_energy(simulation), scale);
}

}  // namespace

std::vector<Case> contrast_cases() {
  std::vector<Case> cases;
  for (const double ratio : {1.0, 1e2, 1e4, 1e6, 1e8})
    cases.push_back(
        {fmt::format("stiffness_ratio_{:g}", ratio),
         fmt::format("a curtain, one half {:g} times as stiff; energy does not grow", ratio),
         [ratio](const Setup& s) { stiffness_ratio(s, ratio, Precision::single_precision); }});
  for (const double ratio : {1e6, 1e8})
    cases.push_back(
        {fmt::format("stiffness_ratio_{:g}_double", ratio), "the same in double precision",
         [ratio](const Setup& s) { stiffness_ratio(s, ratio, Precision::double_precision); }});
  for (const double ratio : {1.0, 1e2, 1e4})
    cases.push_back(
        {fmt::format("mass_ratio_{:g}", ratio),
         fmt::format("a sheet falls on one {:g} times lighter; energy does not grow", ratio),
         [ratio](const Setup& s) { mass_ratio(s, ratio); }});
  return cases;
}

}  // namespace weft::stability
