#pragma once

#include <array>
#include <string>
#include <string_view>
#include <vector>

#include "host/io/pattern/sewing_pattern.hpp"

namespace weft::io {

/// x -> A x + b of the plane, as `transform` of SVG writes it: a c e / b d f.
struct SvgTransform {
  std::array<double, 6> m{1, 0, 0, 1, 0, 0};

  Vec2<double> operator()(const Vec2<double>& p) const {
    return {m[0] * p[0] + m[2] * p[1] + m[4], m[1] * p[0] + m[3] * p[1] + m[5]};
  }
  /// First `other`, then this.
  SvgTransform after(const SvgTransform& other) const;
};

/// What `transform` says: matrix, translate, scale, rotate, skewX, skewY, in any number.
/// @param where for messages: file, line and element
/// @throws SceneError
SvgTransform parse_svg_transform(std::string_view text, const std::string& where);

/// A part of a path between two points.
struct SvgSegment {
  PatternEdge::Shape shape = PatternEdge::Shape::line;
  Vec2<double> from{}, to{};
  std::vector<Vec2<double>> controls{};  ///< of a Bezier curve, or of a polyline for an arc
};

/// A subpath.
struct SvgSubpath {
  std::vector<SvgSegment> segments{};
  bool closed = false;  ///< by Z, or it ends where it began
};

/// Subpaths of the attribute `d`, in user units: M, L, H, V, C, S, Q, T, A and Z, absolute and
/// relative. Arcs become polylines with a point every 5 degrees.
/// @param where for messages
/// @throws SceneError naming the command and its place in the text
std::vector<SvgSubpath> parse_svg_path(std::string_view d, const std::string& where);

/// Numbers of a list, separated by spaces and commas.
/// @throws SceneError
std::vector<double> parse_svg_numbers(std::string_view text, const std::string& where,
                                      const std::string& field);

}  // namespace weft::io
