#pragma once

#include <memory>
#include <string>
#include <vector>

#include "host/app/run_directory.hpp"
#include "host/app/run_lock.hpp"

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
  bool resume_changed = false;         ///< even if the scene is another than the checkpoint's
  bool overwrite = false;              ///< replace a run that the directory holds
  std::string report;                  ///< where to write the report beside DIR/report.json
  bool preview = true;
  int workers = 0;         ///< of the method "time_parallel"; 0: not given
  std::string partition;   ///< a file, likewise
  bool processes = false;  ///< likewise
};

/// Locks the directory of a run if it is there already.
/// @return null if it is not
/// @throws SceneError if another run uses it, or if it holds a run that the request neither
///         continues nor replaces
std::unique_ptr<RunLock> lock_existing(const RunDirectory& directory, const RunRequest& request);

/// Refuses a file that could not be written at the end of a run.
/// @param option that names it
/// @throws SceneError
void refuse_unwritable(const std::string& file, const std::string& option);

/// Simulates a scene and writes its directory.
/// @return 0 done, 4 the simulation failed, 130 stopped by a signal; for the last two a checkpoint
///         and the report were written
/// @throws SceneError for bad input, a directory that another run uses or has left its files in,
///         or a file that cannot be written
/// @throws DeviceError if a device is missing or fails
int run_scene(const RunRequest& request);

/// Adds `weft run SCENE`.
/// @param app       program to add the verb to
/// @param exit_code must outlive the parsing; set when the verb runs, see run_scene(). What that
///                  throws comes out of the parsing.
void add_run_verb(CLI::App& app, int& exit_code);

}  // namespace weft::app
