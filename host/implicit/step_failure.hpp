#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "host/implicit/collision_response/failure_place.hpp"
#include "weft/core/vec.hpp"
#include "weft/devices.hpp"
#include "weft/report.hpp"

namespace weft {

/// Notes why an attempt has failed.
/// @param place [m] see StepReport::failure_place
/// @return      false
inline bool fail(StepReport& report, Failure failure, const std::string& detail,
                 const std::optional<Vec3<double>>& place = {}) {
  report.failure = failure;
  report.failure_detail = detail;
  report.failure_place = place;
  return false;
}

/// Whether a stop was requested. Results that were computed since are invalid.
inline bool stopped(const DeviceSet& devices, StepReport& report) {
  return devices.stop_requested() && !fail(report, Failure::stopped, "");
}

/// Notes that coordinates of the motion on rank 0 are not finite.
/// @return false
template <class T>
bool fail_not_finite(Store<T>& store, const RankMotion<T>& motion, std::int64_t coordinates,
                     StepReport& report) {
  return fail(report, Failure::not_finite,
              std::to_string(coordinates) + " coordinates are not finite",
              place_not_finite(store, motion));
}

/// Whether the latest attempt failed because its collisions could not be resolved.
inline bool collisions_failed(const StepReport& report) {
  return report.failure == Failure::intersection || report.failure == Failure::pinched;
}

/// What follows a failed attempt of the levels whole, halved and rigid.
enum class Fallback { halve, truncate, fail };

/// The fallback table of ARCHITECTURE.md. `budget` is what impact zones have left.
inline Fallback after_failure(const StepReport& report, int bisections_left, std::int64_t budget) {
  if (report.failure == Failure::stopped) return Fallback::fail;
  const bool may_truncate = collisions_failed(report);
  if (bisections_left > 0 && (!may_truncate || budget > 0)) return Fallback::halve;
  return may_truncate ? Fallback::truncate : Fallback::fail;
}

}  // namespace weft
