#pragma once

#include <Eigen/Dense>

#include <array>
#include <cstddef>
#include <vector>

#include "host/base/short_list.hpp"
#include "host/model/plate.hpp"

namespace weft {

/// Vertices that the quadratic of a triangle reads: its own, and one for each condition.
inline constexpr std::size_t quadratic_vertices = 6;
/// A linear functional of one coordinate of these: the sum of weight times value.
using Weights = std::array<double, quadratic_vertices>;

/// What makes a quadratic of the linear interpolant of a triangle: bulge[i] times the product of
/// the barycentric coordinates other than i.
struct Bulges {
  ShortList<Index, quadratic_vertices> vertices;
  Weights bulge[3];  ///< zero beyond the vertices

  /// Where a vertex stands in the list, at the end of which it is put if it is not there yet.
  std::size_t place(Index v);
};

/// The quadratic of one triangle.
struct Quadratic : Bulges {
  Weights second[3];            ///< derivatives by u u, v v and u v
  Eigen::Vector2d gradient[3];  ///< [1/m] of the barycentric coordinates
};

/// Where a rest shape has the vertices that a quadratic reads. [m]
using ShapePoints = ShortList<Vec3<double>, quadratic_vertices>;

/// The triangles of a plate, how they meet, and their quadratics. Edge k of a triangle is the one
/// opposite corner k; neighbours are laid into each other's planes at rest, across seams too.
class PlatePatches {
 public:
  using Point = Eigen::Vector2d;

  /// @param triangles kept by reference
  explicit PlatePatches(const std::vector<PlateTriangle>& triangles);

  const PlateTriangle& triangle(Index t) const { return triangles_[static_cast<std::size_t>(t)]; }
  Index size() const { return static_cast<Index>(triangles_.size()); }
  /// The triangle across an edge; -1: none.
  Index neighbour(Index t, int edge) const {
    return neighbour_[static_cast<std::size_t>(t)][static_cast<std::size_t>(edge)];
  }
  /// Number of the edge by which `other`, the neighbour across edge k of t, meets t.
  int edge_back(Index t, int k) const;
  /// Whether the quadratics of two triangles meet at an edge: neither is held.
  bool joins(Index t, int edge) const {
    const Index other = neighbour(t, edge);
    return other >= 0 && !triangle(t).held && !triangle(other).held;
  }
  /// Whether the neighbour across an edge belongs to the same piece, so that both have one rest
  /// shape.
  bool same_piece(Index t, int edge) const;
  Point rest(Index t, int corner) const {
    const Vec2<double>& p = triangle(t).rest[static_cast<std::size_t>(corner)];
    return {p[0], p[1]};
  }
  double area(Index t) const {
    const Point a = rest(t, 1) - rest(t, 0), b = rest(t, 2) - rest(t, 0);
    return (a.x() * b.y() - a.y() * b.x()) / 2;
  }

  /// The quadratic of a triangle that is not held: through its corners, with the slope of a held
  /// neighbour in the middle of their common edge, and through the opposite corners of the other
  /// neighbours; through points further away where these are too few or lie badly.
  /// @param near  set to whether it reads the triangle and its neighbours alone
  /// @param shape filled with where the rest shape of the triangle has what the quadratic reads.
  ///              Beyond a seam the shape goes on in the triangle's plane
  Quadratic quadratic(Index t, bool* near = nullptr, ShapePoints* shape = nullptr) const;
  /// Makes that quadratic from its bulges.
  void complete(Index t, const Bulges& bulges, Quadratic& q) const;

 private:
  /// A triangle laid into the plane of another.
  struct Placed {
    Index triangle;
    std::array<Point, 3> corner;
    int depth;
    bool own = false;  ///< no seam lies between them
  };

  /// A vertex near a triangle, by the barycentric coordinates of where it lies in its plane.
  struct NearPoint {
    Index vertex;
    Eigen::Vector3d place;
    int depth;
    Index triangle;  ///< of which it is a corner
    int corner;
    bool own = false;  ///< as Placed::own
  };

  /// How many triangles away points may lie; what so many can be at most, and the points there.
  static constexpr int search_depth = 3;
  static constexpr std::size_t around_max = 3 + 6 + 12;
  using NearPoints = ShortList<NearPoint, around_max>;

  /// What fixes a quadratic beside its corners: three at most.
  struct Conditions {
    ShortList<int, 3> clamped;  ///< edges
    ShortList<NearPoint, 3> points;
  };
  /// Of each condition, a row: what it says of each bulge.
  using Products = Eigen::Matrix<double, Eigen::Dynamic, 3, 0, 3, 3>;
  using Fit = Eigen::Matrix<double, 3, Eigen::Dynamic, 0, 3, 3>;

  void find_neighbours();
  void join(Index s, Index r, bool only_ones);
  Placed unfolded(const Placed& from, int k) const;
  NearPoints points_around(Index t, int depth) const;
  static Products products(const Conditions& conditions);
  /// Bulges by conditions: the inverse, or, with fewer than three of them or such as nearly exclude
  /// each other, the least bulges that fit.
  static Fit fit_of(const Products& m);
  static double badness(const Conditions& conditions);
  Conditions choose(Index t, bool& near) const;
  static void try_points(const NearPoints& pool, std::size_t next, Conditions& trial, double& best,
                         Conditions& chosen);
  Vec3<double> shape_point(Index t, const Conditions& conditions, Index v) const;
  void add_clamp(Index t, int k, const Fit& fit, Eigen::Index column, Quadratic& q) const;

  const std::vector<PlateTriangle>& triangles_;
  std::vector<std::array<Index, 3>> neighbour_;  ///< across the edge opposite each corner, or -1
};

}  // namespace weft
