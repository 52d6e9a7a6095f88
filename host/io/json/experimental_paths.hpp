#pragma once

#include <span>
#include <string_view>

namespace weft::io {

/// Is not read where the other keys of its object are.
inline constexpr const char* stiffness_path = "contact.stiffness";

/// All other paths that `--experimental` sets, which are read where the other keys of their object
/// are.
std::span<const char* const> experimental_paths();

/// Whether `--experimental` sets the path, which then is no key of scenes.
bool is_experimental(std::string_view path);

/// The same, and for an object all of whose keys are such.
bool is_hidden(std::string_view path);

}  // namespace weft::io
