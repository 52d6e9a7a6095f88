#pragma once

#include <string>
#include <vector>

#include "host/io/pattern/garment.hpp"
#include "host/scene/fabric/fabrics.hpp"

namespace weft::app {

/// Options of `weft convert` for sewing patterns.
struct PatternRequest {
  std::string input;                       ///< specification of GarmentCode
  std::string output;                      ///< the scene
  std::string body;                        ///< mesh file; empty: none
  double edge = io::default_garment_edge;  ///< [m]
  std::string fabric = default_fabric;
};

/// Writes the scene of a garment and says how large it is, and beside it the meshes that it names:
/// NAME_garment.obj and NAME_body.obj, if the scene is NAME.json. Both are in metres with y up.
/// @return lines about what differs from the files
/// @throws SceneError for a pattern or body that cannot be read, or files that cannot be written
std::vector<std::string> convert_pattern(const PatternRequest& request);

}  // namespace weft::app
