#pragma once

#include <cstddef>
#include <limits>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "host/io/mesh/mesh_file.hpp"

/// One reader and writer a format, from and to bytes. The readers obey what read_mesh() promises.
namespace weft::io {

/// Vertices or triangles that a file may have: Index numbers their coordinates, or corners.
inline constexpr std::size_t max_entries =
    static_cast<std::size_t>(std::numeric_limits<Index>::max()) / 3;

/// @param file     for messages
/// @param warnings gets a line if there are keywords that no OBJ has; null: they are passed over
/// @throws SceneError
Mesh parse_obj(std::string_view bytes, const std::string& file, Uv uv,
               std::vector<std::string>* warnings = nullptr);
/// @param file for messages
/// @throws SceneError
Mesh parse_ply(std::string_view bytes, const std::string& file, Uv uv);
/// Any format that assimp knows; equal positions are joined.
/// @param folders of the files that it names
/// @throws SceneError
Mesh read_with_assimp(const std::filesystem::path& path, Uv uv, const ReadableFolders& folders);

std::string format_obj(const std::vector<NamedMesh>& meshes, Normals normals = Normals::none,
                       Groups groups = Groups::none, const SeamEdges& seams = {});
std::string format_ply(const std::vector<NamedMesh>& meshes, Precision precision,
                       Normals normals = Normals::none, const SeamEdges& seams = {});

/// Whether parts tell faces apart, as panels do: one without a label says no more than the object.
bool has_panels(const Mesh& mesh);

/// Gives groups their labels, as parts of the same names. Without labels nothing changes.
/// @param labels by the group's name
void take_panel_labels(const std::map<std::string, std::string>& labels, Mesh& mesh);

/// Takes the next word off the front of a line.
std::string_view next_word(std::string_view& line);

/// Number from the whole of `token`; a leading + is accepted.
/// @return whether it is one; infinities and NaN are numbers here
bool parse_number(std::string_view token, double& value);
bool parse_number(std::string_view token, long long& value);

}  // namespace weft::io
