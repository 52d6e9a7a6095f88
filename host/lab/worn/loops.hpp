#pragma once

#include <array>
#include <vector>

#include "host/lab/worn/body_figure.hpp"

namespace weft::lab {

/// A mesh whose coincident vertices are one.
struct Welded {
  std::vector<Index> vertex;     ///< [vertices] number of the welded one
  std::vector<Index> component;  ///< [triangles] from 0, in the order of first triangles
  Index components = 0;
  /// Closed boundaries: vertices of the mesh in order, and the component of each boundary. Where
  /// three sheets meet at a seam, one of them ends.
  std::vector<std::vector<Index>> loops;
  std::vector<Index> loop_component;
  std::vector<std::vector<Index>> loop_triangles;  ///< [loops] at its edges
};

/// @param sewn whether vertices at exactly one place become one
Welded weld(const Mesh& mesh, bool sewn);

/// How a closed curve is linked with the lines of a body.
struct Linking {
  std::array<int, body_part_count> turns{};  ///< signed passages of each line
  double trunk_at = 0;  ///< [m] along the trunk's line, of the first passage there

  bool around(BodyPart part) const { return turns[static_cast<std::size_t>(part)] != 0; }
  bool around_nothing() const { return turns == std::array<int, body_part_count>{}; }
  friend bool operator==(const Linking& a, const Linking& b) { return a.turns == b.turns; }
};

/// @param curve [points] closed
Linking link(const std::vector<Vec3<double>>& curve, const BodyLines& lines);

/// A place relative to a line.
struct LinePlace {
  double along = 0;            ///< [m] from its first point
  double distance = 0;         ///< [m]
  double angle = 0;            ///< [rad] about it, from BodyLines::ahead
  Vec3<double> away{0, 0, 0};  ///< from the nearest point of the line
};
LinePlace place_at(const Vec3<double>& x, const BodyLines& lines, BodyPart part);

}  // namespace weft::lab
