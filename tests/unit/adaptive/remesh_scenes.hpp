#pragma once

#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "host/adaptive/remesh_scene.hpp"
#include "weft/core/mat.hpp"
#include "weft/scene.hpp"

/// Scenes whose cloths are remeshed without being simulated.
namespace weft::test {

inline Mat2<double> diagonal(double a, double b) {
  return {{a, 0, 0, b}};
}

inline constexpr double infinity = std::numeric_limits<double>::infinity();

/// Cloths of one material, in double precision.
inline Scene scene_of(std::vector<Mesh> meshes) {
  Scene scene;
  scene.precision = Precision::double_precision;
  scene.method = "adaptive";
  scene.materials.emplace_back();
  for (Mesh& mesh : meshes) {
    Cloth cloth;
    cloth.name = "cloth_" + std::to_string(scene.cloths.size());
    cloth.mesh = std::move(mesh);
    scene.cloths.push_back(std::move(cloth));
  }
  return scene;
}

/// All at rest where it starts.
inline InputState state_at_start(const Scene& scene) {
  InputState state;
  for (const Cloth& cloth : scene.cloths)
    for (const Vec3<double>& x : cloth.mesh.positions) {
      state.positions.push_back(x);
      state.velocities.push_back({0, 0, 0});
    }
  return state;
}

/// A remesh that may cost any energy, of the scene itself.
/// @param kept see named_inputs(), which stands for an empty one
inline SceneRemesh remeshed(Scene& scene, InputState state, const Surroundings& around = {},
                            const std::vector<unsigned char>& kept = {}) {
  SceneRemesh done =
      remesh_scene(scene, joined_inputs(scene, {}), kept.empty() ? named_inputs(scene) : kept,
                   std::move(state), around, {infinity});
  if (done.changed()) scene = done.scene;
  return done;
}

}  // namespace weft::test
