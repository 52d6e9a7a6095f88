#pragma once

#include <vector>

#include "host/io/mesh/mesh_file.hpp"

namespace weft::io {

/// Takes a mesh apart into the objects that its file joined, by Mesh::group: what a file with
/// several objects says of them, see read_mesh().
/// @param joined with material coordinates for all corners, or none
/// @return a mesh a group, in the order of their first vertices, which keep their order; `joined`
///         itself if a vertex belongs to two groups or to none, or if a group has no name
std::vector<NamedMesh> split_objects(NamedMesh joined);

}  // namespace weft::io
