#pragma once

#include <functional>
#include <vector>

#include "host/geometry/planar_domain.hpp"
#include "weft/core/span.hpp"
#include "weft/core/vec.hpp"

namespace weft {

/// Proves that cloth does not come near itself while its vertices move straight from x_0 to x_1, so
/// that the search for its pairs with itself can be skipped.
///
/// Cloth is given as pieces over convex domains of the plane, see PlanarDomain. On a triangle the
/// positions are linear in the domain's coordinates, with gradient F(t) = F_0 + t (F_1 - F_0), and
/// so is the displacement u = x_1 - x_0, with gradient F_1 - F_0. Let A be any 2x3 matrix of norm
/// at most 1 and c(t) the least eigenvalue of the symmetric part of A F(t) over all triangles. As
/// the domain is convex, the straight line from a point Q of it to a point P lies within triangles,
/// so that with d = P - Q
///   d . A (x(P) - x(Q)) = integral of d . A F d along the line >= c |d|^2, hence
///   |x(P, t) - x(Q, t)| >= c(t) |d|.                                                        (1)
/// The least eigenvalue is concave in the matrix, and F linear in t:
///   c(t) >= min(c(0), c(1)),                                                                (2)
/// and with g the largest norm of F_1 - F_0 over all triangles
///   |u(P) - u(Q)| <= g |d|,   c(1) >= c(0) - g.                                             (3)
/// For two primitives that share no vertex |d| is at least PlanarDomain::least_gap, r. A is
/// the transposed polar factor of the piece's mean gradient, so c is about the cosine of the
/// largest bending angle. This resembles the cone of normals of Volino & Magnenat-Thalmann (1994).
/// The convex domain replaces their contour test, and the result is a distance, not yes or no.
///
/// No contact (CollideProximity): a pair is a contact only if its distance is below the thickness,
/// at the start or, along the line between its closest points P and Q, at the predicted end. The
/// latter distance is at least |x(P) - x(Q)| - |u(P) - u(Q)|. So there is no contact if
///   (c(0) - g) r >= thickness.                                                              (4)
/// The kernel uses only the direction and the weights of P and Q, so the bound also holds if these
/// are not exactly the closest points. No collision (CollideContinuous): by (1) and (2), no pair
/// comes closer than the thickness, which is ten times the separation that detection uses, if
///   min(c(0), c(1)) r >= thickness.                                                         (5)
/// False positives of detection occur only within rounding of that separation, or for slivers when
/// its iterations run out (elements/ccd.hpp); planar_domains() refuses slivers. Two pieces are
/// apart if, along an axis, all of one lies below all of the other by more than the thickness, at
/// the start and at the end. Both kernels use the same criterion for pairs.
///
/// Rounding. Gradients are in double. Differences of positions have a relative error of u = 2^-53
/// (float: none). Let e be their largest component and m that of the inverse matrices. Then an
/// entry of A F has an error below 16 u e m, and an eigenvalue an error below 64 u e m. The code
/// subtracts `gradient_rounding` e m from c and adds it to g. Let epsilon be that of the run's
/// precision. The kernels' distances have an error of ten epsilon times the size of primitives and
/// gap, displacements a relative error of epsilon. The thickness is therefore increased by one per
/// cent, and by `distance_rounding` epsilon times edges and displacements. One per cent of the gap
/// exceeds its share of rounding, because c(0) - g must be at least 0.01. The norm of A is kept
/// below 1 by more than its own rounding error.
template <class T>
class SelfCertificate {
 public:
  /// Positions of all vertices in the memory of one rank.
  struct Motion {
    Span<const Vec3<T>> positions_t0;  ///< [>= cloth vertices] [m]
    Span<const Vec3<T>> positions_t1;
  };
  /// Calls part(k) for each rank k, in parallel or not, and waits for all.
  using ForAll = std::function<void(const std::function<void(int)>& part)>;

  /// @param domains   of all of the cloth, see planar_domains()
  /// @param thickness [m] of contacts
  /// @param ranks     that share the work
  SelfCertificate(std::vector<PlanarDomain> domains, double thickness, int ranks);

  std::size_t pieces() const noexcept { return domains_.size(); }
  /// Whether a proof is possible: there are pieces, not too many, and none with a mesh finer than
  /// the thickness.
  bool of_use() const noexcept { return of_use_; }

  /// Whether a motion makes neither contacts nor collisions of cloth with cloth, (4) and (5).
  /// @param motion by rank; the same positions on each
  bool holds(const std::function<Motion(int rank)>& motion, const ForAll& for_all);

  /// Whether the motion from the same start to another end makes no collisions, (5).
  /// @pre the last call of holds() was with the same positions_t0, and true
  bool holds_to(const std::function<Motion(int rank)>& motion, const ForAll& for_all);

 private:
  /// Result of one rank for its share of a piece.
  struct Found {
    double least = 0;      ///< eigenvalue
    double change_sq = 0;  ///< [1] of the gradient
    double edge = 0;       ///< [m] largest component of a side
    double motion = 0;     ///< [m] largest component of a displacement
    bool finite = true;
    Vec3<double> low[2], high[2];  ///< [m] AABB at the start and at the end, for several pieces
  };
  /// Rows of A.
  struct Frame {
    Vec3<double> row[2];
    bool good = false;
  };

  Frame frame(const PlanarDomain& domain, Span<const Vec3<T>> positions) const;
  void look(int rank, const Motion& motion, bool to_end);
  template <bool ToEnd>
  void look_at(const PlanarDomain& domain, const Frame& frame, const Motion& motion,
               std::size_t begin, std::size_t end, Found& found) const;
  void look_at_box(const PlanarDomain& domain, const Motion& motion, Found& found) const;
  Found joined(std::size_t domain) const;
  bool pieces_apart() const;

  std::vector<PlanarDomain> domains_;
  double thickness_;
  bool of_use_;
  std::vector<std::vector<Found>> found_;   ///< [rank][domain]
  std::vector<std::vector<Frame>> frames_;  ///< [rank][domain], the same on each
  std::vector<double> least_t0_;            ///< [domain] c(0) of the last holds(), less rounding
};

}  // namespace weft
