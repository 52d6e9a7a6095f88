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

/// A mesh of a frame.
struct FrameMesh {
  std::string name;
  bool obstacle = false;
  Mesh mesh;  ///< [m] in world places; panels are parts, or else groups
};

/// Numbers of the frames of a run, increasing.
/// @param run a directory of `weft run`, an animation or a mesh file
/// @throws SceneError if it has none
std::vector<int> frame_numbers(const std::filesystem::path& run);

/// Cloths and obstacles of a frame, as the run has written them.
/// @param number among frame_numbers()
/// @throws SceneError if there is none of this number, or it cannot be read
std::vector<FrameMesh> load_frame(const std::filesystem::path& run, int number);

/// Reads and validates a scene file.
/// @param overrides "path=value" each, such as "time.step=0.01"
/// @throws SceneError for anything wrong in the scene, its meshes or the overrides
Scene load_scene(const std::filesystem::path& file, const std::vector<std::string>& overrides = {});

}  // namespace weft
