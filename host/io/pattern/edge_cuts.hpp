#pragma once

#include <string>
#include <vector>

#include "host/io/pattern/edge_curve.hpp"
#include "host/io/pattern/sewing_pattern.hpp"
#include "weft/core/ids.hpp"

namespace weft::io {

/// Where edges are cut into parts.
struct EdgeCuts {
  /// [panels][edges][parts + 1] [m] from an edge's beginning, both ends included
  std::vector<std::vector<std::vector<double>>> distances;
  std::vector<std::string> notes;  ///< a line for each stitch whose notches do not meet
};

/// Cuts edges into parts of equal length. If two edges are sewn only to each other and have the same
/// number of notches, these meet in order, and the parts between two of them are of equal length.
/// Notches at the ends of an edge, and on one side only, have no effect.
/// @param opposite [stitches] see StitchDirections
/// @param parts    [panels][edges], as many on both sides of a stitch
EdgeCuts cut_edges(const SewingPattern& pattern, const std::vector<std::vector<EdgeCurve>>& curves,
                   const std::vector<bool>& opposite, const std::vector<std::vector<Index>>& parts);

}  // namespace weft::io
