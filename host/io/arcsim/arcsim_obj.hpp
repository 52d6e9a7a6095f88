#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "weft/core/ids.hpp"

namespace weft::io {

/// What ARCSim writes into OBJ files beside the mesh, which read_mesh() passes over.
struct ArcsimExtras {
  std::vector<long long> node_label;  ///< [v] from `nl`, 0 where there is none
  /// What the file holds and weft does not take over, such as "plastic strain (ts)".
  std::vector<std::string> ignored;
};

/// @throws SceneError naming file and line if the file cannot be read, or a label is no number
ArcsimExtras read_arcsim_extras(const std::filesystem::path& path);

/// Numbers of the vertices with this label.
std::vector<Index> vertices_with_label(const ArcsimExtras& extras, long long label);

}  // namespace weft::io
