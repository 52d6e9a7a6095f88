#pragma once

#include <nlohmann/json.hpp>

namespace weft::app {

/// Whether a resolved scene sews cloth: its frames then have vertices of several numbers at one
/// place.
inline bool sews(const nlohmann::json& scene) {
  for (const char* key : {"seams", "garments"})
    if (scene.contains(key) && !scene.at(key).empty()) return true;
  return false;
}

}  // namespace weft::app
