#pragma once

#include <array>
#include <filesystem>
#include <string>
#include <vector>

#include "host/input/readable_folders.hpp"
#include "weft/scene.hpp"

namespace weft::io {

struct NamedMesh {
  std::string name;
  Mesh mesh;
};

/// Edges of meshes along which panels are sewn together. [meshes or none][edges] two vertices each
using SeamEdges = std::vector<std::vector<std::array<Index, 2>>>;

/// A frame as meshes, in the order of the scene.
struct FrameMeshes {
  std::vector<NamedMesh> cloths;
  std::vector<NamedMesh> obstacles;  ///< where the scene puts them
  /// All obstacles where they were simulated, if cloth displaced one; else empty. Frame files do
  /// not hold these.
  std::vector<NamedMesh> displaced{};
  /// [cloths][vertices] [m/s] empty: not known
  std::vector<std::vector<Vec3<double>>> cloth_velocities{};
  bool joined = false;           ///< each list is one mesh, with objects that are its groups
  Vec3<double> origin{0, 0, 0};  ///< [m] add it to the positions to get world positions
};

/// Describes a mesh, or all meshes of a frame, from another origin. World positions stay the same.
void move_origin(Mesh& mesh, const Vec3<double>& from, const Vec3<double>& to);
void move_origin(FrameMeshes& meshes, const Vec3<double>& to);

/// The frame in world positions.
FrameMeshes in_world(FrameMeshes meshes);

/// [m] Where a format in single precision had best have the origin of a sequence of frames: where
/// its first frame has it, or else near the cloths of that, see weft::local_origin().
Vec3<double> local_origin(const FrameMeshes& first);

/// All meshes as one, in their order. Material coordinates are kept if every mesh has them.
Mesh joined(const std::vector<NamedMesh>& meshes);

/// What to do with the texture coordinates of a file.
enum class Uv {
  material,   ///< material coordinates [m]; a vertex on a seam has several
  where_all,  ///< the same if every corner has them, else none
  /// The same for the faces of an .obj that have them; the others have corners of -1.
  where_some,
  ignore  ///< not wanted, so that seams do no harm: obstacles
};

/// Reads a mesh; the ending says which format: .obj, .ply (ascii or binary), anything else through
/// assimp. Vertices keep their number and order (formats that store a vertex once a
/// triangle, such as .stl, have equal positions joined). Polygons become fans; those of an .obj
/// with Uv::material and Uv::where_all around the corner that gives the largest smallest angle,
/// else the first. All objects of a file are one mesh. No file, however broken, makes it crash or
/// allocate more than a small multiple of the file's size.
/// @return [m] positions finite, indices in range, at least one triangle; material empty if the
///         file has no texture coordinates or they are ignored; material_triangles empty unless a
///         vertex has several. Groups are the materials of faces, or else the names of groups or
///         objects; "label_<n>" for ARCSim's face labels. Parts are the groups or objects of an
///         .obj that has materials too, or the panels of a file of ours that labels them. Objects
///         are those of an .obj with groups or materials, and of a .ply of ours with panels. More
///         is for check_mesh() to say.
/// @param folders  of the files that it names
/// @param warnings gets a line for what was passed over in an .obj; null: without
/// @throws SceneError naming file, line or element
Mesh read_mesh(const std::filesystem::path& path, Uv uv, const ReadableFolders& folders,
               std::vector<std::string>* warnings = nullptr);
/// The same; files that it names lie below its own folder.
inline Mesh read_mesh(const std::filesystem::path& path, Uv uv = Uv::material) {
  return read_mesh(path, uv, ReadableFolders(path));
}

/// Drops the material coordinates of Uv::where_some unless all corners have them.
void drop_incomplete_material(Mesh& mesh);

/// Whether a file gets normals at the vertices, as vertex_normals() says.
enum class Normals { none, vertex };

/// Whether a file says which faces are in which group and part.
enum class Groups {
  none,
  faces,  ///< groups and parts
  panels  ///< parts as groups, and their labels as comments
};

/// Writes meshes as objects of one OBJ file, material coordinates as vt, normals as vn, groups as
/// g, seam edges as l. Numbers are the shortest that read back as the same double (normals: float).
/// Written beside the target, then renamed.
/// @throws SceneError if the file cannot be written
void write_obj(const std::filesystem::path& path, const std::vector<NamedMesh>& meshes,
               Normals normals = Normals::none, Groups groups = Groups::none,
               const SeamEdges& seams = {});

/// Writes meshes as one mesh in binary little endian PLY, material coordinates as s, t (left out
/// unless all meshes have them; where a vertex has several, as texcoord of the faces), normals as
/// nx, ny, nz in single precision. Faces have an `object`, and a `panel` if any mesh has parts;
/// comments name them. Seam edges are the element edge. Written beside the target, then renamed.
/// @param precision of the coordinates
/// @throws SceneError if the file cannot be written
void write_ply(const std::filesystem::path& path, const std::vector<NamedMesh>& meshes,
               Precision precision = Precision::double_precision, Normals normals = Normals::none,
               const SeamEdges& seams = {});

}  // namespace weft::io
