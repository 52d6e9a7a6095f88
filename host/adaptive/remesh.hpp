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

/// Numbers the sets of pins that hold a vertex. Set 0 is empty.
class PinSets {
 public:
  /// Number of a set.
  /// @param pins in increasing order
  Index number(const std::vector<Index>& pins);
  Index common(Index a, Index b);  ///< number of the intersection of two sets
  const std::vector<Index>& pins(Index set) const { return sets_[static_cast<std::size_t>(set)]; }

 private:
  std::vector<std::vector<Index>> sets_{{}};
  std::map<std::vector<Index>, Index> numbers_{{{}, 0}};
};

struct RemeshOptions {
  std::vector<Remeshing> settings;  ///< [cloths]
  double flip_threshold = 0.01;
  double reach = 0.01;  ///< [m] obstacles farther away do not refine the mesh
  EnergyBudget budget{std::numeric_limits<double>::infinity()};
  BendingLaws bending{};  ///< used only if the budget is finite
  bool single = false;    ///< positions are rounded to single precision
};

/// Adapts the mesh to its sizing field: flips, splits with the worst edges first, collapses, flips
/// (Narain, Samii and O'Brien 2012, section 4.2). The outline in material space, seams, borders
/// between materials and groups, and kept vertices stay; pinned edges keep their ends and at least
/// three vertices. No operation turns a triangle over, makes
/// a sliver, causes an intersection with cloth or an obstacle, or makes two triangles with the same
/// corners once all seams are welded. Mass is preserved, and so is the
/// linear momentum of vertices that are not held. A pure function, on one thread.
/// @param mesh after connect() and set_metric()
/// @param pins the sets that the mesh's `hold` refers to
RemeshCounts remesh(SurfaceMesh& mesh, PinSets& pins, Clearance& clearance,
                    const RemeshOptions& options);

/// Whether the other diagonal of the quad is closer to Delaunay in the mean metric (Bossen and
/// Heckbert 1996). If the edge of h goes from x to z, with w to its left and y to its right:
///   wedge(z - y, x - y) (x - w)^T M (z - w) + (z - y)^T M (x - y) wedge(x - w, z - w)
///     < -threshold (wedge(z - y, x - y) + wedge(x - w, z - w))
/// @return false for borders
bool should_flip(const SurfaceMesh& mesh, Index h, double threshold);

/// Aspect ratio of a triangle: 12 sqrt(3) times its area over its perimeter squared, 1 if regular.
double aspect(double area, double perimeter);

}  // namespace weft
