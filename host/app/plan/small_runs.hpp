#pragma once

#include <map>
#include <string>
#include <vector>

#include "host/app/run/scene_request.hpp"
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

  /// @param request that `scene` was read by
  /// @throws SceneError if the runs have no place to be written to
  SmallRuns(const Scene& scene, SceneRequest request);

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
  SceneRequest request_;
  double triangles_;
  ScratchFolder scratch_;
  std::map<std::vector<std::string>, Run> done_;  ///< by arguments
};

}  // namespace weft::app
