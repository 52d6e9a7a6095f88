#pragma once

#include <functional>
#include <vector>

#include "host/geometry/planar_domain.hpp"
#include "weft/core/span.hpp"
#include "weft/core/vec.hpp"

namespace weft {

/// Proves that cloth does not come near itself while its vertices go straight from x_0 to x_1, so
/// that its pairs with itself need not be looked for.
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
/// For two primitives that share no vertex |d| is at least PlanarDomain::least_gap, r. That A turns
/// the piece's mean gradient upright makes c the cosine of the angle to which the cloth may bend:
/// like the cone of normals of Volino & Magnenat-Thalmann (1994), whose test of the contour the
/// convex domain stands for, and with a distance instead of a yes or no.
///
/// No contact (CollideProximity): a pair is one only if its distance at the start or what it has
/// become along the line between the closest points P, Q at the predicted end is below the
/// thickness; the latter is at least |x(P) - x(Q)| - |u(P) - u(Q)|. So none is where
///   (c(0) - g) r >= thickness.                                                              (4)
/// It reads no more than the direction and the weights of points that it has, so that these need
/// not be the closest ones. No collision (CollideContinuous): by (1) and (2) none comes closer than
/// the thickness on the way, ten times the separation that counts, where
///   min(c(0), c(1)) r >= thickness;                                                         (5)
/// what detection may report in vain it reports within rounding of the separation, or after all of
/// its steps (elements/ccd.hpp), for triangles that are no slivers: planar_domains() takes none.
/// Two pieces are apart if along some axis all of one lies below all of the other by more than the
/// thickness, at the start and at the end, which is what both kernels ask of pairs.
///
/// Rounding. Gradients are in double. Differences of positions are off by u = 2^-53 of themselves
/// (float: not at all), so that with e the largest of their components and m that of the inverse
/// matrices an entry of A F is off by less than 16 u e m and an eigenvalue by less than 64 u e m;
/// `gradient_rounding` e m is taken off c and added to g. The kernels' distances are off by ten
/// epsilon, of the run's precision, of the size of primitives and gap, and displacements by epsilon
/// of themselves: thickness stands for a hundredth more and `distance_rounding` epsilon of edges
/// and displacements; a hundredth of the gap is more than its share of rounding, as c(0) - g has to
/// be a hundredth at least. The norm of A is kept below 1 by more than its own rounding.
template <class T>
class SelfCertificate {
 public:
  /// Positions of all vertices as one rank has them.
  struct Motion {
    Span<const Vec3<T>> positions_t0;  ///< [>= cloth vertices] [m]
    Span<const Vec3<T>> positions_t1;
  };
  /// Calls part(k) for each rank k, side by side or not, and waits for all.
  using ForAll = std::function<void(const std::function<void(int)>& part)>;

  /// @param domains   of all of the cloth, see planar_domains()
  /// @param thickness [m] of contacts
  /// @param ranks     that share the work
  SelfCertificate(std::vector<PlanarDomain> domains, double thickness, int ranks);

  std::size_t pieces() const noexcept { return domains_.size(); }
  /// Whether there is anything that could be proved: pieces, not too many of them, and none that is
  /// finer than the thickness.
  bool of_use() const noexcept { return of_use_; }

  /// Whether a motion makes neither contacts nor collisions of cloth with cloth, (4) and (5).
  /// @param motion by rank; the same positions on each
  bool holds(const std::function<Motion(int rank)>& motion, const ForAll& for_all);

  /// Whether the motion from the same start to another end makes no collisions, (5).
  /// @pre the last call of holds() was with the same positions_t0, and true
  bool holds_to(const std::function<Motion(int rank)>& motion, const ForAll& for_all);

 private:
  /// What a rank has found of its share of a piece.
  struct Found {
    double least = 0;      ///< eigenvalue
    double change_sq = 0;  ///< [1] of the gradient
    double edge = 0;       ///< [m] largest component of a side
    double motion = 0;     ///< [m] likewise of a displacement
    bool finite = true;
    Vec3<double> low[2], high[2];  ///< [m] at the start and at the end; where there are more pieces
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
  std::vector<double> least_t0_;            ///< [domain] of the last holds(), rounding taken off
};

}  // namespace weft
