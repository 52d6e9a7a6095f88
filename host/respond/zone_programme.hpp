#pragma once

#include <cstddef>
#include <vector>

#include "weft/core/vec.hpp"
#include "weft/state/contact.hpp"

namespace weft {

/// The quadratic programme of one impact zone, on its dual: see RespondZones for formula, method
/// and guarantees. In double, whatever the precision of the run. Kept from zone to zone for its
/// memory alone.
class ZoneProgramme {
 public:
  /// Starts a zone.
  /// @param mass_inv [vertices of the zone] [1/kg] 0: infinite mass
  void clear(const std::vector<double>& mass_inv);

  /// @param v      the four vertices, by their place in the zone
  /// @param c      the collision
  /// @param x_free [vertices of the zone] [m] end of the step before any response
  void add(const std::size_t v[4], const Collision& c, const std::vector<Vec3<double>>& x_free);

  /// Climbs the dual until all constraints are met.
  /// @param passes_max most passes over the constraints
  /// @param dual_max   [kg m^2] that the dual does not exceed if there is a solution worth having
  /// @return           false if the passes did not suffice, if the dual exceeded that, or if none
  ///                   of a collision's vertices can move
  bool climb(int passes_max, double dual_max);

  /// That the latest climb() took.
  int passes() const { return passes_; }

  /// [vertices of the zone] [m] M^-1 A^T lambda, for the multipliers as they stand
  const std::vector<Vec3<double>>& displacements() const { return u_; }

 private:
  struct Constraint {
    std::size_t v[4];
    double w[4];
    Vec3<double> n;
    double wanted;      ///< [m] offset less the gap of x_free
    double tolerance;   ///< [m] by which the gap may miss the offset
    double diagonal;    ///< [1/kg] of A M^-1 A^T
    double multiplier;  ///< [kg m] impulse times step
  };

  /// Gap that displacements add to a constraint's.
  double gap(const Constraint& c, const std::vector<Vec3<double>>& u) const;
  /// u += M^-1 a multiplier
  void push(const Constraint& c, double multiplier, std::vector<Vec3<double>>& u) const;
  bool sweep(bool forwards);
  bool met();
  void find_face(std::size_t reach);
  bool step_ahead(int passes_max);
  void step_on_face(int passes_max);
  void find_direction(int passes_max);
  double largest_share() const;
  double dual_now() const;
  double energy(const std::vector<Vec3<double>>& u) const;
  double dual(const std::vector<double>& multipliers);
  void take(const std::vector<double>& multipliers);

  std::vector<double> mass_inv_;
  std::vector<Constraint> constraints_;
  std::vector<Vec3<double>> u_, scratch_;
  std::vector<unsigned char> on_face_, touched_;  ///< [constraints], [vertices]
  std::vector<std::size_t> face_;                 ///< constraints that a step may change
  std::vector<double> direction_, search_, residual_, product_;  ///< [face]
  std::vector<double> cut_, projected_;                          ///< [constraints]
  std::size_t reach_ = 1;  ///< links that step_ahead() looks ahead
  bool solvable_ = true;
  int passes_ = 0;
};

}  // namespace weft
