#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
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
  std::filesystem::path scene() const { return path_ / "scene.json"; }
  std::filesystem::path steps() const { return path_ / "steps.jsonl"; }
  std::filesystem::path report() const { return path_ / "report.json"; }
  std::filesystem::path preview() const { return path_ / "preview.png"; }
  std::filesystem::path checkpoint(int frame) const;
  std::filesystem::path animation() const { return frames() / "animation.usda"; }
  /// From which the animation is made.
  std::filesystem::path spool() const { return frames() / "animation.usda.spool"; }
  /// Point cache of a mesh, by its name in the scene.
  std::filesystem::path cache(const std::string& name, bool obstacle) const;
  /// The mesh that a point cache moves.
  std::filesystem::path cached_mesh(const std::string& name, bool obstacle) const;
  /// Point caches that are there.
  std::vector<std::filesystem::path> caches() const;

  /// Makes the directory and its folders where they are missing.
  /// @throws SceneError naming the directory if that fails
  void create() const;

  /// Whether an earlier run has left anything here.
  bool holds_run() const;

  /// @throws SceneError naming the directory if it holds a run
  void refuse_run() const;

  /// A run that somebody else has made may hold links to files that are none of its own.
  /// @throws SceneError naming the link if a file of a run, or the folder of frames, is one
  void refuse_links() const;

  /// Removes all that an earlier run left.
  /// @throws SceneError naming the file that cannot be removed
  void clear() const;

  /// Removes what a run left beyond `frame`: later frames of a file each, later checkpoints, and
  /// the report and preview of its end. Files that hold several frames are for FrameWriter to cut.
  /// @param keep a checkpoint that is never removed, whatever its name
  /// @throws SceneError naming the file that cannot be removed
  void clear_after(int frame, const std::filesystem::path& keep) const;

  /// Checkpoints that are there, regular files only, newest first.
  std::vector<std::filesystem::path> checkpoints() const;

  /// Writes checkpoint_<frames completed>.weft and removes all but the last two.
  /// @return the file written
  /// @throws std::filesystem::filesystem_error if it cannot be written
  std::filesystem::path save_checkpoint(const Simulation& simulation) const;

  /// Writes frames/cloth_<number> and, if the scene has any, frames/obstacle_<number>, in the
  /// scene's format, which is one of a file a frame.
  /// @throws SceneError if a file cannot be written
  void write_frame(const Scene& scene, const FrameMeshes& meshes, int number) const;

 private:
  std::filesystem::path path_;
};

}  // namespace weft::app
