#pragma once

#include <array>
#include <utility>
#include <vector>

#include "host/geometry/box_tree.hpp"
#include "weft/core/at.hpp"
#include "weft/core/ids.hpp"
#include "weft/core/span.hpp"
#include "weft/core/vec.hpp"

// Where surfaces run through each other: the points at which edges pierce triangles, and the
// contours that the lines between them make.

namespace weft {

/// What cloth's points, which come first of all, are to each other at rest.
struct SheetsAtRest {
  std::vector<Vec2<double>> points;  ///< [cloth points] [m] in the material space of their cloth
  std::vector<Index> cloth;          ///< [cloth points]
  /// [cloth points] Least length of edges around, over that at rest, as found; 1 where it is more.
  std::vector<double> compression;
};

/// Triangle meshes of which some may move: first the triangles of cloth, then those of obstacles.
struct IntersectingSurfaces {
  std::vector<Vec3<double>> points;  ///< [m]
  std::vector<Tri> triangles;
  Index cloth_triangle_count = 0;
  std::vector<double> inverse_mass;  ///< [points] [1/kg]; 0: does not move
  std::vector<Index> mesh;           ///< [triangles] which mesh each belongs to, not decreasing
  std::vector<unsigned char> solid;  ///< [meshes] 1: an obstacle with a closed surface
  bool self = true;                  ///< whether cloth may meet cloth
  SheetsAtRest rest;                 ///< all empty: nothing is known of it
};

/// Edges of triangles, and what hangs together. Does not change while points move.
struct SurfaceTopology {
  std::vector<Edge> edges;
  std::vector<std::array<Index, 3>> triangle_edges;  ///< [triangles] from corner j to j + 1
  std::vector<Index> edge_first;                     ///< [edges + 1] into edge_triangles
  std::vector<Index> edge_triangles;                 ///< in increasing order
  std::vector<Index> point_first;                    ///< [points + 1] into neighbours, point_edges
  std::vector<Index> neighbours;                     ///< across an edge
  std::vector<Index> point_edges;                    ///< that edge

  /// @param point_count numbers of points are below this
  SurfaceTopology(const std::vector<Tri>& triangles, std::size_t point_count);
};

/// An edge that runs through a triangle.
struct Piercing {
  Index edge;
  Index face;
  double along;          ///< 0 to 1, from the edge's first end to its second
  Vec3<double> weights;  ///< of the face's corners, sum 1
  Vec3<double> point;    ///< [m]
};

/// The line that two triangles have in common.
struct ContourArc {
  Index piercing[2];  ///< its ends; the second -1 where it ends at `corner`
  Index corner;       ///< a vertex that both triangles have, or -1
  Index triangle[2];
  double length;  ///< [m]
};

/// Every intersection of some surfaces.
struct Contours {
  std::vector<Piercing> piercings;  ///< by edge, then by face
  std::vector<ContourArc> arcs;
  std::vector<Index> number;  ///< [piercings] which contour each is on, from 0
  Index count = 0;            ///< contours
  /// Triangles that meet without piercing each other: they touch.
  std::vector<std::pair<Index, Index>> touching;

  double length() const;  ///< [m] of all contours
  bool empty() const { return piercings.empty() && touching.empty(); }
};

/// How a contour ends.
enum class ContourKind {
  closed,    ///< it does not
  boundary,  ///< where edges of cloth run out, or at a vertex that both sides have
};

/// Finds contours again and again while points move.
class ContourSearch {
 public:
  /// @param surfaces must outlive the search
  ContourSearch(const IntersectingSurfaces& surfaces, const SurfaceTopology& topology);

  /// Contours as the points are now. Only pairs of triangles with a corner that has moved or woken
  /// since the last call are looked at again.
  /// @param awake [points] pairs of triangles without such a corner are passed over
  Contours find(Span<const unsigned char> awake);

  /// Calls visit(triangle, triangle) for pairs of cloth with cloth or obstacle of which one has an
  /// awake corner and whose boxes, larger by `pads` [m], overlap.
  /// @param pads one for all, or [triangles]
  template <class Pads, class Visit>
  void visit_in_pattern(const Pads& pads, Span<const unsigned char> awake, Visit visit) {
    obstacle_.refit(surfaces_.points, surfaces_.triangles, pads, awake);
    obstacle_pad_ = -1;
    visit_with_cloth(pads, awake, visit);
  }

 private:
  template <class Pads, class Visit>
  void visit_with_cloth(const Pads& pads, Span<const unsigned char> awake, Visit visit) {
    cloth_.refit(surfaces_.points, surfaces_.triangles, pads, awake);
    if (surfaces_.self) visit_own_pairs(cloth_, 1, visit);
    visit_pairs(cloth_, 1, obstacle_, 1, visit);
  }
  std::vector<unsigned char> changed_points(Span<const unsigned char> awake) const;
  void refit_obstacles(double pad, Span<const unsigned char> changed);
  Contours unchanged(Span<const unsigned char> awake, Span<const unsigned char> changed) const;
  Index first_triangle(Index edge) const {
    return topology_.edge_triangles[at(topology_.edge_first[at(edge)])];
  }

  const IntersectingSurfaces& surfaces_;
  const SurfaceTopology& topology_;
  BoxTree cloth_;
  BoxTree obstacle_;
  double obstacle_pad_ = -1;  ///< [m] of boxes of obstacles with nothing awake; -1: of no such ones
  std::vector<Vec3<double>> points_before_;  ///< [m] of the last find(), with what it found
  std::vector<unsigned char> awake_before_;
  std::vector<Piercing> piercings_before_;
  std::vector<std::pair<Index, Index>> touching_before_;
};

/// @param contour a number below contours.count
ContourKind kind_of(const Contours& contours, Index contour);

/// Directions in which the contours go on from each piercing, summed over the lines that end there.
/// @return [piercings] [1] sums of unit vectors
std::vector<Vec3<double>> contour_pull(const IntersectingSurfaces& surfaces,
                                       const Contours& contours);

/// How the length of all contours changes as points move: with R the sum of the directions in which
/// the contour goes on from a piercing, E the direction of the edge and N the normal of the face,
///   shortening = (R - (E.R)/(E.N) N) . d_edge + (E.R)/(E.N) N . d_face
/// plus, where a contour ends at a corner, its motion along the contour.
/// @return [points] [1] gradient of the length
/// @cite volino2006
std::vector<Vec3<double>> contour_gradient(const IntersectingSurfaces& surfaces,
                                           const SurfaceTopology& topology,
                                           const Contours& contours);

}  // namespace weft
