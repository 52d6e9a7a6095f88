#pragma once

#include <limits>
#include <map>
#include <set>
#include <utility>
#include <vector>

#include "host/adaptive/bending_cost.hpp"
#include "host/adaptive/clearance.hpp"
#include "host/adaptive/remesh_parts.hpp"
#include "host/adaptive/sizing.hpp"
#include "host/adaptive/surface_mesh.hpp"

namespace weft {

/// Which pins hold a vertex, as numbers of sets; 0 is the empty one.
class PinSets {
 public:
  /// @param pins in increasing order
  Index number(const std::vector<Index>& pins);
  Index common(Index a, Index b);  ///< the set of those in both
  const std::vector<Index>& pins(Index set) const { return sets_[static_cast<std::size_t>(set)]; }

 private:
  std::vector<std::vector<Index>> sets_{{}};
  std::map<std::vector<Index>, Index> numbers_{{{}, 0}};
};

struct RemeshOptions {
  std::vector<Remeshing> settings;  ///< [cloths]
  double flip_threshold = 0.01;
  double reach = 0.01;  ///< [m] obstacles farther off ask for nothing
  EnergyBudget budget{std::numeric_limits<double>::infinity()};
  BendingLaws bending{};  ///< counts where the budget is not infinite
  bool single = false;    ///< positions are rounded to single precision
};

/// Brings the mesh to its sizing field: flips, splits with the worst edges first, collapses, flips
/// (Narain, Samii and O'Brien 2012, section 4.2). The outline in material space, seams, borders
/// between materials and groups and the vertices that are kept stay. Nothing is done that turns a
/// triangle over, makes a sliver, or meets other cloth or an obstacle. Mass and linear momentum of
/// what is not held are the same as before. One thread; a pure function of its arguments.
/// @param mesh connect() and set_metric() have run
/// @param pins of the mesh's `hold`
RemeshCounts remesh(SurfaceMesh& mesh, PinSets& pins, Clearance& clearance,
                    const RemeshOptions& options);

/// Bossen and Heckbert 1996: whether the other diagonal of the quad is closer to Delaunay in the
/// mean metric. With the edge of h from x to z, and w to its left, y to its right:
///   wedge(z - y, x - y) (x - w)^T M (z - w) + (z - y)^T M (x - y) wedge(x - w, z - w)
///     < -threshold (wedge(z - y, x - y) + wedge(x - w, z - w))
/// @return false for borders
bool should_flip(const SurfaceMesh& mesh, Index h, double threshold);

/// Shape of a triangle: 12 sqrt(3) area over its circumference squared, 1 if regular.
double aspect(double area, double perimeter);

}  // namespace weft
