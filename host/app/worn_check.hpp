#pragma once

#include <string>
#include <vector>

#include "host/lab/worn/worn.hpp"

namespace weft::app {

/// What `weft check --worn` is asked for; an empty text was not given.
struct WornRequest {
  std::string input;         ///< directory of a run, or what else holds frames
  std::string obstacle;      ///< a mesh in place of the input's obstacles
  std::string body;          ///< name of the obstacle that is the body
  std::string segmentation;  ///< file
  std::string start;         ///< mesh of the cloth at the start
  bool sewn = false;         ///< cloth vertices at exactly one place are one
  std::vector<std::string> allowed;
};

struct WornOutcome {
  std::vector<lab::GarmentVerdict> garments;
  bool start_known = false;
};

/// The verdict on the last frame. Panels are those of the scene's cloths where its frames name
/// none. The start is that of the request, else frame 0, else the scene's cloths if the body does
/// not move; else none.
/// @throws SceneError if there is no body, if it is not clear which obstacle is, or if a file is
///         missing or damaged
WornOutcome check_worn(const WornRequest& request);

}  // namespace weft::app
