#pragma once

#include <vector>

#include "host/untangle/contour.hpp"

// What has to move, and where to, for contours to vanish.

namespace weft {

/// A wanted relative displacement of up to five points: sum of weight[j] d_j = displacement. The
/// weights of either side sum to 1 and -1.
struct Correction {
  Index point[5];
  double weight[5];
  int count;
  Vec3<double> displacement;  ///< [m]
  Index region;               ///< into Corrections::regions, that it is made for, or -1
};

/// Everything that is wrong about one contour.
struct Region {
  std::vector<Index> points;  ///< beyond the contour, on the side that has to go back; may be empty
  bool held = false;          ///< one of them does not move
};

/// Steps of one round.
struct Corrections {
  std::vector<Correction> list;
  std::vector<Region> regions;  ///< one a contour or obstacle that divides a surface
};

/// What find_corrections() makes of contours.
enum class Scope {
  all,     ///< what they divide decides
  shrink,  ///< all get shorter, whatever they divide
  solids,  ///< only those on closed obstacles are looked at
};

struct CorrectionSettings {
  double step;    ///< [m] most that is asked of a contour that divides nothing
  double margin;  ///< [m] by which a point should pass what it was behind
  Scope scope = Scope::all;
};

/// Decides for each contour what is on the wrong side.
///
/// A contour may divide a surface: flooding from its two sides, across edges that it does not
/// cross, finds the parts, and the smaller one that nothing holds has to go back through the other
/// surface. Within a closed obstacle it is always the part inside that has to leave. A contour that
/// divides neither surface, such as one between two crossing borders, is made shorter instead
/// (intersection contour minimisation).
/// @cite baraff2003, flooding; volino2006, minimisation
Corrections find_corrections(const IntersectingSurfaces& surfaces, const SurfaceTopology& topology,
                             const Contours& contours, const CorrectionSettings& settings);

}  // namespace weft
