#pragma once

#include <filesystem>
#include <functional>
#include <string>

namespace weft::io {

/// Reads a file in a child process first, with bounds on time and memory. A library that crashes,
/// never ends, or takes all memory on a damaged file does so there.
/// @param path of the file; the bounds grow with its size
/// @param what what it is to be read as, for messages: "a mesh"
/// @param read reads it; what it changes is lost with the child
/// @throws SceneError with the message of what `read` throws, or if the child crashes or exceeds a
///         bound. If no child can be started, nothing is tried
void try_in_child(const std::filesystem::path& path, const std::string& what,
                  const std::function<void()>& read);

}  // namespace weft::io
