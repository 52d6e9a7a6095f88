#pragma once

#include <chrono>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "host/app/run/run_directory.hpp"
#include "host/io/mesh/pc2_file.hpp"
#include "host/io/spool/frame_spool.hpp"
#include "weft/scene.hpp"

namespace weft::app {

/// Writes the frames of a run in its scene's format:
///   obj, ply  a file per frame for the cloths, and one for the obstacles; one file of obstacles
///   for
///             all frames if none of them moves
///   pc2       a point cache a mesh, cloth.NAME.pc2 or obstacle.NAME.pc2, beside the mesh of the
///             first frame, .obj; obstacles that do not move have only that
///   usda      animation.usda, written from animation.usda.spool, at the end and now and then
///   before glb       animation.glb, the same; the spool stays beside it
/// Frames hold obstacles where the scene puts them. If cloth displaced one, all obstacles of the
/// frame as they were simulated go to a file beside the folder of frames:
/// RunDirectory::displaced(). Whatever moment the run is killed at, all frames up to the last are
/// there to be read and gone on from.
class FrameWriter {
 public:
  /// Touches no file yet.
  /// @param directory must outlive this, and so must the scene
  FrameWriter(const RunDirectory& directory, const Scene& scene)
      : directory_(directory), scene_(scene) {}

  /// Goes on with the frames that an earlier run left, of which those after `frame` are removed.
  /// @throws SceneError if files of an earlier run are damaged, or cannot be written
  void keep_until(int frame);

  /// @param number of the frame, that of the last call plus one
  /// @throws SceneError if a file cannot be written, or the format cannot hold the frame
  void write(const FrameMeshes& meshes, int number);

  /// Whether write() keeps a frame until finish(), which writes the last one alone.
  bool only_last() const { return scene_.output.frames == FramesWritten::last; }

  /// Waits until the frames of pc2 and usda are on the disk: a checkpoint must never know more
  /// frames than they, which cannot be written again one by one.
  /// @throws SceneError if that fails
  void sync() const;

  /// Makes of what there is so far what other programs read.
  /// @param complete the run has all its frames, so that nothing need be kept to go on quickly
  /// @throws SceneError if a file cannot be written
  void finish(bool complete);

 private:
  void write_now(const FrameMeshes& meshes, int number);
  void write_files(const FrameMeshes& meshes, int number);
  void write_caches(const FrameMeshes& meshes, int number);
  void write_spool(const FrameMeshes& meshes, int number);
  void show_so_far();
  void write_animation() const;
  void import_animation(int last_frame);
  bool moves(bool obstacle, std::size_t number) const;

  const RunDirectory& directory_;
  const Scene& scene_;
  std::optional<FrameMeshes> last_;  ///< yet to be written
  int last_number_ = 0;
  std::vector<std::unique_ptr<io::PointCacheWriter>> caches_;  ///< cloths, then obstacles
  std::unique_ptr<io::SpoolWriter> spool_;
  bool with_still_obstacles_ = false;  ///< the file of those that do not move is there
  unsigned shown_ = 0;                 ///< frames that were written to the spool
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
  std::chrono::steady_clock::duration writing_{};  ///< time that show_so_far() took
};

}  // namespace weft::app
