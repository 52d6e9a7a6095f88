#pragma once

#include <filesystem>
#include <string_view>

namespace weft {

/// Whether a finished file is on the disk, safe from a power cut, before it takes its name.
enum class Durability { fsync, none };

/// Writes a file so that a reader sees the old one or the whole new one, never a part: into a
/// temporary file beside it, which then takes its name. A symbolic link keeps pointing where it
/// points; a target that is no regular file (a pipe, a terminal) is written to directly.
/// @throws SceneError naming the file and the system's reason; the temporary file is removed
void write_file_atomically(const std::filesystem::path& path, std::string_view bytes,
                           Durability durability = Durability::fsync);

}  // namespace weft
