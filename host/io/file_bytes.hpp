#pragma once

#include <filesystem>
#include <string>

namespace weft::io {

/// Whole content of a regular file.
/// @throws SceneError naming the file and the reason if it is missing, no regular file, or cannot
///         be read
std::string read_file_bytes(const std::filesystem::path& path);

}  // namespace weft::io
