#pragma once

#include <cstdint>
#include <optional>

#include "host/lab/check/validator.hpp"

namespace weft::lab {

/// Verdict on a frame some of whose obstacles cloth may have displaced.
struct DisplacedVerdict {
  FrameVerdict prescribed;  ///< against the obstacles where the scene puts them
  /// Against the obstacles where they were simulated; only if the cloth intersects the former.
  std::optional<FrameVerdict> displaced{};

  /// Nothing was found against the prescribed obstacles.
  bool clean() const { return prescribed.clean(); }

  /// All that was found are intersections with prescribed obstacles, and the displaced ones are
  /// free of those.
  bool clean_against_displaced() const;

  /// Intersecting pairs of triangles; 0 if the frame is clean against displaced obstacles.
  std::int64_t intersections() const;
};

/// Checks one frame against the prescribed obstacles, and if the cloth intersects these, against
/// the displaced ones.
/// @param cloth, obstacle as validate() takes them
/// @param displaced [m] every obstacle of the frame as one mesh, where it was simulated; null: none
///                  was displaced
/// @throws SceneError as validate() does
DisplacedVerdict validate(const Mesh& cloth, const Mesh* obstacle, const Mesh* displaced,
                          const ValidatorOptions& options);

}  // namespace weft::lab
