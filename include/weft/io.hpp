#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "weft/scene.hpp"

/// Files, in the component weft::io.
namespace weft {

/// Reads a mesh from .obj, .ply or any format that assimp reads. Texture coordinates become
/// material coordinates, in metres: the flat pattern of cloth. Materials, groups or objects of the
/// file become groups.
/// @throws SceneError naming file, line or element
Mesh load_mesh(const std::filesystem::path& file);

/// Writes a mesh as .obj or .ply, by the ending.
/// @throws SceneError if the ending is another, or the file cannot be written
void save_mesh(const std::filesystem::path& file, const Mesh& mesh);

/// Reads and validates a scene file.
/// @param overrides "path=value" each, such as "time.step=0.01"
/// @throws SceneError for anything wrong in the scene, its meshes or the overrides
Scene load_scene(const std::filesystem::path& file, const std::vector<std::string>& overrides = {});

}  // namespace weft
