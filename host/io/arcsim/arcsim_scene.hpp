#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "host/input/readable_folders.hpp"

/// Scenes of ARCSim 0.2, unmodified.
namespace weft::io {

/// Whether a document is a scene of ARCSim: it has "frame_time" or "timestep", or a cloth with a
/// list "materials". No scene of weft has any of these.
bool is_arcsim_scene(const nlohmann::json& document);

/// A scene of ARCSim said in weft's terms.
struct ArcsimScene {
  nlohmann::json scene;               ///< as scenes/scene.schema.json describes it, paths absolute
  std::vector<std::string> warnings;  ///< what could not be taken over, a line a key
};

/// Folders of the files that a scene of ARCSim names: its own, and those that the user allows. If
/// its own is called conf, as in ARCSim, the one above is the last: it holds meshes and materials.
ReadableFolders arcsim_folders(const std::filesystem::path& file,
                               const std::vector<std::string>& allowed);

/// Files are looked for in arcsim_folders(), in this order. A frame becomes a frame, frame_steps
/// its time steps; a scene without an end runs for `duration` if it names one, else for 10 s. Node
/// handles that hold from the start and do not fade become pins, others handles. Materials:
/// read_arcsim_material(). The list "obstacles" may be a pattern such as "dir/body%04d.obj": files
/// 0, 1, 2, ... as long as they are there, the i-th with the i-th motion. Obstacle meshes are
/// repaired.
/// @param document is_arcsim_scene()
/// @param file     the scene file
/// @param allowed  folders beside its own
/// @throws SceneError with file, key, value and what is allowed
ArcsimScene weft_scene_of(const nlohmann::json& document, const std::filesystem::path& file,
                          const std::vector<std::string>& allowed = {});

/// Reads a scene of ARCSim and writes it as a scene of weft; the warnings become its description.
/// @throws SceneError if `in` is no scene of ARCSim, or a file cannot be read or written
/// @return the warnings
std::vector<std::string> convert_arcsim(const std::filesystem::path& in,
                                        const std::filesystem::path& out,
                                        const std::vector<std::string>& allowed = {});

}  // namespace weft::io
