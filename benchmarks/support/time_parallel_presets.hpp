#pragma once

#include <fmt/format.h>

#include <map>
#include <string>
#include <vector>

/// The scenes of weft_bench_time_parallel.
namespace weft::bench {

/// A scene of this tree, or of ARCSim, and what is set in it.
struct Preset {
  std::string scene;
  std::vector<std::string> overrides;
  bool arcsim = false;
};

/// A scene of ARCSim in slices that remesh, below a coarse run that does too.
/// @param criteria of the scene, finer by one factor, so that it has the paper's triangles
inline Preset arcsim_preset(const std::string& scene, const std::string& criteria, double step) {
  return {scene,
          {"method.time_parallel.method=adaptive", "method.time_parallel.coarse_mesh=adaptive",
           "method.time_parallel.coarse_newton_iterations=1", "remeshing={" + criteria + "}",
           "remeshing.aspect_min=0.2",
           fmt::format("time={{\"step\": {}, \"frame_rate\": 25, \"frames\": 500}}", step)},
          true};
}

/// Substitutes for the paper's scenes. Blue Dress and Sphere are ARCSim's own, of which the latter
/// is here on a mesh that stays too (`sphere`); of Yellow Dress there is no file, and the blue one
/// with more triangles stands for it. Numbers of triangles are near the paper's, in multiples of
/// five cells where cloths are grids; those of bodies too: what a coarse run takes its time for are
/// their triangles, which nothing coarsens. Where bodies move into cloth, coarse contacts are five
/// times as thick, as edges are as long: impact zones would cost more than all the rest of the
/// coarse run. Not in `falling`, whose sheets begin two such thicknesses apart: its pile would not
/// lie as the fine one. Where bodies drive the cloth (`karate`, `twisting`, `funnel`,
/// ARCSim's) coarse steps by one iteration of Newton's method, as fine ones are, cost a third to
/// eight tenths of those by two or more, and seams jump about as far.
inline const std::map<std::string, Preset> presets{
    {"drape", {"drape", {"triangles=3200", "time.frames=25"}}},
    {"swing",
     {"drape",
      {"cloths.0.grid={\"size\": [0.6, 0.6], \"cells\": [40, 40]}", "obstacles=[]",
       "pins=[{\"cloth\": \"cloth\", \"vertices\": [1640, 1680]}]",
       "materials.cotton.stretch_stiffness=300", "materials.cotton.bending_stiffness=1e-4",
       "time.frames=25"}}},
    {"sphere",
     {"sphere",
      {"triangles=28800", "obstacles.0.sphere.subdivisions=3", "obstacles.1.plane.cells=[24, 24]",
       "method.time_parallel.coarse_thickness=5",
       "time={\"step\": 0.00333333333, \"frame_rate\": 25, \"frames\": 500}"}}},
    {"falling",
     {"stack",
      {"triangles=98000", "obstacles.0.box.cells=[58, 58, 3]",
       "time={\"step\": 0.005, \"frame_rate\": 25, \"frames\": 500}"}}},
    {"karate",
     {"dancer_skirt",
      {"triangles=58000", "method.time_parallel.coarse_thickness=5",
       "method.time_parallel.coarse_newton_iterations=1",
       "time={\"step\": 0.005, \"frame_rate\": 25, \"frames\": 500}"}}},
    {"twisting",
     {"twist",
      {"triangles=64000", "contact.thickness=0.0004", "method.time_parallel.coarse_thickness=5",
       "method.time_parallel.coarse_newton_iterations=1", "obstacles.0.capsule.subdivisions=1",
       "obstacles.1.capsule.subdivisions=1",
       "time={\"step\": 0.005, \"frame_rate\": 25, \"frames\": 500}"}}},
    {"funnel",
     {"funnel",
      {"triangles=65000", "method.time_parallel.coarse_thickness=5",
       "method.time_parallel.coarse_newton_iterations=1", "obstacles.0.revolution.edge=0.045",
       "obstacles.1.sphere.subdivisions=2",
       "time={\"step\": 0.002, \"frame_rate\": 25, \"frames\": 500}"}}},
    {"blue_dress",
     arcsim_preset("dress-blue",
                   R"("size": [0.0057, 0.2], "refine_angle": 0.17, "refine_compression": 0.0057,
                      "refine_velocity": 0.29)",
                   0.002)},
    {"yellow_dress",
     arcsim_preset("dress-blue",
                   R"("size": [0.005, 0.2], "refine_angle": 0.15, "refine_compression": 0.005,
                      "refine_velocity": 0.25)",
                   0.002)},
    {"sphere_adaptive",
     arcsim_preset("sphere",
                   R"("size": [0.0031, 0.2], "refine_angle": 0.095, "refine_compression": 0.0016,
                      "refine_velocity": 0.16)",
                   0.00333333333)},
};

}  // namespace weft::bench
