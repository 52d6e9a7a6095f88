#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "host/io/mesh/mesh_file.hpp"
#include "weft/frame.hpp"
#include "weft/scene.hpp"
#include "weft/simulation.hpp"

namespace weft::app {

using io::FrameMeshes;

/// Joins the positions of a frame with the topology of its scene.
/// @pre `frame` comes from a simulation of `scene`
FrameMeshes frame_meshes(const Scene& scene, const Frame& frame);

/// With other meshes of the cloths than the scene has.
/// @param cloths [cloths]
FrameMeshes frame_meshes(const Scene& scene, const Frame& frame,
                         const std::vector<const Mesh*>& cloths);

/// The directory of a run: its file names, its frames and its checkpoints. Removes only files whose
/// names a run itself writes.
class RunDirectory {
 public:
  explicit RunDirectory(std::filesystem::path path) : path_(std::move(path)) {}

  const std::filesystem::path& path() const { return path_; }
  std::filesystem::path frames() const { return path_ / "frames"; }
  /// Folder of displaced obstacles, apart from the frames so that nothing takes them for frames.
  std::filesystem::path displaced() const { return path_ / "displaced"; }
  /// All obstacles of a frame where they were simulated; there if cloth displaced one of them.
  std::filesystem::path displaced(int frame) const;
  std::filesystem::path scene() const { return path_ / "scene.json"; }
  std::filesystem::path steps() const { return path_ / "steps.jsonl"; }
  std::filesystem::path report() const { return path_ / "report.json"; }
  std::filesystem::path preview() const { return path_ / "preview.png"; }
  /// Picture of the place where a step failed, or where the start could not be untangled.
  std::filesystem::path failure() const { return path_ / "failure.png"; }
  std::filesystem::path checkpoint(int frame) const;
  /// One file of all frames: usda, glb.
  std::filesystem::path animation(FrameFormat format) const {
    return frames() / (format == FrameFormat::glb ? "animation.glb" : "animation.usda");
  }
  /// From which the animation is made.
  std::filesystem::path spool(FrameFormat format) const {
    return animation(format).concat(".spool");
  }
  /// Point cache of a mesh, by its name in the scene.
  std::filesystem::path cache(const std::string& name, bool obstacle) const;
  /// The mesh that a point cache moves.
  std::filesystem::path cached_mesh(const std::string& name, bool obstacle) const;
  /// Point caches that are there.
  std::vector<std::filesystem::path> caches() const;

  /// Makes the directory and its folder of frames where they are missing.
  /// @throws SceneError naming the directory if that fails
  void create() const;

  /// Whether an earlier run has left anything here, other than the picture of a start that was
  /// refused.
  bool holds_run() const;

  /// @throws SceneError naming the directory if it holds a run
  void refuse_run() const;

  /// A run that somebody else has made may hold links to files that are none of its own.
  /// @throws SceneError naming the link if a file or a folder of a run is one
  void refuse_links() const;

  /// Removes the frames that an earlier run left, with their obstacles.
  /// @throws SceneError naming the file that cannot be removed
  void clear_frames() const;

  /// Removes all that an earlier run left.
  /// @throws SceneError naming the file that cannot be removed
  void clear() const;

  /// Removes what a run left beyond `frame`: later frames of a file each, later checkpoints, and
  /// displaced obstacles of later frames, and the report and pictures of its end. Files that hold
  /// several frames are for FrameWriter to cut.
  /// @param keep a checkpoint that is never removed, whatever its name
  /// @throws SceneError naming the file that cannot be removed
  void clear_after(int frame, const std::filesystem::path& keep) const;

  /// Checkpoints that are there, regular files only, newest first.
  std::vector<std::filesystem::path> checkpoints() const;

  /// Writes a checkpoint and removes all but the last two.
  /// @param file  of checkpoint()
  /// @param state see Simulation::state()
  /// @throws std::filesystem::filesystem_error if it cannot be written
  void save_checkpoint(const std::filesystem::path& file, const std::string& state) const;

  /// Which obstacles go with a frame.
  enum class Obstacles {
    of_this_frame,
    of_all_frames,  ///< none of them ever moves
    none,           ///< those of all frames are there already
  };

  /// Writes frames/cloth_<number> and, if the scene has any, frames/obstacle_<number> or
  /// frames/obstacle, in the scene's format, which is one of a file per frame, in world positions.
  /// Far from (0, 0, 0) they are in double precision whatever that of the run.
  /// @throws SceneError if a file cannot be written
  void write_frame(const Scene& scene, const FrameMeshes& meshes, int number,
                   Obstacles obstacles = Obstacles::of_this_frame) const;

  /// Writes displaced/displaced_<number>.obj if the frame has displaced obstacles, and removes what
  /// an earlier run has left under that name if not. The world positions are in double precision,
  /// whatever the format of the frames; near (0, 0, 0) they are those that were simulated, to the
  /// bit.
  /// @throws SceneError if the file cannot be written, or removed
  void write_displaced(const FrameMeshes& meshes, int number) const;

  /// What write_displaced() wrote, as one mesh with a group per obstacle; nothing if no obstacle of
  /// the frame was displaced.
  /// @throws SceneError if the file cannot be read
  std::optional<Mesh> read_displaced(int number) const;

 private:
  /// @param precision of the coordinates of cloths
  void write_frame(const Scene& scene, const FrameMeshes& meshes, int number, Obstacles obstacles,
                   Precision precision) const;

  /// Removes the displaced obstacles of frames beyond `frame`, and their folder if nothing is left.
  void remove_displaced_after(int frame) const;

  std::filesystem::path path_;
};

}  // namespace weft::app
