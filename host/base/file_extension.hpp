#pragma once

#include <filesystem>
#include <string>

namespace weft {

/// Extension of a path with its dot, in lower case; empty if there is none.
inline std::string lower_extension(const std::filesystem::path& path) {
  std::string extension = path.extension().string();
  for (char& c : extension)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  return extension;
}

}  // namespace weft
