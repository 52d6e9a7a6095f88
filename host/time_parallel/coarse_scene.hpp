#pragma once

#include <vector>

#include "host/adaptive/remesh_scene.hpp"
#include "host/implicit/tracking/tracking.hpp"
#include "host/time_parallel/material_map.hpp"
#include "weft/scene.hpp"

namespace weft {

/// A scene with the same cloths on coarser meshes and with a longer step, and where the fine
/// vertices lie in them (Liang & Lin 2018, section 3.1).
struct CoarseScene {
  Scene scene;
  std::vector<MaterialMap> maps;      ///< [cloths] of the fine vertices
  std::vector<Index> schwarz_offset;  ///< [cloths + 1] first coarse input of each
};

/// Makes the coarse level of a scene with the method "time_parallel", by its settings.
///   - A grid (make_grid()) becomes one of fewer cells: a divisor of its own near `coarsening`, so
///     that coarse vertices are fine ones too; the nearest number of cells where there is none.
///   - Any other mesh is remeshed (remesh_scene()) to edges of one length; curved outlines and
///     borders between materials stay as they are.
///   - Where slices remesh, edges are in that ratio to the shortest ones that they make: a scene's
///     own mesh may be coarser.
///   - A coarse run that remeshes begins with such meshes. Its smallest edges are `coarsening`
///     times those of the fine run; its other criteria are the same.
/// A pin or handle holds the coarse vertices that stand for its own; there is at least one. The
/// stiffness of a handle's springs is kept in sum.
/// @throws SceneError if a cloth does not get coarser, has too many triangles even so, or the
///         coarse start stays intersecting
CoarseScene make_coarse_scene(const Scene& fine);

/// Criteria that remesh a cloth to edges of one length, whatever it does.
/// @param ratio of that length to the edges of the mesh
Remeshing even_sizes(const Mesh& mesh, double ratio);

/// Positions or velocities of the fine vertices: those of the coarse ones, linear over triangles.
/// @param coarse [coarse inputs]
/// @return       [fine inputs]
std::vector<Vec3<double>> upsampled(const CoarseScene& level,
                                    const std::vector<Vec3<double>>& coarse);

/// Tracking constraints with the hat functions of the coarse meshes, without a target.
/// @param fine the scene that the level is of
Tracking make_tracking(const Scene& fine, const CoarseScene& level);

}  // namespace weft
