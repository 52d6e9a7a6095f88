#pragma once

#include <vector>

#include "host/io/mesh/mesh_file.hpp"

namespace weft::io {

/// Takes a mesh apart into the objects that its file joined, by Mesh::object, or else Mesh::group:
/// what a file with several objects says of them, see read_mesh(). Where there are objects, they
/// keep their groups and parts.
/// @param joined may be of Uv::where_some
/// @return a mesh per object, in the order of their first vertices, which keep their order;
///         `joined` itself if a vertex belongs to two objects or to none, or if one has no name.
///         Each has material coordinates for all corners, or none
std::vector<NamedMesh> split_objects(NamedMesh joined);

}  // namespace weft::io
