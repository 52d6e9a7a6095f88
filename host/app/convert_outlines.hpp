#pragma once

#include <string>
#include <vector>

namespace weft::app {

/// Writes a sewing pattern around a file of outlines, for its user to add stitches and places, and
/// prints the panels with their edges.
/// @param input  .dxf or .svg, in the folder of the pattern or below it
/// @param output .json; never replaced
/// @throws SceneError
void convert_outlines(const std::string& input, const std::string& output);

}  // namespace weft::app
