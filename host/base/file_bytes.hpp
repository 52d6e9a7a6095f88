#pragma once

#include <filesystem>
#include <string>

namespace weft {

/// Whole content of a regular file.
/// @throws SceneError naming the file and the reason if it is missing, no regular file, larger than
///         the memory of this machine, or cannot be read
std::string read_file_bytes(const std::filesystem::path& path);

/// The same; empty if the file is missing or cannot be read.
std::string bytes_if_readable(const std::filesystem::path& path);

}  // namespace weft
