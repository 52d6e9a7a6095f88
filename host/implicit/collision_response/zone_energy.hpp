#pragma once

#include <cstddef>
#include <vector>

#include "host/implicit/collision_response/impact_zones.hpp"
#include "host/implicit/linear/linear_system.hpp"
#include "host/state/rank_geometry.hpp"
#include "host/state/store.hpp"

namespace weft {

/// Detects energy that impact zones add by holding cloth back. All functions look at the end of an
/// attempt that zones have changed.
template <class T>
class ZoneEnergy {
 public:
  ZoneEnergy(Store<T>& store, const std::vector<RankMotion<T>>& motion, LinearSystem<T>& system,
             const ImpactZones<T>& zones)
      : store_(store), motion_(motion), system_(system), zones_(zones) {}

  void begin_step() { stretched_at_last_ = false; }

  /// Zones know of masses and nothing of elasticity. Where a long step would take much of a cloth
  /// through something, they leave it stretched to many times its size. This is looked for where
  /// nothing that is prescribed moves, so that energy can only fall, and only if cloth moved far.
  /// @param impacts_met over all rounds of the attempt
  /// @param fixed       [vertices] 1 if the position is prescribed
  bool gained(double dt, std::size_t impacts_met, const std::vector<unsigned char>& fixed) const;

  /// Whether zones have stretched cloth to where they hold it, in scenes where bodies or pins move.
  /// Energy is compared with that of the same step without collision response, to leave out the
  /// stretch of the solve. In shorter steps contacts hold most of the cloth that zones hold
  /// here. Where cloth is jammed, they do not: after a truncated step nothing is compared, and
  /// after one whose shortest parts stretch it as well, more is let pass.
  /// @param must_stand no part of a step is shorter: it is accepted, see stretched_at_last()
  bool stretched(double dt, bool must_stand);
  /// Whether that would have failed a shortest part of the step.
  bool stretched_at_last() const noexcept { return stretched_at_last_; }

  /// Whether zones have stretched cloth past a limit of strain that the solve kept. In shorter
  /// steps contacts hold most of the cloth that zones hold here.
  bool broke_limits() const;

 private:
  Store<T>& store_;
  const std::vector<RankMotion<T>>& motion_;
  LinearSystem<T>& system_;
  const ImpactZones<T>& zones_;
  bool stretched_at_last_ = false;
};

}  // namespace weft
