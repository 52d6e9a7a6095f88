#pragma once

#include <map>
#include <string>
#include <vector>

#include "host/base/scratch_folder.hpp"
#include "weft/scene.hpp"

namespace weft::app {

/// Runs of all frames of a scene with other settings, on one CPU thread and a mesh that can be
/// reduced. Each is made once, and removed with this object.
class SmallRuns {
 public:
  struct Run {
    std::string folder;   ///< empty: it did not end well
    std::string problem;  ///< one line: why
  };

  /// @param file      of the scene
  /// @param overrides of the scene's values
  /// @param allowed   folders of files that the scene names, beside its own
  /// @param experimental values that are no keys of scenes
  /// @throws SceneError if the runs have no place to be written to
  SmallRuns(const Scene& scene, std::string file, std::vector<std::string> overrides,
            std::vector<std::string> allowed, std::vector<std::string> experimental);

  /// Triangles of the mesh as it is.
  double triangles() const { return triangles_; }
  /// Whether the mesh can be made with so many triangles.
  bool reducible(double triangles) const;

  /// @param triangles 0: the mesh as it is
  /// @param settings  as for --set
  const Run& run(double triangles, const std::vector<std::string>& settings);

  static constexpr double triangles_max = 1000;  ///< that a run had best have
  static constexpr double seconds_max = 60;      ///< a run is killed after

 private:
  std::string file_;
  std::vector<std::string> overrides_;
  std::vector<std::string> allowed_;
  std::vector<std::string> experimental_;
  double triangles_ = 0;
  ScratchFolder scratch_;
  std::map<std::vector<std::string>, Run> done_;  ///< by arguments
};

}  // namespace weft::app
