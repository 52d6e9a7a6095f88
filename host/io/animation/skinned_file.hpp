#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "host/input/readable_folders.hpp"
#include "host/model/skinning.hpp"

/// Animated characters from drawing programs: FBX, glTF, Collada, DirectX, MD5 and what else
/// assimp reads.
namespace weft::io {

struct SkinnedChoice {
  int animation = 0;                ///< number of the animation in the file
  std::optional<std::string> name;  ///< of the animation, instead of its number
  bool y_up = true;                 ///< once assimp has read it; false: z up
  double scale = 1;                 ///< [m] a unit of the file
};

/// Reads all meshes of a file, those of all its nodes, as one surface that its animation moves.
///
/// Nodes follow the keys of the animation as assimp defines them: linear for positions and scales,
/// slerp for rotations, held before the first and after the last; nodes without keys stand as the
/// file has them. Vertices follow their bones by linear blend skinning, with weights brought to a
/// sum of 1; those without bones follow the node of their mesh. Vertices of equal position and
/// equal weights are one. The mesh is repaired (make_manifold) in the shape of the animation's
/// start.
/// @param warnings gets a line for everything that could not be taken over
/// @param folders  of the files that it names
/// @throws SceneError also for morph targets that the animation moves, and if there is no animation
SkinnedSurface read_skinned(const std::filesystem::path& path, const SkinnedChoice& choice,
                            std::vector<std::string>& warnings, const ReadableFolders& folders);
/// The same; files that it names lie below its own folder.
inline SkinnedSurface read_skinned(const std::filesystem::path& path, const SkinnedChoice& choice,
                                   std::vector<std::string>& warnings) {
  return read_skinned(path, choice, warnings, ReadableFolders(path));
}

}  // namespace weft::io
