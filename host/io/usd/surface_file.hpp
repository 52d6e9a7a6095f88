#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "host/io/mesh/mesh_file.hpp"
#include "host/io/usd/usd_file.hpp"

namespace weft::io {

/// All meshes of a file at a time code as one, in world positions. Groups are materials, or else
/// the names of the meshes, if there are several; parts are subsets, or else those names.
/// Material coordinates are kept if every mesh has them.
/// @throws SceneError as UsdFile::read()
Mesh surface_at(const UsdFile& file, double time, Uv uv);

/// read_mesh() for all mesh files, and for USD text files (.usda) with their first time code.
/// @param warnings gets a line for what was passed over; null: without
/// @throws SceneError naming file, line or element
Mesh read_surface(const std::filesystem::path& path, Uv uv, const ReadableFolders& folders,
                  std::vector<std::string>* warnings = nullptr);

/// Whether a name is that of a USD text file.
bool is_usd_file(const std::filesystem::path& path);

}  // namespace weft::io
