#pragma once

#include <random>

#include "weft/scene.hpp"

namespace weft {

/// The scene from another start, for what chaos decides: cloth is moved by up to a micrometre.
/// @param start number of the start; 0: as the scene is
inline Scene jittered(Scene scene, unsigned start) {
  if (start == 0) return scene;
  std::mt19937 random(start);
  for (Cloth& cloth : scene.cloths)
    for (Vec3<double>& x : cloth.mesh.positions)
      for (int c = 0; c < 3; ++c) x[c] += 1e-6 * (static_cast<double>(random()) / 0x1p31 - 1);
  return scene;
}

}  // namespace weft
