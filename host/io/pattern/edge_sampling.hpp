#pragma once

#include <vector>

#include "host/io/pattern/edge_curve.hpp"
#include "host/io/pattern/sewing_pattern.hpp"

namespace weft::io {

/// How much longer one side of a stitch may be than the other: what is gathered.
inline constexpr double most_gathering = 3;

/// Curves of all edges. [panels][edges]
std::vector<std::vector<EdgeCurve>> edge_curves(const SewingPattern& pattern);

/// Into how many parts each edge is cut: as many on both sides of a stitch. The parts are as long
/// as the aim in the (geometric) mean over all edges that are sewn together.
/// @param opposite [stitches] see StitchDirections
/// @param edge     [m] aim, > 0
/// @return [panels][edges] >= 1; at least 3 where both ends of an edge become one vertex, and so
///         many that no two edges become one that are not sewn to each other
/// @throws SceneError naming a stitch whose sides differ by more than most_gathering
std::vector<std::vector<Index>> edge_parts(const SewingPattern& pattern,
                                           const std::vector<std::vector<EdgeCurve>>& curves,
                                           const std::vector<bool>& opposite, double edge);

}  // namespace weft::io
