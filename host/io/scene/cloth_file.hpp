#pragma once

#include <filesystem>

#include "host/input/readable_folders.hpp"
#include "host/io/json/json_fields.hpp"
#include "host/io/scene/file_axes.hpp"
#include "weft/scene.hpp"

namespace weft::io {

/// The mesh of a cloth from a file, in metres with z up, with material coordinates [m].
/// @param fields  of the cloth: repair, uv, rest
/// @param folders of the files that the mesh names
/// @param scene   gets the warnings
/// @throws SceneError if no cloth can have the mesh
Mesh read_cloth_file(Fields& fields, const std::filesystem::path& path,
                     const ReadableFolders& folders, const FileAxes& axes, Scene& scene);

}  // namespace weft::io
