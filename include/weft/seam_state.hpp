#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>

namespace weft {

/// How far a seam has been sewn. A pair of a seam with a weld distance is closed once it is one
/// vertex; one of a seam without, while it is no farther apart than the contact thickness.
struct SeamState {
  std::array<std::string, 2> cloths;  ///< names of the two sides
  std::int64_t pairs = 0;
  std::int64_t open = 0;            ///< pairs that are not closed
  double largest_gap = 0;           ///< [m] between the two vertices of a pair
  std::optional<double> closed_at;  ///< [s] since when all pairs are closed
  /// The seam should have closed by now: it welds, its springs have their full stiffness, and
  /// Seam::may_stay_open is not set.
  bool due = false;
};

}  // namespace weft
