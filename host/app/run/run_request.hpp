#pragma once

#include <optional>
#include <string>
#include <vector>

#include "host/app/run/scene_request.hpp"

namespace weft::app {

/// What `weft run` was asked for; an empty text was not given.
struct RunRequest : SceneRequest {
  std::string output;  ///< default: see output_folder()
  std::string method;
  std::string device;  ///< also where a run goes on, or the scene says another
  std::string precision;
  std::string frames;
  std::string resume;           ///< a checkpoint, or "latest"
  bool resume_changed = false;  ///< even if the scene is another than the checkpoint's
  bool overwrite = false;       ///< replace a run that the directory holds
  std::string report;           ///< where to write the report beside DIR/report.json
  std::optional<bool> preview;  ///< nothing: if a person watches, see draws_preview()
  double time_limit = 0;        ///< [s] of wall time; 0: none
  int live_port = -1;           ///< where the page of the run is served; 0: any port; -1: nowhere
  int workers = 0;              ///< of the method "time_parallel"; 0: not given
  std::string schedule;         ///< a file, as above
  bool processes = false;       ///< as above
};

/// The overrides, and those that options of their own stand for.
inline std::vector<std::string> all_overrides(const RunRequest& request) {
  std::vector<std::string> overrides = request.overrides;
  if (!request.method.empty()) overrides.push_back("method.type=" + request.method);
  if (!request.precision.empty()) overrides.push_back("precision=" + request.precision);
  if (!request.frames.empty()) overrides.push_back("time.frames=" + request.frames);
  return overrides;
}

}  // namespace weft::app
