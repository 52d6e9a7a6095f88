#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "host/io/mesh/mesh_file.hpp"
#include "weft/scene.hpp"

namespace weft::io {

/// Meshes over time, wherever they stand. Frames are read when they are asked for.
class MeshSequence {
 public:
  virtual ~MeshSequence() = default;

  /// Numbers of the frames, increasing; at least one.
  const std::vector<int>& frames() const { return frames_; }
  double frame_rate() const { return frame_rate_; }  ///< [1/s] 25 where nothing says

  /// Safe to call from several threads at once. Formats in single precision may have an origin.
  /// @param place among frames()
  /// @throws SceneError for a file that is missing or damaged
  virtual FrameMeshes read(std::size_t place) const = 0;

  /// What to call a frame in a message: the file, and the frame where it holds several.
  virtual std::string describe(std::size_t place) const = 0;

 protected:
  std::vector<int> frames_;
  double frame_rate_ = 25;
};

/// Opens what `path` names:
///   DIR          the frames of a run, in any format that `weft run` writes, whether it has ended,
///                was stopped, or still goes on
///   DIR/%05d.obj numbered meshes, .obj or .ply; %d or %0Nd
///   NAME.usda    an animated USD text file
///   NAME.pc2     a point cache, of the mesh NAME.obj or NAME.ply beside it
///   a mesh file  one frame, number 0
/// @param allowed folders that files which the meshes name may lie below, beside the meshes' own
/// @throws SceneError if there is none, or it cannot be read
std::unique_ptr<MeshSequence> open_sequence(const std::filesystem::path& path, Uv uv = Uv::material,
                                            const std::vector<std::string>& allowed = {});

/// Whether a directory holds frames as caches or as USD, rather than numbered meshes.
bool has_frame_caches(const std::filesystem::path& frames);

/// The file of the obstacles that stand in all frames of a run alike; empty: there is none.
std::filesystem::path still_obstacles(const std::filesystem::path& frames);

/// A name with a place for a number, such as "frame_%05d.obj".
class NumberedName {
 public:
  /// @throws SceneError if a % is no place for a number, or there are several
  explicit NumberedName(const std::string& pattern);
  bool has_place() const { return has_place_; }
  std::string with(int number) const;
  /// @return the number in a name of this pattern, -1 if it is of another
  int number_in(const std::string& name) const;

 private:
  std::string before_, after_;
  bool has_place_ = false;
  std::size_t width_ = 0;
};

}  // namespace weft::io
