#pragma once

#include <Eigen/Dense>

#include <array>
#include <utility>
#include <vector>

#include "host/scene/plate.hpp"

namespace weft {

/// A linear functional of the values of one coordinate: the sum of weight times value.
struct Functional {
  std::vector<std::pair<Index, double>> terms;

  void add(Index v, double weight);
  void add(const Functional& other, double scale);
};

/// The quadratic of one triangle: its linear interpolant plus bulge[i] times the product of the
/// barycentric coordinates other than i.
struct Quadratic {
  Functional bulge[3];
  Functional second[3];         ///< derivatives by u u, v v and u v
  Eigen::Vector2d gradient[3];  ///< [1/m] of the barycentric coordinates
};

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
  bool joins(Index t, int edge) const;
  Point rest(Index t, int corner) const;
  double area(Index t) const;

  /// The quadratic of a triangle that is not held: through its corners, with the slope of a held
  /// neighbour in the middle of their common edge, and through the opposite corners of the other
  /// neighbours; through points further away where these are too few or lie badly.
  Quadratic quadratic(Index t) const;

 private:
  /// A triangle laid into the plane of another.
  struct Placed {
    Index triangle;
    std::array<Point, 3> corner;
    int depth;
  };

  /// A vertex near a triangle, in the triangle's plane.
  struct NearPoint {
    Index vertex;
    Point place;
    int depth;
  };

  /// What fixes a quadratic beside its corners.
  struct Conditions {
    std::vector<int> clamped;  ///< edges
    std::vector<NearPoint> points;
  };
  /// Of each condition, a row: what it says of each bulge.
  using Products = Eigen::Matrix<double, Eigen::Dynamic, 3, 0, 3, 3>;
  using Fit = Eigen::Matrix<double, 3, Eigen::Dynamic, 0, 3, 3>;

  void find_neighbours();
  Placed unfolded(const Placed& from, int k) const;
  std::vector<NearPoint> points_around(Index t, int depth) const;
  Eigen::Vector3d barycentric(Index t, const Point& p) const;
  Products products(Index t, const Conditions& conditions) const;
  /// Bulges by conditions: the inverse, or, with fewer than three of them or such as nearly exclude
  /// each other, the least bulges that fit.
  static Fit fit_of(const Products& m);
  double badness(Index t, const Conditions& conditions) const;
  Conditions choose(Index t) const;
  void try_points(Index t, const std::vector<NearPoint>& pool, std::size_t next, Conditions& trial,
                  double& best, Conditions& chosen) const;
  Functional clamp_value(Index t, int k, const Quadratic& q) const;

  const std::vector<PlateTriangle>& triangles_;
  std::vector<std::array<Index, 3>> neighbour_;  ///< across the edge opposite each corner, or -1
};

}  // namespace weft
