#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "host/implicit/attempt.hpp"
#include "host/implicit/collision_resolver.hpp"
#include "host/implicit/collision_response/truncated_motion.hpp"
#include "host/implicit/contact/contact_detection.hpp"
#include "host/implicit/parallel/stage_clock.hpp"
#include "host/implicit/prescribed_motion.hpp"
#include "host/implicit/state_update.hpp"
#include "host/implicit/step_publisher.hpp"
#include "host/implicit/step_solver.hpp"
#include "host/state/rank_geometry.hpp"
#include "host/state/store.hpp"
#include "weft/report.hpp"

namespace weft {

/// The last resort of a step: motions that end short of what they would run into.
template <class T>
class TruncatedStep {
 public:
  /// See ImplicitStep::Watch.
  using Watch =
      std::function<void(Span<const Vec3<T>> positions_t0, Span<const Vec3<T>> positions_t1)>;

  TruncatedStep(Store<T>& store, std::vector<RankMotion<T>>& motion, ContactDetection<T>& detection,
                StepSolver<T>& solver, PrescribedMotion<T>& prescribed,
                CollisionResolver<T>& resolver, StateUpdate<T>& update, StageClock& clock,
                const StepPublisher& publisher);

  /// Grants the work of truncated parts to a step.
  void grant();
  /// Whether any of it is left.
  bool may_approach() const { return approaches_left_ > 0 && truncated_collisions_left_ > 0; }

  /// Goes on from an attempt whose collisions could not be resolved: cuts its motion off before it
  /// meets something, solves again about the place that it has reached, and repeats this until
  /// prescribed vertices are near enough to their targets. Velocities are those of the way that
  /// vertices have made, so collisions are inelastic. In the repeated solves contacts start from
  /// their normal forces (augmented Lagrangian), which separates layers that are pressed together.
  /// @param may_bisect true: fails as soon as prescribed vertices beyond their limits get stuck
  bool advance(const Attempt& a, bool may_bisect, const Watch& watch, StepReport& report);

 private:
  /// The start of the step.
  struct Start {
    struct Rank {
      Buffer<Vec3<T>> positions;
      Buffer<ContactMemory<T>> contacts;
    };
    std::vector<Rank> ranks;
    std::int64_t face_contacts = 0;
  };

  void keep_start();
  bool approach(const Attempt& a, int pass, StepReport& report);
  bool resolve_again(const Attempt& a, StepReport& report);
  bool clear_path(const Attempt& a, TruncationKind kind, bool& complete, StepReport& report);
  void take_part_way(const Watch& watch);
  void return_to_start(const Attempt& a, bool good);

  Store<T>& store_;
  std::vector<RankMotion<T>>& motion_;
  ContactDetection<T>& detection_;
  StepSolver<T>& solver_;
  PrescribedMotion<T>& prescribed_;
  CollisionResolver<T>& resolver_;
  StateUpdate<T>& update_;
  StageClock& clock_;
  const StepPublisher& publisher_;
  TruncatedMotion<T> truncated_;
  Start start_;
  std::vector<Collision> collisions_;           ///< of the latest round
  int approaches_left_ = 0;                     ///< solves, in this step
  std::int64_t truncated_collisions_left_ = 0;  ///< of truncated motions, in this step
};

}  // namespace weft
