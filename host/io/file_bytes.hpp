#pragma once

#include <filesystem>
#include <string>

namespace weft::io {

/// Whole content of a regular file.
/// @throws SceneError naming the file and the reason if it is missing, no regular file, larger than
///         the memory of this machine, or cannot be read
std::string read_file_bytes(const std::filesystem::path& path);

}  // namespace weft::io
