#pragma once

#include <cstddef>
#include <vector>

#include "host/implicit/attempt.hpp"
#include "host/implicit/collision_response/impact_zones.hpp"
#include "host/implicit/collision_response/zone_budget.hpp"
#include "host/implicit/collision_response/zone_energy.hpp"
#include "host/implicit/contact/contact_detection.hpp"
#include "host/implicit/parallel/stage_clock.hpp"
#include "host/implicit/prescribed_motion.hpp"
#include "host/implicit/step_publisher.hpp"
#include "host/implicit/step_solver.hpp"
#include "host/state/rank_geometry.hpp"
#include "host/state/store.hpp"
#include "weft/report.hpp"

namespace weft {

/// Makes the end of an attempt free of intersections. Rejects it if that costs too much energy, or
/// moves prescribed vertices too far from their targets.
template <class T>
class CollisionResolver {
 public:
  CollisionResolver(Store<T>& store, std::vector<RankGeometry<T>>& geometry,
                    std::vector<RankMotion<T>>& motion, ContactDetection<T>& detection,
                    LinearSystem<T>& system, StepSolver<T>& solver,
                    const PrescribedMotion<T>& prescribed, StageClock& clock,
                    const StepPublisher& publisher);

  /// @param nominal_step [s] the scene's step, or the length of an automatic one
  void begin_step(double nominal_step);
  /// Whether tracking constraints do work on the cloth. The energy that zones add is then unknown.
  void set_pulled(bool pulled) { pulled_ = pulled; }

  /// Work that zones may still do in this step.
  ZoneBudget& budget() noexcept { return budget_; }
  void grant(std::int64_t visits) {
    budget_.grant(visits);
    publish_budget();
  }

  /// Continuous detection and impact zones by turns until detection is silent (P-Cloth section 4).
  /// Only then is the step free of intersections: pairs that the broad phase left out cannot meet
  /// as long as every vertex keeps to its swept AABB, and if one does not, pairs are searched
  /// again.
  bool resolve(const Attempt& a, StepReport& report);

  /// Of all rounds of the latest attempt.
  const std::vector<Collision>& collisions() const noexcept { return collisions_; }
  /// Where the solve of the latest attempt ended on rank r, before impact zones. [m], [m/s]
  Span<const Vec3<T>> solved_positions(int r) const {
    return collisions_.empty() ? motion_[static_cast<std::size_t>(r)].positions_t1.span()
                               : zones_.free_positions(r);
  }
  Span<const Vec3<T>> solved_velocities(int r) const {
    return collisions_.empty() ? motion_[static_cast<std::size_t>(r)].velocities_t1.span()
                               : zones_.free_velocities(r);
  }
  /// Whether the scene declares any prescribed vertex compliant.
  bool any_may_comply() const { return zones_.any_may_comply(); }
  /// See ZoneEnergy::stretched_at_last.
  bool stretched_at_last() const noexcept { return energy_.stretched_at_last(); }

  /// Moves the ends of vertices on all ranks, and their velocities with them.
  /// @param h [s] effective step of the integrator
  void apply(const std::vector<MovedVertex<T>>& moved, double h);

  /// Continuous detection of a motion that is not a step, see ImplicitStep::collisions_on_the_way.
  std::vector<Collision> collisions_on_the_way(const std::vector<MovedVertex<T>>& moves,
                                               StepReport& report);

 private:
  void begin();
  void publish_budget() const;
  bool is_acceptable(const Attempt& a, StepReport& report);
  bool respond(const Attempt& a, std::size_t first_new, StepReport& report);

  Store<T>& store_;
  std::vector<RankMotion<T>>& motion_;
  ContactDetection<T>& detection_;
  StepSolver<T>& solver_;
  const PrescribedMotion<T>& prescribed_;
  StageClock& clock_;
  const StepPublisher& publisher_;
  ImpactZones<T> zones_;
  ZoneEnergy<T> energy_;
  ZoneBudget budget_;
  std::vector<Collision> collisions_;
  std::vector<Buffer<MovedVertex<T>>> rank_moved_;
  ZoneMotion zone_motion_ = ZoneMotion::impacts;  ///< for the remaining rounds of the attempt
  int unsolved_rounds_ = 0;                       ///< in a row
  double nominal_step_;                           ///< [s]
  bool pulled_ = false;
};

}  // namespace weft
