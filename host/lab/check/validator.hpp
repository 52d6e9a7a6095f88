#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "weft/scene.hpp"

/// An independent validator of simulated frames. It takes nothing but meshes, and shares no code
/// with the stages that make them: its verdict on intersections comes from CGAL's exact predicates.
namespace weft::lab {

struct ValidatorOptions {
  bool self = true;      ///< cloth against cloth
  bool obstacle = true;  ///< cloth against the obstacle mesh
  /// Cloth vertices at exactly one place are one vertex, as seams make them, whose frames keep the
  /// numbers of their panels.
  bool sewn = false;
  std::size_t list_limit = 1000;  ///< longest list kept of each kind of finding; counts stay exact
  int threads = 1;  ///< workers within one frame, >= 1; the verdict does not depend on it
};

enum class PairKind { cloth_cloth, cloth_obstacle };

/// Two triangles that meet. `a` is a triangle of the cloth mesh; `b` one of the cloth mesh, b > a,
/// or one of the obstacle mesh.
struct TrianglePair {
  PairKind kind = PairKind::cloth_cloth;
  Index a = 0;
  Index b = 0;
  friend auto operator<=>(const TrianglePair&, const TrianglePair&) = default;
};

/// Numbers in increasing order, cut off at ValidatorOptions::list_limit, and how many there are in
/// all.
struct Findings {
  std::vector<Index> list;
  std::int64_t count = 0;
};

/// Order statistics by nearest rank: the p-th percentile of n values is number ceil(p n / 100).
struct Percentiles {
  double min = 0;
  double p1 = 0;
  double p50 = 0;
  double p99 = 0;
  double max = 0;
};

/// Principal stretches minus one of the map from material to world space. Triangles count alike,
/// whatever their area.
struct StrainVerdict {
  Percentiles largest;              ///< the larger principal stretch of each triangle, minus one
  Percentiles smallest;             ///< the smaller one, minus one
  std::int64_t triangle_count = 0;  ///< triangles measured: finite ones with a material area that
                                    ///< is not zero; 0 without material coordinates
};

/// What was found in one frame.
struct FrameVerdict {
  /// Sorted by kind, a, b; the lowest `list_limit` pairs of each kind.
  std::vector<TrianglePair> pairs;
  std::int64_t cloth_cloth_count = 0;
  std::int64_t cloth_obstacle_count = 0;

  /// Cloth triangles whose signed area in material space is zero or has the sign opposite to that
  /// of most triangles of the mesh (positive where both signs are equally frequent). Orientation
  /// has no meaning for a surface in world space; a fold there is no inversion. The sign is exact.
  Findings inverted;
  /// Cloth triangles of zero area in exact arithmetic, or with an aspect, 2 area / longest edge
  /// squared (shortest height over longest edge), below 1e-10.
  Findings degenerate;
  /// Cloth vertices with a NaN or an infinity in their position or material coordinates. Triangles
  /// with such a corner are left out of every other test.
  Findings nonfinite;
  /// Obstacle vertices with a NaN or an infinity in their position.
  Findings nonfinite_obstacle;

  StrainVerdict strain;  ///< reported, never a finding
  std::int64_t triangle_count = 0;
  std::int64_t obstacle_triangle_count = 0;

  /// No intersection, no inverted or degenerate triangle and no vertex that is not finite.
  bool clean() const;
};

/// Checks one frame.
///
/// Intersections: two triangles without a common vertex number intersect if their closed sets meet:
/// touching counts. Two that share one vertex or one edge intersect if they meet anywhere beyond
/// the shared vertex or edge. Two with the same three vertices are one triangle twice, and
/// intersect. A triangle of zero area stands for the segment or point it covers. Positions are
/// taken as the exact numbers they are; nothing is rounded and no tolerance is applied. The
/// obstacle is not tested against itself.
///
/// @param cloth    [m] every cloth of the frame as one mesh; material coordinates may be absent
/// @param obstacle [m] every obstacle of the frame as one mesh, or null
/// @throws SceneError if a triangle names a vertex or a material coordinate that does not exist, or
///         a mesh without corners of their own in material space has a number of material
///         coordinates that is neither zero nor that of the positions
FrameVerdict validate(const Mesh& cloth, const Mesh* obstacle,
                      const ValidatorOptions& options = {});

}  // namespace weft::lab
