#pragma once

#include <filesystem>
#include <string>

namespace weft::app {

/// Where a run writes: the folder that the user names, else out/<name of the scene>, whatever
/// stands in that name.
/// @param asked empty: nothing was named
std::filesystem::path output_folder(const std::string& asked, const std::string& scene_name);

/// Makes a folder where it is missing.
/// @param option that names it
/// @throws SceneError naming it if that fails
void make_output_folder(const std::filesystem::path& path, const std::string& option = "-o");

}  // namespace weft::app
