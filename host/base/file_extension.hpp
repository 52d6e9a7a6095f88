#pragma once

#include <filesystem>
#include <string>

#include "host/base/lower_case.hpp"

namespace weft {

/// Extension of a path with its dot, in lower case; empty if there is none.
inline std::string lower_extension(const std::filesystem::path& path) {
  return lower_case(path.extension().string());
}

}  // namespace weft
