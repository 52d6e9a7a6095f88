#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "host/io/pattern/garment.hpp"

namespace weft::io {

/// What a scene of one garment on one body needs to know beside the garment.
struct GarmentSceneRequest {
  std::string name;  ///< of scene and cloth: letters, digits, _ and -
  std::string description;
  std::string fabric;
  std::string garment_file;  ///< as the scene names it
  std::string body_file;
};

/// A scene in which a garment is sewn at time 0 where its panels stand, moved out of the body, and
/// falls until it hangs. As scenes/scene.schema.json describes it.
nlohmann::json garment_scene(const Garment& garment, const GarmentSceneRequest& request);

/// Writes the mesh of a garment as OBJ, in metres with y up: one object, with its groups and parts.
/// @throws SceneError if the file cannot be written
void write_garment(const std::filesystem::path& path, const std::string& name,
                   const Garment& garment);

}  // namespace weft::io
