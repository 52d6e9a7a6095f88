#pragma once

#include <filesystem>

#include "host/io/json/json_fields.hpp"
#include "weft/scene.hpp"

namespace weft::io {

/// What the coordinates of mesh files mean.
struct FileAxes {
  double unit = 1;    ///< [m] length of one
  bool y_up = false;  ///< y points up, and -z to where +y of the scene does
};

/// units, up
/// @param usual what `fields` does not say
FileAxes read_file_axes(Fields& fields, const FileAxes& usual);

/// The same for one file. A USD file says itself what its coordinates mean, and is read in metres
/// with z up.
/// @throws SceneError if it is one and `fields` has such a key
FileAxes read_axes_of(const std::filesystem::path& file, Fields& fields, const FileAxes& usual);

/// Takes positions and material coordinates from a file's axes to metres, and z up.
void to_scene_axes(const FileAxes& axes, Mesh& mesh);

}  // namespace weft::io
