#pragma once

#include <cerrno>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace weft {

// A file that nobody may look at counts as one that is not there.
bool is_there(const std::filesystem::path& path);
bool is_file(const std::filesystem::path& path);
bool is_folder(const std::filesystem::path& path);

/// All in a folder but folders, in the order of their names; none if it is not there.
std::vector<std::filesystem::path> files_in(const std::filesystem::path& folder);

/// @param what  "write", "open for writing"
/// @param error of the system
/// @throws SceneError naming the file and the reason
[[noreturn]] void fail_on(const std::filesystem::path& path, const std::string& what,
                          int error = errno);

/// Removes a file that may be there. @throws SceneError if that fails
void remove_file(const std::filesystem::path& path);

/// Gives a file another name, in place of what has it. @throws SceneError if that fails
void rename_file(const std::filesystem::path& from, const std::filesystem::path& to);

/// @param file descriptor
/// @param path for messages
/// @throws SceneError if not all could be written
void write_all(const std::filesystem::path& path, int file, std::string_view bytes);

}  // namespace weft
