#pragma once

#include <vector>

#include "host/render/picture.hpp"

namespace weft::io {

/// What a picture of a place and its surroundings shows.
struct CloseUp {
  std::vector<NamedMesh> cloths;     ///< as given, without triangles beyond the surroundings
  std::vector<NamedMesh> obstacles;  ///< cropped too, without what is drawn as wires
  double radius = 0;                 ///< [m] of the surroundings
  PictureOptions options;            ///< with a camera that looks at the place
};

/// Prepares a picture of the surroundings of a place: all within five edge lengths of the
/// nearest cloth, or farther if that cloth itself is farther away. A cross marks the place. Of 96
/// directions, evenly spread, the camera takes the one that shows most of the cloth. Obstacles that
/// would still hide the place are drawn as wires.
/// @param place   [m] finite
/// @param options their camera is replaced
/// @throws SceneError if an option is out of range, no cloth triangle has three finite corners and
///         an area, or a triangle names a vertex that is not there
/// @throws DeviceError if the ray tracer cannot start
CloseUp close_up(const std::vector<NamedMesh>& cloths, const std::vector<NamedMesh>& obstacles,
                 const Vec3<double>& place, const PictureOptions& options = {});

}  // namespace weft::io
