#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "weft/scene.hpp"

namespace weft::io {

struct NamedMesh {
  std::string name;
  Mesh mesh;
};

/// What to do with the texture coordinates of a file.
enum class Uv {
  material,  ///< material coordinates [m], one a vertex
  ignore     ///< not wanted, so that seams do no harm: obstacles
};

/// Reads a mesh; the ending says which format: .obj, .ply (ascii or binary little endian), anything
/// else through assimp. Vertices keep their number and order (formats that store a vertex once a
/// triangle, such as .stl, have equal positions joined). Polygons become fans. All objects of a
/// file are one mesh. No file, however broken, makes it crash or allocate more than a small
/// multiple of the file's size.
/// @return [m] positions finite, indices in range, at least one triangle; material empty if the
///         file has no texture coordinates or they are ignored. More is for check_mesh() to say.
/// @throws SceneError naming file, line or element; also for a uv seam, a vertex with several
///         texture coordinates, unless uv are ignored
Mesh read_mesh(const std::filesystem::path& path, Uv uv = Uv::material);

/// Writes meshes as objects of one OBJ file, material coordinates as vt. Numbers are the shortest
/// that read back as the same double. Written beside the target, then renamed.
/// @throws SceneError if the file cannot be written
void write_obj(const std::filesystem::path& path, const std::vector<NamedMesh>& meshes);

/// Writes meshes as one mesh in binary little endian PLY, material coordinates as s, t (left out
/// unless all meshes have them); names are lost. Written beside the target, then renamed.
/// @param precision of the coordinates
/// @throws SceneError if the file cannot be written
void write_ply(const std::filesystem::path& path, const std::vector<NamedMesh>& meshes,
               Precision precision = Precision::double_precision);

}  // namespace weft::io
