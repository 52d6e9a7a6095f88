#pragma once

#include <cstddef>
#include <vector>

#include "host/io/pattern/sewing_pattern.hpp"

namespace weft::io {

/// A side of a panel as a curve, which knows its lengths.
class EdgeCurve {
 public:
  /// @pre an arc's radius is at least half of the distance of its ends
  EdgeCurve(const PatternPanel& panel, const PatternEdge& edge);

  /// [m]
  double length() const { return lengths_.back(); }
  /// Points at equal distances along the curve.
  /// @param segments >= 1
  /// @return [segments + 1] [m] with both ends, which are exactly those of the panel
  std::vector<Vec2<double>> sample(Index segments) const {
    return sample(even_distances(segments));
  }
  /// @param distances [m] from the beginning, increasing; the first is the beginning, the last the
  ///                  end
  /// @return [distances] [m]; the ends are exactly those of the panel
  std::vector<Vec2<double>> sample(const std::vector<double>& distances) const;
  /// @return [segments + 1] [m] from the beginning
  std::vector<double> even_distances(Index segments) const;

  struct Nearest {
    double along;  ///< [m] from the beginning
    double away;   ///< [m]
  };
  /// The place on the curve nearest to a point.
  Nearest nearest(const Vec2<double>& place) const;

 private:
  Vec2<double> point(double t) const;
  /// Of a polyline: its ends and control points.
  Vec2<double> corner(std::size_t k) const;

  Vec2<double> from_, to_;
  PatternEdge edge_;
  Vec2<double> centre_{};  ///< [m] of an arc
  double start_ = 0;       ///< [rad] of an arc
  double sweep_ = 0;       ///< [rad] of an arc, > 0: to the left
  /// [m] from the beginning to equal steps of the parameter; of a polyline, to its corners
  std::vector<double> lengths_;
};

}  // namespace weft::io
