#pragma once

#include <string>
#include <vector>

#include "host/io/pattern/garment.hpp"
#include "host/scene/fabric/fabrics.hpp"

namespace weft::app {

/// Options of `weft convert` for sewing patterns.
struct PatternRequest {
  std::vector<std::string> inputs;         ///< specifications of GarmentCode, from the inside out
  std::string output;                      ///< the scene
  std::string body;                        ///< mesh file; empty: none
  double edge = io::default_garment_edge;  ///< [m]
  std::string fabric = default_fabric;
};

/// Writes the scene of garments and says how large they are, and beside it the files that it names:
/// NAME_GARMENT.json for each pattern and NAME_body.obj, in metres with y up, if the scene is
/// NAME.json.
/// @return lines about what differs from the files
/// @throws SceneError for a pattern or body that cannot be read, or files that cannot be written
std::vector<std::string> convert_patterns(const PatternRequest& request);

}  // namespace weft::app
