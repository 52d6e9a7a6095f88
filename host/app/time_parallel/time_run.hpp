#pragma once

#include "host/app/run/run_request.hpp"
#include "host/io/scene/scene_file.hpp"

namespace weft::app {

/// Simulates a scene with the method "time_parallel" and writes its directory: that of any run, and
///   partition.json    where slices begin; --partition takes it back
///   time_parallel/    states of the coarse run, starts, checkpoints and frames of slices
/// With --resume latest only what is not done yet is simulated.
/// @return and throws as run_scene()
int run_slices_of(const RunRequest& request, io::SceneFile file);

}  // namespace weft::app
