#pragma once

#include <optional>

#include "host/app/run/run_directory.hpp"
#include "host/lab/check/displaced_verdict.hpp"
#include "weft/scene.hpp"

namespace weft::app {

enum ExitCode { done = 0, simulation_failed = 4, stopped = 130 };

/// Verdict on the last frame of a run.
/// @param sewn see lab::ValidatorOptions
lab::DisplacedVerdict validate_frame(const FrameMeshes& meshes, bool sewn);

/// Draws preview.png. A run whose picture cannot be drawn has been done all the same.
/// @param time [s] of the frame
/// @return     whether it could be
bool write_preview(const RunDirectory& directory, const Scene& scene, const FrameMeshes& meshes,
                   double time);

/// Draws failure.png: cloth and obstacles about the place of a failure, as they were simulated.
/// Says so on standard error if it cannot: that must not hide the failure.
/// @param place [m] see StepReport::failure_place
/// @return whether it is there
bool write_failure_picture(const RunDirectory& directory, const FrameMeshes& meshes,
                           const std::optional<Vec3<double>>& place);

}  // namespace weft::app
