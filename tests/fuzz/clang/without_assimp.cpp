#include "host/io/animation/skinned_file.hpp"
#include "host/io/mesh/mesh_formats.hpp"
#include "host/io/scene/scene_parts.hpp"
#include "weft/error.hpp"

// The readers of weft alone: in a fuzzing build a file that assimp would read is refused.
namespace weft::io {

Mesh read_with_assimp(const std::filesystem::path& path, Uv, const ReadableFolders&) {
  throw SceneError("", "format", path.extension().string(), "formats that weft reads itself");
}

SkinnedSurface read_skinned(const std::filesystem::path& path, const SkinnedChoice&,
                            std::vector<std::string>&, const ReadableFolders&) {
  throw SceneError("", "format", path.extension().string(), "formats that weft reads itself");
}

/// What frames pictures needs a ray tracer.
CameraKey framing_camera(const Scene&) {
  CameraKey key;
  key.position = {0, -5, 1};
  return key;
}

}  // namespace weft::io
