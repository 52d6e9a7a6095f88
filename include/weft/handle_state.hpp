#pragma once

#include <string>

#include "weft/core/vec.hpp"

namespace weft {

/// What the springs of a handle do to a cloth at one instant.
struct HandleState {
  std::string cloth;            ///< name
  Vec3<double> force{0, 0, 0};  ///< [N] of all of its springs; zero of glue, which pulls both ways
  /// Share of the cloth's weight that `force` bears against gravity; 0 if there is none.
  double weight_share = 0;
};

}  // namespace weft
