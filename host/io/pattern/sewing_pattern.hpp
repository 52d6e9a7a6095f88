#pragma once

#include <array>
#include <string>
#include <vector>

#include "weft/core/ids.hpp"
#include "weft/core/vec.hpp"

namespace weft::io {

/// A side of a panel, in the panel's own plane.
struct PatternEdge {
  enum class Shape {
    line,
    bezier,   ///< quadratic or cubic: one or two control points
    arc,      ///< part of a circle
    polyline  ///< straight lines from control point to control point
  };
  Index from = 0, to = 0;  ///< into PatternPanel::vertices
  Shape shape = Shape::line;
  std::vector<Vec2<double>> controls{};  ///< [m] of a Bezier curve or a polyline
  double radius = 0;                     ///< [m] of an arc, at least half of the chord
  bool large = false;                    ///< an arc of more than half a circle
  bool left = false;  ///< the arc turns left, counter-clockwise, on its way from `from` to `to`
  std::string label{};
};

/// A piece of cloth. Its outline may run in either direction: its front is where that is
/// counter-clockwise.
struct PatternPanel {
  std::string name;
  std::string label{};                 ///< part of the body, such as "body", "arm" or "leg"
  std::vector<Vec2<double>> vertices;  ///< [m] in the plane of the panel
  std::vector<PatternEdge> edges;      ///< each begins where the one before ends; closed
  /// Along the warp, in the plane of the panel, of any length; (0, 0): along the steeper axis of
  /// the panel where it stands
  Vec2<double> grain{0, 0};
  std::vector<Vec2<double>> notches{};  ///< [m] in the plane of the panel
  Vec3<double> translation{0, 0, 0};    ///< [m]
  /// [degrees] about the fixed axes x, then y, then z
  Vec3<double> rotation{0, 0, 0};
};

/// One end of a stitch.
struct PatternSide {
  Index panel = 0;  ///< into SewingPattern::panels
  Index edge = 0;   ///< into PatternPanel::edges
};

/// Two sides that are sewn together. Usually the beginning of one comes to the end of the other, so
/// that front meets front.
struct PatternStitch {
  std::array<PatternSide, 2> sides;
  bool right_wrong = false;  ///< front meets back: beginning to beginning
};

/// Panels of a garment, placed around a body, with y up.
struct SewingPattern {
  std::string file;  ///< for messages
  std::string name;
  std::vector<PatternPanel> panels;
  std::vector<PatternStitch> stitches;
  std::vector<std::string> notes;  ///< what the file does not say, a line each

  const PatternPanel& panel(const PatternSide& side) const {
    return panels[static_cast<std::size_t>(side.panel)];
  }
  const PatternEdge& edge(const PatternSide& side) const {
    return panel(side).edges[static_cast<std::size_t>(side.edge)];
  }
};

/// Where a point of a panel's plane stands. [m]
Vec3<double> placed(const PatternPanel& panel, const Vec2<double>& point);

/// Place of a side for messages: pattern.panels.NAME.edges[K]
std::string field_of(const SewingPattern& pattern, const PatternSide& side);

}  // namespace weft::io
