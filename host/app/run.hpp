#pragma once

#include <string>
#include <vector>

namespace CLI {
class App;
}

namespace weft::app {

/// What `weft run` was asked for; an empty text was not given.
struct RunRequest {
  std::string scene;
  std::string output;  ///< default: see output_folder()
  std::string method;
  std::string device;  ///< also where a run goes on, or the scene says another
  std::string precision;
  std::string frames;
  std::vector<std::string> overrides;  ///< "path=value" each
  std::vector<std::string> allowed;    ///< folders of files that the scene names, beside its own
  std::string resume;                  ///< a checkpoint, or "latest"
  std::string report;                  ///< where to write the report beside DIR/report.json
  bool preview = true;
  int workers = 0;         ///< of the method "time_parallel"; 0: not given
  std::string partition;   ///< a file, likewise
  bool processes = false;  ///< likewise
};

/// Simulates a scene and writes its directory.
/// @return 0 done, 4 the simulation failed, 130 stopped by SIGINT or SIGTERM; for the last two a
///         checkpoint and the report were written
/// @throws SceneError for bad input, or a file that cannot be written
/// @throws DeviceError if a device is missing or fails
int run_scene(const RunRequest& request);

/// Adds `weft run SCENE`.
/// @param app       program to add the verb to
/// @param exit_code must outlive the parsing; set when the verb runs, see run_scene(). What that
///                  throws comes out of the parsing.
void add_run_verb(CLI::App& app, int& exit_code);

}  // namespace weft::app
