#pragma once

#include <string>
#include <vector>

#include "host/io/pattern/sewing_pattern.hpp"

namespace weft::io {

/// A closed row of points with marks at its corners.
struct OutlinePoints {
  std::vector<Vec2<double>> points;   ///< [m] the first one is not repeated
  std::vector<unsigned char> corner;  ///< [points] 1: an edge ends there
};

/// [m] Points that are nearer to each other are one: files round their numbers.
inline constexpr double same_place = 1e-4;

/// [degrees] A vertex at which an outline turns by more is a corner, where nothing else says so.
inline constexpr double corner_angle = 20;

/// Leaves out points that repeat the one before, and the last one if it repeats the first.
void drop_repeated(OutlinePoints& outline);

/// Marks the points at which the outline turns by more than corner_angle.
void find_corners(OutlinePoints& outline);

/// Mirror image of a point.
/// @param on    [m] on the line   @param along unit vector
Vec2<double> mirrored(const Vec2<double>& p, const Vec2<double>& on, const Vec2<double>& along);

/// Unfolds half a panel: the side along the line goes, and the rest gets its mirror image. Corners
/// on the line stay corners if the whole outline turns there by more than corner_angle.
/// @param a, b [m] ends of the line
/// @return false if no side of the outline lies along the line
bool unfold(OutlinePoints& outline, const Vec2<double>& a, const Vec2<double>& b);

/// Makes a panel's vertices and edges: lines, or polylines where there are points between corners.
/// The first edge begins at the first corner.
/// @throws SceneError naming `field` if an edge has no length, or there are too many
void take_outline(const OutlinePoints& outline, const std::string& file, const std::string& field,
                  PatternPanel& panel);

}  // namespace weft::io
