#pragma once

#include <memory>
#include <string>

#include "host/app/run/run_directory.hpp"
#include "host/app/run/run_lock.hpp"
#include "host/app/run/run_request.hpp"

namespace weft::app {

/// Locks the directory of a run if it is there already.
/// @return null if it is not
/// @throws SceneError if another run uses it, or if it holds a run that the request neither
///         continues nor replaces
std::unique_ptr<RunLock> lock_existing(const RunDirectory& directory, const RunRequest& request);

/// Refuses a file that could not be written at the end of a run, or that is its scene.
/// @param option that names it
/// @throws SceneError
void refuse_unwritable(const std::string& file, const std::string& option,
                       const std::string& scene = {});

}  // namespace weft::app
