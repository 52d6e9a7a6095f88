#pragma once

#include <optional>
#include <string>

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

/// Whether somebody has asked for an end. What has been computed since may be anything.
inline bool stopped(const DeviceSet& devices, StepReport& report) {
  return devices.stop_requested() && !fail(report, Failure::stopped, "");
}

/// Whether the latest attempt failed because its collisions could not be resolved.
inline bool collisions_failed(const StepReport& report) {
  return report.failure == Failure::intersection || report.failure == Failure::pinched;
}

}  // namespace weft
