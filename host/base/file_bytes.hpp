#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>

namespace weft {

/// Whole content of a regular file.
/// @throws SceneError naming the file and the reason if it is missing, no regular file, larger than
///         the memory of this machine, or cannot be read
std::string read_file_bytes(const std::filesystem::path& path);

/// The same; empty if the file is missing or cannot be read.
std::string bytes_if_readable(const std::filesystem::path& path);

/// Reads from a place in an open file.
/// @param path for messages
/// @param file descriptor
/// @return bytes read, fewer only at the end of the file
/// @throws SceneError if it cannot be read
std::size_t read_at(const std::filesystem::path& path, int file, std::uint64_t offset, void* to,
                    std::size_t size);

}  // namespace weft
