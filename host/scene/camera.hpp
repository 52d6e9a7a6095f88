#pragma once

#include <string>

#include "weft/scene.hpp"

/// The camera of a scene over time.
namespace weft {

/// Where the camera stands at `time`. Between keys position, target, up and field of view follow a
/// cubic Hermite curve with Catmull-Rom slopes and zero slope at both ends of each take; a take
/// ends before a key that jumps. Outside the keys, and between the last key of a take and the jump,
/// the camera is at rest.
/// @param time [s]
/// @return a key of this time
/// @pre camera.keys is not empty and has passed validate_camera()
CameraKey camera_at(const Camera& camera, double time);

/// @param file for messages
/// @throws SceneError if a key looks nowhere or along its up, a field of view is not 1 to 150
///         degrees, times do not increase, or the resolution is not 1 to 16384
void validate_camera(const Camera& camera, const std::string& file);

/// Checks the settings of the method "view", and, of a scene that has that method, that its camera
/// says where it is from the start to the end of the run: in one key, or in a track of that length.
/// A take of a single key counts as a camera at rest.
/// @pre validate_camera() passes
/// @throws SceneError
void validate_view(const Scene& scene);

}  // namespace weft
