#pragma once

#include <optional>

#include "host/app/run/run_directory.hpp"
#include "host/app/run/run_request.hpp"
#include "host/lab/check/displaced_verdict.hpp"
#include "weft/scene.hpp"

namespace weft::app {

enum ExitCode { done = 0, simulation_failed = 4, stopped = 130 };

/// Verdict on the last frame of a run.
/// @param sewn, self see lab::ValidatorOptions
lab::DisplacedVerdict validate_frame(const FrameMeshes& meshes, bool sewn, bool self);

/// Says on standard error that cloth intersects something at the end.
void warn_of_intersections(const lab::DisplacedVerdict& verdict, const RunDirectory& directory);

/// Whether a run draws preview.png: as the request says, else if standard output and standard error
/// are a terminal, where a person waits for it.
bool draws_preview(const RunRequest& request);

/// Draws preview.png, small and with few rays, so that it takes little of the time of a small run.
/// A run whose picture cannot be drawn has been done all the same.
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
