#pragma once

#include <filesystem>
#include <vector>

#include "host/io/json/json_fields.hpp"
#include "weft/scene.hpp"

namespace weft::io {

/// {translate, scale, rotate [degrees, x, y, z]} under `key`; nothing is no transform.
/// @throws SceneError
Transform read_arcsim_transform(Fields& fields, const std::string& key);

/// x -> outer(inner(x)). The rotation is the one of its kind nearest to no turn.
Transform composed(const Transform& outer, const Transform& inner);

/// The motion after a placement: x -> motion(inner(x)). Exact at the keys; between them too if the
/// motion does not turn or scale, else the motion is first divided into short pieces.
Motion composed(const Motion& motion, const Transform& inner);

/// One motion of a scene, a list of {time, transform, velocity}: cubic Hermite, Catmull-Rom slopes,
/// zero slope at both ends. Where keys give velocities of their own, which weft's motions do not
/// have, the curve is divided into pieces of 1/32 of the time between keys and followed to some
/// 2e-4 of the way between two keys; outside of the keys it is held all the same.
/// @return at least two keys
/// @throws SceneError
Motion read_arcsim_keys(std::vector<Fields>& keys);

/// Motion capture (.mot): "NumFrames: N", then for each body a line of text, N positions [m], a
/// line of text and N quaternions w x y z.
/// @param frame_rate [1/s] > 0
/// @throws SceneError naming file and line
std::vector<Motion> read_mot(const std::filesystem::path& path, double frame_rate,
                             const Transform& placement);

/// As the value of a weft scene's "motion".
nlohmann::json motion_json(const Motion& motion);
nlohmann::json transform_json(const Transform& transform);

}  // namespace weft::io
